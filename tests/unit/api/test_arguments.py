# SPDX-License-Identifier: Apache-2.0
"""What callers of the package give: numbers of numpy are numbers, and wrong types are told by name."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hypgen.api.arguments import encoded, encoded_object, in_range, real, words
from hypgen.api.c_interface import PlannerError


def test_numpy_gives_what_python_gives() -> None:
    assert in_range("action", np.int64(3), 0, 5) == 3
    assert real("seconds", np.float32(0.5)) == 0.5
    assert words("seen", np.uint64(7)) == [7]
    assert words("seen", np.array([1, 2], np.uint64)) == [1, 2]
    values = {"at": np.int64(1), "open": np.array([True, False])}
    assert encoded_object("seen", values) == b'{"at": 1, "open": [true, false]}'


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: in_range("action", 6, 0, 5), "action: expected an integer from 0 to 5, found 6"),
        (lambda: in_range("action", 1.0, 0, 5), "action: expected an integer from 0 to 5, found 1.0"),
        (lambda: real("seconds", "1"), "seconds: expected a number, found '1'"),
        (lambda: real("seconds", float("nan")), "seconds: expected a number, found nan"),
        (lambda: encoded("action", 3), "action: expected a text, found 3"),
        (lambda: encoded("action", "a\0b"), "action: has a NUL"),
        (lambda: encoded_object("seen", [1]), "seen: expected values by name, found [1]"),
        (
            lambda: encoded_object("seen", {"at": {1}}),
            "seen: expected bools, numbers, texts and lists of them, found {1}",
        ),
        (lambda: words("seen", None), "seen: expected values by name, or a key, found None"),
        (lambda: words("seen", "metal"), "seen: expected values by name, or a key, found 'metal'"),
        (lambda: words("seen", -1), "key: expected an integer from 0 to 18446744073709551615, found -1"),
    ],
)
def test_wrong_values_are_refused(call: Callable[[], Any], text: str) -> None:
    with pytest.raises(PlannerError) as refused:
        call()
    assert str(refused.value) == text and refused.value.status == "wrong_argument"
