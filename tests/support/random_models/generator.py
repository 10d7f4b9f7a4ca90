# SPDX-License-Identifier: Apache-2.0
"""Random models as text, so that the front end has its part in every comparison.

A model is a tree of items (``random_tree``): what a seed finds can be made small before anyone reads it.
"""

from __future__ import annotations

import random
from contextlib import nullcontext
from dataclasses import dataclass, field, replace

from support.random_models.draws import draw
from support.random_models.expressions import Function, Maker, Reach, visible_only
from support.random_models.laws import sensor
from support.random_models.sorts import BOOL, FLOAT, PROB, Sort, Types, Variable, declare
from support.random_models.tree import Node

DEPTH = 2


@dataclass(frozen=True)
class Owner:
    """An element, or the model itself where the name is empty."""

    name: str
    member: Sort | None
    local: str


@dataclass(frozen=True)
class State:
    """A state variable with what its declaration says besides."""

    read: Variable
    owner: Owner
    fixed: bool
    determined: bool


@dataclass(frozen=True)
class _Names:
    """Names of elements and functions: their own, or those of variables, or one for both."""

    rng: random.Random

    def element(self, i: int) -> str:
        return self.rng.choice((f"e{i}", f"e{i}", f"x{i}", f"k{i}", f"f{i}"))

    def function(self, i: int) -> str:
        return self.rng.choice((f"f{i}", f"f{i}", f"x{i}", f"z{i}", f"e{i}"))


