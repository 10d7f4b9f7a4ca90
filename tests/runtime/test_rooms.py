# SPDX-License-Identifier: Apache-2.0
"""Each room of the runtime's headers has a page that lists its headers in order of dependency."""

import re
from pathlib import Path

import pytest

INCLUDE = Path(__file__).parents[2] / "runtime" / "include" / "hypgen"
ROOMS = sorted(path.name for path in INCLUDE.iterdir() if path.is_dir())


def named(page: Path) -> list[str]:
    """Return the names in backticks of the items of a page, in order."""
    items = [line.partition(": ")[0] for line in page.read_text(encoding="utf-8").splitlines()]
    return [name for item in items if item.startswith("- ") for name in re.findall("`([^`]+)`", item)]


@pytest.mark.parametrize("room", ROOMS)
def test_page_lists_headers_in_order(room: str) -> None:
    page = INCLUDE / room / "README.md"
    assert len(page.read_text(encoding="utf-8").splitlines()) <= 15
    headers = [path for path in (INCLUDE / room).iterdir() if path != page]
    order = named(page)
    assert sorted(order) == sorted(path.name for path in headers)
    for header in headers:
        text = header.read_text(encoding="utf-8")
        for used in re.findall(rf'#include "hypgen/{room}/([^"]+)"', text):
            assert order.index(used) < order.index(header.name), f"{header.name} includes {used}"


def test_page_lists_rooms_in_order() -> None:
    order = named(INCLUDE / "README.md")
    assert sorted(order) == ROOMS
    for header in INCLUDE.glob("*/*.*h*"):
        for room in re.findall(r'#include "hypgen/(\w+)/', header.read_text(encoding="utf-8")):
            assert order.index(room) <= order.index(header.parent.name), f"{header} includes {room}"
