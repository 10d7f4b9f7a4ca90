# SPDX-License-Identifier: Apache-2.0
"""A tuning, from the default settings to a file of better ones."""

from __future__ import annotations

import importlib.util
import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hypgen.api import model as models
from hypgen.api.model import FilePath
from hypgen.api.programs import Progress
from hypgen.dsl import ir
from hypgen.experiments import running
from hypgen.experiments.results import Played
from hypgen.experiments.running import Executor
from hypgen.experiments.store import Store
from hypgen.experiments.suite import Suite, Task, Value
from hypgen.experiments.suite_values import ON_GPU, THREADED
from hypgen.tuning import space
from hypgen.tuning.asked import BUDGETS, EPISODES_A_CELL, Asked, check, key
from hypgen.tuning.outcome import HeldOut, Outcome, Tried, settings_text
from hypgen.tuning.playing import Player, State, TimeIsUp
from hypgen.tuning.space import Dimension, Given, TuningError
from hypgen.whole_files import write_whole

if TYPE_CHECKING:
    from hypgen.tuning.study import Candidates


def need_sampler(name: str) -> None:
    """Raise ``TuningError`` where a library is missing that a sampler needs."""
    if missing := [one for one in ("optuna", "scipy") if importlib.util.find_spec(one) is None]:
        raise TuningError(f"tuning needs {' and '.join(missing)}: pip install 'hypgen[tune]'")
    if name == "gp" and importlib.util.find_spec("torch") is None:
        raise TuningError("Optuna's GP sampler needs PyTorch: pip install torch; the CPU version is enough")


def ask(
    task: Task,
    model: ir.Model,
    *,
    mode: str = "despot",
    options: Mapping[str, Given] | None = None,
    params: Mapping[str, Given] | None = None,
    fixed: Mapping[str, Value] | None = None,
    budget: Mapping[str, float | None] | None = None,
    threads: int | None = None,
    runs: int = 50,
    seed: int = 1,
    sampler: str = "tpe",
) -> Asked:
    """Return what a tuning is asked to play; raise ``TuningError`` where that cannot be.

    Without ``options`` and ``params``, the usual options of the mode are tuned.
    """
    names: Mapping[str, Given] = options or {}
    if not options and not params:
        names = dict.fromkeys(space.USUAL.get(mode, ()))
    dimensions: tuple[Dimension, ...] = (
        *(space.option(name, given) for name, given in names.items()),
        *(space.param(model, name, given) for name, given in (params or {}).items()),
    )
    given = {name: value for name, value in (budget or {}).items() if value is not None}
    if len(given) > 1 or given.keys() - set(BUDGETS):
        raise TuningError(f"give one of {', '.join(BUDGETS)}, found {', '.join(given)}")
    cores = len(os.sched_getaffinity(0))
    asked = Asked(
        task,
        mode,
        next(iter(given.items()), ("time", 0.1)),
        tuple((name.replace("-", "_"), value) for name, value in (fixed or {}).items()),
        dimensions,
        (threads or cores) if mode in THREADED else 1,
        runs,
        seed,
        sampler,
    )
    check(asked)
    need_sampler(sampler)
    return asked


