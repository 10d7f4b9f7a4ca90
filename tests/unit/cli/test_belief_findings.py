# SPDX-License-Identifier: Apache-2.0
"""What ``hypgen check --beliefs`` asks for and prints, without a compiler: the program is made up."""

import json
import sys
from pathlib import Path

import pytest
from support.paths import EXAMPLES

from hypgen.cli import main
from hypgen.cli.show import belief_findings

ROCKS, TIGER = str(EXAMPLES / "rock_sample.pomdp"), str(EXAMPLES / "tiger.pomdp")

# Writes ranks whose kind the seed says: 0 level, 1 too sure, 2 level and then an interrupt, 3 a failure.
PROGRAM = """#!{python}
import json, os, signal, sys, time
options = dict(option.split("=") for option in sys.argv[1:])
seed, episodes = int(options["--seed"]), int(options["--check-beliefs"])
print(json.dumps({{"type": "beliefs", "variables": ["rock.good"]}}))
for i in range(episodes // 2 if seed == 2 else episodes):
    u = (i + 0.5) / episodes
    rank = (0.01 if u < 0.5 else 0.99) if seed == 1 else u
    line = {{"type": "ranks", "episode": i, "step": 3, "unexplained": int(i == 7), "ranks": [rank]}}
    print(json.dumps(line), flush=True)
if seed == 2:
    os.kill(os.getppid(), signal.SIGINT)
    time.sleep(30)
if seed == 3:
    sys.exit("no memory")
"""


@pytest.fixture(autouse=True)
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "program"
    path.write_text(PROGRAM.format(python=sys.executable))
    path.chmod(0o755)
    monkeypatch.setattr(belief_findings, "build", lambda *_: path)


def test_a_belief_that_is_right_has_a_row(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["check", ROCKS, "--beliefs", "100"]) == 0
    printed = capsys.readouterr()
    assert printed.out.splitlines() == [
        "rock_sample.pomdp: 100 episodes, seed 0, exact posteriors: nothing wrong",
        "in 1 of them some step saw what nothing in the belief explained: "
        "add --particles, or give the model's sensors more noise",
        "variable   p  50 % interval        95 % interval        ranks of true values, low to high",
        "rock.good  1  50.0 (40.4 .. 59.6)  96.0 (90.2 .. 98.4)  ▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅",
    ]
    assert printed.err == ""


@pytest.mark.parametrize(
    "options, remedy",
    [
        ((), "its posterior is exact, so this is a bug of hypgen"),
        (("--belief", "particle", "--particles", "10"), "try more particles, --particles 40 here"),
    ],
)
def test_a_belief_that_is_too_sure_is_a_finding(
    options: tuple[str, ...], remedy: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.run(["check", ROCKS, "--beliefs", "100", "--seed", "1", *options]) == 2
    printed = capsys.readouterr()
    assert "1 belief wrong" in printed.out
    assert printed.err.startswith("error[C0501]: the belief of 'rock.good' is too sure")
    assert f"help: {remedy}" in printed.err
    assert printed.err.endswith("  █▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁█\n\n")


def test_an_interrupt_shows_what_is_known(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["check", ROCKS, "--beliefs", "100", "--seed", "2"]) == 130
    printed = capsys.readouterr()
    assert printed.out.startswith("rock_sample.pomdp: 50 of 100 episodes, seed 2")
    assert printed.err.endswith("interrupted\n")


def test_the_result_is_data_too(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["check", ROCKS, "--beliefs", "100", "--seed", "1", "--json"]) == 2
    found = json.loads(capsys.readouterr().out)
    assert not found["ok"] and found["diagnostics"][0]["code"] == "C0501"
    beliefs = found["beliefs"]
    (variable,) = beliefs.pop("variables")
    assert beliefs == {
        "episodes": 100,
        "unexplained": 1,
        "seed": 1,
        "particles": 5000,
        "interrupted": False,
    }
    assert variable["name"] == "rock.good" and variable["p"] == variable["corrected_p"] < 1e-15
    assert variable["histogram"] == [50, *[0] * 18, 50]
    assert variable["held95"]["share"] == 0.0 and variable["held95"]["high"] < 0.05


def test_what_cannot_be_checked_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    seen = tmp_path / "seen.pomdp"
    seen.write_text(Path(TIGER).read_text().replace("hidden tiger", "visible tiger"))
    for arguments, told in (
        ([TIGER, "--beliefs", "100", "--samples", "100"], "three checks: run one after the other"),
        ([TIGER, "--particles", "100"], "--particles is for checks of beliefs: add --beliefs N"),
        ([TIGER, "--time", "10"], "--time is for --samples N and --beliefs N"),
        ([TIGER, "--beliefs", "49"], "49 is not in the range"),
        ([str(seen), "--beliefs", "100"], "no hidden variables"),
        ([ROCKS, "--beliefs", "100", "--seed", "3"], "no memory"),
    ):
        assert main.run(["check", *arguments]) == 2, arguments
        assert told in capsys.readouterr().err
