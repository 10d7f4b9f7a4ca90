# SPDX-License-Identifier: Apache-2.0
"""Slow formulas of finite inputs become tables that are filled once, when params are loaded.

A step of a rollout then reads ``accuracy_table[x][y][r]`` where it would have computed a power, and
``step_table[cell][dir]`` where it would have taken a record apart and branched. The entries come from the
formula itself, so results are the same bit for bit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, overload

from hypgen.codegen.layout import limits
from hypgen.codegen.layout.naming import Names, Scope
from hypgen.codegen.layout.nodes import POSITION, BeliefCall, HistoryRead
from hypgen.codegen.layout.state_layout import pack
from hypgen.codegen.passes import table_draws
from hypgen.codegen.passes.cost import Costs
from hypgen.codegen.passes.hoisting import Hoisting, unguarded
from hypgen.codegen.passes.state_tables import state_reads
from hypgen.dsl import ir
from hypgen.dsl.ir.inline import Inliner
from hypgen.dsl.ir.order import dependencies_first
from hypgen.dsl.ir.reads import reached
from hypgen.dsl.ir.walk import (
    Node,
    bound_names,
    children,
    free_locals,
    map_children,
    shape,
    substitute,
    walk,
)
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import INT32_MAX, INT32_MIN, Int, Type, is_finite, size_of

# The lists of a model's parts, what of each is rewritten, and how names of tables of first values begin.
_PARTS = (
    ("inits", "dist", "init_"),
    ("updates", "dist", ""),
    ("observations", "dist", ""),
    ("rewards", "value", ""),
)
_SLOW = frozenset(
    {"pow", "hypot", "exp", "log", "log2", "sqrt", "sin", "cos", "tan", "asin", "acos", "atan2", "normal_cdf"}
)


@dataclass(frozen=True)
class DerivedTable:
    """A table of ``body`` over all values of ``inputs``; ``name`` is its C++ name in ``Params``.

    Where there are ``variables``, ``body`` reads them: the inputs are their values, or all bits of an array.
    """

    name: str
    inputs: tuple[ir.Binder, ...]
    type: Type
    body: ir.Expr
    span: Span
    variables: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Input:
    """A finite value that a formula reads, and the name it goes by inside the table's formula."""

    read: ir.Expr
    binder: ir.Binder


def tabulate(model: ir.Model, names: Names) -> tuple[ir.Model, tuple[DerivedTable, ...]]:
    """Return ``model`` with reads of derived tables (``ParamRead``) for slow formulas, and the tables."""
    return _Tabulator(model, names).run()


class _TooLarge(Exception):
    """A formula whose calls would be written out without end."""


