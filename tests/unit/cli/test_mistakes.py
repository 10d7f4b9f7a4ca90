"""Newcomers' mistakes: each has its code at the right line; docs/results/mistakes.md shows them."""

import importlib.util
import sys

import pytest
from support.paths import ROOT


def script() -> object:
    """Return benchmarks/mistakes.py, which is no package."""
    spec = importlib.util.spec_from_file_location("mistakes", ROOT / "benchmarks" / "mistakes.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["mistakes"] = module
    spec.loader.exec_module(module)
    return module


MISTAKES = script()


def test_there_are_many_and_each_is_another() -> None:
    found = MISTAKES.mistakes()
    assert len({m.what for m in found}) == len({m.text for m in found}) == len(found) >= 60
    assert sum(m.stan_text is not None for m in found) >= 25


@pytest.mark.parametrize("mistake", MISTAKES.mistakes(), ids=lambda m: m.what)
def test_the_mistake_is_found_where_it_is(mistake) -> None:
    diagnostics, text = MISTAKES.told(mistake)
    assert diagnostics and diagnostics[0].span is not None, text
    assert {d.code for d in diagnostics} == {mistake.code}, text
    assert diagnostics[0].span.line == mistake.line, text


def test_the_page_is_up_to_date() -> None:
    assert MISTAKES.PAGE.read_text() == MISTAKES.page(), "run python benchmarks/mistakes.py"
