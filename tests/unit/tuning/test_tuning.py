# SPDX-License-Identifier: Apache-2.0
"""A tuning with an executor that plays nothing: what is tried, kept, gone on with, tested and written."""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from support.paths import EXAMPLES

pytest.importorskip("optuna", reason="tuning needs Optuna: pip install 'hypgen[tune]'")

from support.synthetic_cells import ABOUT

from hypgen.dsl import ir
from hypgen.dsl.load import load
from hypgen.experiments.cells import Cell
from hypgen.experiments.store import Failure, Store
from hypgen.experiments.suite import Task
from hypgen.experiments.suite_values import SuiteError
from hypgen.tuning.outcome import Outcome, candidates_markdown, held_out_markdown
from hypgen.tuning.playing import Player, State
from hypgen.tuning.running import Tuning, ask
from hypgen.tuning.space import TuningError
from hypgen.tuning.study import JOURNAL

Worth = Callable[[dict[str, object]], float]


@dataclass
class Table:
    """An executor that looks up what settings are worth; episodes are easy or hard for all."""

    worth: Worth
    ends_after: int = 10**9  # cells until Ctrl-C
    played: list[str] = field(default_factory=list)

    def play(self, cells: Sequence[Cell], store: Store, end: float) -> Iterator[Cell | Failure]:
        failed = set()
        for cell in cells:
            if cell.setting in failed:
                continue
            if len(self.played) == self.ends_after:
                raise KeyboardInterrupt
            self.played.append(cell.key)
            options = dict(cell.setting.options) | {"of seed": cell.setting.seed}
            try:
                worth = self.worth(options)
            except ValueError as error:
                failure = Failure(cell, str(error))
                failed.add(cell.setting)
                store.fail(failure)
                yield failure
                continue
            store.put(cell, ABOUT, lines(cell, lambda episode, worth=worth: worth))
            yield cell


def lines(cell: Cell, worth: Callable[[int], float]) -> str:
    run = {"type": "run", "device": "cpu", "scenarios": 500, "xi": 0.95} | dict(cell.setting.options)
    found = [run]
    own = np.random.default_rng(zlib.crc32(cell.key.encode()))
    for episode in range(cell.first, cell.first + cell.runs):
        luck = np.random.default_rng((cell.setting.seed, episode)).normal(0.0, 5.0) + own.normal(0.0, 0.01)
        earned = {
            "discounted_return": worth(episode) + luck,
            "steps": 3,
            "status": "horizon",
            "success": None,
        }
        found.append({"type": "episode", "episode": episode, **earned})
    return "".join(json.dumps(line) + "\n" for line in found)


def peak(options: dict[str, object]) -> float:
    """Best at 100 scenarios."""
    return -abs(float(str(options.get("scenarios", 500))) - 100.0) / 20


@pytest.fixture(autouse=True)
def no_waiting_for_the_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "fsync", lambda file: None)


@pytest.fixture(scope="module")
def model() -> ir.Model:
    return load(EXAMPLES / "tiger.pomdp").model


def tuning(
    model: ir.Model,
    folder: Path,
    executor: Table,
    *,
    candidates: int = 8,
    held_out: int = 20,
    at_once: int = 2,
    program: str = "abc",
    end: float = float("inf"),
    **asked: object,
) -> Outcome:
    own: dict[str, object] = {
        "options": {"scenarios": "20..900"},
        "budget": {"trials": 5},
        "runs": 10,
    } | asked
    found = ask(Task("tiger", Path("tiger.pomdp")), model, **own)  # type: ignore[arg-type]
    store = Store(folder / "out")
    store.open("tuning of Tiger")
    player = Player(program, store, executor, State(0), end)
    return Tuning(
        found, model, player, candidates=candidates, held_out=held_out, at_once=at_once,
        file=folder / "tiger.settings.json",
    ).run()  # fmt: skip


def test_the_winner_is_tested_in_other_episodes_and_written(model: ir.Model, tmp_path: Path) -> None:
    executor = Table(peak)
    outcome = tuning(model, tmp_path, executor)
    assert outcome.is_finished and len(outcome.tried) == 9
    assert outcome.tried[0].is_default and outcome.tried[0].values == {"scenarios": 500}
    assert outcome.winner is not None and outcome.held_out is not None
    assert abs(int(outcome.winner.values["scenarios"]) - 100) < 60
    assert outcome.held_out.difference.is_shown and outcome.held_out.difference.interval.count == 20
    assert outcome.held_out.policy is not None
    assert (
        outcome.verdict() == "in 20 held-out episodes the tuned settings earn more than the default settings"
    )
    written = json.loads((tmp_path / "tiger.settings.json").read_text())
    assert written["options"] == {"mode": "despot", "scenarios": outcome.winner.values["scenarios"]}
    assert "params" not in written and written["found"]["held_out"]["is_shown"]
    assert "default settings" in candidates_markdown(outcome)
    assert "tuned settings" in held_out_markdown(outcome.held_out)
    assert len(set(executor.played)) == len(executor.played)


