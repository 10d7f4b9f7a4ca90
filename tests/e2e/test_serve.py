# SPDX-License-Identifier: Apache-2.0
"""A solver that serves an agent: requests and answers are lines of JSON."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hypgen.codegen.generate import generate
from hypgen.dsl.load import load
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.solver import build_solver
from hypgen.runtime.builder.tools import find_tools

pytestmark = pytest.mark.cxx
TIGER = Path(__file__).parent.parent.parent / "examples" / "tiger.pomdp"
QUICK = ("--mode", "despot", "--trials", "50", "--seed", "7", "--scenarios", "100")


class Served:
    """A serving solver."""

    def __init__(self, solver: Path, *options: str) -> None:
        self.process = subprocess.Popen(
            [str(solver), "--serve", *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def line(self, text: str) -> dict[str, Any]:
        """Return the answer to a line."""
        assert self.process.stdin and self.process.stdout
        self.process.stdin.write(text + "\n")
        self.process.stdin.flush()
        answer: dict[str, Any] = json.loads(self.process.stdout.readline())
        return answer

    def ask(self, do: str, **members: Any) -> dict[str, Any]:
        """Return the answer to a request."""
        return self.line(json.dumps({"do": do, **members}))


@pytest.fixture(scope="module")
def solver() -> Path:
    try:
        find_tools()
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")
    return build_solver(generate(load(TIGER).model), "serve/tiger", lambda step: None)


@pytest.fixture
def served(solver: Path) -> Iterator[Served]:
    one = Served(solver, *QUICK)
    yield one
    one.process.kill()
    one.process.communicate()


def test_it_decides_as_the_solver_does(solver: Path, served: Served) -> None:
    lines = [str(solver), *QUICK, "--runs", "1", "--steps", "6", "--quiet", "--json", "-"]
    played = subprocess.run(lines, capture_output=True, text=True, check=True).stdout.splitlines()
    steps = [json.loads(line) for line in played if '"type":"step"' in line]
    assert served.ask("reset")["status"] == "ok"
    for step in steps:
        decision = served.ask("plan", id=step["step"])
        assert decision["id"] == step["step"]
        for name in ("action", "action_name", "status", "lower", "upper", "trials"):
            assert decision[name] == step[name], name
        if not step["terminal"]:
            update = served.ask("update", action=step["action_name"], key=step["observation_key"])
            assert update == {"status": "ok"}
    assert served.ask("quit") == {"status": "ok"}
    assert served.process.wait(timeout=10) == 0


def test_the_belief_follows_what_is_seen(served: Served) -> None:
    described = served.ask("describe")
    assert described["model"]["model"] == "Tiger"
    assert served.ask("reset", episode=3)["status"] == "ok"
    assert served.ask("update", action="listen", seen={"heard": "left"})["status"] == "ok"
    [tiger] = served.ask("belief")["belief"]
    assert tiger["variable"] == "room.tiger"
    values = {one["value"]: one["probability"] for one in tiger["values"]}
    assert abs(values["left"] - 0.85) < 1e-6


WRONG = {
    "nonsense": "expected a JSON object",
    "[1]": "expected a JSON object",
    '{"do": 1}': "expected",
    '{"do": "dance"}': "no request is named dance",
    '{"do": "plan", "secs": 1}': "secs: this request has no such member",
    '{"do": "plan", "seconds": "1"}': "seconds: expected a number",
    '{"do": "plan", "seconds": -1}': "seconds: expected a number from 0",
    '{"do": "reset", "episode": -1}': "episode: expected",
    '{"do": "reset", "visible": {"x": 1}}': "x",
    '{"do": "update", "action": "listen"}': "it takes action, and seen or key",
    '{"do": "update", "action": "lissen", "seen": {"heard": "left"}}': "no action is named lissen",
    '{"do": "update", "action": 99, "seen": {"heard": "left"}}': "expected a number from 0 to 2",
    '{"do": "update", "action": 0, "seen": {"heard": "up"}}': "heard: expected one of left, right",
    '{"do": "update", "action": 0, "key": 77}': "no observation of the model has it",
    '{"do": "update", "action": 0, "key": "left"}': "key: expected",
}


def test_wrong_requests_are_refused_and_change_nothing(served: Served) -> None:
    early = served.ask("plan")
    assert (early["status"], early["error"]) == ("wrong_argument", "no episode has begun: reset comes first")
    served.ask("reset")
    before = served.ask("belief")
    for line, text in WRONG.items():
        answer = served.line(line)
        assert answer["status"] == "wrong_argument", line
        assert text in answer["error"], (line, answer)
    assert served.line("[" * 100_000)["status"] == "wrong_argument"
    assert served.ask("belief") == before
    assert served.ask("plan")["action_name"] == "listen"


def test_wrong_options_and_the_end_of_input(solver: Path) -> None:
    wrong = subprocess.run([str(solver), "--serve", "--mode", "fast"], capture_output=True, text=True)
    assert wrong.returncode == 2
    assert "--mode" in wrong.stderr
    nothing = subprocess.run([str(solver), "--serve"], input="\n", capture_output=True, text=True)
    assert (nothing.returncode, nothing.stdout) == (0, "")
    both = subprocess.run([str(solver), "--serve", "--json", "-"], capture_output=True, text=True)
    assert (both.returncode, "leave out --json" in both.stderr) == (2, True)
