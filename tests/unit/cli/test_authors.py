# SPDX-License-Identifier: Apache-2.0
"""Models of a new author; docs/results/authors.md tells of them."""

from pathlib import Path

import pytest
from support.paths import ROOT

from hypgen.dsl.load import load


@pytest.mark.parametrize(
    "path", sorted((ROOT / "benchmarks" / "authors").glob("*.pomdp")), ids=lambda p: p.stem
)
def test_they_have_no_mistake(path: Path) -> None:
    assert load(path).warnings == ()
