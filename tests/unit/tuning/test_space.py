# SPDX-License-Identifier: Apache-2.0
"""Ranges of what is tuned: of options, of a param's type, and those that cannot be."""

from pathlib import Path

import pytest
from support.paths import EXAMPLES

from hypgen.dsl import ir
from hypgen.dsl.load import load
from hypgen.experiments.suite import Task
from hypgen.tuning.asked import Asked
from hypgen.tuning.running import ask
from hypgen.tuning.space import Choice, Range, TuningError, default_of, option, param

TEXT = """
model Small
type Cell = 0 .. 3
enum Way { left, right }
param sure: prob = 0.5
param near: Cell = 2
param speed: float = 1.5
param way: Way = right
param eager: bool = true
param start: Cell = 1
param weights: float[Cell] = [c in Cell: 1.0]
param count: int = 4
discount 0.9
action act: Way
element robot {
  visible x: Cell
  init x = start
  x' = x
}
legal when robot.x > 0 or act == left
policy default {
  choose = if sure > 0.5 and robot.x < near and eager and speed + weights[0] > count then way else left
}
reward r = if act == left then 1 else 0
"""


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> ir.Model:
    path = tmp_path_factory.mktemp("models") / "small.pomdp"
    path.write_text(TEXT)
    return load(path).model


@pytest.mark.parametrize(
    ("name", "given", "values"),
    [
        ("scenarios", "20..300", Range(20, 300, whole=True)),
        ("xi", "0.5..0.9", Range(0.5, 0.9)),
        ("xi", (0.5, 0.9), Range(0.5, 0.9)),
        ("in-flight", "1, 8,64", Choice((1, 8, 64))),
        ("pruning", "auto,0.5", Choice(("auto", 0.5))),
        ("pruning", "0.01..1", Range(0.01, 1)),
        ("pruning", [0, 1], Choice((0, 1))),
    ],
)
def test_an_option_has_the_values_that_are_given(name: str, given: str, values: Range | Choice) -> None:
    assert option(name, given).values == values


def test_wide_ranges_are_searched_on_a_logarithmic_scale() -> None:
    assert Range(50, 2000).is_logarithmic and not Range(50, 500).is_logarithmic
    assert not Range(0, 2000).is_logarithmic


@pytest.mark.parametrize(
    ("name", "values", "default"),
    [
        ("sure", Range(0, 1), 0.5),
        ("near", Range(0, 3, whole=True), 2),
        ("way", Choice(("left", "right")), "right"),
        ("eager", Choice((False, True)), True),
    ],
)
def test_a_param_has_the_values_of_its_type(
    model: ir.Model, name: str, values: Range | Choice, default: object
) -> None:
    found = param(model, name, None)
    assert found.values == values and found.is_param
    assert default_of(model, found) == default


def test_a_param_without_a_range_takes_one(model: ir.Model) -> None:
    assert param(model, "speed", "0..2").values == Range(0, 2)
    assert param(model, "count", "1..9").values == Range(1, 9, whole=True)
    assert param(model, "way", "right").values == Choice(("right",))


@pytest.mark.parametrize(
    ("name", "given", "says"),
    [
        ("scenario", None, "no option 'scenario' can be tuned: did you mean 'scenarios'?"),
        ("seed", None, "no option 'seed' can be tuned: there are scenarios, depth"),
        ("xi", "0.9..0.5", "xi=0.9..0.5: the range is empty"),
        ("xi", "0.9..0.9", "the range is empty"),
        ("xi", "0.9..nan", "the range is empty"),
        ("xi", "low..high", "a range is LOW..HIGH, two numbers"),
        ("xi", "..", "a range is LOW..HIGH, two numbers"),
        ("xi", "", "expected LOW..HIGH, or different values separated by commas"),
        ("xi", "0.5,0.5", "different values"),
        ("depth", "1.5..9", "its values are whole numbers"),
    ],
)
def test_what_is_wrong_with_an_options_values_is_said(name: str, given: str | None, says: str) -> None:
    with pytest.raises(TuningError) as error:
        option(name, given)
    assert says in str(error.value)


