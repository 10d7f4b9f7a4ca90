"""The intermediate representation: a checked, typed model with every name resolved.

Invariants, established by ``lower`` and ``analysis`` and relied on by the interpreter and by codegen:

- Every expression has a scalar value: bool, int32 (ranges, enum and record codes) or float32; the node's
  ``type`` says which. Operands of an operator agree in kind: an int becomes a float only by ``ToFloat``.
- Every int expression's interval lies within int32; every index lies within its type; no value stored
  in a variable lies outside the variable's type.
- Expressions are pure; conditionals may evaluate both sides. Constants and enum literals are ``Const``.
- Names are unique within their table of ``Model`` (qualified by the element: ``rover.x``); the names of
  locals do not shadow each other.
- Evaluating the ``updates`` stage by stage, in any order within a stage, reads only next-state values
  that earlier stages have written.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from hypgen.dsl.source import Span
from hypgen.dsl.types import Array, Enum, Record, Type, length_of

# Expressions -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Expr:
    """Base of expressions; ``type`` is never an array."""

    type: Type


@dataclass(frozen=True)
class Const(Expr):
    """A constant: bool, int (or code), or a float that float32 holds exactly."""

    value: bool | int | float


@dataclass(frozen=True)
class Local(Expr):
    """A binder, a ``LetIn`` name, a function's formal or the argument that a ``match`` binds."""

    name: str


@dataclass(frozen=True)
class ParamRead(Expr):
    """An entry of a param; one index for each of its index types."""

    param: str
    indices: tuple[Expr, ...] = ()


@dataclass(frozen=True)
class TableRead(Expr):
    """An entry of a constant array."""

    table: str
    indices: tuple[Expr, ...] = ()


@dataclass(frozen=True)
class StateRead(Expr):
    """A variable's value before the step, or after it when ``primed``.

    Indices: the family member's first (if the element is a family), then the variable's own.
    """

    variable: str
    indices: tuple[Expr, ...] = ()
    primed: bool = False


@dataclass(frozen=True)
class LetRead(Expr):
    """A let's value; ``primed`` evaluates its expression with every unprimed state read primed.

    A let that draws is never primed. One index if the let's element is a family.
    """

    let: str
    indices: tuple[Expr, ...] = ()
    primed: bool = False


@dataclass(frozen=True)
class ActionRead(Expr):
    """The action, or one component of a product action (one index for each index type)."""

    indices: tuple[Expr, ...] = ()


@dataclass(frozen=True)
class Call(Expr):
    """A call of a model function; ``primed`` evaluates its body with every unprimed state read primed."""

    function: str
    arguments: tuple[Expr, ...]
    primed: bool = False


@dataclass(frozen=True)
class ToFloat(Expr):
    """An int (or bool) as float32, rounded to nearest even."""

    operand: Expr


@dataclass(frozen=True)
class Unary(Expr):
    """``neg not`` and the built-ins of one argument: ``abs sign floor ceil round sqrt exp log log2``.

    ``floor ceil round`` take a float and give an int, saturated to the node's interval.
    """

    op: str
    operand: Expr


@dataclass(frozen=True)
class Binary(Expr):
    """``add sub mul div floordiv mod pow min max hypot eq ne lt le gt ge and or``.

    ``div`` is of floats; ``floordiv`` and ``mod`` floor, of ints, and give 0 where the divisor is 0;
    ``pow`` and ``hypot`` are of floats (ints to a constant power are lowered to products);
    ``min`` is ``b < a ? b : a`` and ``max`` is ``a < b ? b : a``.
    """

    op: str
    left: Expr
    right: Expr


@dataclass(frozen=True)
class Clamp(Expr):
    """An int or float forced into [low, high], constants of the node's type."""

    operand: Expr
    low: int | float
    high: int | float


@dataclass(frozen=True)
class If(Expr):
    """``then`` where ``condition`` holds, else ``otherwise``; ``match`` is lowered to a chain of these."""

    condition: Expr
    then: Expr
    otherwise: Expr


@dataclass(frozen=True)
class LetIn(Expr):
    """``body`` with ``name`` standing for ``value``."""

    name: str
    value: Expr
    body: Expr


@dataclass(frozen=True)
class IsVariant(Expr):
    """Whether an enum's value is the variant (of any argument)."""

    enum: Enum
    variant: str
    operand: Expr


@dataclass(frozen=True)
class VariantArgument(Expr):
    """The argument of an enum's value, meaningful only where ``IsVariant`` holds."""

    enum: Enum
    variant: str
    operand: Expr


@dataclass(frozen=True)
class MakeVariant(Expr):
    """A variant with an argument."""

    enum: Enum
    variant: str
    argument: Expr


@dataclass(frozen=True)
class FieldRead(Expr):
    """A field of a record."""

    record: Record
    field: str
    operand: Expr


