# SPDX-License-Identifier: Apache-2.0
"""Units of measurement: how they are written, and what arithmetic makes of them."""

import pytest

from hypgen.dsl.types import units


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("m", (("m", 1),)),
        ("m/s^2", (("m", 1), ("s", -2))),
        ("s*m", (("m", 1), ("s", 1))),
        ("1/s", (("s", -1),)),
        ("kg*m^2/s/s", (("kg", 1), ("m", 2), ("s", -2))),
        ("m/m", units.PLAIN),
        ("1", units.PLAIN),
    ],
)
def test_a_unit_is_read_as_its_factors(text: str, unit: units.Unit) -> None:
    assert units.parse(text) == unit


@pytest.mark.parametrize("text", ["m", "m/s^2", "m*s", "1/s", "kg*m^2/s^2", "1/m/s"])
def test_a_unit_is_shown_as_it_is_written(text: str) -> None:
    assert units.shown(units.parse(text)) == text


def test_products_and_roots() -> None:
    metre, second = units.parse("m"), units.parse("s")
    assert units.product(metre, second, -1) == units.parse("m/s")
    assert units.product(None, metre) == metre
    assert units.product(None, metre, -1) == units.parse("1/m")
    assert units.product(metre, metre, -1) == units.PLAIN
    assert units.power(metre, 2) == units.parse("m^2")
    assert units.root(units.parse("m^2/s^4")) == units.parse("m/s^2")
    assert units.has_root(units.parse("m^2")) and not units.has_root(units.parse("m^3"))


def test_literals_agree_with_every_unit() -> None:
    assert units.agree(None, units.parse("m")) and units.agree(units.PLAIN, None)
    assert not units.agree(units.PLAIN, units.parse("m"))
