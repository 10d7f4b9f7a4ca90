# SPDX-License-Identifier: Apache-2.0
"""Hand-built IR: the models that tests of single stages start from."""

from __future__ import annotations

from typing import Any

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.values import Word
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import BOOL, FLOAT, INT, PROB, Enum, Float, Int, Type, Variant

DOOR = Enum("Door", (Variant("left"), Variant("right")))
TIGER_ACT = Enum("Act", (Variant("listen"), Variant("open_left"), Variant("open_right")))

COL = Int(0, 3)
ROW = Int(0, 2)
ROCK = Int(0, 1)
READING = Enum("Reading", (Variant("nothing"), Variant("looks_good"), Variant("looks_bad")))
ROCK_ACT = Enum("Act", (Variant("east"), Variant("west"), Variant("sample"), Variant("check", ROCK)))


class _Given:
    """Draws of given words: ``words`` one behind the other, ``second`` where the first ties."""

    def __init__(self, words: tuple[Any, ...], second: Any) -> None:
        self._words = words
        self._second = second

    def word(self, site: int, index: Any) -> Any:
        number, is_second = int(index) >> 24 & 127, int(index) >> 31
        return np.asarray(self._second if is_second else self._words[number], np.uint64)


def word(first: Any, second: Any = 0, *behind: Any) -> Word:
    """Return the word of a draw, in each lane, the one that decides where it ties, and those behind it."""
    return Word(_Given((first, *behind), second), 0, 0)


def span(line: int, file: str = "sample.pomdp") -> Span:
    return Span(file, line, 1, line, 2)


def const(value: bool | int | float, type_: Type | None = None) -> ir.Const:
    if type_ is None:
        type_ = BOOL if isinstance(value, bool) else Int(value, value) if isinstance(value, int) else FLOAT
    return ir.Const(type_, value)


def variant(enum: Enum, name: str) -> ir.Const:
    return ir.Const(enum, enum.offsets[name])


def equal(left: ir.Expr, right: ir.Expr) -> ir.Binary:
    return ir.Binary(BOOL, "eq", left, right)


def both(left: ir.Expr, right: ir.Expr) -> ir.Binary:
    return ir.Binary(BOOL, "and", left, right)


def tiger() -> ir.Model:
    """Build Tiger as its file says."""
    here, there = ir.StateRead(DOOR, "room.tiger"), ir.StateRead(DOOR, "room.tiger", (), True)
    act = ir.ActionRead(TIGER_ACT)
    listening = equal(act, variant(TIGER_ACT, "listen"))

    def outcome(door: str) -> ir.Expr:
        return ir.If(Int(-100, 10), equal(here, variant(DOOR, door)), const(-100), const(10))

    reward = ir.If(
        Int(-100, 10),
        listening,
        const(-1),
        ir.If(Int(-100, 10), equal(act, variant(TIGER_ACT, "open_left")), outcome("left"), outcome("right")),
    )
    return ir.Model(
        name="Tiger",
        file="models/tiger.pomdp",
        source_hash="00" * 32,
        discount=0.949999988079071,
        horizon=None,
        enums=(DOOR, TIGER_ACT),
        records=(),
        params=(ir.Param("hearing", PROB, (), (0.8500000238418579,), span(6)),),
        tables=(),
        elements=(ir.Element("room", None, span(10)),),
        variables=(ir.Variable("room.tiger", "room", DOOR, (), False, False, span(11)),),
        lets=(),
        functions=(),
        action=ir.Action("act", TIGER_ACT, (), span(8)),
        inits=(ir.Assign("room.tiger", (), ir.Uniform(DOOR), ir.Site("init:room.tiger"), span(12)),),
        updates=(
            ir.Assign(
                "room.tiger",
                (),
                ir.IfDist(DOOR, listening, ir.Certain(DOOR, here), ir.Uniform(DOOR)),
                ir.Site("room.tiger"),
                span(13),
            ),
        ),
        observations=(
            ir.Observation(
                "heard",
                None,
                DOOR,
                (),
                ir.IfDist(
                    DOOR,
                    listening,
                    ir.Noisy(DOOR, there, ir.ParamRead(PROB, "hearing")),
                    ir.Uniform(DOOR),
                ),
                ir.Site("observe:heard"),
                span(16),
            ),
        ),
        rewards=(ir.Reward("outcome", None, None, reward, span(19)),),
        terminal=const(False),
        legal=const(True),
        policy=ir.Policy(
            (), ir.Certain(TIGER_ACT, variant(TIGER_ACT, "listen")), ir.Site("policy:default"), span(25)
        ),
        upper=const(200.0),
        tail=const(-2000.0),
        lower=None,
        success=None,
        key=(ir.KeyField("heard", True, DOOR, ()),),
    )


