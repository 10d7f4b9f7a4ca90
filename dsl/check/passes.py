# SPDX-License-Identifier: Apache-2.0
"""The passes from a syntax tree to a checked model, each a function of what the pass before gave.

A model goes through three forms: ``Written`` (its syntax tree), ``Draft`` (its checked parts) and ``Whole``
(its IR). ``dsl.pipeline`` has the order. A pass reports mistakes and goes on with what has none.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import PurePath

from hypgen.dsl import ir
from hypgen.dsl.analysis import factorise, float_evidence, init_order, stages
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.check import lint, visibility
from hypgen.dsl.check.constants import settings
from hypgen.dsl.check.expressions import belief_reads
from hypgen.dsl.check.parts import derived_bounds, policies
from hypgen.dsl.check.parts.all_parts import Declarations, Parts, all_declarations, all_parts
from hypgen.dsl.check.program import CheckedProgram
from hypgen.dsl.check.records import flatten_records
from hypgen.dsl.check.scope import symbols
from hypgen.dsl.check.scope.scope import Program
from hypgen.dsl.ir import operators, reward_scale
from hypgen.dsl.messages import e06_ranges
from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.report import Mistake, Report
from hypgen.dsl.messages.source import Source, Span
from hypgen.dsl.syntax import ast

_ZERO = operators.real(0.0)


@dataclass(frozen=True)
class Written:
    """A model as text: its syntax tree with what it imports, and the values that settings give.

    ``original`` is the tree as the author wrote it, and ``sources`` are its text and those of its libraries.
    """

    original: ast.ModelFile
    file: ast.ModelFile
    overrides: Mapping[str, ast.Expr]
    sources: tuple[Source, ...]
    report: Report


@dataclass(frozen=True)
class Draft:
    """A model in checked pieces; each is empty until the pass that gives it.

    ``sites`` are the names of all draws, with their places. ``key`` has the digits of the observation key.
    """

    written: Written
    program: Program
    names: symbols.Symbols
    declarations: Declarations = Declarations()
    parts: Parts = Parts()
    sites: tuple[tuple[ir.Site, Span], ...] = ()
    key: tuple[ir.KeyField, ...] = ()

    @property
    def report(self) -> Report:
        """Return where mistakes go."""
        return self.written.report

    @property
    def variables(self) -> dict[str, ir.Variable]:
        """Return the variables by name."""
        return {v.name: v for v in self.declarations.variables}

    @property
    def learnt(self) -> list[Owner]:
        """Return what the agent learns from, besides the updates of visible variables."""
        return [*(Owner("observe", o.name) for o in self.parts.observations), Owner("terminal")]


@dataclass(frozen=True)
class Whole:
    """A model as one piece of IR, the draft that it was made from, and what is doubtful about it."""

    draft: Draft
    model: ir.Model
    warnings: tuple[Diagnostic, ...] = ()


# From a syntax tree to a draft ---------------------------------------------------------------------


def flatten(written: Written) -> Written:
    """Take a text. Give it with each record of floats as its fields."""
    file, overrides = flatten_records.flatten(written.file, written.overrides, written.report)
    return replace(written, file=file, overrides=overrides)


def collect_symbols(written: Written) -> Draft:
    """Take a text. Give a draft with all names; reports names that are taken, and settings of nothing."""
    names = symbols.collect(written.file, written.report)
    program = CheckedProgram(written.file, written.overrides, names, written.report)
    settings.refuse_unknown(program)
    return Draft(written, program, names)


def check_declarations(draft: Draft) -> Draft:
    """Take the names. Give types, consts, params, functions, elements, variables and lets."""
    return replace(draft, declarations=all_declarations(draft.program))


def check_parts(draft: Draft) -> Draft:
    """Take the names. Give the action, inits, updates, observations, rewards, conditions and bounds."""
    return replace(draft, parts=all_parts(draft.program))


# Rules and orders that follow from who reads what --------------------------------------------------


def check_visibility(draft: Draft) -> Draft:
    """Take the recorded reads. Give the draft as it is; reports reads that are not allowed."""
    parts = draft.parts
    lint.check_float_equalities(draft.program)
    readers = [
        *(Owner("init", i.variable) for i in parts.inits),
        Owner("legal"),
        *policies.readers(draft.program),
        *(Owner("bound", name) for name in parts.bounds),
        *(Owner("invariant", i.name) for i in parts.invariants),
        *(Owner("draw", d.name) for d in parts.drawings),
    ]
    visibility.check_reads(draft.program, draft.variables, readers)
    return draft


def stage_updates(draft: Draft) -> Draft:
    """Take the updates. Give them with the stage of a step that each belongs to; reports circles."""
    updates = stages.stage_updates(draft.parts.updates, draft.program.uses, draft.report)
    return replace(draft, parts=replace(draft.parts, updates=updates))


def order_inits(draft: Draft) -> Draft:
    """Take the inits. Give them in an order in which each has what it reads; reports circles."""
    declared, program = draft.declarations, draft.program
    definitions = init_order.Definitions(
        {x.name: x for x in declared.lets},
        {f.name: f for f in declared.functions} | program.unrolled,
        frozenset(e.name for e in declared.elements if e.binder is not None),
    )
    inits = init_order.order_inits(
        draft.parts.inits, draft.variables, definitions, program.uses, draft.report
    )
    return replace(draft, parts=replace(draft.parts, inits=inits))


def collect_sites(draft: Draft) -> Draft:
    """Take all that draws. Give the draws' names; reports two whose random numbers would be the same."""
    parts = draft.parts
    policy_lets = () if parts.policy is None else parts.policy.lets
    lets = [x for x in (*draft.declarations.lets, *policy_lets) if x.draws]
    sites = (
        *((a.site, a.span) for a in (*parts.inits, *parts.updates)),
        *((o.site, o.span) for o in parts.observations),
        *((x.site, x.span) for x in lets),
        (ir.Site("policy:default"), draft.program.file.span),
    )
    stages.check_sites(sites, draft.report)
    return replace(draft, sites=sites)


