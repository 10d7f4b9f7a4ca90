# SPDX-License-Identifier: Apache-2.0
"""Laws of numbers by themselves: densities count all words, samplers follow them, and both follow the law."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support import ir_samples

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Array, Frame
from hypgen.dsl.types import BOOL, FLOAT, PROB, Float, Int

LANES = 2**16
WORDS = np.arange(LANES, dtype=np.uint64) << np.uint64(16)  # evenly over all words
EDGE_WORDS = np.array([0, 1, 2**31 - 1, 2**31, 2**32 - 2, 2**32 - 1], dtype=np.uint64)


def real(x: float) -> ir.Const:
    return ir.Const(FLOAT, float(np.float32(x)))


def const(k: int) -> ir.Const:
    return ir.Const(Int(k, k), k)


def sample(dist: ir.Dist, words: Array) -> Array:
    evaluator = Evaluator(ir_samples.tiger(), {})
    with np.errstate(all="ignore"):
        return np.broadcast_to(
            evaluator.sample(dist, Frame(np.arange(len(words)), {}), ir_samples.word(words)), words.shape
        )


def densities(dist: ir.Dist) -> dict[int, float]:
    assert isinstance(dist.type, Int)
    evaluator = Evaluator(ir_samples.tiger(), {})
    values = np.arange(dist.type.low, dist.type.high + 1, dtype=np.int32)
    with np.errstate(all="ignore"):
        found = evaluator.density(dist, Frame(np.arange(len(values)), {}), values)
    return dict(zip(values.tolist(), np.broadcast_to(found, values.shape).tolist(), strict=True))


def densities_at(law: ir.Dist, values: list[float]) -> list[float]:
    evaluator, xs = Evaluator(ir_samples.tiger(), {}), np.array(values, dtype=np.float32)
    with np.errstate(all="ignore"):
        found = evaluator.density(law, Frame(np.arange(len(xs)), {}), xs)
    return list(np.broadcast_to(found, xs.shape).tolist())


def poisson(t: Int, mean: float, first: int = 0, last: int | None = None) -> ir.Poisson:
    return ir.Poisson(t, first, last, real(mean))


def binomial(t: Int, n: int, p: float, first: int = 0, last: int | None = None) -> ir.Binomial:
    return ir.Binomial(t, first, last, const(n), ir.Const(PROB, float(np.float32(p))))


def poisson_mass(mean: float) -> Callable[[int], float]:
    return lambda k: math.exp(k * math.log(mean) - mean - math.lgamma(k + 1)) if k >= 0 else 0.0


def binomial_mass(n: int, p: float) -> Callable[[int], float]:
    p = float(np.float32(p))
    return lambda k: math.comb(n, k) * p**k * (1 - p) ** (n - k) if 0 <= k <= n else 0.0


def normal_below(mean: float, deviation: float) -> Callable[[float], float]:
    return lambda x: 0.5 * math.erfc((mean - x) / deviation / math.sqrt(2))


def within(mass: Callable[[int], float], t: Int, first: int = 0, last: int = 2000) -> dict[int, float]:
    """Return a law's probabilities, truncated to first .. last, then clamped into ``t``."""
    total = math.fsum(mass(k) for k in range(first, last + 1))
    result = dict.fromkeys(range(t.low, t.high + 1), 0.0)
    for k in range(first, last + 1):
        result[min(max(k, t.low), t.high)] += mass(k) / total
    return result


def bins(below: Callable[[float], float], low: float, high: float, t: Int) -> dict[int, float]:
    n = t.high - t.low + 1
    edges = [0.0, *(below(low + (high - low) * i / n) for i in range(1, n)), 1.0]
    return {t.low + i: edges[i + 1] - edges[i] for i in range(n)}


def weighted(weights: list[float], otherwise: ir.Dist | None = None) -> ir.Weighted:
    t = Int(1, len(weights))
    chosen: ir.Expr = real(weights[-1])
    for k in reversed(range(1, len(weights))):
        is_k = ir.Binary(BOOL, "eq", ir.Local(t, "j"), const(k))
        chosen = ir.If(FLOAT, is_k, real(weights[k - 1]), chosen)
    return ir.Weighted(Int(0, 9), (ir.Binder("j", t),), None, chosen, otherwise)


