# SPDX-License-Identifier: Apache-2.0
"""A partition that lets warps write one word is caught where it runs: in the generated step, on the CPU."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.random_models import batches

from hypgen.codegen.passes import partition
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.tools import find_compiler

pytestmark = pytest.mark.cxx
LAMPS = """model Lamps
discount 0.95
type Lamp = 0 .. 9
action press: Lamp
element lamp[i in Lamp] {
  hidden on: bool
  init on ~ bernoulli(0.5)
  on' ~ if i == press then bernoulli(0.5) else bernoulli(0.1)
  reward shines = if on' then 1 else 0
}
observe any: bool ~ if lamp[press].on' then bernoulli(0.9) else bernoulli(0.1)
policy default = 3
bound upper = 200
"""

WALKERS = """model Walkers
discount 0.95
type Walker = 1 .. 7
type Mood = -3 .. 100
action call: Walker
element walker[i in Walker] {
  visible stands: bool
  hidden place: float
  hidden mood: Mood
  init stands = true
  init place ~ normal(0.0, 5.0)
  init mood ~ uniform(Mood)
  stands' ~ if call == i then bernoulli(0.9) else bernoulli(0.4)
  mood' ~ if stands then uniform(Mood) else mood
  place' ~ if stands then place else normal(place, 1.0)
  reward calm = if mood' > 50 and place' > 0.0 then 1 else 0
}
policy default = 3
bound upper = 200
"""


@pytest.fixture(scope="module", autouse=True)
def _compiler() -> None:
    try:
        find_compiler()
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")


def test_members_that_share_a_word_stay_together(tmp_path: Path) -> None:
    texts = [LAMPS, WALKERS]
    assert batches.compare(texts, tmp_path, batches.Size(40, 8)) == [None, None]


def test_members_apart_are_caught(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(partition, "_grain", lambda group, state: 1)
    (result,) = batches.compare([LAMPS], tmp_path, batches.Size(10, 5))
    assert result is not None
    assert "the schedule of 2 warps differs" in result
