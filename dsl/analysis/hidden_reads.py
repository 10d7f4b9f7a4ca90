# SPDX-License-Identifier: Apache-2.0
"""Hidden state that an expression reads, given the action and what is visible.

The answer is a tree: a leaf holds the members (of elements) and the draws that are read together; a choice
is a condition on known things between two trees. Calls and lets are followed, so that what they read counts.
``ir.reads`` would say what is read, and not what is read together.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from hypgen.dsl import ir
from hypgen.dsl.ir.inline import Inliner, unnamed
from hypgen.dsl.ir.walk import Node, Numbering, bound_names, children, free_locals, shape
from hypgen.dsl.messages.source import Span

# A tree with more leaves than this is joined into one: then everything counts as read together.
_MAX_LEAVES = 64


@dataclass(frozen=True)
class Part:
    """Hidden state of one member of ``owner`` (``index`` None: no family), or a draw, a let called ``owner``.

    ``read`` is the variable. ``vague``: which member is not known from action and visible state, or several.
    ``span`` is where it is read.
    """

    owner: str
    index: ir.Expr | None
    draw: bool
    read: str
    vague: str = ""
    span: Span | None = field(default=None, compare=False)

    @property
    def key(self) -> tuple[object, ...]:
        """Return what tells members apart."""
        return (self.owner, self.draw, self.vague, shape(self.index))


@dataclass(frozen=True)
class Leaf:
    """What is read together."""

    parts: tuple[Part, ...] = ()


@dataclass(frozen=True)
class Choice:
    """One of two trees, by a condition that reads nothing hidden and no draw."""

    condition: ir.Expr
    then: Tree
    otherwise: Tree


Tree: TypeAlias = Leaf | Choice
NOTHING = Leaf()


def leaves(tree: Tree) -> list[Leaf]:
    """Return the leaves, from the first choice's ``then`` on."""
    if isinstance(tree, Leaf):
        return [tree]
    return [*leaves(tree.then), *leaves(tree.otherwise)]


class Touches:
    """Follows the reads of one model's expressions and distributions."""

    def __init__(self, model: ir.Model) -> None:
        self._variables = {v.name: v for v in model.variables}
        self._families = {e.name for e in model.elements if e.binder is not None}
        self._functions = {f.name: f for f in model.functions}
        self._lets = {x.name: x for x in model.lets}
        self._inliner = Inliner(self._functions, self._lets, mark="_t")
        self._numbering = Numbering()
        self._trees: dict[int, Tree] = {}  # of reads and calls, by their numbers
        self._of_objects: dict[int, tuple[Node, Tree]] = {}  # a value that is read twice stands in two places
        self._known: dict[int, tuple[Node, bool]] = {}  # by id, which the node itself keeps from being reused

    def secret(self, node: Node) -> bool:
        """Return whether ``node`` reads, on any path, hidden state or a draw."""
        known = self._known.get(id(node))
        if known is None:
            # What a belief averages over is no secret: it is known to the agent.
            inside = () if isinstance(node, ir.BeliefRead) else children(node)
            found = self._reveals(node) or any(map(self.secret, inside))
            self._known[id(node)] = known = (node, found)
        return known[1]

    def _reveals(self, node: Node) -> bool:
        match node:
            case ir.StateRead(variable=name):
                return not self._variables[name].visible
            case ir.Call(function=name):
                return self.secret(self._functions[name].body)
            case ir.LetRead(let=name):
                let = self._lets.get(name)  # the policy's lets read what is known
                return let is not None and (let.draws or self.secret(let.dist))
        return False

    def tree(self, node: Node) -> Tree:
        """Return what ``node`` reads."""
        if not self.secret(node):
            return NOTHING
        known = self._of_objects.get(id(node))
        if known is None:
            self._of_objects[id(node)] = known = (node, self._tree(node))
        return known[1]

    def _tree(self, node: Node) -> Tree:
        match node:
            case ir.StateRead():
                return self._state_read(node)
            case ir.LetRead(indices=indices) if self._lets[node.let].draws:
                part = self._part(node.let, indices, True, node.let, self._lets[node.let].binder is not None)
                return _together([Leaf((part,)), *map(self.tree, indices), self.tree(self.body(node))])
            case ir.LetRead() | ir.Call() | ir.LetIn() | ir.LetDist():
                number = self._numbering.of(node)
                if number not in self._trees:  # equal reads have equal trees, and chains of lets repeat them
                    self._trees[number] = self.tree(self.body(node))
                return self._trees[number]
            case (
                ir.If(condition=condition, then=then, otherwise=otherwise)
                | ir.IfDist(condition=condition, then=then, otherwise=otherwise)
            ) if not self.secret(condition):
                return _choice(condition, self.tree(then), self.tree(otherwise))
            case ir.Binary(op="and" | "or" as op, left=left, right=right):
                if self.secret(left) and self.secret(right):
                    return _together([self.tree(left), self.tree(right)])
                known, other = (right, left) if self.secret(left) else (left, right)
                where = self.tree(other)
                return _choice(known, where, NOTHING) if op == "and" else _choice(known, NOTHING, where)
        inside = _together([self.tree(child) for child in children(node)])
        return _unbind(inside, set(bound_names(node)))

    def body(self, node: ir.LetRead | ir.Call | ir.LetIn | ir.LetDist) -> Node:
        """Return what a call, a let or a local let stands for."""
        match node:
            case ir.Call():
                return self._inliner.call(node)
            case ir.LetRead():
                return self._inliner.let(node)
        return unnamed(node)

    def _state_read(self, node: ir.StateRead) -> Tree:
        name, variable = node.variable, self._variables[node.variable]
        inside = [self.tree(i) for i in node.indices]
        if variable.visible:
            return _together(inside)
        family = variable.element in self._families
        part = self._part(variable.element, node.indices, False, name, family)
        return _together([Leaf((replace(part, span=node.span),)), *inside])

    def _part(self, owner: str, indices: tuple[ir.Expr, ...], draw: bool, read: str, family: bool) -> Part:
        index = indices[0] if family else None
        if index is not None and self.secret(index):
            return Part(owner, None, draw, read, "through an index that is not known")
        return Part(owner, index, draw, read)