def test_clearly_worse_candidates_end_early(model: ir.Model, tmp_path: Path) -> None:
    outcome = tuning(model, tmp_path, Table(peak))
    early = [one for one in outcome.tried if one.is_ended_early(10)]
    assert early and outcome.winner is not None
    assert all(one.value < outcome.winner.value and one.episodes < 10 for one in early)
    assert all(
        one.value == pytest.approx(outcome.tried[0].value + peak(dict(one.values)) - peak({}), abs=0.1)
        for one in early
    )


def test_a_candidate_that_gains_much_in_few_episodes_goes_on(model: ir.Model, tmp_path: Path) -> None:
    class Rare(Table):
        def play(self, cells: Sequence[Cell], store: Store, end: float) -> Iterator[Cell | Failure]:
            for cell in cells:
                risky = "xi" in dict(cell.setting.options)
                extra = (40.0, -2.0) if risky else (0.0, 0.0)

                def worth(episode: int, extra: tuple[float, float] = extra) -> float:
                    return extra[episode > 0] - (20.0 if episode < 10 else 0.0)  # the first are hard ones

                store.put(cell, ABOUT, lines(cell, worth))
                yield cell

    outcome = tuning(model, tmp_path, Rare(peak), options={"xi": None}, candidates=2, held_out=0, runs=15)
    assert [one.episodes for one in outcome.tried] == [15, 15, 15]
    assert outcome.winner is not None and outcome.winner.value > outcome.tried[0].value


def test_an_interrupted_tuning_ends_as_one_that_was_not(model: ir.Model, tmp_path: Path) -> None:
    whole = tuning(model, tmp_path / "whole", Table(peak), candidates=5)
    played: list[str] = []
    for cells in (1, 0, 3, 5):
        executor = Table(peak, ends_after=cells)
        with pytest.raises(KeyboardInterrupt):
            tuning(model, tmp_path / "cut", executor, candidates=5)
        played += executor.played
    executor = Table(peak)
    again = tuning(model, tmp_path / "cut", executor, candidates=5)
    played += executor.played
    assert len(set(played)) == len(played), "nothing is played twice"
    assert [(one.values, one.value) for one in again.tried] == [
        (one.values, one.value) for one in whole.tried
    ]
    assert again.winner == whole.winner and again.held_out == whole.held_out
    idle = Table(peak)
    tuning(model, tmp_path / "cut", idle, candidates=5)
    assert not idle.played
    more = tuning(model, tmp_path / "cut", Table(peak), candidates=6)
    assert len(more.tried) == 7


def test_an_interruption_leaves_what_is_known(model: ir.Model, tmp_path: Path) -> None:
    found: list[Outcome] = []
    executor = Table(peak, ends_after=10)
    own = ask(Task("tiger", Path("tiger.pomdp")), model, options={"scenarios": "20..900"}, runs=10)
    store = Store(tmp_path / "out")
    store.open("T")
    player = Player("abc", store, executor, State(0), tell=lambda state: found.append(state.outcome))  # type: ignore[arg-type]
    one = Tuning(own, model, player, candidates=8, held_out=9, at_once=2, file=tmp_path / "file.json")
    with pytest.raises(KeyboardInterrupt):
        one.run()
    assert not found[-1].is_finished and found[-1].winner is not None
    assert not (tmp_path / "file.json").exists()


def test_time_that_is_up_ends_a_tuning(model: ir.Model, tmp_path: Path) -> None:
    outcome = tuning(model, tmp_path, Table(peak), end=0.0)
    assert not outcome.is_finished and outcome.default is None and outcome.verdict() == "not finished"
    assert tuning(model, tmp_path, Table(peak)).is_finished


def test_default_settings_that_are_best_stay(model: ir.Model, tmp_path: Path) -> None:
    executor = Table(lambda options: -1.0 if "xi" in options else 0.0)
    outcome = tuning(model, tmp_path, executor, options={"xi": None}, candidates=3)
    assert outcome.is_finished and outcome.winner is None and outcome.held_out is None
    assert not (tmp_path / "tiger.settings.json").exists()


def test_a_winner_by_luck_alone_is_not_written(model: ir.Model, tmp_path: Path) -> None:
    def lucky(options: dict[str, object]) -> float:
        return 0.0 if "xi" not in options else 1.0 if options["of seed"] == 1 else -1.0

    outcome = tuning(model, tmp_path, Table(lucky), options={"xi": None}, candidates=2)
    assert outcome.winner is not None and outcome.file is None
    assert "earn less" in outcome.verdict() and not (tmp_path / "tiger.settings.json").exists()


def test_without_held_out_episodes_nothing_is_shown(model: ir.Model, tmp_path: Path) -> None:
    outcome = tuning(model, tmp_path, Table(peak), held_out=0)
    assert outcome.file is not None and "held_out" not in json.loads(outcome.file.read_text())["found"]
    assert outcome.verdict() == "no episodes were held out: nothing is shown"


