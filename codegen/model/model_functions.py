# SPDX-License-Identifier: Apache-2.0
"""The functions that stand for parts of the model: each carries the line that it comes from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence, Set
from dataclasses import replace

from hypgen.codegen.cpp.body_printer import Context
from hypgen.codegen.cpp.expressions import ExprPrinter
from hypgen.codegen.cpp.function_builder import Builder, origin
from hypgen.codegen.cpp.sink import RETURN, Sink
from hypgen.codegen.cpp.text import scalar, stored
from hypgen.codegen.passes.arguments import PARTS, Needs
from hypgen.codegen.passes.density_tables import DensityTable
from hypgen.codegen.passes.guards import at_index, own_value
from hypgen.codegen.passes.hoisting import unguarded
from hypgen.codegen.passes.partition import ElementUpdate, entry_binders
from hypgen.codegen.passes.tabulate import DerivedTable
from hypgen.codegen.tree.expr import Expr, Operand, call, cast, member, method, number, plus
from hypgen.codegen.tree.statements import Do, Function, Return, assign, zeroed
from hypgen.dsl import ir
from hypgen.dsl.ir.walk import free_locals, shape, walk
from hypgen.dsl.types import Type


class PartNames:
    """Names of the functions made from updates, rewards and observations."""

    def __init__(self, context: Context, stages: Sequence[Sequence[ElementUpdate]]) -> None:
        unique = context.names.struct.unique
        updates = [update for stage in stages for update in stage]
        names = [u.element.name for u in updates]
        self.updates = {
            key_of(u): unique(
                f"update_{u.element.name}"
                + (f"_stage_{u.stage}" if names.count(u.element.name) > 1 else "")
                + ("_observed" if u.observed else "")
            )
            for u in updates
        }
        self.densities = {
            a.variable: unique(f"density_{a.variable}") for u in updates if u.observed for a in u.assigns
        }
        self.init_densities = {
            i.variable: unique(f"density_init_{i.variable}") for i in context.model.first_seen
        }
        self.rewards = {r.name: unique(f"reward_{r.name}") for r in context.model.rewards}
        self.observations = {o.name: unique(f"observe_{o.name}") for o in context.model.observations}
        self.observation_densities = {o.name: unique(f"density_{o.name}") for o in context.model.observations}


def key_of(update: ElementUpdate) -> tuple[str, int, bool]:
    """Return what tells one element update from another."""
    return update.element.name, update.stage, update.observed


def position(binders: Sequence[ir.Binder], printer: ExprPrinter) -> Expr:
    """Return the row-major position of the binders' current values: the index of a draw."""
    return printer.flat([ir.Local(b.type, b.name) for b in binders], [b.type for b in binders])


def model_functions(context: Context) -> list[Function]:
    """Return the model's functions."""
    result = []
    for function in context.model.functions:
        builder = Builder(context).given(context.needs.function(function.name))
        for formal in function.formals:
            builder.local(formal.name, formal.type)
        name = context.names.functions[function.name]
        comment = [f"// {origin(function.span)}"]
        result.append(builder.value(function.body).done(scalar(function.type), name, comment))
    return result


def lets(context: Context, uncalled: Set[str]) -> list[Function]:
    """Return the lets but those ``uncalled``; one that draws gives the same value wherever it is read."""
    result = []
    for let in context.model.all_lets:
        if let.name in uncalled:
            continue
        builder = Builder(context).given(context.needs.let(let.name))
        binders = [] if let.binder is None else [let.binder]
        for binder in binders:
            builder.local(binder.name, binder.type)
        site = context.names.sites.get(let.site.path, "")
        builder.sampled(let.dist, site, position(binders, builder.printer))
        name, comment = context.names.lets[let.name], [f"// {origin(let.span)}"]
        result.append(builder.done(scalar(let.dist.type), name, comment))
    return result


def update_needs(update: ElementUpdate, context: Context) -> Needs:
    """Return what the element update is given."""
    return context.needs.of(*(a.dist for a in update.assigns)) | {"next"}


