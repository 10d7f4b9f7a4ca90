# SPDX-License-Identifier: Apache-2.0
"""Known answers are those of the Random123 distribution (kat_vectors)."""

from __future__ import annotations

import numpy as np
import pytest

from hypgen.dsl.interpret.floats.philox import PhiloxDraws, Stream, derive, philox

ONES = 0xFFFFFFFF


@pytest.mark.parametrize(
    ("key", "counter", "expected"),
    [
        ((0, 0), (0, 0, 0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
        ((ONES, ONES), (ONES, ONES, ONES, ONES), (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
        (
            (0xA4093822, 0x299F31D0),
            (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
            (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
        ),
    ],
)
def test_known_answers(
    key: tuple[int, int], counter: tuple[int, int, int, int], expected: tuple[int, ...]
) -> None:
    assert tuple(int(word) for word in philox(key, counter)) == expected


def test_lanes_are_independent_of_each_other() -> None:
    together = philox((1, 2), (np.arange(100), 5, 7, np.arange(100) % 3))
    for lane in (0, 17, 99):
        alone = philox((1, 2), (lane, 5, 7, lane % 3))
        assert [int(w[lane]) for w in together] == [int(w) for w in alone]


def test_streams_differ_by_seed_kind_and_number() -> None:
    keys = {derive(seed, kind, n) for seed in (0, 1, 2**32) for kind in Stream for n in (0, 1, 2**32)}
    assert len(keys) == 3 * len(Stream) * 3


def test_derive_puts_seed_in_the_key_and_the_stream_in_the_counter() -> None:
    words = philox((2, 1), (3, 5, 4, 0x68797067))
    assert derive(0x1_0000_0002, 3, 0x4_0000_0005) == (int(words[0]), int(words[1]))


def test_index_of_each_lane_picks_the_same_word_as_a_common_index() -> None:
    lanes = np.arange(8)
    draws = PhiloxDraws((3, 4), lanes, 9)
    varying = draws.word(77, lanes)
    for lane in lanes:
        assert varying[lane] == draws.word(77, int(lane))[lane]
        assert varying[lane] == philox((3, 4), (lane, 9, 77, lane // 4))[lane % 4]
