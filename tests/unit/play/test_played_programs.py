# SPDX-License-Identifier: Apache-2.0
"""What ``hypgen compare`` makes of programs that play, without a real one."""

import signal
import sys
from pathlib import Path

import pytest

from hypgen.play.played_programs import (
    Comparison,
    Policy,
    left_out,
    lines_of,
    numbers,
    outwards,
    play_exact,
    play_mode,
    steps_needed,
    table,
)

# Plays two episodes; mode "broken" fails after the first, mode "slow" waits there for an interrupt.
PROGRAM = """#!{python}
import json, os, signal, sys, time
signal.signal(signal.SIGTERM, signal.default_int_handler)
options = dict(zip(sys.argv[1::2], sys.argv[2::2]))
gain = {{"default": 0.0, "despot": 3.0}}
if "--policy-kind" in options:
    print(json.dumps({{"type": "solve", "lower": 4.0, "upper": 5.0}}))
    for kind in options["--policy-kind"].split(","):
        line = {{"type": "episode", "policy": kind, "episode": 0, "discounted_return": 4.5}}
        print(json.dumps({{**line, "steps": 3, "status": "terminal"}}))
    sys.exit(0)
mode = options["--mode"]
for i in range(2):
    print(json.dumps({{"type": "step", "episode": i, "search_seconds": 0.25}}))
    value = 10.0 * i + gain.get(mode, 1.0)
    line = {{"type": "episode", "episode": i, "discounted_return": value, "steps": 2, "status": "terminal"}}
    print(json.dumps(line))
    if mode == "broken":
        sys.exit("no such mode")
    if mode in ("slow", "endless"):
        sys.stdout.flush()
        try:
            if mode == "slow":
                os.kill(os.getppid(), signal.SIGINT)
            time.sleep(30)
        except KeyboardInterrupt:
            line = {{"type": "episode", "episode": 1, "discounted_return": 0.5, "steps": 1}}
            print(json.dumps({{**line, "status": "interrupted"}}))
            sys.exit(130)
"""


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "program"
    path.write_text(PROGRAM.format(python=sys.executable))
    path.chmod(0o755)
    return path


def ignore(policy: Policy) -> None:
    """See nothing of the progress."""


def test_modes_are_compared_in_the_same_episodes(program: Path) -> None:
    comparison = Comparison()
    for mode in ("default", "despot"):
        play_mode(program, comparison.add(mode), [], ignore)
    policies = comparison.policies
    assert [policy.returns for policy in policies] == [{0: 0.0, 1: 10.0}, {0: 3.0, 1: 13.0}]
    assert table(policies).splitlines() == [
        "policy   return          minus the best   steps  planning",
        "default  5.000 +- 9.800  -3.000 +- 0.000  2.0    250.00 ms",
        "despot   8.000 +- 9.800                   2.0    250.00 ms",
    ]
    found = numbers(comparison)
    assert found["best"] == "despot"
    assert found["policies"][0]["minus_best"] == {"mean": -3.0, "half": 0.0}


def test_what_fails_is_said_and_what_it_played_is_kept(program: Path) -> None:
    policy = Policy("broken")
    play_mode(program, policy, [], ignore)
    assert policy.problem == "no such mode"
    assert policy.returns == {0: 1.0}


def test_steps_without_a_search_are_counted() -> None:
    policy = Policy("despot")
    for looked in ("nowhere", "tree", "nowhere", "one_step"):
        policy.take({"type": "step", "search_seconds": 0.1, "looked": looked})
    assert policy.unsearched == 2


def test_a_model_whose_values_are_no_numbers_is_broken(tmp_path: Path) -> None:
    program = tmp_path / "broken"
    program.write_text("#!/bin/sh\necho 'M: no number (NaN)' >&2\nexit 2\n")
    program.chmod(0o755)
    policy = Policy("despot")
    play_mode(program, policy, [], ignore)
    assert policy.is_broken and policy.problem == "M: no number (NaN)"


def test_policies_of_the_exact_solver_play_too(program: Path) -> None:
    seen: list[str] = []
    comparison = Comparison()
    play_exact(program, ["alpha", "qmdp"], [], lambda one: seen.append(one.name), comparison)
    assert seen == ["alpha", "qmdp"]
    assert [policy.returns for policy in comparison.policies] == [{0: 4.5}, {0: 4.5}]
    assert comparison.solved is not None and comparison.solved["upper"] == 5.0
    assert numbers(comparison)["policies"][0]["return"] == {"mean": 4.5, "half": None}


def test_an_interrupt_keeps_what_has_been_played(program: Path) -> None:
    comparison = Comparison()
    play_mode(program, comparison.add("default"), [], ignore)
    with pytest.raises(KeyboardInterrupt):
        play_mode(program, comparison.add("slow"), [], ignore)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert table(comparison.policies).splitlines() == [
        "policy   episodes  return          minus the best  steps  planning",
        "default  2         5.000 +- 9.800                  2.0    250.00 ms",
        "slow     1         1.000           +1.000          2.0    250.00 ms",
    ]
    assert numbers(comparison)["best"] == "default"


@pytest.mark.parametrize(
    ("discount", "horizon", "steps", "rest"),
    [
        (0.95, None, 135, 0.95**135),
        (0.5, 4, 3, 0.125 / 1.875),
        (1.0, 20, 15, 0.25),
        (0.9, 20, 30, 0.0),
    ],
)
def test_what_a_cut_leaves_out(discount: float, horizon: int | None, steps: int, rest: float) -> None:
    assert left_out(discount, horizon, steps) == pytest.approx(rest)


def test_episodes_are_as_long_as_the_discount_needs_them() -> None:
    assert [steps_needed(d, None) for d in (0.0, 0.5, 0.95, 0.999, 1.0)] == [1, 10, 135, 300, 300]
    assert [steps_needed(d, 40) for d in (0.5, 0.999, 1.0)] == [10, 40, 40]


def test_an_interval_is_printed_outwards() -> None:
    assert outwards(19.3713758, 19.3713759) == "19.3713 .. 19.3714"
    assert outwards(-20.0000092, -20) == "-20.0001 .. -20"
    assert outwards(0.0, 1234567.0) == "0 .. 1.23457e+06"


def test_a_program_ends_when_its_time_is_over(program: Path) -> None:
    assert len(list(lines_of([str(program), "--mode", "endless"], 2))) < 4  # fewer than two whole episodes
    assert len(list(lines_of([str(program), "--mode", "despot"], 60))) == 4
