# SPDX-License-Identifier: Apache-2.0
"""Random expressions: of every type, with every operator, over whatever may be read where they stand."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial

from support.random_models.sorts import BOOL, FLOAT, Sort, Types, Variable
from support.random_models.tree import Node

INT = Sort("int", "int", -99, 99)
MOST_ROUNDS = 300
OF_FLOATS = ("sqrt", "exp", "log", "log2", "sin", "cos", "tan", "asin", "acos", "abs", "sign", "-")


@dataclass(frozen=True)
class Function:
    """A model function of one argument, or a named law; ``hidden`` if it may read hidden state."""

    name: str
    argument: Sort
    sort: Sort
    hidden: bool
    law: bool = False


@dataclass(frozen=True)
class Reach:
    """What may be read: variables before and after the step, lets, functions, the action, the history."""

    before: tuple[Variable, ...] = ()
    after: tuple[Variable, ...] = ()
    lets: tuple[Variable, ...] = ()
    functions: tuple[Function, ...] = ()
    memory: tuple[Variable, ...] = ()
    observed: tuple[Variable, ...] = ()
    remembers: bool = False  # what was done and seen last
    action: bool = False
    primed_calls: bool = False


@dataclass
class Maker:
    """Makes random expressions within its ``reach``."""

    rng: random.Random
    types: Types
    reach: Reach = field(default_factory=Reach)
    locals: list[tuple[str, Sort]] = field(default_factory=list)
    owner: str = ""  # the element in which the expression stands
    member: str = ""  # the local that names its member
    names: int = 0
    rounds: int = 1  # of the loops in which the expression stands
    action_member: Sort | None = None  # the index of a joint action

    def pick(self, *kinds: str) -> str:
        return self.rng.choice(kinds)

    def chance(self, probability: float) -> bool:
        return self.rng.random() < probability

    @contextmanager
    def reading(self, reach: Reach) -> Iterator[None]:
        """Change what may be read."""
        before, self.reach = self.reach, reach
        yield
        self.reach = before

    @contextmanager
    def bound(self, sort: Sort) -> Iterator[str]:
        """Add a local."""
        self.names += 1
        name = f"v{self.names}"
        self.locals.append((name, sort))
        yield name
        self.locals.pop()

    @contextmanager
    def loop(self, sort: Sort) -> Iterator[str]:
        """Add a local that takes every value of a type."""
        self.rounds *= sort.size
        with self.bound(sort) as name:
            yield name
        self.rounds //= sort.size

    def fits(self, sort: Sort) -> bool:
        """Return whether a loop over a type may stand here: each round costs the interpreter time."""
        return self.rounds * sort.size <= MOST_ROUNDS

    def node(self, sort: Sort, *parts: str | Node) -> Node:
        return Node(sort.text, sort.plain, parts)

    # Values of a type ----------------------------------------------------------------------------

    def of(self, sort: Sort, depth: int) -> Node:
        """Return an expression that provably lies within a type."""
        match sort.kind:
            case "bool":
                return self.truth(depth)
            case "float":
                return self.number(depth)
            case "prob":
                return self.node(sort, "clamp(", self.number(depth), ", 0, 1)")
            case "int":
                return self.ranged(sort, depth)
        return self.composed(sort, depth)

    def ranged(self, sort: Sort, depth: int) -> Node:
        if depth <= 0 or self.chance(0.3):
            return self.leaf(sort)
        function = self.pick("clamp", "clamp", "clamp", "wrap", "wrap", "checked")
        value = self.integer(depth)
        if function == "checked":  # what can never fit is refused
            value = self.int_node(
                "(if ", self.truth(depth - 1), " then ", value, " else ", self.leaf(sort), ")"
            )
        return self.node(sort, f"{function}(", value, f", {sort.low}, {sort.high})")

    def composed(self, sort: Sort, depth: int) -> Node:
        """Return a value of an enum or record."""
        if depth <= 0 or self.chance(0.3):
            return self.leaf(sort)
        if self.chance(0.35):
            return self.choice(sort, depth)
        if sort.kind == "record" and self.chance(0.3):
            name, part = self.rng.choice(sort.parts)
            assert part is not None
            whole = self.of(sort, depth - 1)
            return self.node(sort, "(", whole, f" with {{ {name} = ", self.of(part, depth - 1), " })")
        if sort.kind == "record":
            return self.node(sort, f"{sort.text}(", *self._listed([s for _, s in sort.parts], depth), ")")
        name, argument = self.rng.choice(sort.parts)
        if argument is None:
            return self.node(sort, name)
        return self.node(sort, f"{name}(", self.of(argument, depth - 1), ")")

    def _listed(self, sorts: Sequence[Sort | None], depth: int) -> list[str | Node]:
        listed: list[str | Node] = []
        for sort in sorts:
            assert sort is not None
            listed += [", ", self.of(sort, depth - 1)]
        return listed[1:]

    def choice(self, sort: Sort, depth: int) -> Node:
        """Return ``if``, ``match`` or ``let``."""
        kind = self.pick("if", "if", "match", "let")
        if kind == "if":
            condition, then, otherwise = (
                self.truth(depth - 1),
                self.of(sort, depth - 1),
                self.of(sort, depth - 1),
            )
            return self.node(sort, "(if ", condition, " then ", then, " else ", otherwise, ")")
        if kind == "match":
            return self.matched(sort, depth)
        inner = self.rng.choice([BOOL, FLOAT, self.types.small, self.types.mode, self.types.pos])
        value = self.of(inner, depth - 1)
        with self.bound(inner) as name:
            typed = f": {inner.text}" if self.chance(0.3) else ""
            return self.node(sort, f"(let {name}{typed} = ", value, " in ", self.of(sort, depth - 1), ")")

    def matched(self, sort: Sort, depth: int) -> Node:
        """Return ``match`` of a value of an enum, with the arguments of its variants."""
        if self.chance(0.3):
            low, high = self.types.small.low, self.types.small.high
            value = self.of(self.types.small, depth - 1)  # a pattern that it cannot be would be refused
            arms: list[str | Node] = ["(match (if ", self.truth(0), f" then {low} else if ", self.truth(0)]
            arms += [f" then {high} else ", value, ") { "]
            for pattern in self.rng.sample(range(low, high + 1), 2):
                arms += [f"{pattern} => ", self.of(sort, depth - 1), ", "]
            return self.node(sort, *arms, "else => ", self.of(sort, depth - 1), " })")
        enum = self.types.act if self.reach.action and self.chance(0.5) else self.types.mode
        arms = ["(match ", self.action() if enum == self.types.act else self.of(enum, depth - 1), " { "]
        for name, argument in enum.parts[:-1]:
            if argument is None:
                arms += [f"{name} => ", self.of(sort, depth - 1)]
            else:
                with self.bound(argument) as local:
                    arms += [f"{name}({local}) => ", self.of(sort, depth - 1)]
            arms.append(", ")
        return self.node(sort, *arms, "else => ", self.of(sort, depth - 1), " })")

    # Reads ---------------------------------------------------------------------------------------

    def leaf(self, sort: Sort) -> Node:
        """Return a read or a constant of exactly this type."""
        # Only the one that is picked is built: an index of a read may hold further reads.
        found: list[Callable[[], Node]] = [
            partial(self.node, sort, name) for name, local in self.locals if local == sort
        ]
        for variables, prime in ((self.reach.before, ""), (self.reach.after, "'"), (self.reach.lets, "")):
            found += [partial(self.read, v, prime) for v in variables if v.sort == sort]
        found += [partial(self.read, v) for v in self.reach.memory if v.sort == sort]
        found += [partial(self._last_seen, v) for v in self.reach.observed if v.sort == sort]
        if sort == self.types.act and self.reach.remembers:
            found.append(lambda: self._last(self.action()))
        if sort == self.types.act and self.reach.action:
            found.append(self.action)
        if sort == self.types.small:
            found.append(lambda: self.node(sort, "offset[", self.of(self.types.index, 0), "]"))
        if sort == FLOAT:
            found.append(lambda: self.node(sort, "scale"))
        if sort == BOOL:
            found.append(lambda: self.node(sort, "(scale > 1.0)"))
        if found and self.chance(0.9):
            return self.rng.choice(found)()
        return self.constant(sort)

    def constant(self, sort: Sort) -> Node:
        match sort.kind:
            case "bool":
                return self.node(sort, self.pick("true", "false"))
            case "int":
                return self.node(sort, str(self.rng.randint(sort.low, sort.high)))
            case "float":
                return self.node(sort, self.pick("0.0", "1.0", "(-0.5)", "2.0", "0.125", "3.5"))
            case "prob":
                return self.node(sort, self.pick("0.25", "0.5", "chance"))
            case "enum":
                name, argument = self.rng.choice(sort.parts)
                inner = [] if argument is None else ["(", self.constant(argument), ")"]
                return self.node(sort, name, *inner)
        listed: list[str | Node] = []
        for _, part in sort.parts:
            assert part is not None
            listed += [", ", self.constant(part)]
        return self.node(sort, f"{sort.text}(", *listed[1:], ")")

    def read(self, variable: Variable, prime: str = "") -> Node:
        """Return a read: short where the element is one's own, of a random member otherwise."""
        if prime:  # of the indices too, so that they read no state
            with self.reading(Reach()):
                read = self.read(variable)
            return self.node(variable.sort, *read.parts, prime)
        own = variable.element == self.owner and (variable.member is None or self.chance(0.6))
        parts: list[str | Node] = [variable.name]
        if variable.element and not own:
            member: list[str | Node] = []
            if variable.member is not None:
                member = ["[", self.index_of(variable.member), "]"]
            parts = [variable.element, *member, ".", variable.name]
        if variable.indices:
            indices: list[str | Node] = []
            for sort in variable.indices:
                indices += [", ", self.index_of(sort)]
            parts += ["[", *indices[1:], "]"]
        return self.node(variable.sort, *parts)

    def index_of(self, sort: Sort) -> Node:
        """Return an index: a local or a constant, or seldom anything."""
        if self.chance(0.15):
            return self.of(sort, 1)
        found = [self.node(sort, name) for name, local in self.locals if local == sort]
        return self.rng.choice(found) if found and self.chance(0.7) else self.constant(sort)

    def action(self) -> Node:
        index: list[str | Node] = []
        if self.action_member is not None:
            index = ["[", self.index_of(self.action_member), "]"]
        return self.node(self.types.act, "act", *index)

    def _last_seen(self, variable: Variable) -> Node:
        return self._last(self.read(variable))

    def _last(self, seen: Node) -> Node:
        sort = self.types.act if seen.sort == self.types.act.text else None
        kinds = (*self.types.finite, FLOAT)
        first = self.constant(sort or next(t for t in kinds if t.text == seen.sort))
        return Node(seen.sort, seen.plain, ("last(", seen, ", ", first, ")"))

    # Ints ----------------------------------------------------------------------------------------

    def integer(self, depth: int) -> Node:
        """Return an int of moderate size."""
        if depth <= 0:
            return self.int_node(self.leaf(self.rng.choice([self.types.small, self.types.index])))
        kinds = ("binary", "binary", "power", "unary", "choice", "round", "quantified", "table", "field")
        match self.pick(*kinds, "index", "at", "call"):
            case "binary":
                op = self.pick("+", "-", "*", "//", "%", "min", "max")
                a, b = self.integer(depth - 1), self.integer(depth - 1)
                if op in ("min", "max"):
                    return self.int_node(f"{op}(", a, ", ", b, ")")
                if op == "*":
                    return self.int_node("clamp(", a, " * ", b, ", -99, 99)")
                if op in ("//", "%") and self.chance(0.5):
                    return self.int_node("(", a, f" {op} {self.pick('2', '3', '4', '(-3)')})")
                return self.int_node("(", a, f" {op} ", b, ")")
            case "power":
                return self.int_node("(", self.integer(0), f" ** {self.pick('0', '1', '2', '3')})")
            case "unary":
                op = self.pick("-", "abs", "sign")
                return self.int_node(f"({op}(" if op == "-" else f"({op}(", self.integer(depth - 1), "))")
            case "choice":
                return self.int_node(self.choice(INT, depth))
            case "round":
                op = self.pick("floor", "ceil", "round")
                return self.int_node(f"clamp({op}(", self.number(depth - 1), "), -99, 99)")
            case "quantified":
                return self.quantified(self.pick("sum", "count", "min", "max", "argmin", "argmax"), depth)
            case "table":
                return self.int_node("worth[", self.of(self.types.index, depth - 1), ", ", self.truth(0), "]")
            case "field":
                name, sort = self.rng.choice([p for p in self.types.pos.parts if p[1] and p[1].kind == "int"])
                return self.int_node(self.of(self.types.pos, depth - 1), f".{name}")
            case "index":
                return self.int_node("index(", self.of(self.types.mode, depth - 1), ")")
            case "at" if self.chance(0.5):
                return self.int_node("at(offset, ", self.integer(depth - 1), ", ", self.integer(0), ")")
            case "at":  # of an array whose index is a record, field by field
                fields: list[str | Node] = []
                for _, part in self.types.pos.parts:
                    assert part is not None
                    value = self.integer(depth - 1) if part.kind == "int" else self.of(part, 0)
                    fields += [", ", value]
                return self.int_node("at(place", *fields, ", ", self.integer(0), ")")
        return self.called(self.types.small, depth) or self.integer(depth - 1)

    def int_node(self, *parts: str | Node) -> Node:
        return Node("int", "1", parts)

    def called(self, sort: Sort, depth: int) -> Node | None:
        """Return a call of a function, if one gives this type; primed where the next state may be read."""
        functions = [f for f in self.reach.functions if f.sort == sort and not f.law]
        if not functions:
            return None
        function = self.rng.choice(functions)
        if self.reach.primed_calls and self.chance(0.4):
            # What is given is primed too.
            with self.reading(Reach(self.reach.before, functions=self.reach.functions, action=True)):
                argument = self.of(function.argument, depth - 1)
            return self.node(sort, f"{function.name}(", argument, ")'")
        return self.node(sort, f"{function.name}(", self.of(function.argument, depth - 1), ")")

    def quantified(self, kind: str, depth: int, of_floats: bool = False) -> Node:
        """Return a quantifier over a finite type."""
        sort = self.types.index if kind.startswith("arg") else self.rng.choice(self.types.indices)
        if not self.fits(sort):
            if kind in ("any", "all"):
                return self.leaf(BOOL)
            return self.number(0) if of_floats else self.integer(0)
        with self.loop(sort) as name:
            where: list[str | Node] = [" where ", self.truth(depth - 1)] if self.chance(0.7) else []
            body: list[str | Node] = []
            if kind == "any" and where and self.chance(0.5):
                body = []  # a condition alone
            elif kind in ("any", "all"):
                body = [": ", self.truth(depth - 1)]
            elif kind != "count":
                body = [": ", self.number(depth - 1) if of_floats else self.of(self.types.small, depth - 1)]
        rest: list[str | Node] = []
        if kind in ("min", "max") and (where or self.chance(0.2)):
            rest = [" else ", self.number(0) if of_floats else self.integer(0)]
        if kind in ("argmin", "argmax") and (where or self.chance(0.2)):
            rest = [" else ", self.leaf(sort)]
        parts = (f"{kind}({name} in {sort.text}", *where, *body, *rest, ")")
        if kind in ("any", "all"):
            return self.node(BOOL, *parts)
        return self.node(FLOAT, *parts) if of_floats else self.int_node(*parts)

    # Truth values --------------------------------------------------------------------------------

    def truth(self, depth: int) -> Node:
        if depth <= 0:
            return self.leaf(BOOL)
        kinds = ("ints", "ints", "floats", "and", "or", "not", "any", "all", "same", "choice", "call", "is")
        kind = self.pick(*kinds)
        match kind:
            case "and" | "or":
                return self.node(BOOL, "(", self.truth(depth - 1), f" {kind} ", self.truth(depth - 1), ")")
            case "not":
                return self.node(BOOL, "(not ", self.truth(depth - 1), ")")
            case "any" | "all":
                return self.quantified(kind, depth)
            case "same":
                sort = self.rng.choice(self.types.finite)
                if self.reach.action and self.chance(0.4):
                    sort = self.types.act
                op = self.pick("==", "!=")
                return self.node(
                    BOOL, "(", self.of(sort, depth - 1), f" {op} ", self.of(sort, depth - 1), ")"
                )
            case "is":
                enum = self.types.act if self.reach.action and self.chance(0.4) else self.types.mode
                name, _ = self.rng.choice(enum.parts)
                return self.node(BOOL, "(", self.of(enum, depth - 1), f" is {name})")
            case "choice":
                return self.choice(BOOL, depth)
            case "call":
                return self.called(BOOL, depth) or self.truth(depth - 1)
        make = self.number if kind == "floats" else self.integer
        op = self.pick("<", "<=", ">", ">=")
        return self.node(BOOL, "(", make(depth - 1), f" {op} ", make(depth - 1), ")")

    # Floats --------------------------------------------------------------------------------------

    def number(self, depth: int) -> Node:
        if depth <= 0:
            return self.leaf(FLOAT)
        match self.pick(
            *("binary", "binary", "mixed", "unary", "choice", "clamp", "power", "sum", "field", "call", "cdf")
        ):
            case "cdf":
                law = self.pick("normal(0.5, 1.5)", "exponential(0.75)", "uniform(-1.0, 2.0)")
                return self.node(FLOAT, f"cdf({law}, ", self.number(depth - 1), ")")
            case "binary":
                op = self.pick("+", "-", "*", "/", "min", "max", "hypot", "atan2")
                a, b = self.number(depth - 1), self.number(depth - 1)
                if op.isalnum():
                    return self.node(FLOAT, f"{op}(", a, ", ", b, ")")
                if str(b) == "0.0":
                    b = self.node(FLOAT, "2.0")
                return self.node(FLOAT, "(", a, f" {op} ", b, ")")
            case "mixed":
                op = self.pick("+", "-", "*")
                return self.node(FLOAT, "(", self.number(depth - 1), f" {op} ", self.integer(depth - 1), ")")
            case "unary":
                op = self.rng.choice(OF_FLOATS)
                # A constant outside of the function's domain would be refused.
                more = " * scale" if op in ("log", "log2") else ""
                return self.node(FLOAT, f"({op}(", self.number(depth - 1), f"{more}))")
            case "choice":
                return self.choice(FLOAT, depth)
            case "clamp":
                return self.node(FLOAT, "clamp(", self.number(depth - 1), ", -1.5, 2.0)")
            case "power":
                return self.node(FLOAT, "((", self.number(depth - 1), " * scale) ** ", self.number(0), ")")
            case "sum":
                return self.quantified(self.pick("sum", "min", "max"), depth, of_floats=True)
            case "field":
                return self.node(FLOAT, self.of(self.types.vec, depth - 1), self.pick(".x", ".y"))
        return self.called(FLOAT, depth) or self.number(depth - 1)


def visible_only(reach: Reach) -> Reach:
    """Return a reach without hidden variables and without functions that may read them."""
    return replace(
        reach,
        before=tuple(v for v in reach.before if v.visible),
        after=tuple(v for v in reach.after if v.visible),
        functions=tuple(f for f in reach.functions if not f.hidden),
    )