@dataclass
class _Builder:
    make: Maker
    looks: random.Random  # decides alone which visible variables tell of hidden ones at the start
    states: list[State] = field(default_factory=list)
    items: dict[str, list[Node]] = field(default_factory=dict)

    @property
    def types(self) -> Types:
        return self.make.types

    def add(self, owner: Owner, *parts: str | Node) -> None:
        self.items.setdefault(owner.name, []).append(Node("item", "", (*parts, "\n")))

    # What stands where ---------------------------------------------------------------------------

    def assigned(self, sort: Sort, indices: tuple[Sort, ...], exact: bool = False) -> tuple[str | Node, ...]:
        """Return ``= e``, ``~ d`` or a comprehension of them."""
        exact = exact or self.make.chance(0.4)
        sign = "= " if exact else "~ "
        if not indices:
            return sign, self._value(sort, exact)
        with self.make.loop(indices[0]) as name:
            value = self._value(sort, exact)
        return f"{sign}[{name} in {indices[0].text}: ", value, "]"

    def _value(self, sort: Sort, exact: bool) -> Node:
        depth = self.make.rng.randint(1, DEPTH)
        return self.make.of(sort, depth) if exact else draw(self.make, sort, depth)

    def inside(self, owner: Owner) -> None:
        self.make.owner = owner.name
        self.make.locals = [] if owner.member is None else [(owner.local, owner.member)]
        self.make.rounds = 1 if owner.member is None else owner.member.size

    # Declarations --------------------------------------------------------------------------------

    def declare_state(self, owner: Owner, name: str) -> None:
        rng, types = self.make.rng, self.types
        sort = rng.choice([*types.finite, *types.finite, FLOAT, FLOAT, PROB, types.vec])
        visible, fixed = rng.random() < 0.45, rng.random() < 0.12
        if sort in (PROB, types.vec):
            visible = False
        determined = visible and (sort == FLOAT or rng.random() < 0.2)
        indices: tuple[Sort, ...] = ()
        if sort != types.vec and rng.random() < 0.3:
            indices = (rng.choice([*types.indices, types.pos]) if rng.random() < 0.9 else types.pos,)
        read = Variable(owner.name, owner.member, name, sort, indices, visible)
        self.states.append(State(read, owner, fixed, determined))

    def define(self, state: State, lets: tuple[Variable, ...], functions: tuple[Function, ...]) -> None:
        """Add the declaration of a variable, its init and its update as one item."""
        read, owner = state.read, state.owner
        earlier = self.states[: self.states.index(state)]
        self.inside(owner)
        known = Reach(before=tuple(s.read for s in earlier))
        tells = read.visible and read.sort.finite and self.looks.random() < 0.8
        with self.make.reading(visible_only(known) if read.visible and not tells else known):
            init = self.assigned(read.sort, read.indices)
            if owner.member is not None and owner.member.kind == "int" and not read.indices:
                init = self._after_lower(read, owner, init)
        words = ("visible " if read.visible else "hidden ") + ("fixed " if state.fixed else "")
        shape = f"{read.sort.text}[{read.indices[0].text}]" if read.indices else read.sort.text
        parts: list[str | Node] = [f"{words}{read.name}: {shape}\n  init {read.name} ", *init]
        if not state.fixed:
            parts += [f"\n  {read.name}' ", *self._update(state, earlier, lets, functions)]
        self.add(owner, *parts)

    def _after_lower(
        self, read: Variable, owner: Owner, init: tuple[str | Node, ...]
    ) -> tuple[str | Node, ...]:
        """Return an init that reads the member before this one, if there is one."""
        assert owner.member is not None
        if self.make.chance(0.6) or not read.sort.finite or owner.member.low == owner.member.high:
            return init
        before = f"{owner.name}[{owner.local} - 1].{read.name}"
        law = (
            f"noisy({before}, 0.5)"
            if self.make.chance(0.5)
            else f"{{{before}: 0.25, else {read.sort.plain}}}"
        )
        return (f"~ if {owner.local} > {owner.member.low} then {law} else ", *init[1:])

    def _update(
        self, state: State, earlier: list[State], lets: tuple[Variable, ...], functions: tuple[Function, ...]
    ) -> tuple[str | Node, ...]:
        read = state.read
        moving = [s for s in earlier if not s.fixed]
        reach = Reach(
            before=tuple(s.read for s in self.states),
            after=tuple(s.read for s in moving),
            lets=lets,
            functions=functions,
            action=True,
        )
        if state.determined:
            # Nothing hidden and no draw has a part in it, except in a float's own draw.
            sure = tuple(s.read for s in moving if s.determined and s.read.sort != FLOAT)
            reach = visible_only(replace(reach, after=sure, lets=()))
        with self.make.reading(reach):
            return self.assigned(read.sort, read.indices, exact=state.determined and read.sort != FLOAT)

    def define_let(self, owner: Owner, name: str, lets: list[Variable], functions: list[Function]) -> None:
        rng = self.make.rng
        sort = rng.choice([*self.types.finite, FLOAT])
        self.inside(owner)
        reach = Reach(tuple(s.read for s in self.states), (), tuple(lets), tuple(functions), action=True)
        draws = rng.random() < 0.7
        with self.make.reading(reach):
            value = draw(self.make, sort, 1) if draws else self.make.of(sort, DEPTH)
        self.add(owner, f"let {name}: {sort.text} {'~' if draws else '='} ", value)
        lets.append(Variable(owner.name, owner.member, name, sort, draws=draws))

    def define_function(self, name: str, functions: list[Function]) -> None:
        rng, types = self.make.rng, self.types
        argument, sort = (
            rng.choice([types.small, types.index, BOOL, FLOAT]),
            rng.choice([FLOAT, BOOL, types.small]),
        )
        hidden, law = rng.random() < 0.5, rng.random() < 0.3
        reach = Reach(before=tuple(s.read for s in self.states), functions=tuple(functions))
        self.inside(MODEL)
        with self.make.reading(reach if hidden else visible_only(reach)), self.make.bound(argument) as formal:
            body = draw(self.make, sort, 1) if law else self.make.of(sort, DEPTH)
        self.add(MODEL, f"fn {name}({formal}: {argument.text}): {sort.text} {'~' if law else '='} ", body)
        functions.append(Function(name, argument, sort, hidden, law))


