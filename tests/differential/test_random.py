# SPDX-License-Identifier: Apache-2.0
"""Random models: the generated C++ against the interpreter, bit for bit, many models a program."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.random_models import batches, generator
from support.random_models.failures import UNLUCKY, failures
from support.random_models.tree import Node, shrink

from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.tools import find_compiler

FOUND = sorted((Path(__file__).parent / "found").glob("*.pomdp"))
FEW, MODELS, MANY = 20, 200, 10_000


@pytest.fixture(scope="module")
def _compiler() -> None:
    try:
        find_compiler()
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")


@pytest.mark.cxx
@pytest.mark.usefixtures("_compiler")
def test_models_that_failed_once(tmp_path: Path) -> None:
    texts = [path.read_text() for path in FOUND]
    results = batches.compare(texts, tmp_path, batches.Size(scenarios=500, steps=10))
    assert dict(zip([path.name for path in FOUND], results, strict=True)) == {p.name: None for p in FOUND}


@pytest.mark.cxx
@pytest.mark.usefixtures("_compiler")
def test_a_few_random_models() -> None:
    """What fails is made small: put it into ``found/``."""
    assert "\n".join(failures(range(FEW), batches.Size())) == ""


@pytest.mark.cxx
@pytest.mark.property
@pytest.mark.usefixtures("_compiler")
def test_random_models() -> None:
    assert "\n".join(failures(range(FEW, MODELS), batches.Size())) == ""


@pytest.mark.cxx
@pytest.mark.slow
@pytest.mark.usefixtures("_compiler")
def test_many_random_models() -> None:
    assert "\n".join(failures(range(MODELS, MODELS + MANY), batches.Size())) == ""


def test_the_checker_accepts_nearly_all_random_models() -> None:
    results = [batches.lowered(str(generator.model(seed)), 0) for seed in range(50)]
    refused = [result for result in results if isinstance(result, str)]
    assert len(refused) < 10
    assert {text.split(": ")[1] for text in refused} <= UNLUCKY


def test_models_shrink_to_what_matters() -> None:
    small = shrink(generator.model(1), lambda batch: next((m for m in batch if "discount" in str(m)), None))
    assert [line for line in str(small).splitlines() if line.strip()][-1] == "discount 0.95"
    leaf = Node("int", "1", ("2",))
    tree = Node("model", "", ("x = ", Node("int", "1", (leaf, " + ", Node("int", "1", ("3", " * ", "4"))))))
    assert str(shrink(tree, lambda batch: next((m for m in batch if "3" in str(m)), None))) == "x = 3 * 4"
