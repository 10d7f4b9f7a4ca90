# SPDX-License-Identifier: Apache-2.0
"""``hypgen export`` and back: the value stays what it was."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.cxx
ROOT = Path(__file__).parent.parent.parent
HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]

# The agent sees where it walks; what glows depends on where it stood; waiting is not always legal.
WALK = """model Walk
type Cell = 0 .. 2
enum Act { wait, go, peek }
discount 0.9
action act: Act
element walker {
  visible cell: Cell
  hidden lit, awake: bool
  init cell = 0
  init lit ~ bernoulli(0.3)
  init awake ~ bernoulli(0.5)
  let slips ~ bernoulli(0.25)
  cell' = if act == go and not slips then wrap(cell + 1) else cell
  lit' = lit
  awake' ~ bernoulli(0.5)
}
observe glow: bool ~ if act == peek then noisy(walker.lit', if walker.awake then 0.9 else 0.6) else false
legal when act != wait or walker.cell > 0
reward r = if walker.lit and walker.cell' == 2 then 3 else if act == go then -1 else 0
terminal when walker.cell' == 2 and act == go
policy default = go
"""


def hypgen(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*HYPGEN, *arguments], capture_output=True, text=True)


def value(model: Path) -> dict[str, float]:
    done = hypgen("solve", str(model), "--json", "--gap", "1e-4")
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    return {"lower": result["lower"], "upper": result["upper"], **result["bounds"]}


def test_what_is_exported_has_the_same_value(tmp_path: Path) -> None:
    model, exported = tmp_path / "walk.pomdp", tmp_path / "walk.POMDP"
    model.write_text(WALK)
    done = hypgen("export", str(model), "-o", str(exported))
    assert done.returncode == 0, done.stderr
    assert done.stderr.endswith(f"{model}: 8 states; written to {exported}\n")
    assert "-again1" in exported.read_text(), "a state is split"
    assert hypgen("export", str(model), "-o", str(exported)).returncode == 2
    before, after = value(model), value(exported)
    assert before["lower"] <= after["upper"] and after["lower"] <= before["upper"]
    assert before["upper"] - before["lower"] < 2e-4
    assert after["mdp"] == pytest.approx(before["mdp"], abs=1e-4)
    assert after["blind"] == pytest.approx(before["blind"], abs=1e-4)
