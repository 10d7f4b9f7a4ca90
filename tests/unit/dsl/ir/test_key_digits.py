# SPDX-License-Identifier: Apache-2.0
"""Where the digits of an observation key lie, and that what is written is what is read."""

import math

import numpy as np
import pytest

from hypgen.dsl import ir
from hypgen.dsl.interpret.floats.philox import PhiloxDraws
from hypgen.dsl.interpret.interpreter import Interpreter
from hypgen.dsl.ir import key_digits
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse
from hypgen.dsl.types import Int


def fields(*sizes: tuple[int, int]) -> tuple[ir.KeyField, ...]:
    """Return a field for each pair of a digit's size and how many there are."""
    return tuple(
        ir.KeyField(f"f{n}", True, Int(3, 2 + size), (Int(1, count),))
        for n, (size, count) in enumerate(sizes)
    )


@pytest.mark.parametrize(
    ("key", "words"),
    [
        (fields(), 1),
        (fields((2, 64)), 1),
        (fields((2, 65)), 2),
        (fields((64, 40)), 4),
        (fields((2**31, 3)), 2),
        (fields((2**31, 2), (4, 1), (2, 1)), 2),
        (fields((1, 10**9), (2, 64)), 1),
        (fields((2, 64), (1, 5), (2, 64)), 2),
    ],
)
def test_a_word_is_filled_before_the_next_is_begun(key: tuple[ir.KeyField, ...], words: int) -> None:
    assert key_digits.word_count(key) == words
    assert key_digits.is_wide(key) == (words > 1)


def test_counting_stops_where_it_is_told_to() -> None:
    assert key_digits.word_count(fields((256, 10**9)), most=10) == 11


@pytest.mark.parametrize("key", [fields((3, 2), (5, 2)), fields((2, 70), (7, 3), (1, 2), (2**31, 5))])
def test_no_two_digits_of_a_word_share_a_place(key: tuple[ir.KeyField, ...]) -> None:
    digits = key_digits.digits(key)
    assert [(d.field.name, d.entry) for d in digits] == [(f.name, i) for f in key for i in range(f.length)]
    for word in range(key_digits.word_count(key)):
        inside = [d for d in digits if d.word == word]
        by_place = sorted(inside, key=lambda d: (d.place, d.size))
        sizes = [d.size for d in by_place]
        assert [d.place for d in by_place] == [math.prod(sizes[:n]) for n in range(len(sizes))]
        assert math.prod(sizes) <= key_digits.WORD


def test_the_filter_reads_what_a_wide_key_says() -> None:
    text = """model M
    type Lamp = 1 .. 50
    type Colour = -3 .. 60
    enum Act { wait, look }
    discount 0.9
    action act: Act
    element panel {
      visible lit: Colour[Lamp]
      init lit ~ [i in Lamp: uniform(Colour)]
      lit' ~ [i in Lamp: uniform(Colour)]
    }
    observe seen: Colour[Lamp] ~ [i in Lamp: noisy(panel.lit[i]', 0.5)]
    bound upper = 0
    bound tail = 0
    """
    source = Source("m.pomdp", text)
    interpreter = Interpreter(lower(parse(source), {}, source), lanes=20)
    draws = PhiloxDraws((1, 2), np.arange(20), 0)
    state = interpreter.init_visible(draws)
    done = interpreter.step(state, [0], draws)
    key = interpreter.observe(state, [0], draws, done.after)
    assert key.shape == (20, 10)
    weight, filtered = interpreter.filter(state, [0], key, draws)
    assert np.array_equal(filtered["panel.lit"], done.after["panel.lit"])
    assert (weight > 0).all()
