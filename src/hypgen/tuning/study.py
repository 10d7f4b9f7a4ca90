# SPDX-License-Identifier: Apache-2.0
"""Candidates by Optuna, kept in a journal, so that a tuning goes on where it was."""

from __future__ import annotations

import fcntl
import json
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from statistics import fmean
from typing import Any

import optuna
from optuna.trial import FrozenTrial, Trial, TrialState

from hypgen.experiments.suite import Value
from hypgen.tuning.asked import Asked, key
from hypgen.tuning.space import Choice, Range, TuningError

JOURNAL = "candidates.journal"
_ASKED, _DEFAULT, _PROBLEM, _VALUES = "asked", "is_default", "problem", "values"


class Candidates:
    """The candidates of a tuning: by Optuna's numbers, with what they have earned."""

    def __init__(self, asked: Asked, study: optuna.Study) -> None:
        self._asked = asked
        self._study = study

    def take_default(self, values: Mapping[str, Value], returns: Mapping[int, float]) -> None:
        """Let the default settings be the first candidate, unless their values are out of the ranges."""
        dimensions = self._asked.dimensions
        inside = all(key(one) in values and one.values.has(values[key(one)]) for one in dimensions)
        if self._study.trials or not inside:
            return
        distributions = {key(one): _distribution(one.values) for one in dimensions}
        own = {name: values[name] for name in distributions}
        first = optuna.trial.create_trial(
            params=own,
            distributions=distributions,
            value=fmean(returns.values()),
            intermediate_values=dict(returns),
            user_attrs={_VALUES: own, _DEFAULT: True},
        )
        self._study.add_trial(first)

    def next(self, size: int, most: int) -> list[Trial]:
        """Return the candidates of a batch that are not done: those that were begun, and new ones.

        A new one's values depend on the candidates before it and on its number alone. So a tuning that was
        interrupted goes on as if it had not been.
        """
        known = self._study.trials
        begun = [one for one in known if one.state is TrialState.RUNNING]
        made = sum(not one.user_attrs.get(_DEFAULT, False) for one in known)
        count = size - made % size if made % size or not begun else 0
        numbers = range(len(known), len(known) + max(0, min(count, most - made)))
        return [self._trial(one.number, one) for one in begun] + [self._trial(number) for number in numbers]

    def _trial(self, number: int, begun: FrozenTrial | None = None) -> Trial:
        seed = (self._asked.seed * 1_000_003 + number) % 2**32
        self._study.sampler = _sampler(self._asked.sampler, seed)
        trial = self._study.ask() if begun is None else Trial(self._study, begun._trial_id)
        values = {key(one): one.values.suggest(trial, key(one)) for one in self._asked.dimensions}
        trial.set_user_attr(_VALUES, values)
        return trial

    def is_worse(self, trial: Trial, returns: Mapping[int, float]) -> bool:
        """Take a candidate's episodes so far; return whether it is clearly worse than the best.

        Wilcoxon's test is of ranks. It calls a candidate worse that loses a little in most episodes and gains
        much in a few, so the mean has to be lower, too.
        """
        reported = self._study.trials[trial.number].intermediate_values
        for episode, value in returns.items():
            if episode not in reported:
                trial.report(value, episode)
        return trial.should_prune() and self._beyond_best(returns) < 0.0

    def done(self, trial: Trial, returns: Mapping[int, float]) -> None:
        """Keep what a candidate is worth: if it was ended early, the best one's mean and the difference.

        Its own mean would be that of the first episodes, which may be easy or hard ones.
        """
        value = fmean(returns.values())
        if len(returns) < self._asked.runs:
            value = self._study.best_value + self._beyond_best(returns)
        self._study.tell(trial, value)

    def _beyond_best(self, returns: Mapping[int, float]) -> float:
        """Return the mean difference to the best candidate, which has played all episodes."""
        best = self._study.best_trial.intermediate_values
        return fmean(mine - best[episode] for episode, mine in returns.items())

    def failed(self, trial: Trial, problem: str) -> None:
        """Keep why a candidate could not be played."""
        trial.set_user_attr(_PROBLEM, problem)
        self._study.tell(trial, state=TrialState.FAIL)

    @property
    def all(self) -> list[FrozenTrial]:
        """All candidates so far."""
        return self._study.trials


def values_of(trial: FrozenTrial) -> dict[str, Value]:
    """Return a candidate's values."""
    found: dict[str, Value] = trial.user_attrs.get(_VALUES, {})
    return found


def is_default(trial: FrozenTrial) -> bool:
    """Return whether a candidate is the default settings."""
    return bool(trial.user_attrs.get(_DEFAULT, False))


def problem_of(trial: FrozenTrial) -> str:
    """Return why a candidate could not be played; empty if it could."""
    return str(trial.user_attrs.get(_PROBLEM, ""))


@contextmanager
def opened(folder: Path, asked: Asked, program: str) -> Iterator[Candidates]:
    """Yield the candidates of a folder; refuse those of another tuning, and a second process."""
    from optuna.storages import JournalStorage
    from optuna.storages.journal import JournalFileBackend

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    path = folder / JOURNAL
    with path.open("a+b") as journal:
        try:
            fcntl.flock(journal, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise TuningError(f"another process tunes in '{folder}'") from None
        _mend(path)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
                study = optuna.create_study(
                    storage=JournalStorage(JournalFileBackend(str(path))),
                    study_name="tuning",
                    direction="maximize",
                    pruner=optuna.pruners.WilcoxonPruner(),
                    load_if_exists=True,
                )
            known = study.user_attrs.get(_ASKED)
        except (ValueError, KeyError, TypeError) as error:
            raise TuningError(f"the journal '{path}' is damaged: {error}") from None
        described = asked.described(program)
        if known is None:
            study.set_user_attr(_ASKED, described)
        elif known != json.loads(json.dumps(described)):
            raise TuningError(
                f"'{folder}' has another tuning ({_difference(known, described)}); name another with -o"
            )
        yield Candidates(asked, study)


def _mend(path: Path) -> None:
    """Drop what a process has left that was killed as it wrote."""
    path.with_name(f"{path.name}.lock").unlink(missing_ok=True)
    text = path.read_bytes()
    if not text.endswith(b"\n"):
        with path.open("r+b") as file:
            file.truncate(text.rfind(b"\n") + 1)


def _difference(known: Mapping[str, Any], described: Mapping[str, Any]) -> str:
    name = next((one for one in described if known.get(one) != described[one]), "")
    if name == "program":
        return "the model or hypgen has changed since"
    return f"{name}: {_shown(known.get(name))}, not {_shown(described[name])}"


def _shown(value: Any) -> str:
    return (
        (" ".join(map(str, value)) or "nothing")
        if isinstance(value, Sequence) and not isinstance(value, str)
        else str(value)
    )


def _sampler(name: str, seed: int) -> optuna.samplers.BaseSampler:
    if name == "gp":
        return optuna.samplers.GPSampler(seed=seed)
    return optuna.samplers.TPESampler(seed=seed, constant_liar=True)


def _distribution(values: Range | Choice) -> optuna.distributions.BaseDistribution:
    """Return what ``suggest`` tells Optuna of these values."""
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    if isinstance(values, Choice):
        return CategoricalDistribution(values.values)
    if values.whole:
        return IntDistribution(int(values.low), int(values.high), log=values.is_logarithmic)
    return FloatDistribution(values.low, values.high, log=values.is_logarithmic)
