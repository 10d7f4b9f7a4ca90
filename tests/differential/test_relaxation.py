# SPDX-License-Identifier: Apache-2.0
"""Derived bounds against the values of knowing the state and of the default policy, by brute force."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from hypgen.codegen.bounds.relaxation import relax
from hypgen.codegen.generate import generate
from hypgen.codegen.layout import limits
from hypgen.dsl.load import load
from hypgen.runtime.builder.compile_flags import host_flags
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.tools import find_tools

pytestmark = pytest.mark.cxx
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
    states, least, most, largest, *_ = compared(model, settings, folder)
    return int(states), least, most, largest


def compared(model: str, settings: tuple[str, ...], folder: Path) -> list[float]:
    """Return what ``relaxation_main.cpp`` prints of a model's bounds."""
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
        *host_flags(),
        "-pthread",
    ]
    program = str(folder / "compare")
    subprocess.run([compiler, *flags, *names, str(HERE / "relaxation_main.cpp"), "-o", program], check=True)
    found = subprocess.run([program, repr(loaded.discount)], check=True, capture_output=True, text=True)
    return [float(word) for word in found.stdout.split()]


def test_one_group_has_the_value(tmp_path: Path) -> None:
    states, least, most, largest = excess(undeclared((ROOT / "examples/tag.pomdp").read_text()), (), tmp_path)
    assert states > 800
    assert least >= 0
    assert most < 1e-4 * largest


def test_several_groups_are_above_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "MAX_GROUP_ENTRIES", 12 << 2)  # two rocks each
    text = undeclared((ROOT / "examples/rock_sample.pomdp").read_text()).replace("\nparam ", "\nconst ")
    states, least, most, largest = excess(text, SMALL, tmp_path)
    assert states > 100
    assert least >= 0
    assert 0.1 < most < largest


WINDY = """model Windy
discount 0.9
enum Move { left, right, wait }
type Cell = 0 .. 5
action move: Move
element wind {
  hidden strong: bool
  init strong ~ bernoulli(0.5)
  strong' ~ noisy(strong, 0.8)
}
element boat {
  visible cell: Cell
  let pushed ~ bernoulli(if wind.strong then 0.4 else 0.1)
  init cell ~ weighted(c in Cell: 1.0)
  cell' = match move {
    left  => clamp(if pushed then cell else cell - 1)
    right => clamp(if pushed then cell + 2 else cell + 1)
    else  => clamp(if pushed then cell + 1 else cell)
  }
  reward way = if cell' == 5 and cell < 5 then 10 else -1
}
legal when not (move == left and boat.cell == 0)
terminal when boat.cell' == 5
observe felt: bool ~ noisy(wind.strong', 0.7)
policy default ~ if boat.cell > 2 then { left: 0.3, else right } else { wait: 0.5, else right }
"""


@pytest.mark.parametrize("policy", ["declared", "uniform"])
def test_what_the_default_policy_earns_is_known(tmp_path: Path, policy: str) -> None:
    text = WINDY if policy == "declared" else WINDY[: WINDY.index("policy default")]
    states, least, _, largest, under, deepest = compared(text, (), tmp_path)
    assert states == 12
    assert least >= 0
    assert 0 <= under <= deepest < 1e-4 * largest


# The best way to share all rocks is the value; to share half of them at a time is not.
FEW = ("n=3", "k=4", "start_row=[0, 2]", "rock_x=[0, 1, 2, 2]", "rock_y=[2, 0, 1, 2]")


@pytest.mark.parametrize(("rocks", "low", "high"), [(4, 0.0, 1e-5), (2, 0.02, 0.2)])
def test_agents_apart_are_above_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rocks: int, low: float, high: float
) -> None:
    monkeypatch.setattr(limits, "MAX_GROUP_ENTRIES", 12 << rocks)  # a robot's places and some rocks
    text = (ROOT / "examples/two_robot_rock_sample.pomdp").read_text().replace("\nparam ", "\nconst ")
    states, least, most, largest = excess(text, FEW, tmp_path)
    assert states > 1000
    assert least >= 0
    assert low * largest <= most < high * largest