def element_update(update: ElementUpdate, name: str, context: Context) -> Function:
    """Return the function that writes what the element, or one member of a family, writes in a stage."""
    builder = Builder(context).given(update_needs(update, context), next="State&")
    binder = update.element.binder
    if binder is not None:
        builder.local(binder.name, binder.type)
        for written in update.assigns:
            builder.printer.locals[written.binders[0].name] = builder.printer.locals[binder.name]
    for read in repeated_draws(update, context):
        builder.printer.once(read, read.let.rsplit(".", 1)[-1])
    comments = []
    for written, index in zip(update.assigns, update.indices, strict=True):
        comments.append(f"// {origin(written.span)}: {written.variable.rsplit('.', 1)[-1]}'")
        for variable, value in index:
            builder.printer.declare(variable, value, written.dist)
        own = entry_binders(update.element, written)
        with builder.printer.loops([b for b in own if b.name not in dict(index)]):
            assigned(replace(written, dist=at_index(written.dist, index)), "next", builder)
        builder.code.join()
    return builder.done("void", name, comments)


def repeated_draws(update: ElementUpdate, context: Context) -> list[ir.LetRead]:
    """Return the lets that draw and that an update certainly reads, and reads several times.

    Compilers do not see that a draw gives the same value again. What a stage writes no let of it reads.
    """
    reads = Counter(shape(n) for a in update.assigns for n in walk(a.dist) if isinstance(n, ir.LetRead))
    certain = {
        shape(n): n
        for a in update.assigns
        if not entry_binders(update.element, a)
        for n in unguarded(a.dist)
        if isinstance(n, ir.LetRead) and free_locals(n) <= {b.name for b in a.binders}
    }
    return [
        read for key, read in certain.items() if reads[key] > 1 and "draws" in context.needs.let(read.let)
    ]


def assigned(assign: ir.Assign, owner: str, builder: Builder) -> None:
    """Append the draw of one entry of a variable into ``owner``."""
    kept = shape(own_value(assign)) if owner == "next" else None
    _assigned(assign, owner, builder, lambda value: value, kept)


def first_assigned(assign: ir.Assign, first: int, builder: Builder) -> None:
    """Append the first value of one entry of a variable, whose entries are exported from ``first`` on.

    The draws may give another value than the model does.
    """
    variable = builder.context.model.variable(assign.variable)
    entry = number(first)
    if assign.binders:
        entry = plus(entry, position(assign.binders, builder.printer))
    function = f"first_value<{scalar(variable.type)}>"
    _assigned(
        assign,
        "fixed" if variable.fixed else "state",
        builder,
        lambda value: call(function, "draws", entry, value),
    )


def _assigned(
    assign: ir.Assign,
    owner: str,
    builder: Builder,
    given: Callable[[Expr], Expr],
    kept: object = None,
) -> None:
    """Append the draw of one entry into ``owner``, which is given what ``given`` makes of the value."""
    names, printer = builder.context.names, builder.printer
    indices = [printer.locals[b.name] for b in assign.binders]
    setter = names.setters[assign.variable]
    sink = Sink(lambda value: Do(method(owner, setter, *indices, given(value))), kept=kept)
    builder.sampled(
        assign.dist, names.sites.get(assign.site.path, ""), position(assign.binders, printer), sink
    )


def reward(term: ir.Reward, name: str, context: Context) -> Function:
    """Return the function of a reward term, earned once for each member of a family."""
    builder = Builder(context).given(context.needs.of(term.value))
    if term.binder is not None:
        builder.local(term.binder.name, term.binder.type)
    comment = [f"// {origin(term.span)}"]
    return builder.value(term.value).done(scalar(term.value.type), name, comment)


def sampler(observation: ir.Observation, name: str, context: Context) -> Function:
    """Return the function that draws one entry of an observation."""
    builder = Builder(context).given(context.needs.of(observation.dist))
    for binder in observation.binders:
        builder.local(binder.name, binder.type)
    site = context.names.sites.get(observation.site.path, "")
    builder.sampled(observation.dist, site, position(observation.binders, builder.printer))
    return builder.done(scalar(observation.type), name, [f"// {origin(observation.span)}"])