def rocks() -> ir.Model:
    """Build a small RockSample: a family, an enum with an argument, a table, a function, a let."""
    act = ir.ActionRead(ROCK_ACT)
    x, x_next = ir.StateRead(COL, "rover.x"), ir.StateRead(COL, "rover.x", (), True)
    r = ir.Local(ROCK, "r")
    rock_x = ir.ParamRead(COL, "rock_x", (r,))
    good = ir.StateRead(BOOL, "rock.good", (r,))
    here = ir.Call(BOOL, "here", (r,))
    sampling = both(equal(act, variant(ROCK_ACT, "sample")), here)
    gamma = ir.Const(FLOAT, 0.949999988079071)

    distance = ir.Unary(
        FLOAT,
        "neg",
        ir.Binary(
            FLOAT,
            "div",
            ir.ToFloat(FLOAT, ir.Unary(Int(0, 3), "abs", ir.Binary(Int(-3, 3), "sub", x, rock_x))),
            ir.ParamRead(FLOAT, "half_distance"),
        ),
    )
    accuracy = ir.Function(
        "accuracy",
        (ir.Binder("r", ROCK),),
        PROB,
        ir.Binary(
            PROB,
            "mul",
            const(0.5),
            ir.Binary(FLOAT, "add", const(1.0), ir.Binary(FLOAT, "pow", const(2.0), distance)),
        ),
        span(9),
    )

    def reading(likely: str, unlikely: str) -> ir.Dist:
        p = ir.Call(PROB, "accuracy", (r,), primed=True)
        return ir.Table(READING, ((variant(READING, likely), p),), variant(READING, unlikely))

    read_good = ir.StateRead(BOOL, "rock.good", (r,), True)
    checked = ir.LetDist(
        READING,
        "r",
        ir.VariantArgument(ROCK, ROCK_ACT, "check", act),
        ir.IfDist(READING, read_good, reading("looks_good", "looks_bad"), reading("looks_bad", "looks_good")),
    )
    walk = ir.ToFloat(FLOAT, ir.Binary(Int(0, 3), "sub", const(3), x))
    rocks_left = ir.Quantified(
        Float(),
        "sum",
        (ir.Binder("r", ROCK),),
        good,
        const(10.0),
        None,
    )
    step_x = ir.If(
        COL,
        equal(act, variant(ROCK_ACT, "east")),
        ir.Clamp(COL, ir.Binary(Int(1, 4), "add", x, const(1)), 0, 3),
        ir.If(
            COL,
            equal(act, variant(ROCK_ACT, "west")),
            ir.Clamp(COL, ir.Binary(Int(-1, 2), "sub", x, const(1)), 0, 3),
            x,
        ),
    )
    legal = ir.Binary(
        BOOL,
        "or",
        ir.Binary(BOOL, "ne", act, variant(ROCK_ACT, "sample")),
        ir.Quantified(BOOL, "any", (ir.Binder("r", ROCK),), None, here, None),
    )
    exit_ = ir.If(
        Int(0, 10), both(equal(x_next, const(3)), ir.Binary(BOOL, "lt", x, const(3))), const(10), const(0)
    )
    sampled = ir.If(Int(-10, 10), sampling, ir.If(Int(-10, 10), good, const(10), const(-10)), const(0))
    return ir.Model(
        name="SmallRocks",
        file="models/rocks.pomdp",
        source_hash="11" * 32,
        discount=0.949999988079071,
        horizon=None,
        enums=(READING, ROCK_ACT),
        records=(),
        params=(
            ir.Param("rock_x", COL, (ROCK,), (0, 2), span(5)),
            ir.Param("half_distance", FLOAT, (), (20.0,), span(6)),
        ),
        tables=(),
        elements=(
            ir.Element("rover", None, span(12)),
            ir.Element("rock", ir.Binder("r", ROCK), span(18)),
        ),
        variables=(
            ir.Variable("rover.x", "rover", COL, (), True, False, span(13), determined=True, copied=True),
            ir.Variable("rock.good", "rock", BOOL, (ROCK,), False, False, span(19)),
        ),
        lets=(),
        functions=(
            ir.Function("here", (ir.Binder("r", ROCK),), BOOL, equal(x, rock_x), span(8)),
            accuracy,
        ),
        action=ir.Action("act", ROCK_ACT, (), span(7)),
        inits=(
            ir.Assign("rover.x", (), ir.Certain(COL, const(0)), ir.Site("init:rover.x"), span(14)),
            ir.Assign(
                "rock.good",
                (ir.Binder("r", ROCK),),
                ir.Bernoulli(BOOL, const(0.5)),
                ir.Site("init:rock.good"),
                span(20),
            ),
        ),
        updates=(
            ir.Assign("rover.x", (), ir.Certain(COL, step_x), ir.Site("rover.x"), span(15)),
            ir.Assign(
                "rock.good",
                (ir.Binder("r", ROCK),),
                ir.Certain(BOOL, both(good, ir.Unary(BOOL, "not", sampling))),
                ir.Site("rock.good"),
                span(21),
            ),
        ),
        observations=(
            ir.Observation(
                "reading",
                None,
                READING,
                (),
                ir.IfDist(
                    READING,
                    ir.IsVariant(BOOL, ROCK_ACT, "check", act),
                    checked,
                    ir.Certain(READING, variant(READING, "nothing")),
                ),
                ir.Site("observe:reading"),
                span(24),
            ),
        ),
        rewards=(
            ir.Reward("rover.exit", "rover", None, exit_, span(16)),
            ir.Reward("rock.sampled", "rock", ir.Binder("r", ROCK), sampled, span(22)),
        ),
        terminal=equal(x_next, const(3)),
        legal=legal,
        policy=ir.Policy(
            (), ir.Certain(ROCK_ACT, variant(ROCK_ACT, "east")), ir.Site("policy:default"), span(30)
        ),
        upper=ir.Binary(
            FLOAT,
            "add",
            ir.Binary(FLOAT, "mul", const(10.0), ir.Binary(FLOAT, "pow", gamma, walk)),
            rocks_left,
        ),
        tail=const(0.0),
        lower=None,
        success=equal(x_next, const(3)),
        key=(ir.KeyField("reading", True, READING, ()),),
    )