class Tuning:
    """A tuning under way; ``outcome`` is what it knows."""

    def __init__(
        self,
        asked: Asked,
        model: ir.Model,
        player: Player,
        *,
        candidates: int,
        held_out: int,
        at_once: int,
        file: Path,
    ) -> None:
        self._asked, self._model, self._player = asked, model, player
        self._held_out, self._at_once, self._file = held_out, at_once, file
        self.outcome = Outcome(candidates, asked.runs)
        cells = math.ceil(asked.runs / EPISODES_A_CELL)
        beside = 2 if asked.beside is None else 3
        player.state.outcome = self.outcome
        player.state.total = (1 + candidates) * cells + beside * math.ceil(held_out / EPISODES_A_CELL)

    def run(self) -> Outcome:
        """Play what is missing until the tuning is finished, or its time is up."""
        from hypgen.tuning.study import opened

        asked = self._asked
        self._player.store.forget_failures()
        with opened(self._player.store.folder, asked, self._player.program) as candidates:
            try:
                default = self.outcome.default = self._play_default()
                self._count(1, asked.runs)
                candidates.take_default(self._own_values(), default.returns)
                self._try_candidates(candidates)
                self._take(candidates)
                if self.outcome.winner is not None and self._held_out:
                    self._hold_out(self.outcome.winner)
                self.outcome.is_finished = True
            except TimeIsUp:
                pass
            finally:
                self._take(candidates)
        if self.outcome.is_finished:
            self._write()
        return self.outcome

    def _play_default(self) -> Played:
        """Return what the default settings have earned: without that there is nothing to compare with."""
        [played] = self._player.play([self._asked.setting({}, self._asked.seed)], 0, self._asked.runs)
        if isinstance(played, str):
            raise TuningError(f"the default settings cannot be played: {played}")
        return played

    def _own_values(self) -> dict[str, Value]:
        """Return the values that the default settings have of what is tuned."""
        told = self._player.options(self._asked.setting({}, self._asked.seed), self._asked.runs)
        found: dict[str, Value] = {}
        for one in self._asked.dimensions:
            value = space.default_of(self._model, one) if one.is_param else told.get(one.name)
            if isinstance(value, Value):
                found[key(one)] = value
        return found

    def _try_candidates(self, candidates: Candidates) -> None:
        """Play the episodes of candidates, a batch at a time, until enough are done."""
        while batch := candidates.next(self._at_once, self.outcome.asked):
            earned: dict[int, dict[int, float]] = {trial.number: {} for trial in batch}
            for first in range(0, self._asked.runs, EPISODES_A_CELL):
                runs = min(EPISODES_A_CELL, self._asked.runs - first)
                settings = [
                    self._asked.setting(trial.user_attrs["values"], self._asked.seed) for trial in batch
                ]
                played = self._player.play(settings, first, runs)
                for trial, found in zip(list(batch), played, strict=True):
                    if isinstance(found, str):
                        candidates.failed(trial, found)
                    else:
                        earned[trial.number] |= found.returns
                        is_last = first + runs == self._asked.runs
                        mine = earned[trial.number]
                        if not candidates.is_worse(trial, mine) and not is_last:
                            continue
                        candidates.done(trial, mine)
                    batch.remove(trial)
                if not batch:
                    break
            self._take(candidates)

    def _take(self, candidates: Candidates) -> None:
        """Learn what candidates are known."""
        from hypgen.tuning import study

        self.outcome.tried = [
            Tried(
                one.number,
                study.values_of(one),
                len(one.intermediate_values),
                math.nan if one.values is None else one.values[0],
                study.problem_of(one),
                study.is_default(one),
            )
            for one in candidates.all
        ]
        done = sum(one.is_done and not one.is_default for one in self.outcome.tried)
        self._count(1 + done, self._asked.runs)
        best = next(iter(self.outcome.whole), None)
        default = self.outcome.default
        if best is None or best.is_default or default is None or not default.returns:
            self.outcome.winner = None
            return
        mean = sum(default.returns.values()) / len(default.returns)
        self.outcome.winner = best if best.value > mean else None
        if self.outcome.winner is not None:
            self.outcome.settings = self._asked.settings(best.values)

    def _hold_out(self, winner: Tried) -> None:
        """Play episodes of another seed with the default settings, the winner and the default policy."""
        asked, seed = self._asked, self._asked.seed + 1
        settings = [asked.setting({}, seed), asked.setting(winner.values, seed)]
        settings += [] if asked.beside is None else [asked.setting({}, seed, asked.beside)]
        played = self._player.play(settings, 0, self._held_out)
        for one in played:
            if isinstance(one, str):
                raise TuningError(f"held-out episodes cannot be played: {one}")
        found = [one for one in played if isinstance(one, Played)]
        self.outcome.held_out = HeldOut(found[0], found[1], found[2] if len(found) > 2 else None)

    def _count(self, settings: int, runs: int) -> None:
        """Count all cells of settings that are done, also those that were left out."""
        self._player.state.done = max(self._player.state.done, settings * math.ceil(runs / EPISODES_A_CELL))
        self._player.tell(self._player.state)

    def _write(self) -> None:
        """Write the winner's settings, unless they earn less in the held-out episodes."""
        outcome = self.outcome
        if outcome.winner is None or (outcome.held_out and outcome.held_out.difference.interval.mean <= 0):
            return
        told = {"model": self._model.name, **self._asked.described(self._player.program)}
        about: dict[str, Any] = {"candidate": outcome.winner.number, **told}
        try:
            write_whole(self._file, settings_text(outcome, about))
        except OSError as error:
            raise TuningError(f"'{self._file}' cannot be written: {error.strerror}") from None
        outcome.file = self._file