class _Tabulator:
    def __init__(self, model: ir.Model, names: Names) -> None:
        self.model = model
        self.names = names
        self.tables: list[DerivedTable] = []
        self.functions = {f.name: f for f in model.functions}
        self.lets = {let.name: let for let in model.all_lets}
        self.inliner = Inliner(self.functions, self.lets)
        self.hoisting = Hoisting(model)
        self.costs = Costs(self.functions, self.lets)
        self.fields = {field.variable: field for field in pack(model).state.fields}
        self.room = 0  # how many more nodes a formula may have
        self.tested: set[tuple[str, Any]] = set()  # variants that the formula in work tests for

    def run(self) -> tuple[ir.Model, tuple[DerivedTable, ...]]:
        # Functions and lets first: once a body is a table, its callers have nothing slow left.
        calls = {
            f.name: [n.function for n in walk(f.body) if isinstance(n, ir.Call)] for f in self.model.functions
        }
        for function in map(self.functions.__getitem__, dependencies_first(calls)):
            self.functions[function.name] = replace(
                function, body=self.rewrite(function.body, function.name, function.span)
            )
        for let in self.model.all_lets:
            self.lets[let.name] = replace(let, dist=self.rewrite(let.dist, let.name, let.span))
            self.costs.known.clear()  # functions that read it cost less now
        model = replace(
            self.model,
            functions=tuple(self.functions[f.name] for f in self.model.functions),
            lets=tuple(self.lets[let.name] for let in self.model.lets),
        )
        changes: dict[str, Any] = {
            group: tuple(self._part(part, attribute, prefix) for part in getattr(model, group))
            for group, attribute, prefix in _PARTS
        }
        model = replace(model, **changes)
        if model.policy is not None:
            policy = model.policy
            lets = tuple(self.lets[let.name] for let in policy.lets)
            dist = self.rewrite(policy.dist, "policy", policy.span)
            model = replace(model, policy=replace(policy, dist=dist, lets=lets))
        registers = tuple(self._register(r) for r in model.history.registers)
        model = replace(model, history=replace(model.history, registers=registers))
        for group in ("terminal", "legal", "upper", "tail", "lower", "success"):
            value = getattr(model, group)
            if value is not None:
                span = model.spans.get(group, model.action.span)
                changed: dict[str, Any] = {group: self._value(value, group, span)}
                model = replace(model, **changed)
        return model, tuple(self.tables)

    def _register(self, register: ir.Register) -> ir.Register:
        update = register.update
        value = self.rewrite(update.value, register.name, register.span)
        return replace(register, update=replace(update, value=value))

    def _part(self, part: Any, attribute: str, prefix: str) -> Any:
        name = part.name if not isinstance(part, ir.Assign) else f"{prefix}{part.variable}"
        return replace(part, **{attribute: self.rewrite(getattr(part, attribute), name, part.span)})

    # Choosing what to tabulate -------------------------------------------------------------------

    def _value(self, value: ir.Expr, name: str, span: Span) -> ir.Expr:
        """Rewrite the value of a declaration. No condition guards it, so its table may take any state."""
        rewritten = self.rewrite(value, name, span)
        if self.costs.of(rewritten) < limits.STATE_TABLE_COST:
            return rewritten
        inlined = self._inlined(rewritten)
        reads = None if inlined is None else state_reads(inlined, self.fields)
        if reads is None:
            return rewritten
        scope = Scope({local for node in walk(rewritten) for local in bound_names(node)})
        variables = tuple(r.variable for r in reads)
        inputs = tuple(ir.Binder(scope.unique(r.variable), r.type) for r in reads)
        table = self.names.derived_table(f"{name}_state_table")
        self.tables.append(DerivedTable(table, inputs, value.type, rewritten, span, variables))
        return ir.ParamRead(value.type, table, reads)

    @overload
    def rewrite(self, node: ir.Expr, name: str, span: Span) -> ir.Expr: ...
    @overload
    def rewrite(self, node: ir.Dist, name: str, span: Span) -> ir.Dist: ...
    def rewrite(self, node: Node, name: str, span: Span) -> Node:
        """Replace the largest slow expressions inside ``node`` that depend on few enough finite inputs."""
        slow = self._slow(node)
        if not slow and self.costs.of(node) < limits.TABLE_COST:
            return node
        if isinstance(node, ir.Expr) and not isinstance(node, ir.Local):
            table = self._table(node, name, span) if slow else self._code_table(node, name, span)
            if table is not None:
                return table
        if isinstance(node, ir.Dist) and not slow:
            pick = self._pick(node, name, span)
            if pick is not None:
                return pick
        return map_children(node, lambda child: self.rewrite(child, name, span))

    def _pick(self, dist: ir.Dist, name: str, span: Span) -> ir.Dist | None:
        """Return ``dist`` with all its values in a table."""
        made = len(self.tables)
        if isinstance(dist, ir.Table) and (weighted := table_draws.weighted(dist)) is not None:
            value = self._code_table(weighted.value, name, span)
            return None if value is None else replace(weighted, value=value)
        if isinstance(dist, ir.UniformSet) and (uniform := table_draws.uniform(dist)) is not None:
            count = self._code_table(uniform.count, f"{name}_count", span)
            value = None if count is None else self._code_table(uniform.value, name, span)
            if count is not None and value is not None:
                return replace(uniform, count=count, value=value)
            del self.tables[made:]
        return None

    def _slow(self, node: Node) -> bool:
        inside = reached((node,), self.functions, self.lets)
        return any(isinstance(inner, ir.Unary | ir.Binary) and inner.op in _SLOW for inner, _ in inside)

    def _table(self, node: ir.Expr, name: str, span: Span) -> ir.ParamRead | None:
        body, inputs = self._formula(node)
        if inputs is None or self._domain(inputs) > max(
            limits.ALWAYS_JOIN_ENTRIES, limits.JOIN_FACTOR * self._parts_domain(node)
        ):
            return None
        return self._add(node, body, inputs, name, span)

    def _code_table(self, node: ir.Expr, name: str, span: Span) -> ir.ParamRead | None:
        """Return a table's read for ``node``, a value that is cheap to compute and cheaper to look up."""
        if not is_finite(node.type):
            return None
        body, inputs = self._over_inputs(node, {})
        if inputs is None or self._domain(inputs) > limits.MAX_CODE_TABLE_ENTRIES * self._positions(inputs):
            return None
        return self._add(node, body, inputs, name, span)

    @staticmethod
    def _positions(inputs: tuple[_Input, ...]) -> int:
        """Return how many values share the inputs of a pick: they are read together."""
        return math.prod(min(size_of(i.binder.type), limits.MAX_POSITIONS) for i in inputs if _is_position(i))

    def _add(
        self, node: ir.Expr, body: ir.Expr, inputs: tuple[_Input, ...], name: str, span: Span
    ) -> ir.ParamRead:
        table = DerivedTable(
            self.names.derived_table(f"{name}_table"), tuple(i.binder for i in inputs), node.type, body, span
        )
        self.tables.append(table)
        return ir.ParamRead(node.type, table.name, tuple(i.read for i in inputs))

    def _parts_domain(self, node: ir.Expr) -> int:
        """Return how many entries the tables of ``node``'s slow parts would have."""
        total = 0
        for child in children(node):
            if isinstance(child, ir.Expr) and self._slow(child):
                inputs = self._formula(child)[1]
                total += limits.MAX_TABLE_ENTRIES if inputs is None else self._domain(inputs)
        return total or limits.MAX_TABLE_ENTRIES

    @staticmethod
    def _domain(inputs: tuple[_Input, ...]) -> int:
        return math.prod(size_of(i.binder.type) for i in inputs)

    # From an expression to a formula of its inputs -----------------------------------------------

    def _formula(self, node: ir.Expr) -> tuple[ir.Expr, tuple[_Input, ...] | None]:
        """Return ``node`` over named inputs; None for the inputs where they are not few and finite.

        The inputs are what ``node`` reads, or else its largest finite parts, such as a distance.
        """
        formula, found = self._over_inputs(node, {})
        if found is None:
            parts: dict[str, ir.Expr] = {}
            formula, found = self._over_inputs(self._set_apart(node, parts), parts)
        return formula, found

    def _over_inputs(
        self, node: ir.Expr, parts: dict[str, ir.Expr]
    ) -> tuple[ir.Expr, tuple[_Input, ...] | None]:
        formula = None if self._reads_what_is_not_finite(node) else self._inlined(node)
        if formula is None:
            return node, None
        inputs: dict[Any, _Input] = {}
        bound = {name for inner in walk(formula) for name in bound_names(inner)}
        if any(free_locals(part) & bound for part in parts.values()):
            return formula, None
        self.tested = {(n.variant, shape(n.operand)) for n in walk(formula) if isinstance(n, ir.IsVariant)}
        if not self._collect(formula, frozenset(), inputs, Scope(set(bound))):
            return formula, None
        # Locals last: loops run over them, and entries that lie together are read together.
        found = tuple(sorted(inputs.values(), key=lambda i: (isinstance(i.read, ir.Local), _is_position(i))))
        if self._domain(found) > limits.MAX_TABLE_ENTRIES:
            return formula, None
        reads = tuple(_Input(substitute(i.read, parts), i.binder) for i in found)
        certain = {shape(inner) for inner in unguarded(formula)}
        if not all(
            shape(i.read) in certain or self.hoisting.is_safe(r.read)
            for i, r in zip(found, reads, strict=True)
        ):
            return formula, None
        return self._replace_reads(formula, inputs), reads

    def _set_apart(self, node: ir.Expr, parts: dict[str, ir.Expr]) -> ir.Expr:
        """Replace the largest finite parts of ``node`` that are not slow by locals, entered in ``parts``."""
        if not isinstance(node, ir.Const) and is_finite(node.type) and not self._slow(node):
            name = node.function if isinstance(node, ir.Call) else "index"
            name = f"{name}%{len(parts)}"  # no local of the model is called so
            parts[name] = node
            return ir.Local(node.type, name)
        return map_children(node, lambda child: self._set_apart(child, parts))

    def _reads_what_is_not_finite(self, node: ir.Expr) -> bool:
        """Return whether a formula reads what no input can be, told without inlining it."""
        free = free_locals(node)
        if any(isinstance(n, ir.Local) and n.name in free and not is_finite(n.type) for n in walk(node)):
            return True
        inside = reached((node,), self.functions, self.lets)
        return any(isinstance(n, ir.StateRead | HistoryRead) and not is_finite(n.type) for n, _ in inside)

    def _inlined(self, node: ir.Expr) -> ir.Expr | None:
        """Return ``node`` without calls and lets; None where that is too large for a table's formula."""
        self.room = limits.MAX_FORMULA
        try:
            return self._inline(node)
        except _TooLarge:
            return None

    def _inline(self, node: ir.Expr) -> ir.Expr:
        self.room -= 1
        if self.room < 0:
            raise _TooLarge
        match node:
            case ir.Call():
                return self._inline(self.inliner.call(node))
            case ir.LetRead(let=name) if not self.lets[name].draws:
                body = self.inliner.let(node)
                assert isinstance(body, ir.Expr)
                return self._inline(body)
        return map_children(node, self._inline)

    def _collect(self, node: Node, bound: frozenset[str], inputs: dict[Any, _Input], scope: Scope) -> bool:
        """Enter the values that ``node`` reads into ``inputs``; say whether all of them are finite inputs."""
        bound |= set(bound_names(node))
        match node:
            case ir.Local(name=name) if name in bound:
                return True
            case ir.Local(name=name):
                return self._enter(node, name.partition("%")[0], inputs, scope)
            case ir.StateRead(variable=name) | ir.LetRead(let=name) | HistoryRead(field=name):
                # A read whose index is bound inside the formula stands for many values, not one.
                if any(
                    isinstance(i, ir.Local) and i.name in bound for part in node.indices for i in walk(part)
                ):
                    return False
                primed = not isinstance(node, HistoryRead) and node.primed
                return self._enter(node, f"{name}_next" if primed else name, inputs, scope)
            case ir.VariantArgument(operand=operand) if not self._tests(node):
                # The variant is tested outside the formula: only its argument is sure to be in range.
                return not free_locals(operand) & bound and self._enter(node, node.variant, inputs, scope)
            case BeliefCall():
                return False
            case ir.ActionRead():
                return False  # an action is a constant of a step: its tests cost nothing
        return all(self._collect(child, bound, inputs, scope) for child in children(node))

    def _tests(self, node: ir.VariantArgument) -> bool:
        return (node.variant, shape(node.operand)) in self.tested

    @staticmethod
    def _enter(node: ir.Expr, name: str, inputs: dict[Any, _Input], scope: Scope) -> bool:
        if not is_finite(node.type):
            return False
        key = shape(node)
        known = inputs.get(key)
        if known is None:
            inputs[key] = _Input(node, ir.Binder(scope.unique(name), node.type))
        else:
            # Conditions may narrow a read's interval in one branch: the table needs all of them.
            inputs[key] = replace(
                known, binder=ir.Binder(known.binder.name, _join(known.binder.type, node.type))
            )
        return True

    def _replace_reads(self, node: ir.Expr, inputs: dict[Any, _Input]) -> ir.Expr:
        if (found := inputs.get(shape(node))) is not None:
            return ir.Local(node.type, found.binder.name)
        return map_children(node, lambda child: self._replace_reads(child, inputs))


def _is_position(value: _Input) -> bool:
    return isinstance(value.read, ir.Local) and value.read.name == POSITION


def _join(a: Type, b: Type) -> Type:
    if isinstance(a, Int) and isinstance(b, Int):
        return Int(max(INT32_MIN, min(a.low, b.low)), min(INT32_MAX, max(a.high, b.high)))
    return a
