# SPDX-License-Identifier: Apache-2.0
"""Tables in the making against arrays, and what finished tables tell."""

import math
import random

import numpy as np
import pytest

from hypgen.dsl.foreign.pomdpx.diagram import Diagram, TooLargeError
from hypgen.dsl.foreign.tables.table import Table


@pytest.mark.parametrize("seed", range(60))
def test_writes_are_those_of_an_array(seed: int) -> None:
    chance = random.Random(seed)
    sizes = [chance.randint(1, 4) for _ in range(chance.randint(1, 5))]
    diagram, array = Diagram(sizes, 10**6), np.full(sizes, math.nan)
    for _ in range(chance.randint(1, 40)):
        box = [None if chance.random() < 0.6 else chance.randrange(size) for size in sizes]
        at = np.ix_(*(range(s) if b is None else [b] for s, b in zip(sizes, box, strict=True)))
        parents = [n for n, size in enumerate(sizes[:-1]) if size == sizes[-1]]
        if parents and chance.random() < 0.2:
            which = chance.choice(parents)
            box[-1] = None
            diagram.write(box, [int(n == which) for n in range(len(sizes))], lambda _: 1.0, diagonal=True)
            at = np.ix_(*(range(s) if b is None else [b] for s, b in zip(sizes, box, strict=True)))
            index = np.indices(sizes)
            array[at] = np.where(index[which] == index[-1], 1.0, math.nan)[at]
            continue
        strides, size = [0] * len(sizes), 1
        for n in reversed(range(len(sizes))):
            if box[n] is None and chance.random() < 0.5:
                strides[n] = size
                size *= sizes[n]
        numbers = [chance.choice([0.0, 0.5, 1.0, chance.random()]) for _ in range(size)]
        diagram.write(box, strides, numbers.__getitem__)
        index = sum(s * i for s, i in zip(strides, np.indices(sizes), strict=True))
        array[at] = np.array(numbers)[np.broadcast_to(index, sizes)][at]
    table = diagram.table(lambda number: math.nan if number is None else number, len(sizes), 10**6)
    np.testing.assert_array_equal(np.array(table.entries()).reshape(sizes), array)


def test_a_table_tells_what_it_depends_on_and_where_entries_are() -> None:
    sizes = (2, 3, 2)
    entries = [0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 2.0, 0.0, 2.0, 0.0, 2.0]
    table = Table.of(sizes, entries)
    assert table.entries() == entries and table.at((1, 2, 1)) == 2.0
    assert table.tested() == [True, False, True]
    assert table.without([True, False, True]).entries() == [0.0, 1.0, 0.0, 2.0]
    assert table.distinct() == [0.0, 1.0, 2.0]
    assert table.found(lambda e: e > 0) == {1.0: ((0, 0, 1), 3), 2.0: ((1, 0, 1), 3)}
    assert table.mapped(bool).entries() == [bool(e) for e in entries]


def test_a_diagram_has_a_limit() -> None:
    diagram = Diagram([100, 100], 5000)
    diagram.write([None, 3], [0, 0], lambda _: 1.0)
    assert diagram.table(lambda n: n, 2, 200).at((50, 3)) == 1.0
    diagram.write([None, 4], [1, 0], float)
    with pytest.raises(TooLargeError):
        diagram.table(lambda n: n, 2, 200)
    with pytest.raises(TooLargeError):
        diagram.write([None, None], [100, 1], float)