NORMAL = ir.Normal(FLOAT, real(1.25), real(0.75))
TAIL = ir.Truncated(FLOAT, NORMAL, real(5.5), real(8.0))
MIDDLE = ir.Truncated(FLOAT, ir.Exponential(FLOAT, real(2.0)), real(0.5), real(4.0))
NINE, SOME = Int(0, 9), Int(3, 7)


def tail_below(x: float) -> float:
    above = [0.5 * math.erfc((e - 1.25) / 0.75 / math.sqrt(2)) for e in (5.5, x, 8.0)]
    return (above[0] - above[1]) / (above[0] - above[2])


def middle_below(x: float) -> float:
    low, here, high = (math.exp(-min(max(e, 0.5), 4.0) / 2) for e in (0.5, x, 4.0))
    return (low - here) / (low - high)


LAWS: dict[str, tuple[ir.Dist, dict[int, float]]] = {
    "poisson": (poisson(NINE, 2.5), within(poisson_mass(2.5), NINE)),
    "poisson of 0": (poisson(NINE, 0.0), {0: 1.0}),
    "poisson of a large mean": (poisson(Int(0, 900), 600.0), within(poisson_mass(600.0), Int(0, 900))),
    "clamped poisson": (poisson(SOME, 4.5), within(poisson_mass(4.5), SOME)),
    "truncated poisson": (poisson(SOME, 2.0, 3, 7), within(poisson_mass(2.0), SOME, 3, 7)),
    "poisson in its tail": (
        poisson(Int(30, 34), 1.0, 30, 34),
        within(poisson_mass(1.0), Int(30, 34), 30, 34),
    ),
    "binomial": (binomial(NINE, 9, 0.3), within(binomial_mass(9, 0.3), NINE)),
    "binomial of failures": (binomial(NINE, 9, 0.8), within(binomial_mass(9, 0.8), NINE)),
    "binomial of many": (binomial(Int(0, 1000), 1000, 0.6), within(binomial_mass(1000, 0.6), Int(0, 1000))),
    "binomial of certain": (binomial(NINE, 7, 1.0), {7: 1.0}),
    "binomial of none": (binomial(NINE, 7, 0.0), {0: 1.0}),
    "binomial of fewer": (binomial(NINE, 4, 0.5), within(binomial_mass(4, 0.5), NINE)),
    "clamped binomial": (binomial(SOME, 9, 0.7), within(binomial_mass(9, 0.7), SOME)),
    "binomial below its range": (binomial(SOME, 2, 0.7), {3: 1.0}),
    "truncated binomial": (binomial(SOME, 20, 0.9, 3, 7), within(binomial_mass(20, 0.9), SOME, 3, 7)),
    "truncated beyond its trials": (binomial(SOME, 5, 0.4, 3, 7), within(binomial_mass(5, 0.4), SOME, 3, 5)),
    "uniform ints": (ir.UniformInt(NINE, const(2), const(5)), dict.fromkeys(range(2, 6), 0.25)),
    "clamped uniform ints": (ir.UniformInt(SOME, const(1), const(4)), {3: 0.75, 4: 0.25}),
    "uniform ints above": (ir.UniformInt(SOME, const(8), const(11)), {7: 1.0}),
    "uniform ints swapped": (ir.UniformInt(SOME, const(5), const(4)), {5: 1.0}),
    "weights": (weighted([1.0, 0.0, 2.0, 1.0]), {1: 0.25, 3: 0.5, 4: 0.25}),
    "weights below 0": (weighted([-1.0, 3.0, math.nan, 1.0, 0.0]), {2: 0.75, 4: 0.25}),
    "no weights": (weighted([0.0, 0.0]), {1: 1.0}),
    "no weights but else": (weighted([0.0], ir.Certain(NINE, const(6))), {6: 1.0}),
    "bins of a normal": (
        ir.Binned(Int(2, 41), NORMAL, real(-1.0), real(3.0)),
        bins(normal_below(1.25, 0.75), -1.0, 3.0, Int(2, 41)),
    ),
    "bins of a tail": (ir.Binned(NINE, TAIL, real(5.5), real(7.0)), bins(tail_below, 5.5, 7.0, NINE)),
    "bins of a certain normal": (
        ir.Binned(NINE, ir.Normal(FLOAT, real(3.0), real(0.0)), real(0.0), real(10.0)),
        {3: 1.0},
    ),
    "bins of a uniform": (
        ir.Binned(Int(0, 3), ir.UniformFloat(FLOAT, real(1.0), real(5.0)), real(2.0), real(6.0)),
        {0: 0.5, 1: 0.25, 2: 0.25},
    ),
    "bins of an exponential": (
        ir.Binned(NINE, ir.Exponential(FLOAT, real(2.0)), real(-1.0), real(4.0)),
        bins(lambda x: 1 - math.exp(-max(x, 0.0) / 2), -1.0, 4.0, NINE),
    ),
    "bins of a part": (ir.Binned(NINE, MIDDLE, real(0.0), real(5.0)), bins(middle_below, 0.0, 5.0, NINE)),
    "a wider type": (ir.Widened(Int(-2, 12), poisson(NINE, 2.5)), within(poisson_mass(2.5), NINE)),
}