def _choice(condition: ir.Expr, then: Tree, otherwise: Tree) -> Tree:
    return then if _same(then, otherwise) else Choice(condition, then, otherwise)


def _same(a: Tree, b: Tree) -> bool:
    if isinstance(a, Leaf) and isinstance(b, Leaf):
        return {p.key for p in a.parts} == {p.key for p in b.parts}
    return (
        isinstance(a, Choice)
        and isinstance(b, Choice)
        and shape(a.condition) == shape(b.condition)
        and _same(a.then, b.then)
        and _same(a.otherwise, b.otherwise)
    )


def _together(trees: Iterable[Tree]) -> Tree:
    result: Tree = NOTHING
    for tree in trees:
        result = _join(result, tree)
        if isinstance(result, Choice) and len(found := leaves(result)) > _MAX_LEAVES:
            result = _union(found)
    return result


def _union(found: Iterable[Leaf]) -> Leaf:
    return Leaf(tuple({p.key: p for leaf in found for p in leaf.parts}.values()))


def _join(a: Tree, b: Tree) -> Tree:
    if isinstance(a, Leaf) and isinstance(b, Leaf):
        return _union([a, b])
    if isinstance(a, Leaf):
        a, b = b, a
    assert isinstance(a, Choice)
    if isinstance(b, Leaf) and not b.parts:
        return a
    then, otherwise = (_where(b, a.condition, holds) for holds in (True, False))
    return _choice(a.condition, _join(a.then, then), _join(a.otherwise, otherwise))


def _where(tree: Tree, condition: ir.Expr, holds: bool) -> Tree:
    """Return the tree where it is known whether ``condition`` holds."""
    if isinstance(tree, Leaf):
        return tree
    then, otherwise = _where(tree.then, condition, holds), _where(tree.otherwise, condition, holds)
    if shape(tree.condition) == shape(condition):
        return then if holds else otherwise
    return _choice(tree.condition, then, otherwise)


def _unbind(tree: Tree, names: set[str]) -> Tree:
    """Return the tree without locals that are not known outside the expression that binds them."""
    if not names:
        return tree
    if isinstance(tree, Choice):
        then, otherwise = _unbind(tree.then, names), _unbind(tree.otherwise, names)
        if free_locals(tree.condition) & names:
            return _join(then, otherwise)
        return _choice(tree.condition, then, otherwise)
    parts = [
        replace(p, index=None, vague="of several members")
        if p.index is not None and free_locals(p.index) & names
        else p
        for p in tree.parts
    ]
    return _union([Leaf(tuple(parts))])
