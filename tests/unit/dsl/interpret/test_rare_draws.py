# SPDX-License-Identifier: Apache-2.0
"""Draws whose outcomes are rare: their laws against fractions, and samplers at each of their boundaries."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from support import ir_samples

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Frame
from hypgen.dsl.ir import masses, operators
from hypgen.dsl.types import BOOL, PROB, Int

WHOLE = 2**63
NINE = Int(0, 9)


def exact(text: str) -> ir.Const:
    """Return a probability as a model's text gives it."""
    return operators.real(float(text), exact=Fraction(text))


def local(number: int) -> ir.Local:
    return ir.Local(PROB, f"p{number}")


def evaluated(dist: ir.Dist, bits: list[int], given: tuple[float, ...]) -> list[Any]:
    words = np.array(bits, dtype=np.uint64)
    locals_ = {f"p{i}": np.float32(p) for i, p in enumerate(given)}
    frame = Frame(np.arange(len(words)), {}, locals={n: np.asarray(p) for n, p in locals_.items()})
    word = ir_samples.word(words >> np.uint64(31), words << np.uint64(1) & np.uint64(2**32 - 1))
    drawn = Evaluator(ir_samples.tiger(), {}).sample(dist, frame, word)
    found: list[Any] = np.broadcast_to(drawn, words.shape).tolist()
    return found


def drawn_law(
    dist: ir.Dist, given: tuple[float, ...], shares: list[Fraction], whole: int = WHOLE
) -> dict[Any, int]:
    """Return how many of the 2^63 bits draw each value: runs end between the middles of shares."""

    def end(low: int, high: int, first: Any) -> int:
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if evaluated(dist, [middle], given) == [first] else (low, middle)
        return high

    places, before = {0, WHOLE - 1}, Fraction(0)
    for p in shares:
        places.add(min(int((before + p / 2) * whole), WHOLE - 1))
        before += p
    law: dict[Any, int] = {}
    start = 0
    middles = sorted(places)
    for low, high in zip(middles, middles[1:], strict=False):
        value, last = evaluated(dist, [low, high], given)
        while value != last:
            until = end(low, high, value)
            law[value] = law.get(value, 0) + until - start
            start = low = until
            [value] = evaluated(dist, [low], given)
    law[last] = law.get(last, 0) + WHOLE - start
    return law


def density(dist: ir.Dist, value: Any, given: tuple[float, ...] = ()) -> float:
    locals_ = {f"p{i}": np.asarray(np.float32(p)) for i, p in enumerate(given)}
    frame = Frame(np.arange(1), {}, locals=locals_)
    return float(np.max(Evaluator(ir_samples.tiger(), {}).density(dist, frame, np.asarray(value))))


def table(*texts: str, rest: bool = False) -> ir.Table:
    entries = tuple((ir_samples.const(i), exact(text)) for i, text in enumerate(texts))
    return ir.Table(NINE, entries, ir_samples.const(len(texts)) if rest else None)


def check(
    dist: ir.Dist, want: dict[Any, Fraction], given: tuple[float, ...] = (), within: float = 1e-3
) -> None:
    weighed = WHOLE - 2**31 if isinstance(dist, ir.Weighted) else WHOLE
    law = drawn_law(dist, given, list(want.values()), weighed)
    for value, p in want.items():
        assert law.get(value, 0) / WHOLE == pytest.approx(float(p), rel=within), value
        found, drawn = density(dist, value, given), law.get(value, 0) * 2.0**-63
        # The parts of other than a noisy value are equal but for a word, which the density leaves out.
        assert found == (pytest.approx(drawn, rel=1e-3) if isinstance(dist, ir.Noisy) else drawn), value
    assert set(law) == {value for value, p in want.items() if p}


@pytest.mark.parametrize(
    "texts",
    [
        ("0.9999999999", "1e-10"),
        ("1e-10", "0.9999999999"),
        ("1e-15", "0.999999999999999"),
        ("0.999999999999999", "1e-15"),
        ("0.5", "0.4999999", "0.0000001"),
        ("0.3", "1e-12", "0.699999999999"),
        ("0.25", "1e-9", "0.749999998", "1e-9"),
        ("0.5", "0.5", "0"),
        ("1", "0"),
    ],
)
@pytest.mark.parametrize("rest", [False, True])
def test_tables_of_constants(texts: tuple[str, ...], rest: bool) -> None:
    dist = table(*texts[:-1], rest=True) if rest else table(*texts)
    check(dist, {i: Fraction(t) for i, t in enumerate(texts)})