@dataclass(frozen=True)
class MakeRecord(Expr):
    """A record of its fields' values, in order."""

    record: Record
    values: tuple[Expr, ...]


@dataclass(frozen=True)
class Binder:
    """A local that takes every value of a finite type, in ascending order."""

    name: str
    type: Type


@dataclass(frozen=True)
class Quantified(Expr):
    """``sum any all count min max argmin argmax`` over all values of the binders where ``condition`` holds.

    Evaluated in lexicographic order, the first binder outermost; ``sum`` starts from 0 and adds in that
    order; the first of equal values wins in ``argmin`` and ``argmax`` (one binder, whose value it
    gives). ``body`` is None for ``count`` only. ``otherwise`` is the value where nothing matched, for
    ``min max argmin argmax``; without it (provably never empty, or a model error) the body or binder
    at its first values stands in.
    """

    kind: str
    binders: tuple[Binder, ...]
    condition: Expr | None
    body: Expr | None
    otherwise: Expr | None


# Distributions -----------------------------------------------------------------------------------
#
# Each is sampled from one 32-bit word w by inverse CDF. T(p) = trunc(double(p) * 2^32) clamped to
# [0, 2^32] is the threshold of a probability p (NaN gives 0).


@dataclass(frozen=True)
class Dist:
    """Base of distributions over scalars of ``type``."""

    type: Type


@dataclass(frozen=True)
class Certain(Dist):
    """A value with probability 1; takes no word."""

    value: Expr


@dataclass(frozen=True)
class Bernoulli(Dist):
    """true where w < T(p). Density: T(p) / 2^32, or what is left."""

    probability: Expr


@dataclass(frozen=True)
class Uniform(Dist):
    """Every value of the finite ``type``: low + ((w * n) >> 32). Density: 1 / n."""


@dataclass(frozen=True)
class UniformSet(Dist):
    """``value`` at a uniformly chosen match of ``binders where condition``.

    With c matches the one numbered (w * c) >> 32 in order is taken; ``otherwise`` is drawn, from the same
    word, where c is 0 (without it, the value at the binders' first values). Density: the share of matches
    whose value is equal, double(count) / double(c).
    """

    binders: tuple[Binder, ...]
    condition: Expr | None
    value: Expr
    otherwise: Dist | None


@dataclass(frozen=True)
class Table(Dist):
    """Values with weights; ``rest`` (or the last entry, if None) takes what is left.

    With t_i = T(p_i), entry i is the first with w < t_0 + ... + t_i, cumulated in 64 bits. Density of v: the
    number of words that give it, over 2^32.
    """

    entries: tuple[tuple[Expr, Expr], ...]
    rest: Expr | None


@dataclass(frozen=True)
class Noisy(Dist):
    """``value`` with probability p, else uniformly one of the n - 1 others.

    With t = T(p): ``value`` if w < t; otherwise the other numbered ((w - t) * (n - 1)) / (2^32 - t), counted in
    ascending order and passing over ``value``. If n is 1, ``value``. Density: t / 2^32, or
    ((2^32 - t) / 2^32) / (n - 1); 1 if n is 1.
    """

    value: Expr
    probability: Expr


@dataclass(frozen=True)
class IfDist(Dist):
    """One of two distributions, drawn from the same word."""

    condition: Expr
    then: Dist
    otherwise: Dist


@dataclass(frozen=True)
class LetDist(Dist):
    """``body`` with ``name`` standing for ``value``."""

    name: str
    value: Expr
    body: Dist


# Declarations ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Site:
    """Where a draw happens: a name path, and its 32-bit id in the random key (FNV-1a of the path).

    Paths: ``rover.x`` (update), ``init:rover.x``, ``let:car.works``, ``observe:reading``, ``policy:default``.
    """

    path: str

    @cached_property
    def id(self) -> int:
        """Return the 32-bit FNV-1a hash of the path."""
        value = 0x811C9DC5
        for byte in self.path.encode():
            value = ((value ^ byte) * 0x01000193) & 0xFFFFFFFF
        return value


@dataclass(frozen=True)
class Param:
    """A run-time constant; ``default`` holds its entries row-major, or None where the user must give it."""

    name: str
    type: Type
    indices: tuple[Type, ...]
    default: tuple[bool | int | float, ...] | None
    span: Span


@dataclass(frozen=True)
class ConstantArray:
    """A constant array with its entries row-major."""

    name: str
    type: Type
    indices: tuple[Type, ...]
    values: tuple[bool | int | float, ...]
    span: Span


