# SPDX-License-Identifier: Apache-2.0
"""What ``hypgen compare`` asks for and prints, without a compiler: programs and play are made up."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from support.paths import EXAMPLES

from hypgen.api import comparing
from hypgen.api.model import Model
from hypgen.cli import main
from hypgen.cli.exit_codes import Exit
from hypgen.play.played_programs import Comparison, Policy

TIGER, LIGHT_DARK = str(EXAMPLES / "tiger.pomdp"), str(EXAMPLES / "light_dark.pomdp")
GAINS = {"default": 1.0, "despot": 3.0, "blind": 0.5}


@pytest.fixture(autouse=True)
def played(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Plays two episodes of each mode; keeps the options. ``parallel`` is interrupted."""
    kept: list[list[str]] = []

    def take(policy: Policy, show: Callable[[Policy], None]) -> None:
        for i in range(2):
            policy.returns[i] = GAINS[policy.name] + i
            policy.steps.append(4)
            show(policy)

    def play_mode(
        program: Path, policy: Policy, options: Sequence[str], show: Callable[[Policy], None]
    ) -> None:
        kept.append(list(options))
        if policy.name == "parallel":
            raise KeyboardInterrupt
        if policy.name == "pomcp":
            policy.problem = "it has no values"
            return
        take(policy, show)

    def play_exact(
        program: Path,
        kinds: Sequence[str],
        options: Sequence[str],
        show: Callable[[Policy], None],
        comparison: Comparison,
    ) -> None:
        kept.append(list(options))
        comparison.solved = {"lower": 4.0, "upper": 5.0}
        for kind in kinds:
            take(comparison.add(kind), show)

    built = Model.program
    monkeypatch.setattr(
        Model,
        "program",
        lambda self, kind, **options: Path(kind) if kind == "solver" else built(self, kind, **options),
    )
    monkeypatch.setattr(comparing, "play_mode", play_mode)
    monkeypatch.setattr(comparing, "play_exact", play_exact)
    return kept


@pytest.fixture
def exact(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Model, "program", lambda self, kind, **_: Path(kind))


@pytest.mark.usefixtures("exact")
def test_policies_stand_in_a_table_above_the_value(
    played: list[list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    options = ("--modes", "default,despot,blind", "--runs", "2", "--steps", "4", "--time", "0.5")
    assert main.run(["compare", TIGER, *options]) == Exit.OK
    out, told = capsys.readouterr()
    assert [line.split()[0] for line in out.splitlines()] == ["policy", "default", "despot", "blind", "value"]
    assert out.endswith("value of the best policy: 4 .. 5 (4 steps leave out 0.81 of the sum of discounts)\n")
    assert "despot: 2 episodes, mean return 3.500" in told
    assert played[0] == ["--runs=2", "--steps=4", "--seed=0", "--time=0.5"]
    assert played[2][-1].startswith("--time=")


@pytest.mark.usefixtures("exact")
def test_numbers_are_json(played: list[list[str]], capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["compare", TIGER, "--modes", "despot", "--trials", "7", "--json"]) == Exit.OK
    found = json.loads(capsys.readouterr().out)
    assert [policy["returns"] for policy in found["policies"]] == [[3.0, 4.0]]
    assert "--trials=7" in played[0] and not any(option.startswith("--time") for option in played[0])


def test_what_cannot_be_played_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["compare", LIGHT_DARK, "--modes", "pomcp,alpha,qmdp"]) == Exit.MISTAKE
    out, told = capsys.readouterr()
    assert out == ""
    assert "pomcp: it has no values\n" in told
    assert "alpha, qmdp: cannot be enumerated: 'robot." in told and "is drawn from a continuous law" in told


def test_an_interrupt_prints_what_is_known(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["compare", TIGER, "--modes", "default,parallel,alpha"]) == Exit.INTERRUPTED
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()][:2] == ["policy", "default"]


def test_an_unknown_mode_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["compare", TIGER, "--modes", "despot,magic"]) == Exit.MISTAKE
    assert "There is no mode 'magic': --modes takes some of " in capsys.readouterr().err
