# SPDX-License-Identifier: Apache-2.0
import pytest
from support.paths import ROOT

from hypgen.dsl.load import load
from hypgen.experiments.measures import Measure
from hypgen.experiments.suite_values import SuiteError

CROWD = ROOT / "examples" / "crowd_driving.pomdp"
TIGER = ROOT / "examples" / "tiger.pomdp"


@pytest.mark.parametrize(
    ("measure", "value"),
    [
        (Measure("way", visible="car.s", times=0.5), 6.0),
        (Measure("brakes", action="brake"), 3.0),
        (Measure("horns", action="horn"), 0.0),
        (Measure("crashes"), 1.0),
    ],
)
def test_a_measure_is_read_from_the_lines_of_an_episode(measure: Measure, value: float) -> None:
    line = {"visible": {"car.s": 12}, "terminal": True, "success": False}
    assert measure.of({"brake": 3}, line) == value
    if measure.name == "crashes":
        assert measure.of({}, line | {"success": True}) == measure.of({}, line | {"terminal": False}) == 0


def test_what_a_model_does_not_have_is_refused() -> None:
    crowd = load(CROWD).model
    for measure in (Measure("a", visible="car.s"), Measure("a", action="decelerate"), Measure("a")):
        measure.check(crowd, "here")
    for measure, says in (
        (Measure("a", visible="car.gears"), "here: CrowdDriving has no visible variable `car.gears`"),
        (
            Measure("a", visible="ped.x"),
            "no visible variable `ped.x` of one value: there are car.s, car.gear",
        ),
        (Measure("a", action="decelerates"), "no action `decelerates`. did you mean 'decelerate'?"),
    ):
        with pytest.raises(SuiteError) as error:
            measure.check(crowd, "here")
        assert says in str(error.value)
    with pytest.raises(SuiteError, match="does not say what success is"):
        Measure("a").check(load(TIGER).model, "here")
