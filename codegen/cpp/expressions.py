# SPDX-License-Identifier: Apache-2.0
"""IR expressions as C++: text where C++ has an expression for them, statements before it where not.

A loop (quantifier) or a local (let) becomes statements in front of the expression that uses it, inside the
branch that guards it, so that nothing is evaluated that the model's author has ruled out.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field

from hypgen.codegen.cpp.sink import Sink
from hypgen.codegen.cpp.text import Code, code_of, float32, integer, literal, loop, scalar, stored
from hypgen.codegen.layout.naming import Names
from hypgen.codegen.layout.nodes import ArrayBits, BeliefCall, HistoryRead
from hypgen.codegen.passes.arguments import PARTS, Needs, NeedsAnalysis
from hypgen.codegen.passes.expr_shapes import (
    branches,
    is_float_zero,
    needs_statements,
    plain_loop,
    plain_variant,
)
from hypgen.dsl import ir
from hypgen.dsl.ir.walk import free_locals, negated
from hypgen.dsl.types import INT32_MAX, INT32_MIN, Bool, Enum, Float, Int, Type, low_of, size_of

PRIMARY, UNARY, MULTIPLY, ADD, COMPARE, EQUAL, AND, OR, TERNARY = 100, 90, 80, 70, 60, 55, 40, 30, 20

_OPERATORS = {
    "add": ("+", ADD),
    "sub": ("-", ADD),
    "mul": ("*", MULTIPLY),
    "div": ("/", MULTIPLY),
    "eq": ("==", EQUAL),
    "ne": ("!=", EQUAL),
    "lt": ("<", COMPARE),
    "le": ("<=", COMPARE),
    "gt": (">", COMPARE),
    "ge": (">=", COMPARE),
    "and": ("&&", AND),
    "or": ("||", OR),
}
_ROUNDINGS = {"floor": "floor_to_int", "ceil": "ceil_to_int", "round": "round_to_int"}

Append = Callable[[], None]


@dataclass(frozen=True)
class Context:
    """What printing any expression of a model takes."""

    model: ir.Model
    names: Names
    needs: NeedsAnalysis
    index_types: dict[str, tuple[Type, ...]]  # of params, derived tables and constant arrays, by IR name
    beliefs: Mapping[int, ir.BeliefRead] = field(default_factory=dict)  # those that take a function
    masses: dict[str, str] = field(default_factory=dict)  # fields of Params, by the masses printed so far


class ExprPrinter:
    """Prints the expressions of one generated function into ``code``."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self.names = context.names
        self.code = Code()
        self.scope = context.names.locals()
        self.locals: dict[str, str] = {}

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
                self.code.add(sink(self.text(expr)))

    def _chain(self, expr: ir.If, sink: Sink) -> None:
        """Append ``if .. else if .. else``: what a ``match`` has become."""
        rest: ir.Expr = expr
        head = "if"
        while isinstance(rest, ir.If) and (head == "if" or not needs_statements(rest.condition)):
            with self.block(f"{head} ({self.text(rest.condition)})"):
                self.emit(rest.then, sink)
            if sink.returns:
                self.code.join()
            else:
                head = "else if"
            rest = rest.otherwise
        if sink.returns:
            self.emit(rest, sink)
            return
        with self.block("else"):
            self.emit(rest, sink)

    def branch(self, condition: str, then: Append, otherwise: Append, sink: Sink) -> None:
        """Append ``if``; with ``else`` unless the first branch returns. ``then`` and ``otherwise`` append."""
        with self.block(f"if ({condition})"):
            then()
        if sink.returns:
            self.code.join()
            otherwise()
            return
        with self.block("else"):
            otherwise()

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Put what is added meanwhile into a block; names declared in it are free again behind it."""
        taken = set(self.scope.taken)
        with self.code.block(head):
            yield
        self.scope.taken = taken

    def declare(self, name: str, value: ir.Expr, body: ir.Expr | ir.Dist) -> None:
        """Append the declaration of a let's local, if the body reads it."""
        if name not in free_locals(body):
            return
        if branches(value):
            local = self.scope.unique(name)
            self.code.add(f"{scalar(value.type)} {local}{{}};")
            self.emit(value, Sink(f"{local} = "))
        else:
            text = self.text(value)
            local = self.scope.unique(name)
            self.code.add(f"const {scalar(value.type)} {local} = {text};")
        self.locals[name] = local

    def bind(self, name: str, text: str | None = None) -> str:
        """Let a local stand for ``text``, or for a new C++ local, whose name is given back."""
        self.locals[name] = self.scope.unique(name) if text is None else text
        return self.locals[name]

    @contextmanager
    def loops(self, binders: Sequence[ir.Binder]) -> Iterator[None]:
        """Put what is added meanwhile into loops over the binders, the first outermost."""
        with ExitStack() as stack:
            for b in binders:
                stack.enter_context(self.loop(b, loop(b.type, "{0}")))
            yield
        self.code.join()

    @contextmanager
    def loop(self, binder: ir.Binder, head: str) -> Iterator[None]:
        """Put what is added meanwhile into a loop, whose ``head`` has ``{0}`` for its variable."""
        variable = self.scope.unique(binder.name)
        self.scope.taken.discard(variable)
        with self.block(head.format(variable)):
            self.bind(binder.name)
            if isinstance(binder.type, Bool):
                self.locals[binder.name] = f"({variable} != 0)"
            yield

    # Expressions ---------------------------------------------------------------------------------

    def text(self, expr: ir.Expr, level: int = 0) -> str:
        """Return a C++ expression, in parentheses if it binds less tightly than ``level``."""
        text, own = self._print(expr)
        return f"({text})" if own < level else text

    def _print(self, expr: ir.Expr) -> tuple[str, int]:
        match expr:
            case ir.Const(type=type_, value=value):
                text = literal(value, type_, self.names)
                return text, UNARY if text.startswith("-") else PRIMARY
            case ir.Local(name=name):
                return self.locals[name], PRIMARY
            case ir.ParamRead(param=name, indices=indices):
                cpp = self.names.params.get(name, name)  # a derived table goes by its C++ name
                return f"params.{cpp}{self.subscript(name, indices)}", PRIMARY
            case ir.TableRead(table=name, indices=indices):
                return f"{self.names.tables[name]}({', '.join(self.codes(name, indices))})", PRIMARY
            case ir.StateRead():
                return self._state_read(expr), PRIMARY
            case HistoryRead(field=name, indices=indices):
                return f"history.{self.names.history[name]}({self.arguments(indices)})", PRIMARY
            case BeliefCall(number=number, arguments=arguments):
                needs = self.context.needs.belief(number)
                return self.call(self.names.beliefs[number], needs, arguments, False), PRIMARY
            case ArrayBits(variable=name):
                return f"state.{self.names.bits[name]}()", PRIMARY
            case ir.ActionRead(indices=indices):
                return self._action_read(indices), PRIMARY
            case ir.LetRead(let=name, indices=arguments, primed=primed):
                needs = self.context.needs.let(name)
                return self.call(self.names.lets[name], needs, arguments, primed), PRIMARY
            case ir.Call(function=name, arguments=arguments, primed=primed):
                needs = self.context.needs.function(name)
                return self.call(self.names.functions[name], needs, arguments, primed), PRIMARY
            case ir.ToFloat(operand=ir.Const(value=value)):
                return float32(struct.unpack("<f", struct.pack("<f", value))[0]), UNARY
            case ir.ToFloat(operand=operand):
                return f"static_cast<float>({self.text(operand)})", PRIMARY
            case ir.Unary():
                return self._unary(expr)
            case ir.Binary():
                return self._binary(expr)
            case ir.Clamp():
                return self._clamp(expr), PRIMARY
            case ir.If():
                return self._if(expr)
            case ir.LetIn(name=name, value=value, body=body):
                self.declare(name, value, body)
                return self._print(body)
            case ir.Quantified():
                return self._quantified(expr), PRIMARY
        return self._coded(expr)

    def subscript(self, array: str, indices: Sequence[ir.Expr]) -> str:
        """Return ``[i][j]`` for an array of the model."""
        return "".join(f"[{code}]" for code in self.codes(array, indices))

    def codes(self, array: str, indices: Sequence[ir.Expr]) -> list[str]:
        """Return the indexes of an entry of an array, each counted from 0."""
        types = self.context.index_types[array]
        return [self.code_text(i, t) for i, t in zip(indices, types, strict=True)]

    def code_text(self, expr: ir.Expr, type_: Type) -> str:
        """Return the code from 0 of a value of ``type_``."""
        if isinstance(expr, ir.Const) and isinstance(type_, Int | Bool):
            return str(int(expr.value) - low_of(type_))
        return code_of(self.text(expr, ADD), type_)

    def _state_read(self, expr: ir.StateRead) -> str:
        variable = self.context.model.variable(expr.variable)
        owner = "fixed" if variable.fixed else "next" if expr.primed else "state"
        return f"{owner}.{self.names.variables[expr.variable]}({self.arguments(expr.indices)})"

    def _action_read(self, indices: Sequence[ir.Expr]) -> str:
        action = self.context.model.action
        if not action.indices:
            return self.names.action
        return f"{self.names.action}[{self.flat(indices, action.indices)}]"

    def flat(self, indices: Sequence[ir.Expr], types: Sequence[Type]) -> str:
        """Return the row-major position of an entry."""
        result = ""
        for index, type_ in zip(indices, types, strict=True):
            text = self.code_text(index, type_)
            if result:
                left = f"({result})" if " " in result else result
                text = f"{left} * {size_of(type_)} + {text}"
            result = text
        return result or "0"

    def arguments(self, expressions: Sequence[ir.Expr]) -> str:
        """Return the texts of an argument list."""
        return ", ".join(self.text(e) for e in expressions)

    def call(self, function: str, needs: Needs, arguments: Sequence[ir.Expr], primed: bool) -> str:
        """Return a call; a primed one is given the next state for the state."""
        given = [self.names.action if p == "action" else p for p in PARTS if p in needs]
        if primed:
            given = ["next" if p == "state" else p for p in given]
        return f"{function}({', '.join([*given, *(self.text(a) for a in arguments)])})"

    def _unary(self, expr: ir.Unary) -> tuple[str, int]:
        operand = expr.operand
        match expr.op, operand:
            case "not", ir.Binary(op="eq" | "ne" as op, left=left, right=right):
                return self._binary(ir.Binary(expr.type, "ne" if op == "eq" else "eq", left, right))
            case "not", ir.IsVariant(enum=enum, variant=variant) if plain_variant(enum, variant):
                return self._is_plain(operand, "!="), EQUAL
            case "not", _:
                return f"!{self.text(operand, UNARY)}", UNARY
            case "neg", _:
                text = self.text(operand, UNARY)
                return f"-({text})" if text.startswith("-") else f"-{text}", UNARY
            case op, _ if op in _ROUNDINGS:
                assert isinstance(expr.type, Int)
                bounds = f"{integer(expr.type.low)}, {integer(expr.type.high)}"
                return f"math::{_ROUNDINGS[op]}({self.text(operand)}, {bounds})", PRIMARY
        return f"math::{expr.op}({self._widened(operand)})", PRIMARY

    def _binary(self, expr: ir.Binary) -> tuple[str, int]:
        if expr.op in ("and", "or") and needs_statements(expr.right):
            return self._guarded(expr), PRIMARY
        left, right = expr.left.type, expr.right
        natural = isinstance(left, Int) and left.low >= 0 and isinstance(right, ir.Const) and right.value > 0
        if expr.op in ("floordiv", "mod") and natural:
            # C++ truncates, which is the floor of what is not negative.
            sign = "/" if expr.op == "floordiv" else "%"
            return f"{self.text(expr.left, MULTIPLY)} {sign} {self.text(right, UNARY)}", MULTIPLY
        if expr.op == "sub" and is_float_zero(expr.left):
            return f"math::from_zero({self.text(right)})", PRIMARY
        if expr.op not in _OPERATORS:
            return f"math::{expr.op}({self._widened(expr.left)}, {self._widened(right)})", PRIMARY
        sign, level = _OPERATORS[expr.op]
        # Parentheses that C++ does not need, but its compilers ask for: && in ||, ! and == in ==.
        inner = {OR: EQUAL, EQUAL: ADD, COMPARE: ADD}.get(level, level)
        texts = []
        for position, operand in enumerate((expr.left, right)):
            need = level + 1 if position and level in (ADD, MULTIPLY) else inner
            same = (
                isinstance(operand, ir.Binary)
                and operand.op == expr.op
                and level in (AND, OR)
                and not position
            )
            text = self.text(operand, 0 if same else need)
            if level in (EQUAL, COMPARE) and text.startswith("!"):
                text = f"({text})"
            texts.append(text)
        return f"{texts[0]} {sign} {texts[1]}", level

    def _guarded(self, expr: ir.Binary) -> str:
        """Print ``and`` and ``or`` whose right side takes statements: they run only where they matter."""
        left = self.text(expr.left)
        name = self.scope.unique("holds")
        self.code.add(f"bool {name} = {left};")
        with self.block(f"if ({name})" if expr.op == "and" else f"if (!{name})"):
            self.emit(expr.right, Sink(f"{name} = "))
        self.code.join()
        return name

    def _clamp(self, expr: ir.Clamp) -> str:
        def bound(value: float) -> str:
            return float32(float(value)) if isinstance(expr.type, Float) else integer(int(value))

        text, operand = self._widened(expr.operand), expr.operand.type
        if isinstance(operand, Int) and operand.low >= expr.low:
            return f"math::min({text}, {bound(expr.high)})"
        if isinstance(operand, Int) and operand.high <= expr.high:
            return f"math::max({text}, {bound(expr.low)})"
        return f"math::clamp({text}, {bound(expr.low)}, {bound(expr.high)})"

    def _widened(self, expr: ir.Expr) -> str:
        """Return the text of an operand of a template, which takes C++ types as they are."""
        text = self.text(expr)
        return f"{scalar(expr.type)}{{{text}}}" if self._narrow(expr) else text

    def _narrow(self, expr: ir.Expr) -> bool:
        match expr:
            case ir.ParamRead(type=type_, param=name):
                return name not in self.names.params and stored(type_) != scalar(type_)
            case ir.If(then=then, otherwise=otherwise):
                return self._narrow(then) or self._narrow(otherwise)
            case ir.LetIn(body=body):
                return self._narrow(body)
        return False

    def _if(self, expr: ir.If) -> tuple[str, int]:
        condition = self.text(expr.condition, OR)
        if needs_statements(expr.then, expr.otherwise):
            name = self.scope.unique("chosen")
            self.code.add(f"{scalar(expr.type)} {name}{{}};")
            sink = Sink(f"{name} = ")
            self.branch(
                condition, lambda: self.emit(expr.then, sink), lambda: self.emit(expr.otherwise, sink), sink
            )
            return name, PRIMARY
        then, otherwise = self.text(expr.then, OR), self.text(expr.otherwise, OR)
        return f"{condition} ? {then} : {otherwise}", TERNARY

    def _coded(self, expr: ir.Expr) -> tuple[str, int]:
        """Print what takes values of enums and records apart and puts them together."""
        types, members = self.names.types, self.names.members
        match expr:
            case ir.IsVariant(enum=enum, variant=variant) if plain_variant(enum, variant):
                return self._is_plain(expr, "=="), EQUAL
            case ir.IsVariant(enum=enum, variant=variant, operand=operand):
                test = members[enum.name][f"is {variant}"]
                return f"{types[enum.name]}::{test}({self.text(operand)})", PRIMARY
            case ir.VariantArgument(enum=enum, variant=variant, operand=operand):
                argument = members[enum.name][f"of {variant}"]
                return f"{types[enum.name]}::{argument}({self.text(operand)})", PRIMARY
            case ir.MakeVariant(enum=enum, variant=variant, argument=argument):
                return f"{self.constructor(enum, variant)}({self.text(argument)})", PRIMARY
            case ir.FieldRead(record=record, field=field, operand=operand):
                return f"{types[record.name]}::{members[record.name][field]}({self.text(operand)})", PRIMARY
            case ir.MakeRecord(record=record, values=values):
                make = f"{types[record.name]}::{members[record.name]['make']}"
                return f"{make}({self.arguments(values)})", PRIMARY
        raise TypeError(f"no C++ for {type(expr).__name__}")

    def constructor(self, enum: Enum, variant: str) -> str:
        """Return the name of the function that makes a variant of its argument."""
        return f"{self.names.types[enum.name]}::{self.names.members[enum.name][variant]}"

    def _is_plain(self, test: ir.IsVariant, sign: str) -> str:
        """Return ``operand == Enum::variant``, or with ``!=``, for a variant without an argument."""
        enum = test.enum.name
        constant = f"{self.names.types[enum]}::{self.names.members[enum][test.variant]}"
        return f"{self.text(test.operand, ADD)} {sign} {constant}"

    # Quantifiers ---------------------------------------------------------------------------------

    def _quantified(self, expr: ir.Quantified) -> str:
        match expr.kind:
            case "sum":
                zero = "0.0f" if isinstance(expr.type, Float) else "0"
                return self._accumulate(expr, "total", f"{scalar(expr.type)} {{}} = {zero};", "{} += ")
            case "count":
                return self._accumulate(expr, "count", "std::int32_t {} = 0;", "")
            case "any":
                return self._accumulate(expr, "found", "bool {} = false;", "{} |= ")
            case "all":
                return self._accumulate(expr, "holds", "bool {} = true;", "{} &= ")
        return self._best(expr)

    def _accumulate(self, expr: ir.Quantified, base: str, declaration: str, update: str) -> str:
        name = self.scope.unique(base)
        self.code.add(declaration.format(name))
        leaves = expr.kind in ("any", "all") and not plain_loop(expr)
        with self.loops(expr.binders):
            with ExitStack() as stack:
                if expr.condition is not None:
                    stack.enter_context(self.block(f"if ({self.text(expr.condition)})"))
                if expr.body is None:
                    self.code.add(f"++{name};")
                else:
                    self.emit(expr.body, Sink(update.format(name)))
            self.code.join()
            if leaves and len(expr.binders) == 1:
                self.code.add(f"if ({name}) break;" if expr.kind == "any" else f"if (!{name}) break;")
        return name

    def _best(self, expr: ir.Quantified) -> str:
        """Print ``min max argmin argmax``: the first of equal values stays."""
        assert expr.body is not None
        if isinstance(expr.body.type, Int) and expr.kind in ("min", "max"):
            reached = {"min": expr.body.type.high < INT32_MAX, "max": expr.body.type.low > INT32_MIN}
            if reached[expr.kind]:
                return self._extremum(expr, expr.body)
        best, found = self.scope.unique("best"), self.scope.unique("found")
        picks = expr.kind.startswith("arg")
        value_type = scalar(expr.body.type)
        self.code.add(f"bool {found} = false;")
        self.code.add(f"{value_type} {best}{{}};")
        picked = self.scope.unique("picked") if picks else best
        if picks:
            self.code.add(f"{scalar(expr.type)} {picked}{{}};")
        sign = "<" if expr.kind.endswith("min") else ">"
        with self.loops(expr.binders), ExitStack() as stack:
            if expr.condition is not None:
                stack.enter_context(self.block(f"if ({self.text(expr.condition)})"))
            value = self.scope.unique("candidate")
            self.code.add(f"const {value_type} {value} = {self.text(expr.body)};")
            with self.block(f"if (!{found} || {value} {sign} {best})"):
                self.code.add(f"{found} = true;")
                self.code.add(f"{best} = {value};")
                if picks:
                    self.code.add(f"{picked} = {self.locals[expr.binders[0].name]};")
        first = ir.Local(expr.type, expr.binders[0].name) if picks else expr.body
        self._unless_found(expr, f"!{found}", first, picked)
        return picked

    def _extremum(self, expr: ir.Quantified, body: ir.Expr) -> str:
        """Print ``min max`` of integers without a branch: what none of them reaches stands for no value."""
        best = self.scope.unique("best")
        least = expr.kind == "min"
        none = f"std::numeric_limits<std::int32_t>::{'max' if least else 'min'}()"
        self.code.add(f"std::int32_t {best} = {none};")
        with self.loops(expr.binders), ExitStack() as stack:
            if expr.condition is not None:
                stack.enter_context(self.block(f"if ({self.text(expr.condition)})"))
            value = self.scope.unique("candidate")
            self.code.add(f"const std::int32_t {value} = {self.text(body)};")
            self.code.add(f"{best} = {value} {'<' if least else '>'} {best} ? {value} : {best};")
        self._unless_found(expr, f"{best} == {none}", body, best)
        return best

    def _unless_found(self, expr: ir.Quantified, missing: str, first: ir.Expr, target: str) -> None:
        """Append what the best of no values is."""
        if expr.otherwise is None and expr.condition is None:
            return
        with self.block(f"if ({missing})"):
            for binder in expr.binders:
                self.bind(binder.name, self.first(binder))
            self.emit(first if expr.otherwise is None else expr.otherwise, Sink(f"{target} = "))
        self.code.join()

    def first(self, binder: ir.Binder) -> str:
        """Return the first value of a binder."""
        value = low_of(binder.type)
        return literal(bool(value) if isinstance(binder.type, Bool) else value, binder.type, self.names)