MODEL = Owner("", None, "")


def model(seed: int, attempt: int = 0) -> Node:
    """Return a random model; by bad luck it may have a mistake, such as a division by 1 - 1."""
    rng = random.Random(f"{seed} {attempt}")
    types = declare(rng)
    make = Maker(rng, types)
    joint = types.index.high - types.index.low < 2 and rng.random() < 0.25
    make.action_member = types.index if joint else None
    build = _Builder(make, random.Random(f"first looks of {seed} {attempt}"))
    _declare_constants(build, joint)

    names = _Names(random.Random(f"names of {seed} {attempt}"))
    owners = [
        Owner(names.element(i), rng.choice([None, None, types.index, BOOL]), f"m{i}")
        for i in range(rng.randint(1, 3))
    ]
    for i in range(rng.randint(2, 6)):
        build.declare_state(rng.choice(owners), f"x{i}")
    functions: list[Function] = []
    for i in range(rng.randint(0, 3)):
        build.define_function(names.function(i), functions)
    lets: list[Variable] = []
    for i in range(rng.randint(0, 3)):
        build.define_let(rng.choice(owners), f"k{i}", lets, functions)
    for state in build.states:
        build.define(state, tuple(lets), tuple(functions))
    step = Reach(
        before=tuple(s.read for s in build.states),
        after=tuple(s.read for s in build.states if not s.fixed),
        lets=tuple(lets),
        functions=tuple(functions),
        action=True,
        primed_calls=True,
    )
    observed = _declare_step(build, [MODEL, *owners], step)
    observed += _declare_sensors(build, [MODEL, *owners], step, f"{seed} {attempt}")
    _declare_policy(build, Reach(before=step.before, functions=step.functions), observed, joint)
    _declare_drawings(build, Reach(before=step.before), f"{seed} {attempt}")

    parts: list[str | Node] = [f"model Random{seed}\n", "\n".join(types.declarations), "\n"]
    for owner in owners:
        binder = "" if owner.member is None else f"[{owner.local} in {owner.member.text}]"
        inside = [part for item in build.items.pop(owner.name, []) for part in ("  ", item)]
        parts.append(Node("item", "", (f"element {owner.name}{binder} {{\n", *inside, "}\n")))
    return Node("model", "", (*parts, *build.items[""], *_looked_at(f"{seed} {attempt}", types, joint)))


def _looked_at(seed: str, types: Types, joint: bool) -> tuple[Node, ...]:
    """Return, for some models, a family of bools of which the action chooses the one that is seen.

    It has random numbers of its own: the rest of a seed's model does not depend on it.
    """
    rng = random.Random(f"looked at {seed}")
    if rng.random() > 0.3:
        return ()
    act = f"act[{types.index.low}]" if joint else "act"
    update = rng.choice(
        ["= good", "~ noisy(good, 0.75)", f"= good and {act} != move(m)", f"= good != ({act} == move(m))"]
    )
    seen = rng.choice(
        ["= {}", "= not {}", "~ noisy({}, 0.875)", "~ {{true: if {} then 0.75 else 0.125, else false}}"]
    )
    sign, value = seen[0], seen[2:].format("g[i].good'")
    family = "element g[m in Small] {\n  hidden good: bool\n  init good ~ bernoulli(0.5)\n"
    family += f"  good' {update}\n}}\n"
    rest = rng.choice(["false", "true", "bernoulli(0.25)" if sign == "~" else "false"])
    text = f"observe look_at: bool {sign} match {act} {{ move(i) => {value}  else => {rest} }}\n"
    return Node("item", "", (family,)), Node("item", "", (text,))


