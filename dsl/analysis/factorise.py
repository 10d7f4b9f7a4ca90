# SPDX-License-Identifier: Apache-2.0
"""Hidden variables that are independent of all others given what the agent has seen.

The hidden variables of an element (of a family: of each member) are a factor if no init or update, and
nothing that the agent learns from, brings them together with other hidden state; docs/internals/beliefs.md
has the rules. All elements that are none make one factor together, beside those that are. What forbids it
is kept for ``hypgen explain``, and for the message of a ``belief`` that needs it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from hypgen.dsl import ir
from hypgen.dsl.analysis.float_moments import moments_of
from hypgen.dsl.analysis.hidden_reads import Leaf, Touches, Tree, leaves
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.analysis.uses import Uses
from hypgen.dsl.ir.walk import negated, shape
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import BOOL, Bool, Int, Type, is_finite, length_of, low_of, size_of

# Most joint values of an exact factor; fewer where updates draw, since a step then goes through all pairs.
_MAX_VALUES = 4096
_MAX_DRAWN_VALUES = 512


def factorise(model: ir.Model, uses: Uses) -> tuple[tuple[ir.Factor, ...], tuple[ir.Obstacle, ...]]:
    """Return the factors, and for every other element with hidden state what forbids that it is one."""
    return _Factors(model, uses).result()


@dataclass(frozen=True)
class _Seen:
    """What the agent learns from one declaration: ``tree`` is what its law reads."""

    kind: str
    name: str
    binders: tuple[ir.Binder, ...]
    tree: Tree
    condition: ir.Expr | None = None

    @property
    def owner(self) -> Owner:
        """Return the declaration as the graph of reads knows it."""
        match self.kind:
            case "visible" | "copied":
                return Owner("update", self.name)
            case "observe":
                return Owner("observe", self.name)
            case "first":
                return Owner("init", self.name)
        return Owner("terminal")

    @property
    def words(self) -> str:
        """Return the declaration in words."""
        return _words(self.owner)


@dataclass(frozen=True)
class _Draw:
    """A read of a draw: by whom, and together with which member (None: with none)."""

    owner: Owner
    binders: tuple[ir.Binder, ...]
    index: object
    unit: tuple[str, object] | None


@dataclass
class _Factors:
    model: ir.Model
    uses: Uses
    touches: Touches = field(init=False)
    obstacles: dict[str, ir.Obstacle] = field(default_factory=dict)
    draws: dict[str, list[_Draw]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.touches = Touches(self.model)
        self.elements = {e.name: e for e in self.model.elements}
        self.variables = {v.name: v for v in self.model.variables}
        self.hidden = {
            e: tuple(v for v in self.model.variables if v.element == e and not v.visible)
            for e in dict.fromkeys(v.element for v in self.model.variables if not v.visible)
        }

    def result(self) -> tuple[tuple[ir.Factor, ...], tuple[ir.Obstacle, ...]]:
        for assign in self.model.inits:
            self._own(assign, Owner("init", assign.variable))
        for assign in self.model.updates:
            self._own(assign, Owner("update", assign.variable))
        seen, first = list(self._seen()), list(self._first_seen())
        for item in (*first, *seen):
            for leaf in leaves(item.tree):
                self._one_member(leaf, item)
        for name, reads in self.draws.items():
            self._untied(name, reads)
        factors = tuple(self._factor(e, seen, first) for e in self.hidden if e not in self.obstacles)
        tied = [e for e in self.hidden if e in self.obstacles]
        if factors and tied and not self._draws_again(tied):
            factors = (*factors, self._joined(tied, seen, first))
        return factors, tuple(self.obstacles[e] for e in tied)

    # What forbids it -----------------------------------------------------------------------------

    def _forbid(self, element: str, owner: Owner, read: str, reason: str, span: Span | None = None) -> None:
        if element not in self.obstacles:
            self.obstacles[element] = ir.Obstacle(element, span or self._span(owner, read), reason)

    def _span(self, owner: Owner, read: str) -> Span:
        """Return where ``owner`` comes to read ``read``, or where it is declared."""
        found = [r.path[-1].span for r in self.uses.closure(owner) if r.name == read]
        declared: list[Span] = {
            "update": [u.span for u in self.model.updates if u.variable == owner.name],
            "init": [i.span for i in self.model.inits if i.variable == owner.name],
            "observe": [o.span for o in self.model.observations if o.name == owner.name],
        }.get(owner.kind, [s for k, s in self.model.spans.items() if k == "terminal"])
        return (found or declared or [self.variables[read].span])[0]

    def _own(self, assign: ir.Assign, owner: Owner) -> None:
        """Check that what gives a hidden variable its value reads the member's own hidden state only."""
        variable = self.variables[assign.variable]
        if variable.visible:
            return
        element = variable.element
        own = shape(self._member(element, assign.binders))
        for leaf in leaves(self.touches.tree(assign.dist)):
            for part in leaf.parts:
                if part.draw:
                    index = shape(part.index)
                    self.draws.setdefault(part.owner, []).append(
                        _Draw(owner, assign.binders, index, (element, own))
                    )
                elif part.owner != element:
                    reason = f"{_words(owner)} reads '{part.read}', hidden state of another element"
                    self._forbid(element, owner, part.read, reason)
                    self._forbid(part.owner, owner, part.read, reason)
                elif part.vague or shape(part.index) != own:
                    reason = f"{_words(owner)} reads '{part.read}' of another member of the family"
                    self._forbid(element, owner, part.read, reason, part.span)

    def _member(self, element: str, binders: tuple[ir.Binder, ...]) -> ir.Expr | None:
        """Return the member that the first of ``binders`` stands for; None where there is no family."""
        if self.elements[element].binder is None:
            return None
        return ir.Local(binders[0].type, binders[0].name)

    def _one_member(self, leaf: Leaf, item: _Seen) -> None:
        """Check that what is learnt from the declaration tells of one member at most."""
        members = [p for p in leaf.parts if not p.draw]
        first = members[0] if members else None
        unit = None if first is None else (first.owner, shape(first.index))
        for part in leaf.parts:
            if part.draw:
                read = _Draw(item.owner, item.binders, shape(part.index), unit)
                self.draws.setdefault(part.owner, []).append(read)
        for part in members:
            if part.vague:
                self._forbid(
                    part.owner, item.owner, part.read, f"{item.words} reads '{part.read}' {part.vague}"
                )
        if first is None or len(members) == 1:
            return
        other = next((p for p in members if p.owner != first.owner), members[1])
        reason = f"{item.words} reads '{first.read}' and '{other.read}' at once"
        if other.owner == first.owner:
            reason = f"{item.words} reads '{first.read}' of several members at once"
        for part in members:
            self._forbid(part.owner, item.owner, part.read, reason)

    def _untied(self, name: str, reads: list[_Draw]) -> None:
        """Check that no draw brings together a member with anything else."""
        units = list(dict.fromkeys(r.unit for r in reads))
        if all(unit is None for unit in units):
            return
        owners = list(dict.fromkeys(r.owner for r in reads))
        names = [b.name for b in reads[0].binders]
        entry = shape(ir.Local(reads[0].binders[0].type, names[0])) if len(names) == 1 else None
        alone = len(owners) == 1 and len(names) <= 1 and all(r.index == entry for r in reads)
        elements = {unit[0] for unit in units if unit is not None}
        along = (
            None not in units and len(elements) == 1 and all(r.unit and r.index == r.unit[1] for r in reads)
        )
        if alone or along:
            return
        readers = " and ".join(map(_words, owners))
        for element in sorted(elements):
            self._forbid(element, owners[0], name, f"the draw '{name}' ties what reads it: {readers}")

    # What is learnt ------------------------------------------------------------------------------

    def _first_seen(self) -> Iterator[_Seen]:
        """Yield what the agent learns at the start."""
        for init in self.model.first_seen:
            yield _Seen("first", init.variable, init.binders, self.touches.tree(init.dist))

    def _seen(self) -> Iterator[_Seen]:
        """Yield what the agent learns in a step, in the order in which a filter weighs it."""
        for update in sorted(self.model.updates, key=lambda u: u.stage):
            variable = self.variables[update.variable]
            if variable.visible and not variable.determined:
                tree = self.touches.tree(update.dist)
                yield _Seen("copied" if variable.copied else "visible", update.variable, update.binders, tree)
        for observation in self.model.observations:
            tree = self.touches.tree(observation.dist)
            yield _Seen("observe", observation.name, observation.binders, tree)
        for binders, condition in self._ends(self.model.terminal):
            yield _Seen("end", "", binders, self.touches.tree(condition), condition)

    def _ends(self, e: ir.Expr) -> Iterator[tuple[tuple[ir.Binder, ...], ir.Expr]]:
        """Yield conditions, each for all values of binders, whose ``or`` is ``e``."""
        match e:
            case _ if not self.touches.secret(e):
                yield (), e
            case ir.Binary(op="or", left=left, right=right):
                yield from self._ends(left)
                yield from self._ends(right)
            case ir.Binary(op="and", left=left, right=right) if not self.touches.secret(left):
                yield from _guarded(left, self._ends(right))
            case ir.Binary(op="and", left=left, right=right) if not self.touches.secret(right):
                yield from _guarded(right, self._ends(left))
            case ir.If(condition=condition, then=then, otherwise=otherwise) if not self.touches.secret(
                condition
            ):
                yield from _guarded(condition, self._ends(then))
                yield from _guarded(negated(condition), self._ends(otherwise))
            case ir.Quantified(kind="any", binders=binders, condition=where, body=ir.Expr() as body):
                found = self._ends(body if where is None else ir.Binary(BOOL, "and", where, body))
                yield from (((*binders, *more), end) for more, end in found)
            case ir.Call() | ir.LetIn():
                inner = self.touches.body(e)
                assert isinstance(inner, ir.Expr)
                yield from self._ends(inner)
            case ir.LetRead() if not next(x for x in self.model.lets if x.name == e.let).draws:
                inner = self.touches.body(e)
                assert isinstance(inner, ir.Expr)
                yield from self._ends(inner)
            case _:
                yield (), e

    # Factors -------------------------------------------------------------------------------------

    def _factor(self, element: str, seen: list[_Seen], first: list[_Seen]) -> ir.Factor:
        declared = self.elements[element]
        touching = [s for s in seen if _touches(s.tree, element)]
        evidence = tuple(_evidence(s, declared) for s in touching)
        at_start = tuple(_evidence(s, declared) for s in first if _touches(s.tree, element))
        variables = self.hidden[element]
        names = {v.name for v in variables}
        size, inexact, moments, unmatched = 0, "", None, ""
        updates = [u for u in self.model.updates if u.variable in names]
        floats = [v.name for v in variables if not is_finite(v.type)]
        laws = [self.touches.tree(u.dist) for u in updates] + [s.tree for s in touching]
        drawn = [p.owner for law in laws for leaf in leaves(law) for p in leaf.parts if p.draw]
        if floats:
            inexact = f"'{floats[0]}' is a float"
            unmatched = f"the draw '{drawn[0]}' is read" if drawn else ""
            if not drawn:
                learnt = [(s.words, s.condition or self._law(s)) for s in touching]
                moments, unmatched = moments_of(self.model, declared, learnt)
        elif drawn:
            inexact = f"the draw '{drawn[0]}' is read"
        else:
            bits = sum(math.log2(size_of(v.type)) * length_of(self._own_indices(v)) for v in variables)
            certain = all(isinstance(u.dist, ir.Certain) for u in updates)
            most = _MAX_VALUES if certain else _MAX_DRAWN_VALUES
            if bits > math.log2(most) + 1e-9:
                inexact = f"it has more than {most} joint values"
            else:
                size = math.prod(size_of(v.type) ** length_of(self._own_indices(v)) for v in variables)
        names_in_order = tuple(v.name for v in variables)
        return ir.Factor(
            *(element, declared.binder, names_in_order, size, inexact, evidence, at_start),
            moments=moments,
            unmatched=unmatched,
        )

    def _draws_again(self, elements: list[str]) -> bool:
        """Return whether particles of the whole state serve better: copies draw unread values again."""
        return any(v.fixed and v.indices for e in elements for v in self.hidden[e])

    def _joined(self, elements: list[str], seen: list[_Seen], first: list[_Seen]) -> ir.Factor:
        """Return one factor of all elements that are none: nothing ties them to the others."""
        return ir.Factor(
            "_and_".join(elements),
            None,
            tuple(v.name for e in elements for v in self.hidden[e]),
            size=0,
            inexact="it joins what is no factor" if len(elements) > 1 else "its members are no factors",
            evidence=_of_any(elements, seen),
            first=_of_any(elements, first),
            joined=True,
        )

    def _law(self, seen: _Seen) -> ir.Dist:
        """Return what is seen is drawn from."""
        if seen.kind == "observe":
            return next(o.dist for o in self.model.observations if o.name == seen.name)
        return next(u.dist for u in self.model.updates if u.variable == seen.name)

    def _own_indices(self, variable: ir.Variable) -> tuple[Type, ...]:
        return variable.indices[1:] if self.elements[variable.element].binder else variable.indices


