# SPDX-License-Identifier: Apache-2.0
"""``check --samples``: one model for each kind of finding, word for word, and none in models that are right.

HYPGEN_UPDATE=1 rewrites the expected texts; review the difference.
"""

import os
from pathlib import Path

import numpy as np
import pytest
from support.paths import ROOT

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Array, Frame
from hypgen.dsl.interpret.sampling.findings import Finding
from hypgen.dsl.interpret.sampling.sample_laws import check_densities, check_returns
from hypgen.dsl.interpret.sampling.sample_model import Walk
from hypgen.dsl.load import load

MODELS = sorted((Path(__file__).parent / "findings").glob("*.pomdp"))
SLOW = {"crowd_driving", "laser_tag", "pocman"}  # more than a minute each
RIGHT = [
    *(path for path in (ROOT / "examples").glob("*.pomdp") if path.stem not in SLOW),
    *(ROOT / "tests" / "differential" / "models" / f"{n}.pomdp" for n in ("draws", "wide_key")),
]
# Whatever the number of samples, to check the others' laws takes seconds.
QUICK = [path for path in RIGHT if path.stem not in ("draws", "light_dark", "two_robot_rock_sample")]


def quiet(phase: str, done: int, total: int) -> None:
    """Show no progress."""


def sample(path: Path, samples: int, seed: int = 0) -> list[Finding]:
    walk = Walk(load(path).model, samples, seed)
    walk.run(quiet)
    check_densities(walk, quiet)
    check_returns(walk, quiet)
    assert walk.visited == samples
    return walk.findings


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_the_finding_is_told_word_for_word(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(path.parent)
    sources = load(path.name).sources
    found = sample(Path(path.name), 2000)
    assert {f.diagnostic.code.lower() for f in found} == {path.stem.split("_")[0]}
    text = "\n".join(f.render(sources) for f in found)
    expected = path.with_suffix(".expected")
    if os.environ.get("HYPGEN_UPDATE"):
        expected.write_text(text)
    assert text == expected.read_text()


@pytest.mark.parametrize("path", sorted(QUICK), ids=lambda p: p.stem)
def test_nothing_is_found_in_a_model_that_is_right(path: Path) -> None:
    assert [f.diagnostic.message for f in sample(path, 200)] == []


@pytest.mark.property
@pytest.mark.parametrize("path", sorted(RIGHT), ids=lambda p: p.stem)
def test_nothing_is_found_in_many_samples_of_a_model_that_is_right(path: Path) -> None:
    assert [f.diagnostic.message for f in sample(path, 3000)] == []


def test_the_same_seed_finds_the_same() -> None:
    path = MODELS[0]
    first, again, other = (sample(path, 500, seed) for seed in (1, 1, 2))
    assert [f.to_json() for f in first] == [f.to_json() for f in again]
    assert [f.count for f in first] != [f.count for f in other]


@pytest.mark.parametrize("bias", [0.9, 0.0])
def test_a_density_that_the_sampler_does_not_follow_is_found(
    bias: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    density = Evaluator.density

    def biased(self: Evaluator, dist: ir.Dist, frame: Frame, value: Array) -> Array:
        found = density(self, dist, frame, value)
        return np.where(
            value == 0, bias * found, found + (1 - bias) * density(self, dist, frame, np.asarray(0))
        )

    monkeypatch.setattr(Evaluator, "density", biased)
    found = sample(ROOT / "examples" / "tiger.pomdp", 500)
    assert [f.diagnostic.code for f in found] == ["C0401"]
    message = found[0].diagnostic.message
    assert ("its density is 0" if bias == 0.0 else "chi-square") in message


def test_what_was_found_before_an_interrupt_is_kept() -> None:
    def interrupt(phase: str, done: int, total: int) -> None:
        raise KeyboardInterrupt

    walk = Walk(load(MODELS[0]).model, 100_000, 0)
    with pytest.raises(KeyboardInterrupt):
        walk.run(interrupt)
    assert 0 < walk.visited < 100_000


SENSORS = """model Sensors
enum Act { wait, look }
action act: Act
discount 0.9
element thing {
  hidden x: float
  init x ~ normal(0.0, 2.0)
  x' = x
  let gust ~ normal(0.0, 0.5)
}
observe near: float ~ if act == look then normal(0.1 * thing.x' + thing.gust, 0.5) else 0
observe held: float ~ clamp(exponential(1 + abs(thing.x')), 0.5, 2.0)
reward r = if act == look then -1 else 0
"""


def wrong_sensors(folder: Path) -> set[str]:
    """Return which of the sensors' densities are told to be wrong."""
    (folder / "sensors.pomdp").write_text(SENSORS)
    walk = Walk(load(folder / "sensors.pomdp").model, 40, 0)
    walk.run(quiet)
    check_densities(walk, quiet)
    return {name for name in ("near", "held") for f in walk.findings if f"'{name}'" in f.diagnostic.message}


def test_draws_of_continuous_laws_follow_their_densities(tmp_path: Path) -> None:
    assert wrong_sensors(tmp_path) == set()


@pytest.mark.parametrize("place", ["1000.0", "20000.0", "400000.0", "8e8"])
def test_draws_far_from_zero_repeat_and_are_no_mistake(place: str, tmp_path: Path) -> None:
    text = SENSORS.replace("normal(0.1 * thing.x' + thing.gust, 0.5)", f"normal({place} + thing.gust, 0.5)")
    (tmp_path / "far.pomdp").write_text(text)
    walk = Walk(load(tmp_path / "far.pomdp").model, 40, 0)
    walk.run(quiet)
    check_densities(walk, quiet)
    assert [f.diagnostic.message for f in walk.findings] == []


@pytest.mark.parametrize(("law", "name", "factor"), [(ir.Normal, "near", 1.25), (ir.Clamped, "held", 0.75)])
def test_a_wrong_density_of_a_continuous_law_is_found(
    law: type[ir.Continuous], name: str, factor: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    density = Evaluator.density_of_law

    def biased(self: Evaluator, dist: ir.Continuous, frame: Frame, value: Array) -> Array:
        found = density(self, dist, frame, value)
        return factor * found if isinstance(dist, law) else found

    monkeypatch.setattr(Evaluator, "density_of_law", biased)
    assert wrong_sensors(tmp_path) == {name}


def test_the_walk_ends_when_its_time_is_over() -> None:
    walk = Walk(load(MODELS[0]).model, 1_000_000, 0, seconds=0.0)
    walk.run(quiet)
    check_densities(walk, quiet)
    check_returns(walk, quiet)
    assert 0 < walk.visited <= walk.lanes
    assert walk.cut[0] == f"the walk ended after {walk.visited:,} of 1,000,000 states"


@pytest.mark.parametrize("law", ["normal(x, 2.0)", "uniform(0.5 * x, 9.0)", "exponential(0.5 + x)"])
def test_a_bin_is_drawn_as_often_as_its_density_says(law: str, tmp_path: Path) -> None:
    path = tmp_path / "m.pomdp"
    path.write_text(
        f"""model M
type Bin = 3 .. 40
action act: bool
discount 0.9
reward r = 0
element e {{
  hidden fixed x: 0 .. 9
  init x ~ uniform(0, 9)
  observe seen: Bin ~ binned({law}, -3.0, 15.0)
}}
"""
    )
    walk = Walk(load(path).model, 500, 0)
    walk.run(quiet)
    check_densities(walk, quiet)
    assert walk.findings == []
