# SPDX-License-Identifier: Apache-2.0
"""One thread builds the same tree, bit for bit, as when the table was made.

The table (``pinned_signatures.json``) was last made when leaves began to roll out few actions, that of
navigation when its particles began to draw all first words by the model's own names, and that of
crowd_driving, light_dark and pocman when moves of particles got names for up to 128 words. A change that
does not mean to change arithmetic, the order of trials or what an example says must leave it as it is.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from support.paths import EXAMPLES
from support.pinned import PINS, signatures

from hypgen.codegen.generate import generate
from hypgen.dsl.load import load
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.solver import build_solver
from hypgen.runtime.builder.tools import find_tools

pytestmark = pytest.mark.cxx
MODELS = sorted(EXAMPLES.glob("*.pomdp"))


def test_every_example_is_pinned() -> None:
    assert list(PINS) == [path.stem for path in MODELS]


@pytest.mark.parametrize("example", MODELS, ids=[path.stem for path in MODELS])
def test_signatures_are_those_of_the_table(example: Path) -> None:
    try:
        find_tools()
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")
    solver = build_solver(generate(load(example).model), f"signature/{example.stem}", lambda step: None)
    assert signatures(solver, example.stem) == PINS[example.stem]