def _guarded(
    condition: ir.Expr, ends: Iterator[tuple[tuple[ir.Binder, ...], ir.Expr]]
) -> Iterator[tuple[tuple[ir.Binder, ...], ir.Expr]]:
    for binders, end in ends:
        yield binders, ir.Binary(BOOL, "and", condition, end)


def _evidence(seen: _Seen, element: ir.Element) -> ir.Evidence:
    return ir.Evidence(seen.kind, seen.name, seen.binders, _touch(seen.tree, element), seen.condition)


def _of_any(elements: list[str], seen: list[_Seen]) -> tuple[ir.Evidence, ...]:
    """Return what tells of any of the elements; it touches position 0."""
    return tuple(
        ir.Evidence(s.kind, s.name, s.binders, _touch_of_any(s.tree, elements), s.condition)
        for s in seen
        if any(_touches(s.tree, e) for e in elements)
    )


def _touch_of_any(tree: Tree, elements: list[str]) -> ir.Expr:
    """Return 0 where ``tree`` reads any of the elements, -1 elsewhere."""
    type_ = Int(-1, 0)
    if isinstance(tree, Leaf):
        touches = any(_touches(tree, e) for e in elements)
        return ir.Const(type_, 0 if touches else -1)
    then, otherwise = _touch_of_any(tree.then, elements), _touch_of_any(tree.otherwise, elements)
    return then if shape(then) == shape(otherwise) else ir.If(type_, tree.condition, then, otherwise)


