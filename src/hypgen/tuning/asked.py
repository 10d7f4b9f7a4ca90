# SPDX-License-Identifier: Apache-2.0
"""What a tuning is asked to play."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hypgen.dsl.messages.diagnostic import did_you_mean
from hypgen.experiments.suite import Setting, Study, Task, Value
from hypgen.experiments.suite_values import BESIDE, MODES, ON_GPU, THREADED
from hypgen.tuning.space import Dimension, TuningError, text_of

EPISODES_A_CELL = 5
SAMPLERS = ("tpe", "gp")
BUDGETS = ("time", "period", "trials")
_FIXED = (
    "scenarios", "depth", "xi", "rollouts", "pruning", "exploration", "observation_loss", "in_flight",
    "particles", "belief", "memory", "device", "device_memory", "steps", "on_depletion",
)  # fmt: skip
_OF_EPISODES = ("steps", "on_depletion")  # no settings of a planner

Candidate = Mapping[str, Value]  # values by the names of dimensions


@dataclass(frozen=True)
class Asked:
    """A tuning: what is tuned, in which episodes, and what all candidates share.

    ``fixed`` are options that are not tuned. ``budget`` is the name of one of ``BUDGETS`` and its value.
    ``runs`` are the episodes of a candidate, numbered from 0, of ``seed``.
    """

    task: Task
    mode: str
    budget: tuple[str, float]
    fixed: tuple[tuple[str, Value], ...]
    dimensions: tuple[Dimension, ...]
    threads: int
    runs: int
    seed: int
    sampler: str

    def setting(self, candidate: Candidate, seed: int, mode: str | None = None) -> Setting:
        """Return what plays a candidate's episodes; one without values is the default settings."""
        mode = mode or self.mode
        params = {
            one.name: candidate[key(one)] for one in self.dimensions if one.is_param and key(one) in candidate
        }
        tuned = [
            (one.name, candidate[key(one)])
            for one in self.dimensions
            if not one.is_param and key(one) in candidate
        ]
        options: list[tuple[str, Value]] = [("mode", mode), *self.fixed]
        options += [self.budget] if mode != "default" else []
        options += [("threads", self.threads)] if mode in THREADED else []
        options += [("require_gpu", True)] if mode in ON_GPU else []
        options += tuned
        options += [("settings", json.dumps({"params": params}, separators=(",", ":")))] if params else []
        return Setting(self.task, (("mode", mode), *candidate.items()), tuple(options), seed)

    def study(self, settings: tuple[Setting, ...], runs: int) -> Study:
        """Return settings that play the same episodes."""
        return Study("tuning", settings, runs, (self.mode,), EPISODES_A_CELL)

    @property
    def beside(self) -> str | None:
        """The simplest policy to play beside the settings, unless it is what is tuned."""
        return None if self.mode == BESIDE[0] else BESIDE[0]

    def settings(self, candidate: Candidate) -> dict[str, Any]:
        """Return a candidate as the solver, Python and the C interface take it."""
        own = [(name, value) for name, value in self.fixed if name not in _OF_EPISODES]
        tuned = [(one.name, candidate[key(one)]) for one in self.dimensions if not one.is_param]
        options = {name.replace("_", "-"): value for name, value in (("mode", self.mode), *own, *tuned)}
        params = {one.name: candidate[key(one)] for one in self.dimensions if one.is_param}
        return {"options": options, **({"params": params} if params else {})}

    def described(self, program: str) -> dict[str, Any]:
        """Return what tells this tuning from another in the same folder."""
        return {
            "program": program,
            "mode": self.mode,
            "budget": "=".join(map(str, self.budget)),
            "fixed": [f"{name}={text_of(value)}" for name, value in self.fixed],
            "tuned": [str(one) for one in self.dimensions],
            "threads": self.threads,
            "runs": self.runs,
            "seed": self.seed,
            "sampler": self.sampler,
        }


def key(dimension: Dimension) -> str:
    """Return a dimension's name among candidates: a param may be called as an option is."""
    return f"param {dimension.name}" if dimension.is_param else dimension.name


def check(asked: Asked) -> None:
    """Raise ``TuningError`` where a tuning cannot be played."""
    if asked.mode not in MODES:
        raise TuningError(f"there is no mode {asked.mode!r}; there are {', '.join(MODES)}")
    if not asked.dimensions:
        raise TuningError(f"mode {asked.mode!r} has no options to tune: name params")
    if asked.sampler not in SAMPLERS:
        raise TuningError(f"there is no sampler {asked.sampler!r}; there are {', '.join(SAMPLERS)}")
    if asked.runs < 3:
        raise TuningError("a candidate has to play 3 episodes or more")
    names = [key(one) for one in asked.dimensions]
    if doubled := next((name for name in names if names.count(name) > 1), None):
        raise TuningError(f"{doubled!r} is tuned twice")
    for name, _ in asked.fixed:
        if name not in _FIXED:
            nearest = did_you_mean(name, _FIXED) or f"there are {', '.join(_FIXED)}"
            raise TuningError(f"no option {name!r} can be fixed: {nearest}")
        if name in names:
            raise TuningError(f"{name!r} is both tuned and fixed")
    if asked.mode == "default" and (
        given := next((one for one in asked.dimensions if not one.is_param), None)
    ):
        raise TuningError(f"the default policy has no search: {given.name!r} changes nothing")
