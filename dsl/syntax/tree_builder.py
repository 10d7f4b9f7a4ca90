# SPDX-License-Identifier: Apache-2.0
"""From lark's parse tree to the syntax tree of ``ast``, one method for each rule of the grammar."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from lark import Token, Tree

from hypgen.dsl.messages import e01_syntax
from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Source, Span
from hypgen.dsl.syntax import ast

QUANTIFIERS = (
    "sum",
    "any",
    "all",
    "count",
    "min",
    "max",
    "argmin",
    "argmax",
    "uniform",
    "weighted",
    "distance",
)
_WITHOUT_BODY = ("count", "uniform", "distance")
_MAX_DIGITS = 18
_LIBRARY_ITEMS = (ast.Import, ast.Const, ast.TypeAlias, ast.EnumDecl, ast.RecordDecl, ast.Function)


@dataclass(frozen=True)
class _FirstLook(ast.Observe):
    """``observe name: type at start rhs``, in an element short for a variable that never changes."""

    def placed(self) -> list[ast.Item]:
        """Return the visible variable, whose value is seen at the start, and its init."""
        variable = ast.Variable(self.span, True, True, self.name, self.type)
        return [variable, ast.Init(self.span, self.name, self.rhs)]


def build(tree: Tree[Token], source: Source) -> tuple[Any, list[Diagnostic]]:
    """Return the syntax tree of a parse tree, and what is wrong with it beyond the grammar."""
    builder = _Builder(source.name)
    built: dict[int, Any] = {}
    for node in tree.iter_subtrees():  # children first; a loop, because chains of operators nest deeply
        children = [built[id(c)] if isinstance(c, Tree) else c for c in node.children]
        built[id(node)] = getattr(builder, str(node.data))(builder.span_of(node), *children)
    return built[id(tree)], builder.diagnostics


def _flat(members: Iterable[Any]) -> tuple[Any, ...]:
    """Splice the lists that rules with several names give, and drop what was not built."""
    result: list[Any] = []
    for member in members:
        if isinstance(member, list):
            result.extend(member)
        elif member is not None:
            result.append(member)
    return tuple(result)


def _called(item: ast.Item) -> str:
    """Return what an item is, in the words of the language."""
    match item:
        case ast.Element(_, name):
            return f"the element '{name}'"
        case ast.Setting(_, kind):
            return f"a {kind}"
        case ast.Condition(_, kind):
            return f"'{kind} when'"
        case ast.Observe():
            return "'observe'"
    return f"'{type(item).__name__.lower()}'"


class _Builder:
    """Makes the node of each rule from its span and its children's nodes; tokens arrive as they are."""

    def __init__(self, file: str) -> None:
        self.file_name = file
        self.diagnostics: list[Diagnostic] = []

    def span_of(self, piece: Tree[Token] | Token) -> Span:
        """Return the span of a tree or a token."""
        at: Any = piece.meta if isinstance(piece, Tree) else piece
        if isinstance(piece, Tree) and at.empty:
            return Span(self.file_name, 1, 1, 1, 1)
        return Span(self.file_name, at.line, at.column, at.end_line, at.end_column)

    def _named(self, span: Span, names: list[Token]) -> list[tuple[Span, str]]:
        """Give a lone name the whole declaration's span, and each of several names its own."""
        return [(span if len(names) == 1 else self.span_of(n), str(n)) for n in names]

    # Files and items -----------------------------------------------------------------------------

    def file(self, _: Span, content: Any) -> Any:
        return content

    def expression(self, _: Span, expr: ast.Expr) -> ast.Expr:
        return expr

    def model_file(self, span: Span, name: Token, *items: Any) -> ast.ModelFile:
        for item in items:
            if isinstance(item, _FirstLook):
                self.diagnostics.append(e01_syntax.first_look_outside_element(item.name, item.span))
        return ast.ModelFile(span, str(name), _flat(items))

    def library_file(self, span: Span, name: Token, *items: Any) -> ast.LibraryFile:
        for item in _flat(items):
            if not isinstance(item, _LIBRARY_ITEMS):
                self.diagnostics.append(e01_syntax.foreign_to_library(_called(item), item.span))
        return ast.LibraryFile(span, str(name), _flat(items))

    def instance_file(
        self, span: Span, name: Token, model: Token, *settings: ast.Assignment
    ) -> ast.InstanceFile:
        return ast.InstanceFile(span, str(name), model[1:-1], settings, self.span_of(model))

    def assignment(self, span: Span, name: Token, value: ast.Expr) -> ast.Assignment:
        return ast.Assignment(span, str(name), value)

    def import_(self, span: Span, path: Token) -> ast.Import:
        return ast.Import(span, path[1:-1], self.span_of(path))

    def const(self, span: Span, name: Token, type_: ast.TypeExpr, value: ast.Expr) -> ast.Const:
        return ast.Const(span, str(name), type_, value)

    def param(self, span: Span, name: Token, type_: ast.TypeExpr, default: ast.Expr | None) -> ast.Param:
        return ast.Param(span, str(name), type_, default)

    def type_alias(self, span: Span, name: Token, type_: ast.TypeExpr) -> ast.TypeAlias:
        return ast.TypeAlias(span, str(name), type_)

    def enum(self, span: Span, name: Token, *variants: ast.VariantDecl) -> ast.EnumDecl:
        return ast.EnumDecl(span, str(name), variants)

    def variant(
        self, span: Span, name: Token, argument: ast.TypeExpr | None, glyph: Token | None
    ) -> ast.VariantDecl:
        return ast.VariantDecl(span, str(name), argument, None if glyph is None else glyph[1:-1])

    def record(self, span: Span, name: Token, *fields: list[ast.FieldDecl]) -> ast.RecordDecl:
        return ast.RecordDecl(span, str(name), _flat(fields))

    def fields(self, span: Span, names: list[Token], type_: ast.TypeExpr) -> list[ast.FieldDecl]:
        return [ast.FieldDecl(at, name, type_) for at, name in self._named(span, names)]

    def names(self, _: Span, *names: Token) -> list[Token]:
        return list(names)

    def function(
        self, span: Span, name: Token, formals: tuple[ast.FieldDecl, ...], type_: ast.TypeExpr, rhs: ast.Rhs
    ) -> ast.Function:
        return ast.Function(span, str(name), formals, type_, rhs)

    def formals(self, _: Span, *formals: ast.FieldDecl | None) -> tuple[ast.FieldDecl, ...]:
        return _flat(formals)

    def formal(self, span: Span, name: Token, type_: ast.TypeExpr) -> ast.FieldDecl:
        return ast.FieldDecl(span, str(name), type_)

    def action(self, span: Span, name: Token, type_: ast.TypeExpr) -> ast.Action:
        return ast.Action(span, str(name), type_)

    def setting(self, span: Span, kind: Token, value: ast.Expr) -> ast.Setting:
        return ast.Setting(span, str(kind), value)

    def condition(self, span: Span, kind: Token, condition: ast.Expr) -> ast.Condition:
        return ast.Condition(span, str(kind), condition)

    def element(
        self, span: Span, name: Token, binders: tuple[ast.Binder, ...] | None, *members: Any
    ) -> ast.Element:
        if binders is not None and len(binders) > 1:
            indexes = [(b.name, b.type.name if isinstance(b.type, ast.TypeName) else "..") for b in binders]
            self.diagnostics.append(e01_syntax.several_indexes(name, indexes, binders[1].span))
        binder = None if binders is None else binders[0]
        placed = [m.placed() if isinstance(m, _FirstLook) else m for m in members]
        return ast.Element(span, str(name), binder, _flat(placed))

    def policy(self, span: Span, name: Token, rhs: ast.Rhs) -> ast.Policy:
        return ast.Policy(span, str(name), rhs)

    def policy_block(self, span: Span, name: Token, *parts: Any) -> ast.Policy:
        return ast.Policy(span, str(name), parts[-1], parts[:-1])

    def memory(self, span: Span, name: Token, type_: ast.TypeExpr, first: ast.Expr) -> ast.Memory:
        return ast.Memory(span, str(name), type_, first)

    def bound(self, span: Span, name: Token, value: ast.Expr) -> ast.Bound:
        return ast.Bound(span, str(name), value)

    def invariant(self, span: Span, condition: ast.Expr) -> ast.Invariant:
        return ast.Invariant(span, condition)

    def draw(
        self,
        span: Span,
        name: Token,
        binders: tuple[ast.Binder, ...] | None,
        where: ast.Expr | None,
        shape: Token,
        *fields: ast.NewField | None,
    ) -> ast.Draw:
        return ast.Draw(span, str(name), binders or (), where, str(shape), self.span_of(shape), _flat(fields))

    def observe(
        self, span: Span, name: Token, type_: ast.TypeExpr, at_start: bool | None, rhs: ast.Rhs
    ) -> ast.Observe:
        return (_FirstLook if at_start else ast.Observe)(span, str(name), type_, rhs)

    def moment(self, span: Span, *words: Token) -> bool:
        if words != ("at", "start"):
            self.diagnostics.append(e01_syntax.unknown_moment(" ".join(words), span))
        return True

    def reward(self, span: Span, name: Token, value: ast.Expr) -> ast.Reward:
        return ast.Reward(span, str(name), value)

    def variables(
        self, span: Span, visibility: Token, fixed: Token | None, names: list[Token], type_: ast.TypeExpr
    ) -> list[ast.Variable]:
        visible = visibility == "visible"
        return [ast.Variable(at, visible, fixed is not None, n, type_) for at, n in self._named(span, names)]

    def init(self, span: Span, name: Token, rhs: ast.Rhs) -> ast.Init:
        return ast.Init(span, str(name), rhs)

    def let(self, span: Span, name: Token, type_: ast.TypeExpr | None, rhs: ast.Rhs) -> ast.Let:
        return ast.Let(span, str(name), type_, rhs)

    def update(self, span: Span, name: Token, rhs: ast.Rhs) -> ast.Update:
        return ast.Update(span, str(name), rhs)

    def rhs(self, span: Span, sign: Token, expr: ast.Expr) -> ast.Rhs:
        return ast.Rhs(span, sign == "~", expr)

    # Types ---------------------------------------------------------------------------------------

    def array_type(self, span: Span, element: ast.TypeExpr, *indices: ast.TypeExpr) -> ast.TypeArray:
        return ast.TypeArray(span, element, indices)

    def type_name(self, span: Span, name: Token) -> ast.TypeName:
        return ast.TypeName(span, str(name))

    def float_unit(self, span: Span, name: Token, unit: str) -> ast.TypeName:
        return ast.TypeName(span, str(name), unit)

    def unit(self, _: Span, *parts: Token | None) -> str:
        return "".join(str(p) for p in parts if p is not None)

    def range_type(self, span: Span, low: ast.Expr, high: ast.Expr) -> ast.TypeRange:
        return ast.TypeRange(span, low, high)

    def binder(self, span: Span, name: Token, type_: ast.TypeExpr) -> ast.Binder:
        return ast.Binder(span, str(name), type_)

    def binders(self, _: Span, *binders: ast.Binder) -> tuple[ast.Binder, ...]:
        return binders

    # Expressions ---------------------------------------------------------------------------------

    def if_(self, span: Span, condition: ast.Expr, then: ast.Expr, otherwise: ast.Expr) -> ast.If:
        return ast.If(span, condition, then, otherwise)

    def let_in(
        self, span: Span, name: Token, type_: ast.TypeExpr | None, rhs: ast.Rhs, body: ast.Expr
    ) -> ast.LetIn:
        return ast.LetIn(span, str(name), rhs.expr, body, rhs.draw, type_)

    def binary(self, span: Span, left: ast.Expr, op: Token, right: ast.Expr) -> ast.Binary:
        return ast.Binary(span, str(op), left, right)

    def unary(self, span: Span, op: Token, operand: ast.Expr) -> ast.Unary:
        return ast.Unary(span, str(op), operand)

    def prime(self, span: Span, operand: ast.Expr) -> ast.Prime:
        return ast.Prime(span, operand)

    def member(self, span: Span, operand: ast.Expr, name: Token) -> ast.Member:
        return ast.Member(span, operand, str(name))

    def index(self, span: Span, operand: ast.Expr, *indices: ast.Expr) -> ast.Index:
        return ast.Index(span, operand, indices)

    def is_variant(self, span: Span, operand: ast.Expr, variant: Token) -> ast.Is:
        return ast.Is(span, operand, str(variant))

    def new_field(self, span: Span, name: Token, value: ast.Expr) -> ast.NewField:
        return ast.NewField(span, str(name), value)

    def changed(self, span: Span, operand: ast.Expr, *fields: ast.NewField | None) -> ast.With:
        return ast.With(span, operand, _flat(fields))

    def integer(self, span: Span, digits: Token) -> ast.Literal:
        return ast.Literal(span, self._integer(span, digits))

    def _integer(self, span: Span, digits: Token) -> int:
        if len(digits) <= _MAX_DIGITS:
            return int(digits)
        self._number_too_large(span)
        return 0

    def _number_too_large(self, span: Span) -> None:
        self.diagnostics.append(e01_syntax.number_too_large(span))

    def real(self, span: Span, digits: Token) -> ast.Literal:
        value = float(digits)
        if math.isinf(value):
            self._number_too_large(span)
            value = 0.0
        # A number that double takes for 0 may have an exponent of any size.
        return ast.Literal(span, value, Fraction(digits) if value else None)

    def string(self, span: Span, text: Token) -> ast.Literal:
        return ast.Literal(span, text[1:-1])

    def boolean(self, span: Span, word: Token) -> ast.Literal:
        return ast.Literal(span, word == "true")

    def name(self, span: Span, name: Token) -> ast.Name:
        return ast.Name(span, str(name))

    def call(self, span: Span, name: Token, *arguments: ast.Expr | None) -> ast.Call:
        return ast.Call(span, str(name), _flat(arguments))

    def quantified(
        self,
        span: Span,
        kind: Token,
        binders: tuple[ast.Binder, ...],
        where: ast.Expr | None,
        body: ast.Expr | None,
        otherwise: ast.Expr | None,
    ) -> ast.Quantified:
        at = self.span_of(kind)
        if kind not in QUANTIFIERS:
            self.diagnostics.append(e01_syntax.unknown_quantifier(kind, QUANTIFIERS, at))
        elif body is None and kind not in _WITHOUT_BODY and not (kind == "any" and where is not None):
            self.diagnostics.append(e01_syntax.missing_body(kind, span))
        return ast.Quantified(span, str(kind), binders, where, body, otherwise)

    def where(self, _: Span, condition: ast.Expr | None) -> ast.Expr | None:
        return condition

    body = otherwise = where

    def array(self, span: Span, *items: ast.Expr | None) -> ast.ArrayLiteral:
        return ast.ArrayLiteral(span, _flat(items))

    def comprehension(self, span: Span, binders: tuple[ast.Binder, ...], body: ast.Expr) -> ast.Comprehension:
        return ast.Comprehension(span, binders, body)

    def table(self, span: Span, *parts: Any) -> ast.TableLiteral:
        """Take weights as pairs; a lone expression is the rest."""
        entries = tuple(p for p in parts if isinstance(p, tuple))
        rest = next((p for p in parts if isinstance(p, ast.Expr)), None)
        return ast.TableLiteral(span, entries, rest)

    def weight(self, _: Span, value: ast.Expr, probability: ast.Expr) -> tuple[ast.Expr, ast.Expr]:
        return value, probability

    def rest(self, _: Span, value: ast.Expr) -> ast.Expr:
        return value

    def match(self, span: Span, scrutinee: ast.Expr, *arms: ast.Arm) -> ast.Match:
        return ast.Match(span, scrutinee, arms)

    def arm(self, span: Span, *parts: Any) -> ast.Arm:
        return ast.Arm(span, tuple(parts[:-1]), parts[-1])

    def variant_pattern(self, span: Span, name: Token, argument: Token | None) -> ast.Pattern:
        return ast.Pattern(span, name=str(name), argument=None if argument is None else str(argument))

    def integer_pattern(self, span: Span, *digits: Token) -> ast.Pattern:
        value = self._integer(span, digits[-1])
        return ast.Pattern(span, value=-value if len(digits) == 2 else value)

    def boolean_pattern(self, span: Span, word: Token) -> ast.Pattern:
        return ast.Pattern(span, name=str(word), value=word == "true")

    def else_pattern(self, span: Span) -> ast.Pattern:
        return ast.Pattern(span)