def _touches(tree: Tree, element: str) -> bool:
    return any(p.owner == element and not p.draw for leaf in leaves(tree) for p in leaf.parts)


def _touch(tree: Tree, element: ir.Element) -> ir.Expr:
    """Return the position of the member that ``tree`` reads, -1 where it reads none."""
    members = 1 if element.binder is None else size_of(element.binder.type)
    type_ = Int(-1, members - 1)
    if isinstance(tree, Leaf):
        part = next((p for p in tree.parts if p.owner == element.name and not p.draw), None)
        return ir.Const(type_, -1) if part is None else _position(part.index, element)
    then, otherwise = _touch(tree.then, element), _touch(tree.otherwise, element)
    return then if shape(then) == shape(otherwise) else ir.If(type_, tree.condition, then, otherwise)


def _position(index: ir.Expr | None, element: ir.Element) -> ir.Expr:
    """Return where a member stands in its family, from 0; a code of an enum or record is its position."""
    if index is None or element.binder is None:
        return ir.Const(Int(0, 0), 0)
    member = element.binder.type
    last = size_of(member) - 1
    if isinstance(member, Bool):
        return ir.If(Int(0, 1), index, ir.Const(Int(0, 1), 1), ir.Const(Int(0, 1), 0))
    if low_of(member) == 0:
        return index
    return ir.Binary(
        Int(0, last), "sub", index, ir.Const(Int(low_of(member), low_of(member)), low_of(member))
    )


def _words(owner: Owner) -> str:
    """Return a declaration as a message calls it."""
    match owner.kind:
        case "update" | "init" as kind:
            return f"the {kind} of '{owner.name}'"
        case "observe":
            return f"'observe {owner.name.rsplit('.', 1)[-1]}'"
    return f"'{owner}'"
