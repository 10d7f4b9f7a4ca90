"""Derived upper bounds against the value of knowing the state, by brute force over the whole model's step."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from hypgen.codegen import options
from hypgen.codegen.driver import generate
from hypgen.codegen.groups import relax
from hypgen.dsl.driver import load
from hypgen.runtime.errors import ToolchainError
from hypgen.runtime.toolchain import find_tools

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
SMALL = (
    "n=3",
    "k=4",
    "start_row=1",
    "rock_x=[0, 1, 2, 2]",
    "rock_y=[2, 0, 1, 2]",
)


def undeclared(text: str) -> str:
    """Return a model's text without its upper bound, the last declaration but the tail's."""
    return re.sub(r"^bound upper(.|\n)*?(?=^bound tail)", "", text, flags=re.MULTILINE)


def excess(model: str, settings: tuple[str, ...], folder: Path) -> tuple[int, float, float, float]:
    """Return how many states there are, by how much the bound exceeds the value, and the largest value."""
    try:
        compiler = str(find_tools().compiler.path)
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")
    (folder / "model.pomdp").write_text(model)
    loaded = load(folder / "model.pomdp", settings=settings).model
    assert relax(loaded).groups
    header = next(text for name, text in generate(loaded).items() if name.endswith(".hpp"))
    (folder / "model.hpp").write_text(header)
    names = [
        f'-DHEADER="{folder / "model.hpp"}"',
        f"-DMODEL={loaded.name}",
        f"-I{ROOT / 'runtime' / 'include'}",
    ]
    flags = [
        "-std=c++17",
        "-O1",
        "-Wall",
        "-Wextra",
        "-Wconversion",
        "-Werror",
        "-ffp-contract=off",
        "-pthread",
    ]
    program = str(folder / "compare")
    subprocess.run([compiler, *flags, *names, str(HERE / "relaxation_main.cpp"), "-o", program], check=True)
    found = subprocess.run([program, repr(loaded.discount)], check=True, capture_output=True, text=True)
    states, least, most, largest = found.stdout.split()
    return int(states), float(least), float(most), float(largest)


def test_one_group_has_the_value(tmp_path: Path) -> None:
    states, least, most, largest = excess(undeclared((ROOT / "examples/tag.pomdp").read_text()), (), tmp_path)
    assert states > 800
    assert least >= 0
    assert most < 1e-4 * largest


def test_several_groups_are_above_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(options, "MAX_GROUP_ENTRIES", 12 << 2)  # two rocks each
    text = undeclared((ROOT / "examples/rock_sample.pomdp").read_text()).replace("\nparam ", "\nconst ")
    states, least, most, largest = excess(text, SMALL, tmp_path)
    assert states > 100
    assert least >= 0
    assert 0.1 < most < largest
