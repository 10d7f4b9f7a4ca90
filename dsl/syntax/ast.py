# SPDX-License-Identifier: Apache-2.0
"""The syntax tree: what the author wrote, with spans and before any name is resolved."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction

from hypgen.dsl.messages.source import Span


@dataclass(frozen=True)
class Node:
    """Base of all nodes; ``span`` covers the node's whole text."""

    span: Span


# Types -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class TypeExpr(Node):
    """Base of type expressions."""


@dataclass(frozen=True)
class TypeName(TypeExpr):
    """A named type; ``bool``, ``prob``, ``int`` and ``float`` included."""

    name: str
    unit: str | None = None


@dataclass(frozen=True)
class TypeRange(TypeExpr):
    """``low .. high``, both included, constant expressions."""

    low: Expr
    high: Expr


@dataclass(frozen=True)
class TypeArray(TypeExpr):
    """``element[Index, ...]``."""

    element: TypeExpr
    indices: tuple[TypeExpr, ...]


# Expressions -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Expr(Node):
    """Base of expressions; distributions are expressions too."""


@dataclass(frozen=True)
class Literal(Expr):
    """``3``, ``0.5``, ``true`` or a string; ``exact`` is the number that a decimal says."""

    value: bool | int | float | str
    exact: Fraction | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Name(Expr):
    """A bare name."""

    name: str


@dataclass(frozen=True)
class Unary(Expr):
    """``-x`` or ``not x``."""

    op: str
    operand: Expr


@dataclass(frozen=True)
class Binary(Expr):
    """``+ - * / // % ** == != < <= > >= and or``."""

    op: str
    left: Expr
    right: Expr


@dataclass(frozen=True)
class Prime(Expr):
    """``e'``: every state read in ``e`` is of the next state."""

    operand: Expr


@dataclass(frozen=True)
class Member(Expr):
    """``e.name``: an element's variable or let, a record's field, or an enum's variant."""

    operand: Expr
    name: str


@dataclass(frozen=True)
class Index(Expr):
    """``e[i, ...]``."""

    operand: Expr
    indices: tuple[Expr, ...]


@dataclass(frozen=True)
class Call(Expr):
    """``f(x, ...)``: a function, a distribution, a record or a variant with an argument."""

    name: str
    arguments: tuple[Expr, ...]


@dataclass(frozen=True)
class Is(Expr):
    """``e is variant``, of any argument."""

    operand: Expr
    variant: str


@dataclass(frozen=True)
class NewField(Node):
    """``name = e`` behind ``with``."""

    name: str
    value: Expr


@dataclass(frozen=True)
class With(Expr):
    """``e with { name = value, ... }``: a record with some of its fields changed."""

    operand: Expr
    fields: tuple[NewField, ...]


@dataclass(frozen=True)
class Binder(Node):
    """``name in Type``."""

    name: str
    type: TypeExpr


@dataclass(frozen=True)
class Quantified(Expr):
    """``sum(r in Rock where c: e else e2)``, ``any all count min max argmin argmax uniform weighted``."""

    kind: str
    binders: tuple[Binder, ...]
    where: Expr | None
    body: Expr | None
    otherwise: Expr | None


@dataclass(frozen=True)
class If(Expr):
    """``if c then a else b``."""

    condition: Expr
    then: Expr
    otherwise: Expr


@dataclass(frozen=True)
class LetIn(Expr):
    """``let x [: type] = e in body``, or ``let x [: type] ~ d in body`` (``draw`` True)."""

    name: str
    value: Expr
    body: Expr
    draw: bool = False
    type: TypeExpr | None = None


@dataclass(frozen=True)
class Pattern(Node):
    """One alternative of an arm: ``else`` (name and value None), a variant or boolean name with an optional
    name for its argument, or an integer.
    """

    name: str | None = None
    argument: str | None = None
    value: int | bool | None = None

    @property
    def is_else(self) -> bool:
        """Return whether this is the ``else`` pattern."""
        return self.name is None and self.value is None


@dataclass(frozen=True)
class Arm(Node):
    """``p | q => e``."""

    patterns: tuple[Pattern, ...]
    body: Expr


@dataclass(frozen=True)
class Match(Expr):
    """``match e { arms }``."""

    scrutinee: Expr
    arms: tuple[Arm, ...]


@dataclass(frozen=True)
class ArrayLiteral(Expr):
    """``[a, b, ...]``; arrays of more than one index nest."""

    items: tuple[Expr, ...]


@dataclass(frozen=True)
class Comprehension(Expr):
    """``[i in T, j in U: e]``."""

    binders: tuple[Binder, ...]
    body: Expr


@dataclass(frozen=True)
class TableLiteral(Expr):
    """``{value: weight, ..., else value}``, a distribution."""

    entries: tuple[tuple[Expr, Expr], ...]
    rest: Expr | None


# Items -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Item(Node):
    """Base of declarations."""


