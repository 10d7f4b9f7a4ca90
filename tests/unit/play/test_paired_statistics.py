# SPDX-License-Identifier: Apache-2.0
"""What benchmarks/search's studies compute, and how they play episodes, without a real solver."""

import math
import sys
from pathlib import Path

import episodes
import pytest
import study

from hypgen.play import paired_statistics

# Plays each episode in one step, whose return says which episode and which setting it was.
SOLVER = """#!{python}
import json, sys
options = dict(zip(sys.argv[1:-2:2], sys.argv[2::2]))
first, runs = int(options["--first-run"]), int(options["--runs"])
with open(sys.argv[-1], "w") as lines, open({log!r}, "a") as log:
    print(first, file=log)
    print(json.dumps({{"type": "run", "threads": 1}}), file=lines)
    for i in range(first, first + runs):
        step = {{"type": "step", "episode": i, "step": 0, "status": "ok", "search_seconds": 0.5, "trials": 5}}
        print(json.dumps(step), file=lines)
        value = 10.0 * i + float(options["--gain"])
        end = {{"type": "episode", "episode": i, "discounted_return": value, "steps": 1}}
        print(json.dumps({{**end, "status": "terminal"}}), file=lines)
"""


def test_an_interval_is_1_96_standard_errors() -> None:
    assert paired_statistics.interval([1.0, 2.0, 3.0, 4.0]) == pytest.approx(
        (2.5, 1.96 * math.sqrt(5 / 3) / 2)
    )
    assert paired_statistics.interval([7.0])[0] == 7.0 and math.isnan(paired_statistics.interval([7.0])[1])
    assert all(map(math.isnan, paired_statistics.interval([])))


def test_differences_are_those_of_common_episodes() -> None:
    assert paired_statistics.differences({3: 5.0, 1: 2.0, 7: 0.0}, {1: 1.0, 2: 9.0, 3: 1.0}) == [1.0, 4.0]
    assert paired_statistics.with_interval([1.0, 4.0], "+") == "+2.500 +- 2.940"


def test_a_study_has_each_setting_once() -> None:
    axes = [[1.0, 4.0], [0.0, 2.0, 16.0], [1.0, 0.5], [0.0, 0.1], [0.95]]
    found = study.points(axes, False, 1)
    assert found[0] == study.Point(1.0, 1.0, 1.0, 0.0, 0.95)
    # One thread: F 1 without a loss, 2 and 16 with two; four: F 4 and 16 with two; each with two c_a.
    assert len(found) == len(set(found)) == 2 * (1 + 2 * 2 + 2 * 2)
    single = study.points(axes, True, 1)
    assert len(single) == (1 + 2 + 0 + 1) + (1 + 1 + 1 + 1)


def test_episodes_are_played_once_and_paired(tmp_path: Path) -> None:
    solver, log, keep = tmp_path / "solver", tmp_path / "log", tmp_path / "keep"
    solver.write_text(SOLVER.format(python=sys.executable, log=str(log)))
    solver.chmod(0o755)
    settings = [episodes.Setting(gain, solver, ("--gain", gain)) for gain in ("0", "3", "wrong")]
    settings.append(episodes.Setting("gpu", solver, ("--gain", "0"), 1, True))
    pieces = episodes.pieces_of(settings, 7)
    assert [(piece.wave, piece.first, piece.runs) for piece in pieces[::4]] == [(0, 0, 5), (1, 5, 2)]
    assert len(episodes.play(pieces, episodes.Machine(2, []), keep, 0.0)) == 1 and not log.exists()
    problems = episodes.play(pieces, episodes.Machine(2, []), keep, 60.0)
    assert [problem.split(":")[0] for problem in problems] == ["solver, gpu", "solver, wrong"]
    played = episodes.read(pieces, keep)
    assert played[settings[0]].returns == {i: 10.0 * i for i in range(7)}
    assert played[settings[1]].returns == {i: 10.0 * i + 3.0 for i in range(7)}
    assert played[settings[0]].rate("trials") == 10.0
    log.unlink()
    kept = [piece for piece in pieces if piece.setting in settings[:2]]
    assert episodes.play(kept, episodes.Machine(2, []), keep, 60.0) == [] and not log.exists()
