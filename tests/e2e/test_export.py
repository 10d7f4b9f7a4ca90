# SPDX-License-Identifier: Apache-2.0
"""``hypgen export`` and back: the value stays what it was."""

import json
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from hypgen.codegen.generate import generate_exact
from hypgen.dsl.load import load
from hypgen.runtime.builder.solver import build_solver

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


def returns(program: Path, policy: Path) -> list[float]:
    command = [str(program), f"--load-policy={policy}", "--runs=30", "--seed=2", "--json=-", "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return [json.loads(line)["discounted_return"] for line in done.stdout.splitlines()]


def test_a_policy_in_appls_format_is_one_of_the_exported_model(tmp_path: Path) -> None:
    model, exported = tmp_path / "walk.pomdp", tmp_path / "walk.POMDP"
    ours, theirs = tmp_path / "walk", tmp_path / "walk.policy"
    model.write_text(WALK)
    assert hypgen("export", str(model), "-o", str(exported)).returncode == 0
    [states] = [line for line in exported.read_text().splitlines() if line.startswith("states: ")]
    for path, options in ((ours, ()), (theirs, ("--policy-format", "appl"))):
        done = hypgen("solve", str(model), "--gap", "1e-4", "--policy", str(path), *options)
        assert done.returncode == 0, done.stderr
    head = ElementTree.fromstring(theirs.read_text()).find("AlphaVector")
    assert head is not None
    assert int(head.attrib["vectorLength"]) == len(states.split()) - 1
    assert len(head) == int(head.attrib["numVectors"])
    names = theirs.read_text().split("<!-- hypgen ")[1].split(" -->")[0]
    assert json.loads(names)["actions"] == ["wait", "go", "peek"]
    program = build_solver(generate_exact(load(model).model), str(model), lambda step: None)
    assert returns(program, theirs) == returns(program, ours)
    theirs.write_text(theirs.read_text().replace("</AlphaVector>", ""))
    done = subprocess.run([str(program), f"--load-policy={theirs}"], capture_output=True, text=True)
    assert done.returncode == 2 and "the policy's file is damaged" in done.stderr


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