def mark_variables(draft: Draft) -> Draft:
    """Take staged updates. Give variables with what a filter need not weigh."""
    declared, uses = draft.declarations, draft.program.uses
    marked = stages.mark_variables(declared.variables, draft.parts.updates, uses, draft.learnt)
    return replace(draft, declarations=replace(declared, variables=marked))


def check_floats(draft: Draft) -> Draft:
    """Take what the agent sees. Give the draft as it is; reports floats that cannot weigh a belief."""
    declared, parts, variables = draft.declarations, draft.parts, draft.variables
    shown = [
        float_evidence.Shown(Owner("observe", o.name), f"the observation '{o.name}'", o.dist, o.span)
        for o in parts.observations
    ]
    for kind, assigns in (("update", parts.updates), ("init", parts.inits)):
        for assign in assigns:
            variable = variables[assign.variable]
            told = variable.informative if kind == "init" else not (variable.determined or variable.copied)
            if variable.visible and told:
                what = f"the visible float '{variable.name}'"
                owner = Owner(kind, variable.name)  # type: ignore[arg-type]  # both are kinds of owners
                shown.append(float_evidence.Shown(owner, what, assign.dist, assign.span))
    functions = {f.name: f for f in (*declared.functions, *draft.program.unrolled.values())}
    lets = {x.name: x for x in declared.lets}
    float_evidence.check_floats(shown, variables, functions, lets, draft.program.uses, draft.report)
    return draft


def derive_bounds(draft: Draft) -> Draft:
    """Take the parts. Give them with the bounds that nobody declared; reports those that do not follow."""
    parts = draft.parts
    declared = {i.name for i in draft.program.file.items if isinstance(i, ast.Bound)}
    names = [name for name in ("upper", "tail") if name not in declared]
    found = draft.report.attempt(
        partial(derived_bounds.derived, names, parts, draft.declarations, draft.program)
    )
    bounds = found or dict.fromkeys(names, _ZERO)
    return replace(draft, parts=replace(parts, bounds={**parts.bounds, **bounds}))


def make_key(draft: Draft) -> Draft:
    """Take observations and marked variables. Give the key's digits; reports a key that is too long."""
    key = stages.key_fields(draft.parts.observations, draft.declarations.variables)
    stages.check_key(key, draft.program.file.span, draft.report)
    return replace(draft, key=key)


# From a draft to a model ---------------------------------------------------------------------------


