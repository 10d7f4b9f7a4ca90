# SPDX-License-Identifier: Apache-2.0
"""IR -> views: decides everything that templates then only lay out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from hypgen.codegen.belief import redraw
from hypgen.codegen.belief.belief_functions import BeliefFunctions
from hypgen.codegen.belief.factor_functions import FactorFunctions
from hypgen.codegen.belief.policy_memory import HistoryFunctions
from hypgen.codegen.belief.value_moves import ValueMoves
from hypgen.codegen.bounds.group_functions import GroupFunctions
from hypgen.codegen.bounds.groups import Relaxation
from hypgen.codegen.bounds.least_reward import least_reward
from hypgen.codegen.bounds.relaxation import relax
from hypgen.codegen.bounds.token_split import TeamFunctions
from hypgen.codegen.cpp import template_data
from hypgen.codegen.cpp.body_printer import Context
from hypgen.codegen.cpp.constant_arrays import constant_array, dimensions
from hypgen.codegen.cpp.function_builder import Builder, laid_out, origin
from hypgen.codegen.cpp.key_codes import KeyLayout
from hypgen.codegen.cpp.text import float32, scalar, stored
from hypgen.codegen.cpp.value_types import enum_view, history_view, joint_view, record_view, words_view
from hypgen.codegen.lanes.model_lanes import in_lanes
from hypgen.codegen.layout.history_layout import belief_reads, with_field_reads
from hypgen.codegen.layout.naming import Names, base_name, file_stem, sites_of
from hypgen.codegen.layout.state_layout import Layout, pack
from hypgen.codegen.model import descriptor
from hypgen.codegen.model.interface import Interface
from hypgen.codegen.model.model_functions import (
    PartNames,
    density,
    density_entry,
    density_fill,
    element_update,
    key_of,
    lets,
    model_functions,
    reward,
    sampler,
    table_entry,
    table_fill,
)
from hypgen.codegen.model.partitioned_step import PartitionedStep
from hypgen.codegen.model.policy_functions import PolicyFunctions, uncalled_lets
from hypgen.codegen.passes.arguments import NeedsAnalysis
from hypgen.codegen.passes.density_tables import density_tables
from hypgen.codegen.passes.enumerable import sees_continuously
from hypgen.codegen.passes.operand_order import OperandOrder
from hypgen.codegen.passes.partition import ElementUpdate, partition
from hypgen.codegen.passes.tabulate import DerivedTable, tabulate
from hypgen.codegen.tree.expr import FALSE, TRUE, Literal, Prefix, member, method, not_
from hypgen.codegen.tree.passes import called, tidy
from hypgen.codegen.tree.sharing import renamed, share
from hypgen.codegen.tree.statements import Function, Return, assign, when
from hypgen.dsl import ir
from hypgen.dsl.ir.rounding import rounding, with_any_params
from hypgen.dsl.messages.watch import Watch, nobody
from hypgen.dsl.types import Type, length_of, size_of

_BOUNDS = "Bounds from small models"

# Sections of what stands for parts of the model: nothing but other functions calls it.
_PARTS = (
    "Constant arrays",
    "Functions of the model",
    "Element updates",
    "Rewards",
    "Observations",
    "Densities, for the filter",
)

# No version: a release that generates the same code leaves files, caches and golden files as they are.
LICENCE = "This file belongs to the owner of the model. hypgen's library is under the Apache License 2.0."


def lower(
    model: ir.Model, exact: bool = False, watch: Watch = nobody
) -> tuple[template_data.Header, template_data.Main, template_data.Project]:
    """Return the views of the three kinds of files; ``exact``: for the exact solver's program."""
    names = Names(model)
    tabulated, derived = tabulate(with_field_reads(model), names)
    watch("tabulate", (tabulated, derived))
    context = context_of(tabulated, derived, names, belief_reads(model))
    project = project_view(model)
    relaxation = Relaxation() if exact else relax(model)  # a solver's bounds, which nothing exact reads
    watch("relax", relaxation)
    packed = pack(tabulated)
    watch("pack", packed)
    stages = partition(tabulated)
    watch("partition", stages)
    return (
        _header(context, derived, relaxation, packed, stages, project.banner),
        descriptor.exact_view(context, project, (rounding(model), rounding(with_any_params(model))))
        if exact
        else descriptor.main_view(context, project),
        project,
    )