@pytest.mark.parametrize(
    ("name", "given", "says"),
    [
        ("sur", None, "the model has no param 'sur': did you mean 'sure'?"),
        ("speed", None, "the param 'speed' is a float, which has no range: give speed=LOW..HIGH"),
        ("count", None, "the param 'count' is a int, which has no range"),
        ("weights", "0..1", "the param 'weights' is an array"),
        ("start", None, "the param 'start' changes what is visible or legal"),
        ("sure", "0.5..2", "sure=0.5..2: the param's type is prob"),
        ("near", "2..7", "near=2..7: the param's type is 0 .. 3"),
        ("way", "up,left", "way: up is no value of it; there are left,right"),
        ("way", "0..1", "way=0..1: it has no range; list values"),
    ],
)
def test_what_is_wrong_with_a_param_is_said(model: ir.Model, name: str, given: str | None, says: str) -> None:
    with pytest.raises(TuningError) as error:
        param(model, name, given)
    assert says in str(error.value)


def asked(model: ir.Model, **settings: object) -> Asked:
    return ask(Task("small", Path("small.pomdp")), model, **settings)  # type: ignore[arg-type]


def test_settings_are_told_to_the_solver(model: ir.Model) -> None:
    found = asked(
        model, options={"in-flight": "1..8"}, params={"sure": None}, fixed={"steps": 9, "belief": "particle"},
        budget={"trials": 7, "time": None},
    )  # fmt: skip
    assert found.setting({}, 1).arguments() == [
        "--mode=despot", "--steps=9", "--belief=particle", "--trials=7", "--seed=1"
    ]  # fmt: skip
    own = {"in_flight": 4, "param sure": 0.25}
    assert found.setting(own, 2).arguments() == [
        "--mode=despot", "--steps=9", "--belief=particle", "--trials=7", "--in-flight=4",
        '--settings={"params":{"sure":0.25}}', "--seed=2",
    ]  # fmt: skip
    assert found.settings(own) == {
        "options": {"mode": "despot", "belief": "particle", "in-flight": 4},
        "params": {"sure": 0.25},
    }, "budgets and steps are no settings"


def test_each_mode_has_its_usual_options(model: ir.Model) -> None:
    assert [one.name for one in asked(model, mode="rollout").dimensions] == ["scenarios", "depth"]
    assert "in_flight" in [one.name for one in asked(model, mode="hyp").dimensions]
    assert [one.name for one in asked(model, params={"sure": None}).dimensions] == ["sure"]


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"mode": "depot"}, "there is no mode 'depot'; there are default"),
        ({"mode": "default"}, "mode 'default' has no options to tune: name params"),
        (
            {"mode": "default", "options": {"xi": None}},
            "the default policy has no search: 'xi' changes nothing",
        ),
        ({"runs": 2}, "a candidate has to play 3 episodes or more"),
        ({"sampler": "cma"}, "there is no sampler 'cma'; there are tpe, gp"),
        ({"fixed": {"xi": 0.5}}, "'xi' is both tuned and fixed"),
        ({"fixed": {"seed": 3}}, "no option 'seed' can be fixed"),
        ({"options": {"in-flight": None, "in_flight": None}}, "'in_flight' is tuned twice"),
        ({"budget": {"time": 1.0, "trials": 3}}, "give one of time, period, trials, found time, trials"),
    ],
)
def test_what_cannot_be_asked_is_said(model: ir.Model, settings: dict[str, object], says: str) -> None:
    with pytest.raises(TuningError) as error:
        asked(model, **settings)
    assert says in str(error.value)


def test_the_gp_sampler_without_torch_is_refused(model: ir.Model, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "torch" else object())
    with pytest.raises(TuningError, match="GP sampler needs PyTorch: pip install torch"):
        asked(model, sampler="gp")
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(TuningError, match=r"tuning needs optuna and scipy: pip install 'hypgen\[tune\]'"):
        asked(model)


def test_params_of_the_default_policy_of_the_examples_can_be_tuned() -> None:
    rocks = load(EXAMPLES / "rock_sample.pomdp").model
    assert param(rocks, "sure", None).values == Range(0, 1)
    with pytest.raises(TuningError, match="changes what is visible or legal"):
        param(rocks, "start_row", None)
