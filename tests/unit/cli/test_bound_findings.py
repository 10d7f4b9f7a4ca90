# SPDX-License-Identifier: Apache-2.0
"""What ``hypgen check --bounds`` asks for and prints, without a compiler: the program is made up."""

import json
import sys
from pathlib import Path

import pytest
from support.paths import EXAMPLES

from hypgen.cli import main
from hypgen.cli.show import bound_findings

TIGER = str(EXAMPLES / "tiger.pomdp")

# Violates the bounds that the seed says: 0 none, 1 a derived upper one, 2 the tail; 3 is a failure.
PROGRAM = """#!{python}
import json, sys
options = dict(option.split("=") for option in sys.argv[1:])
seed, beliefs = int(options["--seed"]), int(options["--check-bounds"])
if seed == 3:
    sys.exit("no memory")
wrong = {{1: "upper", 2: "tail"}}.get(seed)
names = ("upper", "declared upper", "lower", "tail")
bounds = {{n: {{"beliefs": beliefs, "violations": 7 * (n == wrong), "mean_room": 2.5}} for n in names}}
print(json.dumps({{"type": "bounds", "bounds": bounds}}))
sys.exit(1 if wrong else 0)
"""


@pytest.fixture(autouse=True)
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "program"
    path.write_text(PROGRAM.format(python=sys.executable))
    path.chmod(0o755)
    monkeypatch.setattr(bound_findings, "build", lambda *_: path)


def test_bounds_that_hold_have_a_row(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["check", TIGER, "--bounds", "1000"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "tiger.pomdp: bounds at 1,000 beliefs, seed 0: nothing wrong",
        "bound              beliefs  violations  mean room",
        "upper, in use        1,000           0        2.5",
        "upper, as written    1,000           0        2.5",
        "lower                1,000           0        2.5",
        "tail                 1,000           0        2.5",
    ]


def test_a_violated_bound_is_a_finding(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["check", TIGER, "--bounds", "1000", "--seed", "1"]) == 2
    printed = capsys.readouterr()
    assert "1 bound wrong" in printed.out
    message = "error[C0204]: bound upper is below what the default policy earns, at 7 of 1,000 beliefs"
    assert printed.err.startswith(message)
    assert "hypgen derives this bound" in printed.err
    assert main.run(["check", TIGER, "--bounds", "1000", "--seed", "2"]) == 2
    assert "bound tail is above" in capsys.readouterr().err


def test_the_result_is_data_too(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["check", TIGER, "--bounds", "50", "--seed", "1", "--json"]) == 2
    found = json.loads(capsys.readouterr().out)
    assert not found["ok"] and found["diagnostics"][0]["code"] == "C0204"
    assert (found["bounds"]["beliefs"], found["bounds"]["seed"]) == (50, 1)
    assert found["bounds"]["compared"][0] == {
        "name": "upper",
        "beliefs": 50,
        "violations": 7,
        "mean_room": 2.5,
    }


def test_what_cannot_be_checked_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments, told in (
        (["--bounds", "100", "--samples", "100"], "three checks: run one after the other"),
        (["--bounds", "0"], "0 is not in the range"),
        (["--bounds", "100", "--particles", "9"], "--particles is for checks of beliefs"),
        (["--bounds", "100", "--seed", "3"], "no memory"),
    ):
        assert main.run(["check", TIGER, *arguments]) == 2, arguments
        assert told in capsys.readouterr().err