@pytest.mark.parametrize("name", LAWS)
def test_densities_count_all_words_and_follow_the_law(name: str) -> None:
    dist, want = LAWS[name]
    found = densities(dist)
    assert sum(found.values()) == (pytest.approx(1.0, abs=1e-15) if "weights" in name else 1.0)
    for k, density in found.items():
        assert density == pytest.approx(want.get(k, 0.0), abs=2**-31)


@pytest.mark.parametrize("name", LAWS)
def test_samplers_follow_densities_word_for_word(name: str) -> None:
    dist, _ = LAWS[name]
    found = densities(dist)
    ends = np.cumsum([round(d * 2**32) for d in found.values()])
    values = np.array(list(found))
    near = np.concatenate([ends[:-1] - 1, ends[:-1], ends[:-1] + 1])
    words = np.concatenate([WORDS, EDGE_WORDS, near[(near >= 0) & (near < 2**32)].astype(np.uint64)])
    want = values[np.searchsorted(ends, words.astype(np.int64), side="right")]
    if name == "no weights but else" or name == "uniform ints":
        assert set(sample(dist, words)) == {k for k, d in found.items() if d}
    if isinstance(
        dist, ir.Weighted
    ):  # what all leave, less than a word, is the likeliest's: test_rare_draws.py
        far = np.abs(words.astype(np.int64)[:, np.newaxis] - ends).min(axis=1) > 1
        words, want = words[far], want[far]
    assert np.array_equal(sample(dist, words), want)


CONTINUOUS: dict[str, tuple[ir.Dist, Callable[[float], float]]] = {
    "normal": (NORMAL, normal_below(1.25, 0.75)),
    "uniform": (ir.UniformFloat(FLOAT, real(-1.0), real(3.0)), lambda x: (x + 1) / 4),
    "exponential": (ir.Exponential(FLOAT, real(2.0)), lambda x: 1 - math.exp(-x / 2)),
    "tail of a normal": (TAIL, tail_below),
    "part of a normal": (
        ir.Truncated(FLOAT, NORMAL, real(-20.0), real(1.25)),
        lambda x: 2 * normal_below(1.25, 0.75)(x),
    ),
    "part of an exponential": (MIDDLE, middle_below),
}


@pytest.mark.parametrize("name", CONTINUOUS)
def test_continuous_draws_spread_as_their_law(name: str) -> None:
    law, below = CONTINUOUS[name]
    drawn = np.sort(sample(law, WORDS + np.uint64(2**15))).astype(np.float64)
    places = np.array([below(float(x)) for x in drawn[::97]])
    want = (np.arange(LANES) + 0.5)[::97] / LANES
    assert np.max(np.abs(places - want)) < 2.0 / LANES  # the words are evenly spread, so the draws are too


