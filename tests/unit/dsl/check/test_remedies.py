# SPDX-License-Identifier: Apache-2.0
"""Remedies that take up what the model has."""

from pathlib import Path

import pytest

from hypgen.dsl.load import load
from hypgen.dsl.messages.diagnostic import ModelError

HIVES = """model M
enum Health { good, dead }
type Hive = 0 .. 3
enum Act { wait, visit(Hive) }
discount 0.9
action act: Act
element hive[h in Hive] {
  hidden health: Health
  init health ~ uniform(Health)
  health' = health
}
fn worth(h: Hive): float = 1.0 + h
reward r = if act == wait then 0 else 1
bound tail = 0
"""


@pytest.mark.parametrize(
    ("line", "remedy"),
    [
        ("terminal when all(hive.health == dead)", "write all(h in Hive: ..)"),
        (
            "reward s = let best = max(h in Hive: worth(h)) in if hive[best].health == dead then 1 else 0",
            "round it: floor(..), ceil(..) or round(..); where a value is largest, argmax(i in T: ..) says",
        ),
    ],
)
def test_remedies_name_what_is_meant(line: str, remedy: str, tmp_path: Path) -> None:
    path = tmp_path / "m.pomdp"
    path.write_text(f"{HIVES}{line}\n")
    with pytest.raises(ModelError) as caught:
        load(path)
    assert [d.remedy for d in caught.value.diagnostics] == [remedy]