def _declare_constants(build: _Builder, joint: bool) -> None:
    rng, types = build.make.rng, build.types
    entries = range(types.index.high - types.index.low + 1)
    offsets = ", ".join(str(rng.randint(types.small.low, types.small.high)) for _ in entries)
    worth = ", ".join(f"[{rng.randint(-7, 8)}, {rng.randint(-7, 8)}]" for _ in entries)
    for text in (
        "discount 0.95",
        f"action act: Act{'[Index]' if joint else ''}",
        f"param offset: Small[Index] = [{offsets}]",
        f"param scale: float = {rng.choice(['1.5', '-0.75', '3'])}",
        f"param chance: prob = {rng.choice(['0.3', '0.5', '0.0', '1.0'])}",
        f"const worth: int[Index, bool] = [{worth}]",
        "const place: int[Pos] = [p in Pos: p.row * p.col]",
    ):
        build.add(MODEL, text)


def _declare_step(build: _Builder, owners: list[Owner], step: Reach) -> tuple[Variable, ...]:
    """Add observations, which are returned, rewards, ends and legality."""
    observed: list[Variable] = []
    make, rng, types = build.make, build.make.rng, build.types
    with make.reading(step):
        for i in range(rng.randint(0, 3)):
            build.inside(owner := rng.choice(owners))
            sort = rng.choice(types.finite)
            indices = (rng.choice([*types.indices, types.pos]),) if rng.random() < 0.4 else ()
            shape = f"{sort.text}[{indices[0].text}]" if indices else sort.text
            build.add(owner, f"observe z{i}: {shape} ", *build.assigned(sort, indices))
            observed.append(Variable(owner.name, owner.member, f"z{i}", sort, indices))
        for i in range(rng.randint(1, 4)):
            build.inside(owner := rng.choice(owners))
            value = make.integer(DEPTH) if rng.random() < 0.4 else make.number(DEPTH)
            build.add(owner, f"reward r{i} = ", value)
        build.inside(MODEL)
        if rng.random() < 0.6:
            few = make.node(BOOL, "(", make.leaf(types.small), f" == {types.small.high})")
            build.add(MODEL, "terminal when ", make.node(BOOL, "(", make.truth(DEPTH), " and ", few, ")"))
        if rng.random() < 0.5:
            build.add(MODEL, "success when ", make.truth(DEPTH))
    if rng.random() < 0.6:
        with make.reading(visible_only(Reach(before=step.before, functions=step.functions, action=True))):
            moves = make.node(BOOL, "(", make.action(), " == wait)")
            build.add(MODEL, "legal when ", make.node(BOOL, "(", moves, " or ", make.truth(DEPTH), ")"))
    return tuple(observed)


def _declare_sensors(build: _Builder, owners: list[Owner], step: Reach, seed: str) -> tuple[Variable, ...]:
    """Add to some models observations of continuous laws, which are returned.

    They have random numbers of their own, as ``_looked_at``.
    """
    rng = random.Random(f"sensors of {seed}")
    if rng.random() > 0.33:
        return ()
    old, make = build.make, Maker(rng, build.types)
    make.action_member, build.make = old.action_member, make
    observed: list[Variable] = []
    with make.reading(step):
        for i in range(rng.randint(1, 2)):
            build.inside(owner := rng.choice(owners))
            indices = (rng.choice(build.types.indices),) if rng.random() < 0.3 else ()
            with make.loop(indices[0]) if indices else nullcontext("") as name:
                parts = sensor(make, DEPTH)
            shape = f"float[{indices[0].text}]" if indices else "float"
            law = (f"[{name} in {indices[0].text}: ", *parts, "]") if indices else parts
            build.add(owner, f"observe w{i}: {shape} ~ ", *law)
            observed.append(Variable(owner.name, owner.member, f"w{i}", FLOAT, indices))
    build.make = old
    return tuple(observed)


