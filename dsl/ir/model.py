# SPDX-License-Identifier: Apache-2.0
"""The parts of a model: declarations, updates, observations, rewards, and the model itself."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import groupby

from hypgen.dsl.ir.factors import Evidence, Factor, Obstacle
from hypgen.dsl.ir.nodes import (
    Binder,
    Certain,
    Const,
    Dist,
    Expr,
)
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Array, Enum, Float, Record, Type, digits_of, length_of, size_of

# The fraction bits of rewards in fixed point, where these are neither very large nor very small.
REWARD_BITS = 24

# Declarations ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Site:
    """Where a draw happens: a name path, and its 32-bit id in the random key (FNV-1a of the path).

    Paths: ``rover.x`` (update), ``init:rover.x``, ``let:car.works``, ``observe:reading``, ``policy:default``,
    ``policy:tries`` (a let of the policy).
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
    """A run-time constant; ``default`` holds its entries row-major, or None where the user must give it.

    ``error`` is a bound of how far an entry is from the number that the text says.
    """

    name: str
    type: Type
    indices: tuple[Type, ...]
    default: tuple[bool | int | float, ...] | None
    span: Span
    error: float = 0.0


@dataclass(frozen=True)
class ConstantArray:
    """A constant array with its entries row-major; ``error`` as of a ``Param``.

    ``exact`` are the numbers that the text says; None where entries are computed, or many.
    """

    name: str
    type: Type
    indices: tuple[Type, ...]
    values: tuple[bool | int | float, ...]
    span: Span
    error: float = 0.0
    exact: tuple[Fraction, ...] | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Variable:
    """A state variable, an array if ``indices`` is not empty (a family's member index comes first).

    ``determined``: visible, and the same in all scenarios that agree on visible state and action, so that it
    is not part of the observation key. ``copied``: visible, and drawn from nothing that anything hidden
    reads, so that the filter takes the observed value at weight 1. docs/internals/contracts.md has the rules.
    ``informative``: visible, and its init reads hidden state, so that what is seen at the start weighs the
    first belief.
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
    informative: bool = False


@dataclass(frozen=True)
class Element:
    """An owner of variables; ``binder`` names the member of a family."""

    name: str
    binder: Binder | None
    span: Span


@dataclass(frozen=True)
class Assign:
    """How a variable gets its value, at the start or in a step, for each value of ``binders``.

    ``binders`` stand for the variable's ``indices`` one by one. ``reads`` are the variables read primed,
    directly or through functions and lets. ``stage`` is 0 for an init; inits are in dependency order. Inits
    of one ``group`` are consecutive and of one family: they run member by member, all of them each time.
    """

    variable: str
    binders: tuple[Binder, ...]
    dist: Dist
    site: Site
    span: Span
    stage: int = 0
    reads: frozenset[str] = frozenset()
    group: str | None = None


@dataclass(frozen=True)
class Let:
    """A named temporary (``dist`` is Certain) or draw of an element, one for each member of a family.

    One of the policy's is named ``policy.name`` and belongs to the element ``policy``, which no model has.
    """

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
    """What the agent sees in a step, an array if ``binders`` is not empty; evaluated after all updates.

    A float comes from a continuous law, or has values of its own that no hidden float decides.
    """

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
class Invariant:
    """What holds in every state, for each value of ``binder``; solvers do not evaluate it."""

    name: str
    element: str | None
    binder: Binder | None
    condition: Expr
    span: Span


@dataclass(frozen=True)
class Drawing:
    """A shape of the picture for each value of ``binders`` for which ``where`` holds.

    Solvers do not evaluate it. ``fields`` are expressions or texts by name, in the order of the text.
    ``reads`` are the variables that it comes to read.
    """

    name: str
    shape: str
    binders: tuple[Binder, ...]
    where: Expr
    fields: dict[str, Expr | str]
    span: Span
    reads: frozenset[str] = frozenset()


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
        return size_of(Array(self.type, self.indices)) if self.indices else size_of(self.type)


@dataclass(frozen=True)
class Policy:
    """The default policy: a distribution for each value of ``binders`` (a product action's indices).

    ``lets`` are its own, in order of declaration; ``LetRead`` reads them by ``policy.name``. They draw in the
    step in which the policy chooses.
    """

    binders: tuple[Binder, ...]
    dist: Dist
    site: Site
    span: Span
    lets: tuple[Let, ...] = ()


@dataclass(frozen=True)
class Entries:
    """What each entry of an array is: ``value`` for each value of ``binders``; a scalar has no binders."""

    binders: tuple[Binder, ...]
    value: Expr


@dataclass(frozen=True)
class Register:
    """A policy's memory, an array if ``indices`` is not empty.

    ``first`` is what it holds at the start of an episode and reads visible state and params. ``update`` is
    what it holds at the next decision: evaluated at this one, on what the policy sees, whatever is done then.
    All registers of a policy change at once.
    """

    name: str
    type: Type
    indices: tuple[Type, ...]
    first: Entries
    update: Entries
    span: Span


@dataclass(frozen=True)
class History:
    """What the agent keeps of the past for the policy and ``bound lower``.

    The registers; the observations named in ``observations`` (in the order of ``Model.observations``) and, if
    ``action``, the action of the step before; whether there was a step before; and the posteriors of the
    elements in ``beliefs``, which are exact factors, or factors of which ``moments`` are kept.
    """

    registers: tuple[Register, ...] = ()
    observations: tuple[str, ...] = ()
    action: bool = False
    beliefs: tuple[str, ...] = ()

    @property
    def is_empty(self) -> bool:
        """Return whether nothing is kept."""
        return not (self.registers or self.observations or self.action or self.beliefs)


@dataclass(frozen=True)
class KeyField:
    """A digit of the observation key: an observation, or a visible variable that is not determined.

    A finite value counts from 0; of a float the digit is its 32 bits, every NaN those of 0x7FC00000.
    """

    name: str
    observed: bool
    type: Type
    indices: tuple[Type, ...]

    @property
    def size(self) -> int:
        """Return the number of values of one digit."""
        return digits_of(self.type)

    @property
    def length(self) -> int:
        """Return the number of digits that the field takes."""
        return length_of(self.indices)


@dataclass(frozen=True)
class Model:
    """A whole model. ``updates`` has one entry for each variable that is not fixed.

    ``key`` lists the digits of the observation key, the first the most significant: observations in order,
    then visible variables that are not determined; arrays row-major. ``legal`` and ``terminal`` are True or
    False constants where the author wrote none; ``upper`` and ``tail`` are derived where the author wrote
    none; ``lower`` is None unless declared, and then replaces the rollout. ``policy`` None means uniform over
    the legal actions, drawn at the site ``policy:default``. ``source_hash`` is the SHA-256 of the text with
    all settings applied. Elements with hidden variables are ``factors``, or have one of the ``obstacles``.
    ``reward_bits`` are the fraction bits of rewards in fixed point; below 0, the last bit is above 1.
    ``rewards_fit``: no step's sum of rewards leaves its range.
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
    history: History = History()
    invariants: tuple[Invariant, ...] = ()
    drawings: tuple[Drawing, ...] = ()
    factors: tuple[Factor, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    reward_bits: int = REWARD_BITS
    rewards_fit: bool = False
    spans: dict[str, Span] = field(default_factory=dict, compare=False)

    @property
    def all_lets(self) -> tuple[Let, ...]:
        """Return the lets of the elements, then those of the policy."""
        return self.lets + (() if self.policy is None else self.policy.lets)

    @property
    def endless(self) -> bool:
        """Return whether nothing ends an episode."""
        return self.horizon is None and isinstance(self.terminal, Const) and not self.terminal.value

    @property
    def factored(self) -> bool:
        """Return whether every hidden variable belongs to a factor."""
        factored = {name for f in self.factors for name in f.variables}
        return all(v.visible or v.name in factored for v in self.variables)

    def variable(self, name: str) -> Variable:
        """Return the variable with this qualified name."""
        return next(v for v in self.variables if v.name == name)

    def weighs_floats(self, evidence: Iterable[Evidence]) -> bool:
        """Return whether some of the evidence is a float, so that its density has any scale."""
        types = {o.name: o.type for o in self.observations} | {v.name: v.type for v in self.variables}
        return any(isinstance(types.get(e.name), Float) for e in evidence)

    @property
    def first_seen(self) -> tuple[Assign, ...]:
        """Return the inits of informative variables, in order: what weighs the first belief."""
        return tuple(i for i in self.inits if self.variable(i.variable).informative)

    def init_groups(self, visible: bool) -> tuple[tuple[Assign, ...], ...]:
        """Return the inits of visible or of hidden variables, in order; those of a group together.

        Where visible variables tell of hidden ones, all inits are among those of the visible variables.
        """
        all_first = visible and bool(self.first_seen)
        inits = [i for i in self.inits if all_first or self.variable(i.variable).visible == visible]
        parts = groupby(inits, key=lambda i: i.group or i.variable)
        return tuple(tuple(part) for _, part in parts)

    def stages(self) -> tuple[tuple[Assign, ...], ...]:
        """Return the updates grouped by stage, in order."""
        count = 1 + max((u.stage for u in self.updates), default=-1)
        return tuple(tuple(u for u in self.updates if u.stage == s) for s in range(count))