@dataclass(frozen=True)
class Variable:
    """A state variable, an array if ``indices`` is not empty (a family's member index comes first).

    ``determined``: visible, and the same in all scenarios that agree on visible state and action, so that it
    is not part of the observation key. ``copied``: visible, and drawn from nothing that anything hidden reads, so
    that the filter takes the observed value at weight 1. The exact rules are in docs/design/0001.
    """

    name: str
    element: str
    type: Type
    indices: tuple[Type, ...]
    visible: bool
    fixed: bool
    span: Span
    determined: bool = False
    copied: bool = False


@dataclass(frozen=True)
class Element:
    """An owner of variables; ``binder`` names the member of a family."""

    name: str
    binder: Binder | None
    span: Span


@dataclass(frozen=True)
class Assign:
    """How a variable gets its value, at the start or in a step, for each value of ``binders``.

    ``binders`` stand for the variable's ``indices`` one by one. ``reads`` are the variables read primed, directly or
    through functions and lets. ``stage`` is 0 for an init; inits are listed in dependency order.
    """

    variable: str
    binders: tuple[Binder, ...]
    dist: Dist
    site: Site
    span: Span
    stage: int = 0
    reads: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Let:
    """A named temporary (``dist`` is Certain) or draw of an element, one for each member of a family."""

    name: str
    element: str
    binder: Binder | None
    dist: Dist
    site: Site
    span: Span

    @property
    def draws(self) -> bool:
        """Return whether the let is a draw."""
        return not isinstance(self.dist, Certain)


@dataclass(frozen=True)
class Function:
    """A model function of scalar formals. A body may read primed state, unprimed state, or both."""

    name: str
    formals: tuple[Binder, ...]
    type: Type
    body: Expr
    span: Span


@dataclass(frozen=True)
class Observation:
    """What the agent sees in a step, an array if ``binders`` is not empty; evaluated after all updates."""

    name: str
    element: str | None
    type: Type
    binders: tuple[Binder, ...]
    dist: Dist
    site: Site
    span: Span


@dataclass(frozen=True)
class Reward:
    """A reward term, earned once for each value of ``binder`` (a family's member)."""

    name: str
    element: str | None
    binder: Binder | None
    value: Expr
    span: Span


@dataclass(frozen=True)
class Action:
    """The action: a finite type, or a product of ``indices`` components coded row-major, the first the most
    significant digit.
    """

    name: str
    type: Type
    indices: tuple[Type, ...]
    span: Span

    @property
    def count(self) -> int:
        """Return the number of joint actions."""
        from hypgen.dsl.types import size_of

        return size_of(Array(self.type, self.indices)) if self.indices else size_of(self.type)


@dataclass(frozen=True)
class Policy:
    """The default policy: one distribution, evaluated for each value of ``binders`` (a product action's indices)."""

    binders: tuple[Binder, ...]
    dist: Dist
    site: Site
    span: Span


@dataclass(frozen=True)
class KeyField:
    """A digit of the observation key: an observation, or a visible variable that is not determined."""

    name: str
    observed: bool
    type: Type
    indices: tuple[Type, ...]

    @property
    def length(self) -> int:
        """Return the number of digits that the field takes."""
        return length_of(self.indices)


@dataclass(frozen=True)
class Model:
    """A whole model. ``updates`` has one entry for each variable that is not fixed.

    ``key`` lists the digits of the observation key, the first the most significant: observations in order,
    then visible variables that are not determined; arrays row-major. ``legal`` and ``terminal`` are True or False
    constants where the author wrote none; ``upper`` and ``tail`` are derived where the author wrote none;
    ``lower`` is None unless declared, and then replaces the rollout. ``policy`` None means uniform over the
    legal actions, drawn at the site ``policy:default``. ``source_hash`` is the SHA-256 of the text with all settings applied.
    """

    name: str
    file: str
    source_hash: str
    discount: float
    horizon: int | None
    enums: tuple[Enum, ...]
    records: tuple[Record, ...]
    params: tuple[Param, ...]
    tables: tuple[ConstantArray, ...]
    elements: tuple[Element, ...]
    variables: tuple[Variable, ...]
    lets: tuple[Let, ...]
    functions: tuple[Function, ...]
    action: Action
    inits: tuple[Assign, ...]
    updates: tuple[Assign, ...]
    observations: tuple[Observation, ...]
    rewards: tuple[Reward, ...]
    terminal: Expr
    legal: Expr
    policy: Policy | None
    upper: Expr
    tail: Expr
    lower: Expr | None
    success: Expr | None
    key: tuple[KeyField, ...]
    spans: dict[str, Span] = field(default_factory=dict, compare=False)

    def variable(self, name: str) -> Variable:
        """Return the variable with this qualified name."""
        return next(v for v in self.variables if v.name == name)

    def stages(self) -> tuple[tuple[Assign, ...], ...]:
        """Return the updates grouped by stage, in order."""
        count = 1 + max((u.stage for u in self.updates), default=-1)
        return tuple(tuple(u for u in self.updates if u.stage == s) for s in range(count))