@pytest.mark.parametrize("seed", range(60))
def test_random_tables_of_constants(seed: int) -> None:
    rng = random.Random(seed)
    parts = [Fraction(f"{rng.uniform(1, 9):.6g}e-{rng.randint(1, 15)}") for _ in range(rng.randint(1, 4))]
    parts = [p / 20 for p in parts]
    parts.insert(rng.randrange(len(parts) + 1), 1 - sum(parts))
    entries = tuple((ir_samples.const(i), operators.real(float(p), exact=p)) for i, p in enumerate(parts))
    found = masses.of_table(ir.Table(NINE, entries, None))
    assert found is not None and sum(found) == WHOLE
    for mass, p in zip(found, parts, strict=True):
        assert abs(mass - p * WHOLE) <= p * WHOLE / 2**13 + 1
    if seed < 15:
        check(ir.Table(NINE, entries, None), dict(enumerate(parts)))


@pytest.mark.parametrize("q", [0.25, 1e-3, 1e-5, 1e-8, 1e-10, 1e-15, 0.0])
def test_what_is_known_when_a_model_runs(q: float) -> None:
    small, one = local(0), ir_samples.const(1.0)
    nearly = operators.arithmetic("sub", one, small)
    lacking = masses.complement(nearly)
    assert lacking == small
    p = Fraction(float(np.float32(q)))
    values = (ir_samples.const(0), ir_samples.const(1))
    law = {0: 1 - p, 1: p}
    for dist in (
        ir.Table(NINE, ((values[0], nearly), (values[1], small)), None),
        ir.Table(NINE, ((values[0], nearly),), values[1], (lacking,)),
        ir.Table(NINE, ((values[0], nearly), (values[1], small)), None, (lacking, None)),
    ):
        check(dist, law, (q,))
    check(ir.Table(NINE, ((values[1], small), (values[0], nearly)), None), {1: p, 0: 1 - p}, (q,))
    check(ir.Bernoulli(BOOL, small), {True: p, False: 1 - p}, (q,))
    check(ir.Bernoulli(BOOL, nearly, lacking), {True: 1 - p, False: p}, (q,))
    check(
        ir.Noisy(Int(0, 4), values[1], nearly, lacking),
        {1: 1 - p, **dict.fromkeys((0, 2, 3, 4), p / 4)},
        (q,),
    )


@pytest.mark.parametrize("text", ["0.99", "0.9999999999", "1e-10", "0.999999999999999", "1e-15", "0.5", "1"])
def test_constants(text: str) -> None:
    p = Fraction(text)
    check(ir.Bernoulli(BOOL, exact(text)), {True: p, False: 1 - p})
    check(
        ir.Noisy(Int(0, 3), ir_samples.const(2), exact(text)), {2: p, **dict.fromkeys((0, 1, 3), (1 - p) / 3)}
    )


@pytest.mark.parametrize(
    "weights", [(1.0, 1e-12), (1e-12, 1.0), (1e-15, 2.0, 3.0), (3.0, 1e-15, 2.0, 1e-9), (0.0, 5.0)]
)
def test_weights(weights: tuple[float, ...]) -> None:
    t = Int(0, len(weights) - 1)
    chosen: ir.Expr = ir_samples.const(float(np.float32(weights[-1])))
    for i, w in enumerate(weights[:-1]):
        here = ir_samples.equal(ir.Local(t, "j"), ir_samples.const(i))
        chosen = ir.If(chosen.type, here, ir_samples.const(float(np.float32(w))), chosen)
    dist = ir.Weighted(t, (ir.Binder("j", t),), None, chosen, None)
    exactly = [Fraction(float(np.float32(w))) for w in weights]
    check(dist, {i: w / sum(exactly) for i, w in enumerate(exactly)})


def test_complements() -> None:
    p, q, one = local(0), local(1), ir_samples.const(1.0)

    def minus(a: ir.Expr, b: ir.Expr) -> ir.Expr:
        return operators.arithmetic("sub", a, b)

    def times(a: ir.Expr, b: ir.Expr) -> ir.Expr:
        return operators.arithmetic("mul", a, b)

    plus = operators.arithmetic("add", p, q)
    assert masses.complement(minus(minus(one, p), q)) == plus
    assert masses.complement(times(minus(one, p), minus(one, q))) == operators.arithmetic(
        "add", p, times(minus(one, p), q)
    )
    assert masses.complement(p) is None
    assert masses.complement(exact("0.9999999999")) is None
    assert masses.complement(minus(exact("0.5"), p)) is None
    either = operators.choose(ir_samples.equal(p, q), minus(one, p), exact("0.9999999999"))
    found = masses.complement(either)
    assert isinstance(found, ir.If) and isinstance(found.otherwise, ir.Const)
    assert found.otherwise.exact == Fraction("1e-10")