@pytest.mark.parametrize("name", CONTINUOUS)
def test_a_density_is_what_the_probability_below_grows_by(name: str) -> None:
    law, below = CONTINUOUS[name]
    drawn = sample(law, WORDS)[LANES // 128 :: LANES // 64].astype(np.float64)
    for x, density in zip(drawn, densities_at(law, drawn.tolist()), strict=True):
        assert (below(x + 1e-5) - below(x - 1e-5)) / 2e-5 == pytest.approx(density, rel=1e-3, abs=1e-10)
    if name not in ("normal", "exponential"):
        assert densities_at(law, [-25.0, 9.0]) == [0.0, 0.0]


POINTS: list[tuple[ir.Continuous, float]] = [
    (ir.Normal(FLOAT, real(2.0), real(0.0)), 2.0),
    (ir.UniformFloat(FLOAT, real(3.0), real(2.0)), 2.0),
    (ir.Exponential(FLOAT, real(-1.0)), 0.0),
    (ir.Truncated(FLOAT, ir.Normal(FLOAT, real(0.0), real(0.0)), real(2.0), real(3.0)), 2.0),
    (ir.Truncated(FLOAT, ir.Normal(FLOAT, real(2.5), real(0.0)), real(2.0), real(3.0)), 2.5),
    (ir.Truncated(FLOAT, ir.Normal(FLOAT, real(-90.0), real(0.5)), real(2.0), real(3.0)), 2.0),
    (ir.Truncated(FLOAT, ir.Normal(FLOAT, real(90.0), real(0.5)), real(2.0), real(3.0)), 3.0),
    (ir.Truncated(FLOAT, ir.Exponential(FLOAT, real(0.0)), real(2.0), real(3.0)), 2.0),
]


@pytest.mark.parametrize(("law", "point"), POINTS)
def test_what_has_no_width_is_a_point(law: ir.Continuous, point: float) -> None:
    assert set(sample(law, WORDS[::4096]).tolist()) == {point}
    assert densities_at(law, [point, point + 0.25, math.nan]) == [1.0, 0.0, 0.0]
    clamped = ir.Clamped(FLOAT, law, 2.25, 2.5)
    inside = min(max(point, 2.25), 2.5)
    assert densities_at(clamped, [inside, 2.375, math.inf]) == [1.0, 0.0, 0.0]


def test_a_clamp_moves_what_lies_outside_to_the_ends() -> None:
    drawn = sample(ir.Clamped(Float(0.5, 2.0), NORMAL, 0.5, 2.0), WORDS)
    free = sample(NORMAL, WORDS)
    assert np.array_equal(drawn, np.clip(free, np.float32(0.5), np.float32(2.0)))


def test_the_ends_of_a_clamp_have_probabilities() -> None:
    law = ir.Clamped(Float(0.5, 2.0), NORMAL, 0.5, 2.0)
    found = densities_at(law, [0.25, 0.5, 1.25, 2.0, 2.25, math.nan])
    below = normal_below(1.25, 0.75)
    inside = densities_at(NORMAL, [1.25])[0]
    assert found == pytest.approx([0.0, below(0.5), inside, 1 - below(2.0), 0.0, 0.0], rel=1e-12)


def test_an_end_far_in_the_tail_keeps_its_probability() -> None:
    """1 - F is 0 there: every particle would be dropped."""
    end = densities_at(ir.Clamped(Float(0.0, 9.0), ir.Normal(FLOAT, real(0.0), real(1.0)), 0.0, 9.0), [9.0])
    assert end == [pytest.approx(0.5 * math.erfc(9 / math.sqrt(2)), rel=1e-9)]
    end = densities_at(ir.Clamped(Float(0.0, 90.0), ir.Exponential(FLOAT, real(1.0)), 0.0, 90.0), [90.0])
    assert end == [pytest.approx(math.exp(-90), rel=1e-9)]


def test_the_law_may_differ_by_lane() -> None:
    """Lanes with few trials, likely and unlikely, draw as they would alone."""
    trials = np.array([0, 1, 5, 9, 9, 3], dtype=np.int32)
    p = np.array([0.5, 0.9, 0.25, 0.75, 0.0, 1.0], dtype=np.float32)
    dist = ir.Binomial(NINE, 0, None, ir.Local(NINE, "n"), ir.Local(PROB, "p"))
    words = np.array([7, 2**31, 2**32 - 1, 123456789, 2**30, 99], dtype=np.uint64)
    together = Evaluator(ir_samples.tiger(), {}).sample(
        dist, Frame(np.arange(6), {}, locals={"n": trials, "p": p}), ir_samples.word(words)
    )
    alone: list[Any] = [
        sample(binomial(NINE, int(n), float(q)), words[i : i + 1])[0]
        for i, (n, q) in enumerate(zip(trials, p, strict=True))
    ]
    assert together.tolist() == alone


def test_one_word_draws_in_every_lane() -> None:
    """A single episode has one word, and state of one lane."""
    dist = ir.Binned(NINE, ir.Normal(FLOAT, ir.Local(FLOAT, "x"), real(0.5)), real(0.0), real(10.0))
    frame = Frame(np.arange(2), {}, locals={"x": np.array([2.5, 9.5], dtype=np.float32)})
    drawn = Evaluator(ir_samples.tiger(), {}).sample(dist, frame, ir_samples.word(np.uint64(2**31)))
    assert drawn.tolist() == [2, 9]