def lower_embedded(
    model: ir.Model, watch: Watch = nobody
) -> tuple[template_data.Header, template_data.Main, template_data.Project, template_data.Library]:
    """Return the views of the files of a solver or library, with what callers of either have to know."""
    header, main, project = lower(model, watch=watch)
    return header, main, project, descriptor.library_view(context_of(model, (), Names(model)), project)


def context_of(
    model: ir.Model,
    derived: tuple[DerivedTable, ...],
    names: Names,
    beliefs: Mapping[int, ir.BeliefRead] | None = None,
) -> Context:
    """Return what printing the model's expressions takes."""
    index_types: dict[str, tuple[Type, ...]] = {p.name: p.indices for p in model.params}
    index_types |= {t.name: t.indices for t in model.tables}
    index_types |= {t.name: tuple(b.type for b in t.inputs) for t in derived}
    needs = NeedsAnalysis(model, beliefs)
    densities = density_tables(model, needs, names)
    index_types |= {t.name: tuple(b.type for b in t.inputs) for t in densities.values()}
    order = OperandOrder(model, needs)
    return Context(model, names, needs, order, index_types, beliefs or {}, density_tables=densities)


def project_view(model: ir.Model) -> template_data.Project:
    """Return what build files and pages say of the model."""
    file = base_name(model.file)
    stem = file_stem(model)
    banner = f"Generated by hypgen from {file} (SHA-256 {model.source_hash[:16]}). Do not edit.\n{LICENCE}"
    doubtful = tuple(descriptor.doubtful_terms(model, file))
    return template_data.Project(
        banner, model.name, stem, f"{stem}_solver", file, model.source_hash, doubtful
    )


def _header(
    context: Context,
    derived: tuple[DerivedTable, ...],
    relaxation: Relaxation,
    packed: Layout,
    stages: tuple[tuple[ElementUpdate, ...], ...],
    banner: str,
) -> template_data.Header:
    model, names = context.model, context.names
    interface = Interface(context, PartNames(context, stages), stages)
    partitioned = PartitionedStep(interface, packed.state)
    factors = FactorFunctions(interface) if model.factors else None
    kind = TeamFunctions if relaxation.team else GroupFunctions
    groups = kind(interface, relaxation, packed.state.fields) if relaxation.groups else None
    bases = [*([] if packed.history.fields else ["NoHistory"]), *([] if factors else ["NotFactored"])]
    tracks = bool(redraw.redrawn(model))
    moves = ValueMoves(interface) if redraw.moves_values(model) else None
    whole = {variable for table in derived for variable in table.variables} & names.bits.keys()
    whole |= groups.whole() if groups else set()
    sections, functions = _sections(
        interface, partitioned, factors, moves, groups, derived
    )  # finds the masses
    lanes, no_lanes = in_lanes(model, names, packed, functions, model.lower is not None or relaxation.earned)
    return template_data.Header(
        banner=banner,
        name=names.model,
        constants=(
            *_constants(model, relaxation),
            *(groups.constants() if groups else []),
            *redraw.constants(model),
            *(moves.constants() if moves else []),
            *partitioned.constants(),
            *(factors.constants() if factors else []),
        ),
        types=(
            *(enum_view(e, names) for e in model.enums),
            *(record_view(r, names) for r in model.records),
            *([joint_view(model.action)] if model.action.indices else []),
        ),
        sites=tuple(
            f"static constexpr std::uint32_t {names.sites[s.path]} = 0x{s.id:08X}u;  // {s.path}"
            for s in {s.path: s for s in (*sites_of(model), *_policy_site(model))}.values()
        ),
        params=(*_params(context, derived), *(groups.params() if groups else [])),
        words=(
            words_view(
                "Fixed",
                "What never changes: stored once a scenario.",
                packed.fixed,
                names,
                word="FixedWord" if tracks else "std::uint32_t",
            ),
            words_view("State", "What a step changes.", packed.state, names, whole),
            *([history_view(packed.history, names)] if packed.history.fields else []),
        ),
        base=f" : {', '.join(bases)}" if bases else "",
        posterior=factors.fields() if factors else None,
        evidence=factors.evidence() if factors and factors.sampled and model.factored else (),
        tracks=tracks,
        moments=bool(factors and factors.matched) or any(b.deviation for b in context.beliefs.values()),
        relaxed=groups is not None,
        shares=relaxation.team is not None,
        sections=sections,
        lanes=lanes,
        no_lanes=no_lanes,
    )


