# SPDX-License-Identifier: Apache-2.0
"""IR expressions as C++: an expression where C++ has one for them, statements before it where not.

A loop (quantifier) or a local (let) becomes statements in front of the expression that uses it, inside the
branch that guards it, so that nothing is evaluated that the model's author has ruled out.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from contextlib import ExitStack

from hypgen.codegen.cpp.body_printer import BodyPrinter
from hypgen.codegen.cpp.sink import Sink, into
from hypgen.codegen.cpp.text import code_of, float32, literal, row_major, scalar, stored
from hypgen.codegen.layout.nodes import ArrayBits, BeliefCall, HistoryRead
from hypgen.codegen.passes.arguments import PARTS, Needs
from hypgen.codegen.passes.expr_shapes import (
    branches,
    is_float_zero,
    needs_statements,
    plain_loop,
    plain_variant,
)
from hypgen.codegen.tree.expr import (
    FALSE,
    TRUE,
    Choice,
    Expr,
    Literal,
    Prefix,
    braces,
    call,
    cast,
    member,
    method,
    not_,
    number,
    of,
    op,
)
from hypgen.codegen.tree.statements import (
    BREAK,
    assign,
    const,
    increment,
    var,
    when,
    zeroed,
)
from hypgen.dsl import ir
from hypgen.dsl.ir.walk import free_locals, negated, shape
from hypgen.dsl.types import INT32_MAX, INT32_MIN, Bool, Enum, Float, Int, Type, low_of

_ARITHMETIC = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_TESTS = {"eq": "==", "ne": "!=", "lt": "<", "le": "<=", "gt": ">", "ge": ">=", "and": "&&", "or": "||"}
_OPERATORS = _ARITHMETIC | _TESTS
_ROUNDINGS = {"floor": "floor_to_int", "ceil": "ceil_to_int", "round": "round_to_int"}

Append = Callable[[], None]


class ExprPrinter(BodyPrinter):
    """Prints the expressions of one generated function into ``code``."""

    # Statements ----------------------------------------------------------------------------------

    def emit(self, expr: ir.Expr, sink: Sink) -> None:
        """Append statements that give ``expr``'s value to ``sink``."""
        match expr:
            case _ if sink.keeps(expr):
                return
            case ir.LetIn(name=name, value=value, body=body):
                self.declare(name, value, body)
                self.emit(body, sink)
            case ir.If(then=then, otherwise=otherwise) if sink.keeps(then) and sink.keeps(otherwise):
                return
            case ir.If(condition=condition, then=then, otherwise=otherwise) if sink.keeps(then):
                self.emit(ir.If(expr.type, negated(condition), otherwise, then), sink)
            case ir.If() if branches(expr) or sink.keeps(expr.otherwise):
                self._chain(expr, sink)
            case _:
                self.code.add(sink(self.expr(expr)))

    def _chain(self, expr: ir.If, sink: Sink) -> None:
        """Append ``if .. else if .. else``: what a ``match`` has become."""
        rest: ir.Expr = expr
        first = True
        while isinstance(rest, ir.If) and (first or not needs_statements(rest.condition)):
            with self.when(self.expr(rest.condition), chained=not first):
                self.emit(rest.then, sink)
            if sink.returns:
                self.code.join()
            else:
                first = False
            rest = rest.otherwise
        if sink.returns:
            self.emit(rest, sink)
            return
        with self.otherwise():
            self.emit(rest, sink)

    def branch(self, condition: Expr, then: Append, otherwise: Append, sink: Sink) -> None:
        """Append ``if``; with ``else`` unless the first branch returns. ``then`` and ``otherwise`` append."""
        with self.when(condition):
            then()
        if sink.returns:
            self.code.join()
            otherwise()
            return
        with self.otherwise():
            otherwise()

    def declare(self, name: str, value: ir.Expr, body: ir.Expr | ir.Dist) -> None:
        """Append the declaration of a let's local, if the body reads it."""
        if name not in free_locals(body):
            return
        if branches(value):
            local = self.scope.unique(name)
            self.code.add(zeroed(scalar(value.type), local))
            self.emit(value, into(local))
        else:
            expr = self.expr(value)
            local = self.scope.unique(name)
            self.code.add(const(scalar(value.type), local, expr))
        self.bind(name, local)

    def once(self, expr: ir.Expr, name: str) -> None:
        """Append a local of that name, or one like it, for a value that does not change."""
        value = self.expr(expr)
        local = self.scope.unique(name)
        self.code.add(const(scalar(expr.type), local, value))
        self.known[shape(expr)] = of(local)

    # Expressions ---------------------------------------------------------------------------------

    def expr(self, expr: ir.Expr) -> Expr:
        """Return a C++ expression, and append what it takes."""
        match expr:
            case ir.Const(type=type_, value=value):
                return literal(value, type_, self.names)
            case ir.Local(name=name):
                return self.locals[name]
            case ir.ParamRead(param=name, indices=indices):
                cpp = self.names.params.get(name, name)  # a derived table goes by its C++ name
                return self.entry(member("params", cpp), name, indices)
            case ir.TableRead(table=name, indices=indices):
                return call(self.names.tables[name], *self.codes(name, indices))
            case ir.StateRead():
                return self._state_read(expr)
            case HistoryRead(field=name, indices=indices):
                return method("history", self.names.history[name], *self.exprs(indices))
            case BeliefCall(number=belief, arguments=arguments):
                needs = self.context.needs.belief(belief)
                return self.call(self.names.beliefs[belief], needs, arguments, False)
            case ArrayBits(variable=name):
                return method("state", self.names.bits[name])
            case ir.ActionRead(indices=indices):
                return self._action_read(indices)
            case ir.LetRead() if shape(expr) in self.known:
                return self.known[shape(expr)]
            case ir.LetRead(let=name, indices=arguments, primed=primed):
                needs = self.context.needs.let(name)
                return self.call(self.names.lets[name], needs, arguments, primed)
            case ir.Call(function=name, arguments=arguments, primed=primed):
                needs = self.context.needs.function(name)
                return self.call(self.names.functions[name], needs, arguments, primed)
            case ir.ToFloat(operand=ir.Const(value=value)):
                return Literal(float32(struct.unpack("<f", struct.pack("<f", value))[0]))
            case ir.ToFloat(operand=operand):
                return cast("float", self.expr(operand))
            case ir.Unary():
                return self._unary(expr)
            case ir.Binary():
                return self._binary(expr)
            case ir.Clamp():
                return self._clamp(expr)
            case ir.If():
                return self._if(expr)
            case ir.LetIn(name=name, value=value, body=body):
                self.declare(name, value, body)
                return self.expr(body)
            case ir.Quantified():
                return self._quantified(expr)
        return self._coded(expr)

    def exprs(self, expressions: Sequence[ir.Expr]) -> list[Expr]:
        """Return C++ expressions, and append what they take."""
        return [self.expr(e) for e in expressions]

    def entry(self, owner: Expr, array: str, indices: Sequence[ir.Expr]) -> Expr:
        """Return ``owner[i][j]``, where ``owner`` holds an array of the model."""
        for code in self.codes(array, indices):
            owner = owner[code]
        return owner

    def codes(self, array: str, indices: Sequence[ir.Expr]) -> list[Expr]:
        """Return the indexes of an entry of an array, each counted from 0."""
        types = self.context.index_types[array]
        return [self.code_expr(i, t) for i, t in zip(indices, types, strict=True)]

    def code_expr(self, expr: ir.Expr, type_: Type) -> Expr:
        """Return the code from 0 of a value of ``type_``."""
        if isinstance(expr, ir.Const) and isinstance(type_, Int | Bool):
            return Literal(str(int(expr.value) - low_of(type_)))
        return code_of(self.expr(expr), type_)

    def _state_read(self, expr: ir.StateRead) -> Expr:
        variable = self.context.model.variable(expr.variable)
        owner = "fixed" if variable.fixed else "next" if expr.primed else "state"
        return method(owner, self.names.variables[expr.variable], *self.exprs(expr.indices))

    def _action_read(self, indices: Sequence[ir.Expr]) -> Expr:
        action = self.context.model.action
        if not action.indices:
            return of(self.names.action)
        return of(self.names.action)[self.flat(indices, action.indices)]

    def flat(self, indices: Sequence[ir.Expr], types: Sequence[Type]) -> Expr:
        """Return the row-major position of an entry."""
        return row_major([self.code_expr(i, t) for i, t in zip(indices, types, strict=True)], types)

    def call(self, function: str, needs: Needs, arguments: Sequence[ir.Expr], primed: bool) -> Expr:
        """Return a call; a primed one is given the next state for the state."""
        given = [self.names.action if p == "action" else p for p in PARTS if p in needs]
        if primed:
            given = ["next" if p == "state" else p for p in given]
        return call(function, *given, *self.exprs(arguments))

    def _unary(self, expr: ir.Unary) -> Expr:
        operand = expr.operand
        match expr.op, operand:
            case "not", ir.Binary(op="eq" | "ne" as sign, left=left, right=right):
                return self._binary(ir.Binary(expr.type, "ne" if sign == "eq" else "eq", left, right))
            case "not", ir.IsVariant(enum=enum, variant=variant) if plain_variant(enum, variant):
                return self._is_plain(operand, "!=")
            case "not", _:
                return not_(self.expr(operand))
            case "neg", _:
                return Prefix("-", self.expr(operand))
            case rounding, _ if rounding in _ROUNDINGS:
                assert isinstance(expr.type, Int)
                function = f"math::{_ROUNDINGS[rounding]}"
                return call(function, self.expr(operand), expr.type.low, expr.type.high)
        return call(f"math::{expr.op}", self._widened(operand))

    def _binary(self, expr: ir.Binary) -> Expr:
        if expr.op in ("and", "or"):
            expr = self.context.order.ordered(expr)
            if needs_statements(expr.right):
                return self._guarded(expr)
        left, right = expr.left.type, expr.right
        natural = isinstance(left, Int) and left.low >= 0 and isinstance(right, ir.Const) and right.value > 0
        if expr.op in ("floordiv", "mod") and natural:
            # C++ truncates, which is the floor of what is not negative.
            return op(self.expr(expr.left), "/" if expr.op == "floordiv" else "%", self.expr(right))
        if expr.op == "sub" and is_float_zero(expr.left):
            return call("math::from_zero", self.expr(right))
        if expr.op not in _OPERATORS:
            return call(f"math::{expr.op}", self._widened(expr.left), self._widened(right))
        return op(self.expr(expr.left), _OPERATORS[expr.op], self.expr(right))

    def _guarded(self, expr: ir.Binary) -> Expr:
        """Give ``and`` and ``or`` whose right side takes statements: they run only where they matter."""
        left = self.expr(expr.left)
        name = self.scope.unique("holds")
        self.code.add(var("bool", name, left))
        with self.when(of(name) if expr.op == "and" else not_(name)):
            self.emit(expr.right, into(name))
        self.code.join()
        return of(name)

    def _clamp(self, expr: ir.Clamp) -> Expr:
        def bound(value: float) -> Expr:
            return Literal(float32(float(value))) if isinstance(expr.type, Float) else number(int(value))

        value, operand = self._widened(expr.operand), expr.operand.type
        if isinstance(operand, Int) and operand.low >= expr.low:
            return call("math::min", value, bound(expr.high))
        if isinstance(operand, Int) and operand.high <= expr.high:
            return call("math::max", value, bound(expr.low))
        return call("math::clamp", value, bound(expr.low), bound(expr.high))

    def _widened(self, expr: ir.Expr) -> Expr:
        """Return an operand of a template, which takes C++ types as they are."""
        value = self.expr(expr)
        return braces(scalar(expr.type), value) if self._narrow(expr) else value

    def _narrow(self, expr: ir.Expr) -> bool:
        match expr:
            case ir.ParamRead(type=type_, param=name):
                return name not in self.names.params and stored(type_) != scalar(type_)
            case ir.If(then=then, otherwise=otherwise):
                return self._narrow(then) or self._narrow(otherwise)
            case ir.LetIn(body=body):
                return self._narrow(body)
        return False

    def _if(self, expr: ir.If) -> Expr:
        condition = self.expr(expr.condition)
        if needs_statements(expr.then, expr.otherwise):
            name = self.scope.unique("chosen")
            self.code.add(zeroed(scalar(expr.type), name))
            sink = into(name)
            self.branch(
                condition, lambda: self.emit(expr.then, sink), lambda: self.emit(expr.otherwise, sink), sink
            )
            return of(name)
        return Choice(condition, self.expr(expr.then), self.expr(expr.otherwise))

    def _coded(self, expr: ir.Expr) -> Expr:
        """Return what takes values of enums and records apart and puts them together."""
        types, members = self.names.types, self.names.members
        match expr:
            case ir.IsVariant(enum=enum, variant=variant) if plain_variant(enum, variant):
                return self._is_plain(expr, "==")
            case ir.IsVariant(enum=enum, variant=variant, operand=operand):
                return call(self.constructor(enum, f"is {variant}"), self.expr(operand))
            case ir.VariantArgument(enum=enum, variant=variant, operand=operand):
                return call(self.constructor(enum, f"of {variant}"), self.expr(operand))
            case ir.MakeVariant(enum=enum, variant=variant, argument=argument):
                return call(self.constructor(enum, variant), self.expr(argument))
            case ir.FieldRead(record=record, field=field, operand=operand):
                return call(f"{types[record.name]}::{members[record.name][field]}", self.expr(operand))
            case ir.MakeRecord(record=record, values=values):
                make = f"{types[record.name]}::{members[record.name]['make']}"
                return call(make, *self.exprs(values))
        raise TypeError(f"no C++ for {type(expr).__name__}")

    def constructor(self, enum: Enum, variant: str) -> str:
        """Return the name of a variant: a constant, or the function that makes it of its argument."""
        return f"{self.names.types[enum.name]}::{self.names.members[enum.name][variant]}"

    def _is_plain(self, test: ir.IsVariant, sign: str) -> Expr:
        """Return ``operand == Enum::variant``, or with ``!=``, for a variant without an argument."""
        return op(self.expr(test.operand), sign, Literal(self.constructor(test.enum, test.variant)))

    # Quantifiers ---------------------------------------------------------------------------------

    def _quantified(self, expr: ir.Quantified) -> Expr:
        match expr.kind:
            case "sum":
                zero = Literal("0.0f") if isinstance(expr.type, Float) else number(0)
                return self._accumulate(expr, "total", scalar(expr.type), zero, "+=")
            case "count":
                return self._accumulate(expr, "count", "std::int32_t", number(0), "")
            case "any":
                return self._accumulate(expr, "found", "bool", FALSE, "|=")
            case "all":
                return self._accumulate(expr, "holds", "bool", TRUE, "&=")
        return self._best(expr)

    def _accumulate(self, expr: ir.Quantified, base: str, type_: str, start: Expr, update: str) -> Expr:
        name = self.scope.unique(base)
        self.code.add(var(type_, name, start))
        leaves = expr.kind in ("any", "all") and not plain_loop(expr)
        with self.loops(expr.binders):
            with ExitStack() as stack:
                if expr.condition is not None:
                    stack.enter_context(self.when(self.expr(expr.condition)))
                if expr.body is None:
                    self.code.add(increment(name))
                else:
                    self.emit(expr.body, into(name, update))
            self.code.join()
            if leaves and len(expr.binders) == 1:
                self.code.add(when(of(name) if expr.kind == "any" else not_(name), BREAK))
        return of(name)

    def _best(self, expr: ir.Quantified) -> Expr:
        """Give ``min max argmin argmax``: the first of equal values stays."""
        assert expr.body is not None
        if isinstance(expr.body.type, Int) and expr.kind in ("min", "max"):
            reached = {"min": expr.body.type.high < INT32_MAX, "max": expr.body.type.low > INT32_MIN}
            if reached[expr.kind]:
                return self._extremum(expr, expr.body)
        picks = expr.kind.startswith("arg")
        if picks and isinstance(expr.body, ir.Const):
            return self._first_match(expr)
        best, found = self.scope.unique("best"), self.scope.unique("found")
        value_type = scalar(expr.body.type)
        self.code.add(var("bool", found, FALSE))
        self.code.add(zeroed(value_type, best))
        picked = self.scope.unique("picked") if picks else best
        if picks:
            self.code.add(zeroed(scalar(expr.type), picked))
        sign = "<" if expr.kind.endswith("min") else ">"
        with self.loops(expr.binders), ExitStack() as stack:
            if expr.condition is not None:
                stack.enter_context(self.when(self.expr(expr.condition)))
            value = self.scope.unique("candidate")
            self.code.add(const(value_type, value, self.expr(expr.body)))
            with self.when(op(not_(found), "||", op(value, sign, best))):
                self.code.add(assign(found, TRUE))
                self.code.add(assign(best, value))
                if picks:
                    self.code.add(assign(picked, self.locals[expr.binders[0].name]))
        first = ir.Local(expr.type, expr.binders[0].name) if picks else expr.body
        self._unless_found(expr, not_(found), first, picked)
        return of(picked)

    def _first_match(self, expr: ir.Quantified) -> Expr:
        """Give ``argmin argmax`` of a constant: the first value that fulfils the condition."""
        [binder] = expr.binders
        found, picked = self.scope.unique("found"), self.scope.unique("picked")
        self.code.add(var("bool", found, FALSE))
        self.code.add(zeroed(scalar(expr.type), picked))
        with self.loops(expr.binders), ExitStack() as stack:
            if expr.condition is not None:
                stack.enter_context(self.when(self.expr(expr.condition)))
            self.code.add(assign(found, TRUE))
            self.code.add(assign(picked, self.locals[binder.name]))
            self.code.add(BREAK)
        self._unless_found(expr, not_(found), ir.Local(expr.type, binder.name), picked)
        return of(picked)

    def _extremum(self, expr: ir.Quantified, body: ir.Expr) -> Expr:
        """Give ``min max`` of integers without a branch: what none of them reaches stands for no value."""
        best = self.scope.unique("best")
        least = expr.kind == "min"
        none = call(Literal(f"std::numeric_limits<std::int32_t>::{'max' if least else 'min'}"))
        self.code.add(var("std::int32_t", best, none))
        with self.loops(expr.binders), ExitStack() as stack:
            if expr.condition is not None:
                stack.enter_context(self.when(self.expr(expr.condition)))
            value = self.scope.unique("candidate")
            self.code.add(const("std::int32_t", value, self.expr(body)))
            self.code.add(assign(best, Choice(op(value, "<" if least else ">", best), of(value), of(best))))
        self._unless_found(expr, op(best, "==", none), body, best)
        return of(best)

    def _unless_found(self, expr: ir.Quantified, missing: Expr, first: ir.Expr, target: str) -> None:
        """Append what the best of no values is."""
        if expr.otherwise is None and expr.condition is None:
            return
        with self.when(missing):
            for binder in expr.binders:
                self.bind(binder.name, self.first(binder))
            self.emit(first if expr.otherwise is None else expr.otherwise, into(target))
        self.code.join()

    def first(self, binder: ir.Binder) -> Expr:
        """Return the first value of a binder."""
        value = low_of(binder.type)
        return literal(bool(value) if isinstance(binder.type, Bool) else value, binder.type, self.names)