def test_params_are_tuned_in_a_world_that_keeps_its_own(model: ir.Model, tmp_path: Path) -> None:
    def by_hearing(options: dict[str, object]) -> float:
        text = str(options.get("settings", '{"params":{"hearing":0.85}}'))
        return -abs(json.loads(text)["params"]["hearing"] - 0.6) * 20

    outcome = tuning(model, tmp_path, Table(by_hearing), mode="default", options={}, params={"hearing": None})
    assert outcome.tried[0].is_default and outcome.tried[0].values == {"param hearing": 0.85}
    assert outcome.held_out is not None and outcome.held_out.policy is None, "it is what is tuned"
    assert outcome.settings["options"] == {"mode": "default"}
    assert abs(outcome.settings["params"]["hearing"] - 0.6) < 0.25


def test_default_values_out_of_the_ranges_are_no_candidate(model: ir.Model, tmp_path: Path) -> None:
    outcome = tuning(model, tmp_path, Table(peak), options={"scenarios": "20..200"})
    assert len(outcome.tried) == 8 and not any(one.is_default for one in outcome.tried)
    assert outcome.winner is not None


def test_candidates_that_fail_are_left_out(model: ir.Model, tmp_path: Path) -> None:
    def small_ones_fail(options: dict[str, object]) -> float:
        if int(str(options.get("scenarios", 500))) < 100:
            raise ValueError("out of memory")
        return peak(options)

    outcome = tuning(model, tmp_path, Table(small_ones_fail))
    failed = [one for one in outcome.tried if one.problem]
    assert failed and failed[0].problem == "out of memory" and outcome.is_finished
    assert outcome.winner is not None and int(outcome.winner.values["scenarios"]) >= 100


def test_where_everything_fails_it_is_said(model: ir.Model, tmp_path: Path) -> None:
    def fails(options: dict[str, object]) -> float:
        raise ValueError("it hung")

    for _ in range(2):
        with pytest.raises(TuningError, match="the default settings cannot be played: it hung"):
            tuning(model, tmp_path, Table(fails))

    def only_default(options: dict[str, object]) -> float:
        if "scenarios" in options:
            raise ValueError("it hung")
        return 0.0

    outcome = tuning(model, tmp_path / "candidates", Table(only_default), candidates=3)
    assert outcome.is_finished and outcome.winner is None
    assert [one.problem for one in outcome.tried[1:]] == ["it hung"] * 3


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"runs": 25}, "runs: 10, not 25"),
        ({"options": {"scenarios": "20..800"}}, "tuned: scenarios=20..900, not scenarios=20..800"),
        ({"budget": {"trials": 6}}, "budget: trials=5, not trials=6"),
        ({"fixed": {"xi": 0.5}}, "fixed: nothing, not xi=0.5"),
        ({"program": "other"}, "the model or hypgen has changed since"),
    ],
)
def test_a_folder_of_another_tuning_is_refused(
    model: ir.Model, tmp_path: Path, change: dict[str, object], says: str
) -> None:
    tuning(model, tmp_path, Table(peak), candidates=1, held_out=0)
    with pytest.raises(TuningError) as error:
        tuning(model, tmp_path, Table(peak), **change)  # type: ignore[arg-type]
    assert "has another tuning" in str(error.value) and says in str(error.value)


def test_a_folder_of_something_else_is_refused(model: ir.Model, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.tex").write_text("years of work")
    with pytest.raises(SuiteError, match="files that are no suite's"):
        tuning(model, tmp_path, Table(peak))


def test_a_journal_that_was_cut_is_mended_and_a_damaged_one_refused(model: ir.Model, tmp_path: Path) -> None:
    whole = tuning(model, tmp_path, Table(peak), candidates=3)
    journal = tmp_path / "out" / JOURNAL
    with journal.open("a") as file:
        file.write('{"op_code": 4, "worker')
    journal.with_name(f"{JOURNAL}.lock").write_text("of a process that was killed")
    assert tuning(model, tmp_path, Table(peak), candidates=3).tried == whole.tried
    journal.write_text("years of work\n" * 3)
    with pytest.raises(TuningError, match=r"candidates\.journal' is damaged"):
        tuning(model, tmp_path, Table(peak))


def test_two_processes_do_not_share_a_folder(model: ir.Model, tmp_path: Path) -> None:
    class Second(Table):
        def play(self, cells: Sequence[Cell], store: Store, end: float) -> Iterator[Cell | Failure]:
            tuning(model, tmp_path, Table(peak))
            yield from super().play(cells, store, end)

    with pytest.raises(TuningError, match="another process tunes in"):
        tuning(model, tmp_path, Second(peak))


def test_settings_that_cannot_be_written_are_said(model: ir.Model, tmp_path: Path) -> None:
    (tmp_path / "tiger.settings.json").mkdir()
    with pytest.raises(TuningError, match="cannot be written"):
        tuning(model, tmp_path, Table(peak))