def tune(
    model: FilePath,
    folder: FilePath,
    *,
    instance: FilePath | None = None,
    values: Mapping[str, Any] | None = None,
    mode: str = "despot",
    options: Mapping[str, Given] | None = None,
    params: Mapping[str, Given] | None = None,
    fixed: Mapping[str, Value] | None = None,
    seconds: float | None = None,
    period: float | None = None,
    trials: int | None = None,
    threads: int | None = None,
    candidates: int = 40,
    runs: int = 50,
    held_out: int = 100,
    seed: int = 1,
    sampler: str = "tpe",
    jobs: int = 1,
    gpus: Sequence[str] = (),
    limit: float | None = None,
    cell_limit: float = 3600.0,
    write: FilePath | None = None,
    target: str = "auto",
    progress: Progress | None = None,
    tell: Callable[[State], None] = lambda state: None,
    executor: Executor | None = None,
) -> Outcome:
    """Look for settings that earn more than the default ones, and return what is found.

    ``options`` and ``params`` name what is tuned, each with a range "LOW..HIGH" or (low, high), a list of
    values, or None for the usual one; without both, the usual options of the mode. All candidates have the
    ``fixed`` options. A decision takes ``seconds`` (0.1), ``trials``, or ``period`` with its update. So many
    ``candidates`` play ``runs`` episodes of ``seed``, fewer where they are clearly worse. The winner and the
    default settings then play ``held_out`` episodes of the next seed.

    ``folder`` keeps all that is played: the same call goes on where it was. ``limit`` is in seconds. The file
    ``write`` gets the settings, by default NAME.settings.json. ``values`` are those of consts and params, the
    other arguments those of ``hypgen.bench``. What cannot be tuned raises ``TuningError``.
    """
    own = models.load(model, instance, **(values or {})).loaded.model
    told = tuple(f"{name}={models.text_of(value)}" for name, value in (values or {}).items())
    task = Task(own.name, Path(model), None if instance is None else Path(instance), told)
    budget = {"time": seconds, "period": period, "trials": trials}
    asked = ask(
        task, own, mode=mode, options=options, params=params, fixed=fixed, budget=budget, threads=threads,
        runs=runs, seed=seed, sampler=sampler,
    )  # fmt: skip
    needs_gpu = mode in ON_GPU
    if needs_gpu and not gpus:
        raise TuningError(f"mode {mode!r} needs a GPU: name one or more")
    store = Store(Path(folder))
    store.open(f"tuning of {own.name}")
    study = asked.study((asked.setting({}, seed),), runs)
    builds = running.build(Suite("tuning", Path(model), (study,)), target, progress)
    at_once = max(
        1, min(jobs, len(os.sched_getaffinity(0)) // asked.threads, len(gpus) if needs_gpu else jobs)
    )
    player = Player(
        builds[task.name].program,
        store,
        executor or running.local(builds, jobs, list(gpus), cell_limit),
        State(0),
        math.inf if limit is None else time.monotonic() + limit,
        tell,
    )
    file = Path(f"{Path(model).stem}.settings.json") if write is None else Path(write)
    return Tuning(
        asked, own, player, candidates=candidates, held_out=held_out, at_once=at_once, file=file
    ).run()