def _policy_site(model: ir.Model) -> tuple[ir.Site, ...]:
    return (ir.Site("policy:default"),) if model.policy is None else ()


def _constants(model: ir.Model, relaxation: Relaxation) -> tuple[str, ...]:
    visible = sum(length_of(v.indices) for v in model.variables if v.visible)
    has_lower = model.lower is not None or relaxation.earned
    least = least_reward(model)
    bits = model.reward_bits
    lines = [
        f"static constexpr int kActionCount = {model.action.count};",
        f"static constexpr int kVisibleCount = {visible};",
        f"static constexpr int kVariableCount = {sum(length_of(v.indices) for v in model.variables)};",
        f"static constexpr bool kHasLower = {'true' if has_lower else 'false'};",
        *([] if model.history.is_empty else ["static constexpr bool kHasHistory = true;"]),
        *([] if least is None else [f"static constexpr float kLeastReward = {float32(least)};"]),
        *([] if bits == ir.REWARD_BITS else [f"static constexpr int kRewardBits = {bits};"]),
        *(["static constexpr bool kRewardsFit = true;"] if model.rewards_fit else []),
        *([] if all(k.observed for k in model.key) else ["static constexpr bool kKeyHoldsState = true;"]),
        *(["static constexpr bool kKeyIsContinuous = true;"] if sees_continuously(model) else []),
        f"using Key = {KeyLayout(model.key).type};",
    ]
    return tuple(lines)


def _params(context: Context, derived: tuple[DerivedTable, ...]) -> tuple[str, ...]:
    lines = []
    for param in context.model.params:
        name = context.names.params[param.name]
        lines.append(f"{scalar(param.type)} {name}{dimensions(param.indices)};  // {origin(param.span)}")
    for table in derived:
        inputs = ", ".join(b.name for b in table.inputs)
        over = f", by {inputs}" if inputs else ""
        dims = dimensions(tuple(b.type for b in table.inputs))
        lines.append(f"{stored(table.type)} {table.name}{dims};  // computed: {origin(table.span)}{over}")
    for densities in context.density_tables.values():
        inputs = ", ".join(context.names.locals().unique(b.name) for b in densities.inputs)
        dims = dimensions(tuple(b.type for b in densities.inputs))
        where = origin(densities.observation.span)
        lines.append(f"double {densities.name}{dims};  // computed: {where}, by {inputs}")
    lines += [f"std::uint64_t {name};  // computed" for name in context.masses.values()]
    return tuple(lines)


