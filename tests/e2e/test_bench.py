# SPDX-License-Identifier: Apache-2.0
"""A suite from its file to its tables: played, interrupted, failed and gone on with."""

import json
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from support.paths import ROOT

from hypgen.experiments.reports import read_report

HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]
pytestmark = pytest.mark.cxx
TIGER = ROOT / "examples" / "tiger.pomdp"
SUITE = f"""
title = "Tigers"
[tasks.tiger]
model = "{TIGER}"
[[study]]
name = "trials"
runs = 6
episodes_a_cell = 2
play = ["despot"]
trials = [5, 20]
scenarios = 50
steps = 6
"""


def bench(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [*HYPGEN, "bench", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True)


@pytest.fixture
def suite(tmp_path: Path) -> Path:
    path = tmp_path / "tigers.toml"
    path.write_text(SUITE)
    return path


def test_a_suite_is_played_once_and_its_table_stays(suite: Path, tmp_path: Path) -> None:
    done = bench(suite, "-o", tmp_path / "out", "--jobs", 2)
    assert done.returncode == 0, done.stderr
    cells = list((tmp_path / "out").glob("*.jsonl"))
    assert len(cells) == 3 + 2 * 2 * 3, "default once, two searches at two budgets"
    head = json.loads(cells[0].read_text().splitlines()[0])
    assert head["type"] == "cell" and head["machine"]["cores"] >= 1 and head["compiler"]
    assert "| despot, trials 20 | 6 |" in done.stdout and "minus default" in done.stdout
    page = read_report(tmp_path / "out").page()
    assert "30 of 30 episodes" in page and page.count('class="panel"') == 3
    cells[0].unlink()
    again = bench(suite, "-o", tmp_path / "out", "--tables")
    assert again.returncode == 0 and "not all episodes are played yet" in again.stdout
    again = bench(suite, "-o", tmp_path / "out")
    assert "14 of 15 cells" in again.stderr
    assert without_times(again.stdout) == without_times(done.stdout)


def interrupt(suite: Path, folder: Path, number: signal.Signals, wait: float) -> int:
    """Play a suite, end that some time after it has begun to play, and return how many cells there are."""
    command = [*HYPGEN, "bench", str(suite), "-o", str(folder)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    while "cells" not in process.stderr.readline():  # it plays
        pass
    time.sleep(wait)
    process.send_signal(number)
    process.communicate()
    # The second: while Python ends, after all is said.
    assert process.returncode in (128 + number, -number, 0)
    assert number == signal.SIGKILL or not list(folder.glob("lines-*"))
    return len(list(folder.glob("*.jsonl")))


def test_an_interrupted_suite_ends_with_the_same_table(suite: Path, tmp_path: Path) -> None:
    whole = bench(suite, "-o", tmp_path / "whole", "--jobs", 2)
    chance = random.Random(1)
    for _ in range(4):
        interrupt(suite, tmp_path / "cut", signal.SIGINT, chance.uniform(0.0, 0.5))
    done = bench(suite, "-o", tmp_path / "cut")
    assert done.returncode == 0, done.stderr
    assert without_times(done.stdout) == without_times(whole.stdout)


@pytest.mark.faults
def test_a_suite_that_is_ended_ten_times_ends_with_the_same_table(suite: Path, tmp_path: Path) -> None:
    text = SUITE.replace("runs = 6", "runs = 40").replace("[5, 20]", "[20, 100]")
    suite.write_text(text.replace("steps = 6", "steps = 30"))
    whole = bench(suite, "-o", tmp_path / "whole", "--jobs", 2)
    chance, total = random.Random(10), len(list((tmp_path / "whole").glob("*.jsonl")))
    played = []
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL, signal.SIGINT) * 2:
        played.append(interrupt(suite, tmp_path / "cut", number, chance.uniform(0.0, 0.6)))
    print(f"\ncells after each of ten signals, of {total}: {played}")
    assert played == sorted(played) and played[0] < total
    done = bench(suite, "-o", tmp_path / "cut")
    assert done.returncode == 0, done.stderr
    assert without_times(done.stdout) == without_times(whole.stdout)


def test_a_setting_that_fails_is_left_out_and_the_rest_goes_on(suite: Path, tmp_path: Path) -> None:
    suite.write_text(SUITE.replace("trials = [5, 20]", "trials = 5\nxi = [0.95, 7.0]"))
    done = bench(suite, "-o", tmp_path / "out")
    assert done.returncode == 1
    assert "xi 7.0" in done.stderr and "the solver ended with code" in done.stderr
    assert "| despot, xi 0.95 | 6 |" in done.stdout
    assert "| despot, xi 7.0 | 0 |" in done.stdout
    again = bench(suite, "-o", tmp_path / "out")
    assert again.returncode == 1 and "--retry plays it again" in again.stderr
    assert again.stderr.count("cells") == 1, "nothing is played"


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("steps = 6", "stepz = 6", "study trials: solvers have no option `stepz`. did you mean 'steps'?"),
        ("runs = 6", "runs = none", "is not TOML"),
        (str(TIGER), "none.pomdp", "which is no file"),
    ],
)
def test_what_cannot_be_played_is_refused(suite: Path, tmp_path: Path, old: str, new: str, says: str) -> None:
    suite.write_text(SUITE.replace(old, new))
    done = bench(suite, "-o", tmp_path / "out")
    assert done.returncode == 2 and says in done.stderr, done.stderr


def without_times(page: str) -> str:
    """Return a page without the column of seconds."""
    return "\n".join("|".join(line.split("|")[:8] + line.split("|")[9:]) for line in page.splitlines())