def assemble(draft: Draft) -> Whole:
    """Take a draft without mistakes. Give its model."""
    program, declared, parts = draft.program, draft.declarations, draft.parts
    assert parts.action is not None
    assert parts.discount is not None
    model = ir.Model(
        name=program.file.name,
        file=PurePath(draft.written.sources[0].name).name,
        source_hash=_hash(draft.written.sources, draft.written.original, program),
        discount=parts.discount,
        horizon=parts.horizon,
        enums=declared.enums,
        records=declared.records,
        params=declared.params,
        tables=(*declared.tables, *program.literals),
        elements=declared.elements,
        variables=declared.variables,
        lets=declared.lets,
        functions=(*declared.functions, *program.unrolled.values()),
        action=parts.action,
        inits=parts.inits,
        updates=parts.updates,
        observations=parts.observations,
        rewards=parts.rewards,
        terminal=parts.terminal or operators.FALSE,
        legal=parts.legal or operators.TRUE,
        policy=parts.policy,
        upper=parts.bounds["upper"],
        tail=parts.bounds["tail"],
        lower=parts.bounds.get("lower"),
        success=parts.success,
        key=draft.key,
        history=parts.history,
        invariants=parts.invariants,
        drawings=tuple(
            replace(d, reads=_variables_read(Owner("draw", d.name), draft)) for d in parts.drawings
        ),
        spans=_spans(program.file),
    )
    return Whole(draft, model)


def scale_rewards(whole: Whole) -> Whole:
    """Take a model with bounds. Give it with the scale of its rewards; reports rewards that have none."""
    step, most = reward_scale.largest_reward(whole.model), reward_scale.largest_return(whole.model)
    if math.isfinite(step) and most >= reward_scale.LARGEST_FLOAT:
        span = whole.model.rewards[0].span
        whole.draft.report.add(Mistake(e06_ranges.large_return(step, most, span)))
    bits = reward_scale.reward_bits(whole.model)
    fit = reward_scale.rewards_fit(whole.model, bits)
    return replace(whole, model=replace(whole.model, reward_bits=bits, rewards_fit=fit))


def find_factors(whole: Whole) -> Whole:
    """Take a model. Give it with the hidden state that is independent of all other, or what forbids that."""
    factors, obstacles = factorise.factorise(whole.model, whole.draft.program.uses)
    return replace(whole, model=replace(whole.model, factors=factors, obstacles=obstacles))


def resolve_beliefs(whole: Whole) -> Whole:
    """Take a model with factors. Give each ``belief(..)`` its factor; reports those that none answers."""
    return replace(whole, model=belief_reads.resolved(whole.model, whole.draft.program))


def warn(whole: Whole) -> Whole:
    """Take a model without mistakes. Give the warnings about it."""
    original, program = whole.draft.written.original, whole.draft.program
    return replace(whole, warnings=tuple(lint.warnings(original, whole.model, program)))


def _variables_read(owner: Owner, draft: Draft) -> frozenset[str]:
    return frozenset(r.name for r in draft.program.uses.closure(owner) if r.kind == "variable")


def _hash(sources: Sequence[Source], file: ast.ModelFile, program: Program) -> str:
    """Return the SHA-256 of the texts and, in order of names, the values that settings replace.

    What the model draws is left out, so that a solver need not be built again for another picture.
    """
    drawn = [item.span for item in file.items if isinstance(item, ast.Draw)]
    digest = hashlib.sha256("\n".join(s.without(drawn) for s in sources).encode())
    for name in sorted(program.overrides):
        item = program.symbols.values[name]
        value: object = None
        if isinstance(item, ast.Param):
            value = program.param(item).default
        elif isinstance(item, ast.Const):
            found = program.const(item)
            value = found.values if isinstance(found, ir.ConstantArray) else found.value
        digest.update(f"\n{name} = {value!r}".encode())
    return digest.hexdigest()


def _spans(file: ast.ModelFile) -> dict[str, Span]:
    """Return where the model's nameless parts are declared: ``terminal``, ``policy``, ``upper`` ..."""
    spans: dict[str, Span] = {}
    for item in file.items:
        match item:
            case ast.Condition(span, kind) | ast.Setting(span, kind):
                spans.setdefault(kind, span)
            case ast.Bound(span, name):
                spans.setdefault(name, span)
            case ast.Policy(span):
                spans.setdefault("policy", span)
    return spans
