# SPDX-License-Identifier: Apache-2.0
"""A tuning as a person types it, and its settings as the solver takes them."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from support.paths import ROOT

pytest.importorskip("optuna", reason="tuning needs Optuna: pip install 'hypgen[tune]'")

HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]
pytestmark = pytest.mark.cxx
TIGER = ROOT / "examples" / "tiger.pomdp"


def hypgen(folder: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*HYPGEN, *map(str, arguments)], cwd=folder, capture_output=True, text=True)


ASKED = (
    "tune", TIGER, "--trials", 5, "--runs", 5, "--candidates", 2, "--held-out", 5, "--fix", "steps=4",
    "--tune", "scenarios=5..40",
)  # fmt: skip


def test_a_tuning_is_interrupted_and_ends_the_same(tmp_path: Path) -> None:
    whole = hypgen(tmp_path, *ASKED, "-o", "whole")
    assert whole.returncode == 0, whole.stderr
    assert "| default settings | 5 |" in whole.stdout and "2 of 2 candidates" in whole.stderr
    process = subprocess.Popen(
        [*HYPGEN, *map(str, ASKED), "-o", "cut"], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    while process.poll() is None and not list((tmp_path / "cut").glob("*.jsonl")):
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    process.communicate()
    assert process.returncode in (0, 130)
    again = hypgen(tmp_path, *ASKED, "-o", "cut")
    assert again.returncode == 0, again.stderr
    assert again.stdout == whole.stdout


def test_params_of_settings_are_the_planners_alone(tmp_path: Path) -> None:
    def seen(*arguments: str) -> list[object]:
        done = hypgen(
            tmp_path,
            "run",
            TIGER,
            "--quiet",
            "--mode=default",
            "--runs=5",
            "--steps=4",
            "--json=-",
            *arguments,
        )
        assert done.returncode == 0, done.stderr
        lines = [json.loads(line) for line in done.stdout.splitlines()]
        return [line["observation"] for line in lines if line["type"] == "step"]

    settings = tmp_path / "deaf settings.json"
    settings.write_text('{"options": {"particles": 50}, "params": {"hearing": 0.5}, "found": {"by": "hand"}}')
    deaf = tmp_path / "deaf.json"
    deaf.write_text('{"hearing": 0.5}')
    assert seen() == seen(f"--settings={settings}") != seen(f"--param={deaf}")


def test_wrong_settings_are_refused(tmp_path: Path) -> None:
    for text, says in (
        ('{"params": {"hear": 1}}', '--settings: unknown param "hear"; the model\'s params are hearing'),
        (
            '{"params": {"hearing": 2}}',
            '--settings: param "hearing": expected probability from 0 to 1, found 2',
        ),
        ('{"options": {"steps": 2}}', 'no setting is named "steps"'),
    ):
        done = hypgen(tmp_path, "run", TIGER, f"--settings={text}")
        assert done.returncode == 2 and says in done.stderr, done.stderr