def _declare_drawings(build: _Builder, known: Reach, seed: str) -> None:
    """Add a picture to some models; it has random numbers of its own, as ``_looked_at``."""
    rng = random.Random(f"drawings of {seed}")
    if rng.random() > 0.5:
        return
    old, make = build.make, Maker(rng, build.types)
    make.action_member, build.make = old.action_member, make
    build.inside(MODEL)
    build.add(MODEL, "draw world = area { x = -999999, y = -999999, x2 = 999999, y2 = 999999 }")
    with make.reading(known):
        for i in range(rng.randint(1, 3)):
            shape, more = rng.choice(
                [("cell", ()), ("marker", ()), ("rectangle", ("width", "height")), ("line", ("x2", "y2"))]
            )
            families = rng.random() < 0.5
            with make.loop(build.types.small) if families else nullcontext("") as name:
                head = (f"[{name} in Small where ", make.truth(DEPTH), "]") if families else ()
                fields: list[str | Node] = []
                for field_name in ("x", "y", *more):
                    number = (
                        make.integer(DEPTH) if shape == "cell" or rng.random() < 0.5 else make.number(DEPTH)
                    )
                    fields += [f"{field_name} = ", number, ", "]
                colour = ("if ", make.truth(1), " then red else blue")
            build.add(MODEL, f"draw d{i}", *head, f" = {shape} {{ ", *fields, "colour = ", *colour, " }")
    build.make = old


def _declare_memory(build: _Builder, known: Reach, indices: tuple[Sort, ...]) -> Reach:
    """Add a policy that remembers; return what a lower bound may read besides."""
    make, rng, types = build.make, build.make.rng, build.types
    parts: list[str | Node] = []
    memory: list[Variable] = []
    with make.reading(replace(known, observed=())):
        for i in range(rng.randint(0, 3)):
            sort = rng.choice([*types.finite, types.act, FLOAT])
            shape = (rng.choice(types.indices),) if rng.random() < 0.3 else ()
            memory.append(Variable("", None, f"q{i}", sort, shape))
            text = f"memory q{i}: {sort.text}{f'[{shape[0].text}]' if shape else ''} "
            parts.append(Node("item", "", (text, *build.assigned(sort, shape, exact=True), "\n")))
    known = replace(known, memory=tuple(memory), remembers=True)
    lets: list[Variable] = []
    for i in range(rng.randint(0, 2)):
        sort, draws = rng.choice([*types.finite, FLOAT]), rng.random() < 0.7
        with make.reading(replace(known, lets=tuple(lets))):
            value = draw(make, sort, 1) if draws else make.of(sort, DEPTH)
        parts.append(Node("item", "", (f"let p{i}: {sort.text} {'~' if draws else '='} ", value, "\n")))
        lets.append(Variable("", None, f"p{i}", sort))
    with make.reading(known):
        for cell in memory:
            assigned = build.assigned(cell.sort, cell.indices, exact=True)
            parts.append(Node("item", "", (f"{cell.name}' ", *assigned, "\n")))
    with make.reading(replace(known, lets=tuple(lets))):
        parts += ["choose ", *build.assigned(types.act, indices), "\n"]
    build.add(MODEL, "policy default {\n", *parts, "}")
    return known


def _declare_policy(build: _Builder, reach: Reach, observed: tuple[Variable, ...], joint: bool) -> None:
    """Add the default policy and the bounds."""
    make, rng, types = build.make, build.make.rng, build.types
    build.inside(MODEL)
    indices = (types.index,) if joint else ()
    known, kind = visible_only(reach), rng.random()
    if kind < 0.4:
        known = _declare_memory(build, replace(known, observed=observed), indices)
    elif kind < 0.75:
        with make.reading(known):
            build.add(MODEL, "policy default ", *build.assigned(types.act, indices))
    if rng.random() < 0.5:
        with make.reading(known):
            build.add(MODEL, "bound lower = ", make.number(DEPTH))
    with make.reading(reach):
        build.add(MODEL, "bound upper = ", make.number(DEPTH))
        build.add(MODEL, "bound tail = ", make.number(1))
