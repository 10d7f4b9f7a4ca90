# SPDX-License-Identifier: Apache-2.0
"""The benchmark beside SARSOP: what is told to scikit-decide, and what is made of its vectors."""

import importlib
import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "benchmarks" / "exact"
# The agent sees at the start whether it is in the lit room (0) or the dark one (1, 2), where a switch is up
# or down. Pulling ends the episode for 2, 4 or -1; in the dark it may wait, or look how the switch is.
DARK = [{"type": "row", "state": s, "action": 0, "reward": 0.0, "outcomes": [[0, s, 1.0]]} for s in (1, 2)]
LOOKS = [
    {"type": "row", "state": s, "action": 2, "reward": 0.0, "outcomes": [[o, s, 0.9], [3 - o, s, 0.1]]}
    for s, o in ((1, 1), (2, 2))
]
PULLS = [
    {"type": "row", "state": s, "action": 1, "reward": reward, "outcomes": []}
    for s, reward in ((0, 2.0), (1, 4.0), (2, -1.0))
]
MODEL = [
    {
        "type": "model", "name": "Rooms", "discount": 0.5, "variables": ["room"], "policy_hash": 12,
        "actions": ["wait", "pull", "look"], "observations": ["nothing", "up", "down"],
    },
    {"type": "start", "probability": 0.25, "class": 0, "belief": [[0, 1.0]]},
    {"type": "start", "probability": 0.75, "class": 1, "belief": [[1, 0.1], [2, 0.9]]},
    *({"type": "state", "state": s, "class": min(s, 1), "values": [str(s)]} for s in range(3)),
    *PULLS, *DARK, *LOOKS,
    {"type": "end"},
]  # fmt: skip


def test_equal_vectors_are_written_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(FOLDER))
    policy_file = importlib.import_module("policy_file")
    lit = policy_file.ClassVectors([0], [(1, (2.0,)), (0, (2.0,)), (0, (0.5,))])
    dark = policy_file.ClassVectors([1, 2], [])
    assert list(policy_file.policy_lines(7, [lit, dark])) == [
        "hypgen-policy-1\n", "7 2\n", "2 0\n", "1 0 2.0\n", "0 0 0.5\n", "0 0\n",
    ]  # fmt: skip


def test_sarsop_solves_what_starts_in_several_ways(tmp_path: Path) -> None:
    if importlib.util.find_spec("skdecide") is None:
        pytest.skip("scikit-decide is not installed: pip install scikit-decide")
    (tmp_path / "model.jsonl").write_text("".join(json.dumps(line) + "\n" for line in MODEL))
    child = [sys.executable, str(FOLDER / "sarsop_domain.py"), str(tmp_path), "10", "1e-6"]
    subprocess.run(child, check=True, capture_output=True)
    bounds = json.loads((tmp_path / "bounds.json").read_text())
    # In the dark: look, and pull if it looks up, which is likelier to be right by then.
    looked = 0.5 * (0.1 * 0.9 * 4 - 0.9 * 0.1 * 1)
    assert bounds["lower"] <= bounds["upper"] < bounds["lower"] + 0.01
    assert bounds["lower"] == pytest.approx(0.25 * 2 + 0.75 * looked, abs=0.02)
    head, number, *lines = (tmp_path / "policy").read_text().splitlines()
    assert (head, number) == ("hypgen-policy-1", "12 2")
    lit = int(lines[0].split()[0])
    dark = int(lines[1 + lit].split()[0])
    assert len(lines) == 2 + lit + dark
    assert all(line.startswith("1 0 ") for line in lines[1 : 1 + lit]), "only pulling is legal"