def _sections(
    interface: Interface,
    partitioned: PartitionedStep,
    factors: FactorFunctions | None,
    moves: ValueMoves | None,
    groups: GroupFunctions | None,
    derived: tuple[DerivedTable, ...],
) -> tuple[tuple[template_data.Section, ...], list[Function]]:
    """Return the sections of the header, and their functions."""
    context, model, parts = interface.context, interface.model, interface.parts
    updates = [update for stage in interface.stages for update in stage]
    beliefs = BeliefFunctions(factors) if factors else None
    history = [] if model.history.is_empty else HistoryFunctions(interface, beliefs).all()
    densities = context.density_tables.values()
    tables = [t.name for t in derived] + [t.name for t in densities]
    entries = {name: context.names.struct.unique(f"compute_{name}") for name in tables}
    sections = [
        ("Constant arrays", [constant_array(t, context) for t in model.tables]),
        ("Functions of the model", [*model_functions(context), *lets(context, uncalled_lets(context))]),
        ("Element updates", [element_update(u, parts.updates[key_of(u)], context) for u in updates]),
        ("Rewards", [reward(r, parts.rewards[r.name], context) for r in model.rewards]),
        ("Observations", [sampler(o, parts.observations[o.name], context) for o in model.observations]),
        (
            "Densities, for the filter",
            [
                *(
                    density(a, model.variable(a.variable).type, parts.densities[a.variable], context)
                    for u in updates
                    if u.observed
                    for a in u.assigns
                    if not model.variable(a.variable).copied
                ),
                *(
                    density(o, o.type, parts.observation_densities[o.name], context)
                    for o in model.observations
                ),
                *(
                    density(i, model.variable(i.variable).type, parts.init_densities[i.variable], context)
                    for i in model.first_seen
                ),
                *(moves.density_functions() if moves else []),
            ],
        ),
        ("Posteriors of factors", factors.all() if factors else []),
        (
            "What the runtime calls",
            [
                *([interface.joint()] if model.action.indices else []),
                interface.init(True),
                interface.init(False),
                *interface.init_likelihood(),
                interface.export(True),
                interface.import_visible(),
                interface.export(False),
                interface.is_legal(),
                *interface.tests(),
                interface.step(),
                *partitioned.all(),
                interface.observe(),
                interface.filter(),
                interface.observation_density(),
                *redraw.functions(model, context.names, pack(model).fixed),
                *(moves.all() if moves else []),
                *(beliefs.all() if beliefs else []),
                *history,
                *PolicyFunctions(interface).all(),
                *interface.bounds(
                    derived=groups is not None, looks_up=groups is not None and groups.earned is not None
                ),
            ],
        ),
        (_BOUNDS, [*groups.all(), groups.upper(), *groups.lower()] if groups else []),
        (
            "Loading",
            [
                *(table_entry(t, entries[t.name], context) for t in derived),
                *(density_entry(t, entries[t.name], context) for t in densities),
                _load(context, derived, entries, groups),
            ],
        ),
    ]
    return _laid_out([(title, [*found]) for title, found in sections], context.names)


def _laid_out(
    sections: list[tuple[str, list[Function]]], names: Names
) -> tuple[tuple[template_data.Section, ...], list[Function]]:
    """Return sections of functions after the passes over C++, without functions of parts that none calls.

    What comes with them are the functions as trees.
    """
    functions = {f.name: f for f in tidy([function for _, found in sections for function in found])}
    parts = [f.name for title, found in sections if title in _PARTS for f in found]
    kept = called([*functions.values()], parts)
    alike = [functions[f.name] for title, found in sections if title == _BOUNDS for f in found]
    shared, instances = share(alike, names.struct.unique)
    result = []
    for title, found in sections:
        some = [renamed(functions[f.name], instances) for f in found if f.name in kept]
        lines = tuple(map(laid_out, shared if title == _BOUNDS else some))
        result += [template_data.Section(title, lines)] if lines else []
    return tuple(result), [f for f in functions.values() if f.name in kept]


def _load(
    context: Context,
    derived: tuple[DerivedTable, ...],
    entries: dict[str, str],
    groups: GroupFunctions | None,
) -> Function:
    builder = Builder(context)
    builder.take("const ParamValues&", "values").take("Params&", "params").take("std::string&", "error")
    for param in context.model.params:
        count = math.prod(size_of(i) for i in param.indices)
        target = member("params", context.names.params[param.name])
        for _ in param.indices:
            target = target[0]
        target = Prefix("&", target)
        copied = method("values", "copy", Literal(f'"{param.name}"'), target, count, "error")
        builder.code.add(when(not_(copied), Return(FALSE)))
    for mass, name in context.masses.items():
        builder.code.add(assign(member("params", name), mass))
    for table in derived:
        table_fill(table, entries[table.name], context, builder)
    for densities in context.density_tables.values():
        density_fill(densities, entries[densities.name], context, builder)
    if groups:
        groups.fill(builder.code)
    builder.code.add(Return(TRUE))
    function = builder.done("bool", "load")
    # Only the host loads. A template, so that nvcc does not compile a step over draws that only the host has.
    template = ("class Draws = exact::EnumeratingDraws",) if groups else ()
    return replace(function, mark="static", template=template)