def density_needs(dist: ir.Dist, context: Context) -> Needs:
    """Return what a density is given: draws only if it depends on a let that draws."""
    return context.needs.of_density(dist) | ({"params"} if dist in context.density_tables else set())


def density(part: ir.Observation | ir.Assign, type_: Type, name: str, context: Context) -> Function:
    """Return the function that gives the probability of one entry's value."""
    builder = Builder(context).given(density_needs(part.dist, context))
    for binder in part.binders:
        builder.local(binder.name, binder.type)
    table = context.density_tables.get(part.dist)
    if table is None:
        builder.take(scalar(type_), "value")
        builder.dist.density(part.dist, "value", RETURN)
    else:
        builder.local(table.value.name, type_)
        found = [ir.Local(b.type, b.name) for b in (table.value, *part.binders)]
        reads = zip(table.variables, table.reads, strict=True)
        inputs = [*found, *(ir.StateRead(b.type, variable, primed=True) for variable, b in reads)]
        entry = builder.printer.entry(member("params", table.name), table.name, inputs)
        builder.code.add(Return(entry))
    return builder.done("double", name, [f"// {origin(part.span)}"])


def density_entry(table: DensityTable, name: str, context: Context) -> Function:
    """Return the function that computes one entry of a table of densities."""
    dist = table.observation.dist
    builder = Builder(context).given(context.needs.of_density(dist) & {"params"})
    builder.take(scalar(table.value.type), "value")
    for binder in table.inputs[1:]:
        builder.local(binder.name, binder.type)
    if table.variables:
        builder.code.add(zeroed("State", "next"))
        for variable, binder in zip(table.variables, table.reads, strict=True):
            setter = context.names.setters[variable]
            builder.code.add(Do(method("next", setter, builder.printer.locals[binder.name])))
    builder.dist.density(dist, "value", RETURN)
    return builder.done("double", name, [f"// {origin(table.observation.span)}"])


def density_fill(table: DensityTable, name: str, context: Context, builder: Builder) -> None:
    """Append the loops that fill a table of densities to ``load``."""
    printer = builder.printer
    with printer.loops(table.inputs):
        inputs = [ir.Local(b.type, b.name) for b in table.inputs]
        needs = context.needs.of_density(table.observation.dist) & {"params"}
        value = call(name, *arguments(needs, context, *printer.exprs(inputs)))
        builder.code.add(assign(printer.entry(member("params", table.name), table.name, inputs), value))


def arguments(needs: Needs, context: Context, *more: Operand) -> list[Operand]:
    """Return an argument list: the parts, then what comes after them."""
    return [*(context.names.action if p == "action" else p for p in PARTS if p in needs), *more]


def table_entry(table: DerivedTable, name: str, context: Context) -> Function:
    """Return the function that computes one entry of a derived table."""
    builder = Builder(context).given(_table_needs(table, context))
    for binder in table.inputs:
        builder.local(binder.name, binder.type)
    if table.variables:
        builder.code.add(zeroed("State", "state"))
        setters = context.names.setters | context.names.bits_setters
        for variable, binder in zip(table.variables, table.inputs, strict=True):
            builder.code.add(Do(method("state", setters[variable], builder.printer.locals[binder.name])))
    return builder.value(table.body).done(scalar(table.type), name, [f"// {origin(table.span)}"])


def _table_needs(table: DerivedTable, context: Context) -> Needs:
    # A formula that reads the state makes one of the inputs.
    return context.needs.of(table.body) - {"state"}


def table_fill(table: DerivedTable, name: str, context: Context, builder: Builder) -> None:
    """Append the loops that fill a derived table to ``load``."""
    printer = builder.printer
    with printer.loops(table.inputs):
        inputs = [ir.Local(b.type, b.name) for b in table.inputs]
        given = arguments(_table_needs(table, context), context, *printer.exprs(inputs))
        value = call(name, *given)
        if stored(table.type) != scalar(table.type):
            value = cast(stored(table.type), value)
        builder.code.add(assign(printer.entry(member("params", table.name), table.name, inputs), value))