@dataclass(frozen=True)
class Rhs(Node):
    """The right side of a definition: ``= e`` (``draw`` False) or ``~ d`` (``draw`` True)."""

    draw: bool
    expr: Expr


@dataclass(frozen=True)
class Import(Item):
    """``import "path"``; ``path_span`` covers the quoted path."""

    path: str
    path_span: Span


@dataclass(frozen=True)
class Const(Item):
    """``const name: type = value``."""

    name: str
    type: TypeExpr
    value: Expr


@dataclass(frozen=True)
class Param(Item):
    """``param name: type [= default]``."""

    name: str
    type: TypeExpr
    default: Expr | None


@dataclass(frozen=True)
class TypeAlias(Item):
    """``type Name = type``."""

    name: str
    type: TypeExpr


@dataclass(frozen=True)
class VariantDecl(Node):
    """A variant of an enum; ``argument`` names its argument's type, ``glyph`` is for grid literals."""

    name: str
    argument: TypeExpr | None
    glyph: str | None


@dataclass(frozen=True)
class EnumDecl(Item):
    """``enum Name { variants }``."""

    name: str
    variants: tuple[VariantDecl, ...]


@dataclass(frozen=True)
class FieldDecl(Node):
    """A field of a record; ``a, b: T`` gives two."""

    name: str
    type: TypeExpr


@dataclass(frozen=True)
class RecordDecl(Item):
    """``record Name { fields }``."""

    name: str
    fields: tuple[FieldDecl, ...]


@dataclass(frozen=True)
class Function(Item):
    """``fn name(formals): type rhs``."""

    name: str
    formals: tuple[FieldDecl, ...]
    type: TypeExpr
    rhs: Rhs


@dataclass(frozen=True)
class Action(Item):
    """``action name: type``."""

    name: str
    type: TypeExpr


@dataclass(frozen=True)
class Setting(Item):
    """``discount e`` or ``horizon e`` (``kind``)."""

    kind: str
    value: Expr


@dataclass(frozen=True)
class Condition(Item):
    """``terminal when e``, ``legal when e`` or ``success when e`` (``kind``)."""

    kind: str
    condition: Expr


@dataclass(frozen=True)
class Variable(Item):
    """``visible|hidden [fixed] a, b: type`` gives one node a name."""

    visible: bool
    fixed: bool
    name: str
    type: TypeExpr


@dataclass(frozen=True)
class Init(Item):
    """``init name rhs``."""

    name: str
    rhs: Rhs


@dataclass(frozen=True)
class Let(Item):
    """``let name [: type] rhs`` of an element."""

    name: str
    type: TypeExpr | None
    rhs: Rhs


@dataclass(frozen=True)
class Update(Item):
    """``name' rhs``."""

    name: str
    rhs: Rhs


@dataclass(frozen=True)
class Observe(Item):
    """``observe name: type rhs``."""

    name: str
    type: TypeExpr
    rhs: Rhs


@dataclass(frozen=True)
class Reward(Item):
    """``reward name = e``."""

    name: str
    value: Expr


@dataclass(frozen=True)
class Element(Item):
    """``element name[i in T] { members }``."""

    name: str
    binder: Binder | None
    members: tuple[Item, ...]


@dataclass(frozen=True)
class Memory(Item):
    """``memory name: type = first`` of a policy."""

    name: str
    type: TypeExpr
    first: Expr


@dataclass(frozen=True)
class Policy(Item):
    """``policy name rhs``, or ``policy name { members choose rhs }``: memory, lets and updates."""

    name: str
    rhs: Rhs
    members: tuple[Memory | Let | Update, ...] = ()


@dataclass(frozen=True)
class Bound(Item):
    """``bound upper|lower|tail = e``."""

    name: str
    value: Expr


@dataclass(frozen=True)
class Invariant(Item):
    """``invariant e``, of the model or of an element's members."""

    condition: Expr


@dataclass(frozen=True)
class Draw(Item):
    """``draw name[i in T where c] = shape { field = e, .. }``; ``shape_span`` covers the shape's name."""

    name: str
    binders: tuple[Binder, ...]
    where: Expr | None
    shape: str
    shape_span: Span
    fields: tuple[NewField, ...]


@dataclass(frozen=True)
class Assignment(Node):
    """``name = e`` of an instance file."""

    name: str
    value: Expr


# Files -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ModelFile(Node):
    """``model Name`` and its items."""

    name: str
    items: tuple[Item, ...]


@dataclass(frozen=True)
class LibraryFile(Node):
    """``library Name`` and its items: imports, consts, types, enums, records and functions."""

    name: str
    items: tuple[Item, ...]


@dataclass(frozen=True)
class InstanceFile(Node):
    """``instance name of "file" { assignments }``; ``model_span`` covers the quoted file name."""

    name: str
    model: str
    assignments: tuple[Assignment, ...]
    model_span: Span | None = None


File = ModelFile | LibraryFile | InstanceFile
