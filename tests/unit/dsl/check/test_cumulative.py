# SPDX-License-Identifier: Apache-2.0
"""``cdf(D, x)`` against the laws' own formulas, with parameters that vary and where x lies outside."""

import math
from pathlib import Path

import numpy as np
import pytest

from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Frame
from hypgen.dsl.load import load

MODEL = """model M
enum Act {{ wait, go }}
discount 0.9
action act: Act
param width: float = 2
element robot {{
  visible x: float
  init x = 0
  x' = x
}}
reward r = {}
bound upper = 1
bound tail = 0
"""
XS = np.array([-50.0, -1.0, 0.0, 0.25, 1.5, 3.0, 80.0], dtype=np.float32)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("cdf(normal(0.5, width), robot.x)", lambda x: 0.5 * math.erfc((0.5 - x) / 2 / math.sqrt(2))),
        ("cdf(normal(robot.x, -width), 1.0)", lambda x: 0.5 * math.erfc((x - 1) / 2 / math.sqrt(2))),
        ("cdf(exponential(width), robot.x + 1)", lambda x: 1 - math.exp(-max(x + 1, 0) / 2)),
        ("cdf(uniform(-1.0, width), robot.x)", lambda x: min(max((x + 1) / 3, 0), 1)),
        ("cdf(uniform(width, width), robot.x)", lambda x: 1.0 if x > 2 else 0.0),
        ("cdf(normal(0.0, 1.0), 1.0) + 0 * robot.x", lambda x: 0.8413447),
    ],
)
def test_values(text: str, wanted: object, tmp_path: Path) -> None:
    path = tmp_path / "m.pomdp"
    path.write_text(MODEL.format(text))
    model = load(path).model
    frame = Frame(np.arange(len(XS)), {"robot.x": XS})
    with np.errstate(all="ignore"):
        found = Evaluator(model, {}).value(model.rewards[0].value, frame)
    assert callable(wanted)
    assert found.tolist() == pytest.approx([wanted(float(x)) for x in XS], abs=2e-7)


def test_a_law_that_cdf_takes_is_no_draw(tmp_path: Path) -> None:
    path = tmp_path / "m.pomdp"
    path.write_text(
        MODEL.format("robot.p").replace(
            "  init x = 0\n", "  init x = 0\n  let p: float ~ cdf(uniform(-1.0, 2.0), x)\n"
        )
    )
    [let] = load(path).model.lets
    assert not let.draws
