# SPDX-License-Identifier: Apache-2.0
"""An agent that sees something before it first acts: from a model file to what commands say and earn."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from hypgen.cli.exit_codes import Exit

HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]

# Tiger with one growl heard before the first action. Tiger itself is worth 19.3714 and begins by listening,
# which costs 1 and a step, so this is worth (19.3714 + 1) / 0.95.
VALUE = 21.4436
START = """
model FirstLook
enum Door { left, right }
enum Act { listen, open_left, open_right }
discount 0.95
action act: Act
"""
VARIABLE = """
element room {
  hidden tiger: Door
  visible heard: Door
  init tiger ~ uniform(Door)
  init heard ~ noisy(tiger, 0.85)
  tiger' ~ if act == listen then tiger else uniform(Door)
  heard' ~ if act == listen then noisy(tiger', 0.85) else uniform(Door)
}
"""
OBSERVATION = """
element room {
  hidden tiger: Door
  init tiger ~ uniform(Door)
  tiger' ~ if act == listen then tiger else uniform(Door)
  observe first: Door at start ~ noisy(tiger, 0.85)
}
observe heard: Door ~ if act == listen then noisy(room.tiger', 0.85) else uniform(Door)
"""
END = """
reward outcome = match act {
  listen     => -1
  open_left  => if room.tiger == left  then -100 else 10
  open_right => if room.tiger == right then -100 else 10
}
policy default = listen
"""


def hypgen(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*HYPGEN, *arguments], capture_output=True, text=True)


def rows(text: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in text.splitlines()]


@pytest.fixture(params=[VARIABLE, OBSERVATION], ids=["variable", "observation"])
def model(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    path = tmp_path / "first_look.pomdp"
    path.write_text(START + request.param + END)
    return str(path)


def test_the_simulation_shows_what_is_seen_first(model: str) -> None:
    first, *_ = rows(hypgen("sim", model, "--policy", "default", "--steps", "1", "--json").stdout)
    (name, seen), *others = first["observation"].items()
    assert not others and first["state"][name] == seen
    told = hypgen("sim", model, "--policy", "default", "--steps", "1").stdout
    assert f"  observed {name} = {seen}\n" in told


def test_the_first_belief_of_a_simulation_is_given_what_is_seen(model: str, tmp_path: Path) -> None:
    script = tmp_path / "script"
    script.write_text("belief\n")
    first, belief, *_ = rows(hypgen("sim", model, "--script", str(script), "--json").stdout)
    (seen,) = first["observation"].values()
    assert belief["factors"]["room"][0][["left", "right"].index(seen)] == pytest.approx(0.85)


def test_a_sample_of_states_finds_nothing_wrong(model: str) -> None:
    assert "nothing wrong" in hypgen("check", model, "--samples", "2000").stdout


@pytest.mark.cxx
def test_the_value_at_the_start_is_that_of_the_conditioned_beliefs(model: str) -> None:
    done = hypgen("solve", model, "--json", "--gap", "1e-4")
    assert done.returncode == Exit.OK, done.stderr
    result = json.loads(done.stdout)
    assert result["lower"] - 1e-4 <= VALUE <= result["upper"] + 1e-4 < result["lower"] + 0.003
    assert len(result["first"]) == result["starts"] == 2
    assert len({first["seen"] for first in result["first"]}) == 2
    mean = sum(first["probability"] * first["actions"][0]["lower"] for first in result["first"])
    assert mean == pytest.approx(result["lower"], abs=1e-4)


@pytest.mark.cxx
def test_a_format_without_a_first_observation_is_refused(model: str) -> None:
    done = hypgen("export", model)
    assert done.returncode == Exit.MISTAKE
    assert "starts in 2 ways that the agent can tell apart" in done.stderr
    assert "let the first step show what is seen now before it" in done.stderr


@pytest.mark.cxx
@pytest.mark.parametrize("belief", ["factored", "particle"])
def test_a_search_earns_what_the_first_look_is_worth(model: str, belief: str) -> None:
    options = ["--mode", "despot", "--trials", "50", "--scenarios", "100", "--runs", "400", "--steps", "60"]
    done = hypgen("run", model, "--", *options, "--belief", belief, "--json", "-", "--quiet")
    assert done.returncode == Exit.OK, done.stderr
    lines = rows(done.stdout)
    starts = [line for line in lines if line["type"] == "start"]
    assert [line["episode"] for line in starts] == list(range(400))
    assert {line["observation"] for line in starts} == {"left", "right"}
    assert {line["belief"] for line in starts} == {"ok"}
    summary = lines[-1]
    assert summary["discounted_return"] == pytest.approx(VALUE, abs=2 * summary["interval95"])


@pytest.mark.cxx
def test_what_is_seen_first_follows_from_a_given_start(model: str, tmp_path: Path) -> None:
    start = tmp_path / "start.json"
    start.write_text('{"room.tiger": "left"}')
    options = ["--mode", "default", "--runs", "300", "--steps", "1", "--json", "-", "--quiet"]
    done = hypgen("run", model, "--", *options, "--start", str(start))
    assert done.returncode == Exit.OK, done.stderr
    seen = [line["observation"] for line in rows(done.stdout) if line["type"] == "start"]
    assert seen.count("left") == pytest.approx(0.85 * 300, abs=25)