def wanderer() -> ir.Model:
    """Build a model of the rarer constructs.

    A product action, a fixed array, a visible variable drawn from a hidden one, two stages, a drawing
    let, a set, a noisy value, a table and two-component observations.
    """
    cell, bot = Int(1, 5), Int(0, 1)
    move = Enum("Move", (Variant("stay"), Variant("go")))
    b, p = ir.Local(bot, "b"), ir.Local(cell, "p")
    bots = (ir.Binder("b", bot),)
    wall = ir.StateRead(BOOL, "map.wall", (p,))
    free = ir.Unary(BOOL, "not", wall)
    at = ir.StateRead(cell, "bot.at", (b,))
    at_next = ir.StateRead(cell, "bot.at", (b,), True)
    slips = ir.LetRead(BOOL, "bot.slips", (b,))
    moving = both(
        equal(ir.ActionRead(move, (b,)), variant(move, "go")),
        ir.Unary(BOOL, "not", slips),
    )
    somewhere = ir.UniformSet(cell, (ir.Binder("p", cell),), free, p, ir.Certain(cell, const(1)))
    same = ir.Quantified(BOOL, "all", bots, None, equal(at_next, const(5)), None)
    nearest = ir.Quantified(bot, "argmin", bots, ir.Binary(BOOL, "gt", at, const(1)), at, ir.Const(bot, 0))
    return ir.Model(
        name="Wanderer",
        file="models/wanderer.pomdp",
        source_hash="22" * 32,
        discount=0.949999988079071,
        horizon=40,
        enums=(move,),
        records=(),
        params=(ir.Param("slip", PROB, (bot,), None, span(3)),),
        tables=(ir.ConstantArray("worth", INT, (cell,), (0, -1, 2, 0, 7), span(4)),),
        elements=(
            ir.Element("map", None, span(6)),
            ir.Element("bot", ir.Binder("b", bot), span(10)),
        ),
        variables=(
            ir.Variable("map.wall", "map", BOOL, (cell,), False, True, span(7)),
            ir.Variable("bot.at", "bot", cell, (bot,), False, False, span(11)),
            ir.Variable("bot.seen", "bot", cell, (bot,), True, False, span(12)),
        ),
        lets=(
            ir.Let(
                "bot.slips",
                "bot",
                ir.Binder("b", bot),
                ir.Bernoulli(BOOL, ir.ParamRead(PROB, "slip", (b,))),
                ir.Site("let:bot.slips"),
                span(13),
            ),
        ),
        functions=(),
        action=ir.Action("move", move, (bot,), span(5)),
        inits=(
            ir.Assign("bot.seen", bots, ir.Certain(cell, const(1)), ir.Site("init:bot.seen"), span(16)),
            ir.Assign(
                "map.wall",
                (ir.Binder("p", cell),),
                ir.Bernoulli(BOOL, const(0.25)),
                ir.Site("init:map.wall"),
                span(8),
            ),
            ir.Assign("bot.at", bots, somewhere, ir.Site("init:bot.at"), span(15)),
        ),
        updates=(
            ir.Assign(
                "bot.at",
                bots,
                ir.IfDist(cell, moving, somewhere, ir.Certain(cell, at)),
                ir.Site("bot.at"),
                span(17),
            ),
            ir.Assign(
                "bot.seen",
                bots,
                ir.Noisy(cell, at_next, const(0.75)),
                ir.Site("bot.seen"),
                span(18),
                stage=1,
                reads=frozenset({"bot.at"}),
            ),
        ),
        observations=(
            ir.Observation(
                "bot.bump",
                "bot",
                Int(-1, 1),
                bots,
                ir.Table(
                    Int(-1, 1),
                    (
                        (const(-1), const(0.25)),
                        (const(0), const(0.5)),
                        (
                            ir.Unary(Int(0, 1), "sign", ir.Binary(Int(-4, 4), "sub", at_next, at)),
                            const(0.125),
                        ),
                    ),
                    const(1),
                ),
                ir.Site("observe:bot.bump"),
                span(19),
            ),
        ),
        rewards=(
            ir.Reward(
                "bot.worth", "bot", ir.Binder("b", bot), ir.TableRead(INT, "worth", (at_next,)), span(20)
            ),
        ),
        terminal=same,
        legal=const(True),
        policy=ir.Policy(
            bots,
            ir.IfDist(
                move,
                equal(ir.StateRead(cell, "bot.seen", (b,)), const(5)),
                ir.Certain(move, variant(move, "stay")),
                ir.Uniform(move),
            ),
            ir.Site("policy:default"),
            span(22),
        ),
        upper=ir.ToFloat(
            FLOAT, ir.Binary(Int(0, 12), "mul", const(7), ir.Binary(Int(0, 1), "min", nearest, const(1)))
        ),
        tail=const(-20.0),
        lower=ir.Const(FLOAT, -20.0),
        success=same,
        key=(
            ir.KeyField("bot.bump", True, Int(-1, 1), (bot,)),
            ir.KeyField("bot.seen", False, cell, (bot,)),
        ),
    )
