# SPDX-License-Identifier: Apache-2.0
"""Small inputs of other people, with values worked out by hand: proven, or refused with the reason."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from support.paths import ROOT

from hypgen.cli.exit_codes import Exit

FIELD = ROOT.parent / "shared" / "field"
pytestmark = pytest.mark.skipif(not FIELD.is_dir(), reason="../shared/field is not beside the checkout")
HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]

VALUES = {
    "big_rewards.POMDP": -1.375e8,
    "small_rewards_dsl.pomdp": 2e-7,
    "rare_event.POMDP": -5,
    "near_one.POMDP": -1e5,
    "cost_goal.POMDP": -3.8,
    "first_look.pomdp": 21.4435,
    "one_axis.pomdp": -2.5,
}
REFUSED = {
    "odd_values.POMDP": ("1.2 is no probability", "-0.2 is no probability"),
    "order_reset.POMDP": ("'reset' stands for a row",),
    "thirteen_rough.POMDP": ("--normalise",),
    "pomdpx_zero_belief.pomdpx": ("sum to 0",),
}


def hypgen(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*HYPGEN, *arguments], capture_output=True, text=True)


@pytest.mark.cxx
@pytest.mark.parametrize("name", VALUES)
def test_the_value_lies_in_a_narrow_interval(name: str) -> None:
    done = hypgen("solve", str(FIELD / name), "--json", "--time", "20")
    assert done.returncode == Exit.OK, done.stderr
    result, value = json.loads(done.stdout), VALUES[name]
    half_digit = 0.5e-5 * abs(value)  # values have six digits
    assert result["lower"] <= value + half_digit and value - half_digit <= result["upper"]
    assert result["upper"] - result["lower"] <= 0.03 * abs(value)


@pytest.mark.parametrize("name", REFUSED)
def test_a_wrong_file_is_refused_with_the_reason(name: str, tmp_path: Path) -> None:
    done = hypgen("import", str(FIELD / name), "-o", str(tmp_path / "m.pomdp"))
    assert done.returncode == Exit.MISTAKE, done.stderr
    assert all(text in done.stderr for text in REFUSED[name])


def test_rounded_rows_are_taken_on_demand(tmp_path: Path) -> None:
    file = str(FIELD / "thirteen_rough.POMDP")
    assert hypgen("import", file, "--normalise", "-o", str(tmp_path / "m.pomdp")).returncode == Exit.OK


@pytest.mark.cxx
def test_a_model_whose_bound_is_no_number_is_called_broken() -> None:
    done = hypgen("run", str(FIELD / "nan_bound.pomdp"), "--runs", "1", "--steps", "5", "--time", "0.01")
    assert done.returncode == Exit.MISTAKE
    assert "THE MODEL IS BROKEN" in done.stdout and "bound upper (nan_bound.pomdp:21)" in done.stdout


def test_a_reward_that_may_be_no_number_is_refused() -> None:
    done = hypgen("check", str(FIELD / "nan_reward.pomdp"))
    assert done.returncode == Exit.MISTAKE and "'sqrt' in it may have no value" in done.stderr


@pytest.mark.cxx
def test_many_actions_are_compared_and_counted() -> None:
    done = hypgen("run", str(FIELD / "many_actions.pomdp"), "--runs", "1", "--steps", "3", "--time", "0.5")
    assert done.returncode == Exit.OK and "actions compared            mean 10001.0" in done.stdout


@pytest.mark.cxx
def test_a_shortest_path_without_a_discount_is_played() -> None:
    done = hypgen("run", str(FIELD / "cost_goal.POMDP"), "--runs", "2", "--steps", "40", "--time", "0.01")
    assert done.returncode == Exit.OK and "terminal 2" in done.stdout


def test_a_reward_that_is_never_paid_is_told() -> None:
    done = hypgen("check", str(FIELD / "never_paid.pomdp"), "--samples", "2000")
    assert "'prize'" in done.stderr + done.stdout and "1 warning" in done.stdout


def test_the_belief_that_is_not_there_points_at_the_read_of_another_member() -> None:
    done = hypgen("check", str(FIELD / "exposed.pomdp"))
    line = "  let exposed = any(j in M where j != i: not machine[j].works)"
    assert done.returncode == Exit.MISTAKE
    assert f"{line}\n   | {' ' * line.index('machine[j]')}{'^' * len('machine[j].works')}\n" in done.stderr


@pytest.mark.parametrize("calls", [5, 40])
def test_code_grows_with_the_number_of_calls_alone(calls: int) -> None:
    done = subprocess.run(
        [*HYPGEN, "explain", str(FIELD / "blowup.pomdp"), "--set", f"n={calls}", "--stage", "cpp"],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == Exit.OK, done.stderr
    files = re.split(r"(?m)^// (?=src/)", done.stdout)
    lanes = sum(len(text) for text in files if text.startswith("src/lanes.cpp"))  # a second text of the same
    assert max(len(done.stdout) - lanes, lanes) < 20_000 + 500 * calls


@pytest.mark.cxx
def test_elements_have_names_that_the_compiler_knows() -> None:
    options = ("--runs", "2", "--steps", "10", "--time", "0.01")
    done = hypgen("run", str(FIELD / "keyword_element.pomdp"), *options)
    assert done.returncode == Exit.OK, done.stderr


def test_a_queue_is_played() -> None:
    done = hypgen("sim", str(FIELD / "queue.pomdp"), "--policy", "random", "--steps", "20")
    assert done.returncode == Exit.OK, done.stderr


@pytest.mark.cxx
def test_too_few_particles_recover_and_are_called_so() -> None:
    options = ("--particles", "200", "--runs", "10", "--steps", "100", "--time", "0.01", "--json", "-")
    done = hypgen("run", str(FIELD / "sharp_sensor.pomdp"), *options)
    assert done.returncode == Exit.OK, done.stderr
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    statuses = [line["belief"] for line in lines if line["type"] == "step"]
    assert len(statuses) >= 500 and "impossible_observation" not in statuses
