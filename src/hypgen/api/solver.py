# SPDX-License-Identifier: Apache-2.0
"""A compiled model: a library in this process, which makes planners."""

from __future__ import annotations

import importlib.util
import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hypgen.api.arguments import encoded_object, in_range
from hypgen.api.c_interface import CLibrary, PlannerError
from hypgen.api.planner import Planner
from hypgen.api.simulation import EpisodeRecord, Policy, StepRecord, simulate
from hypgen.api.worlds import Worlds

if TYPE_CHECKING:
    from hypgen.api.environments import WorldEnv, WorldVectorEnv


class Solver:
    """A model's library; ``Model.compile`` makes one, and ``hypgen compile --library`` the file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._library = CLibrary(path)

    @property
    def description(self) -> dict[str, Any]:
        """The model: its names, types, actions, params and hash."""
        found: dict[str, Any] = self._library.json("describe", self._library.model)
        return found

    def planner(
        self,
        *,
        params: Mapping[str, Any] | None = None,
        settings: str | os.PathLike[str] | Mapping[str, Any] | None = None,
        **options: str | bool | int | float,
    ) -> Planner:
        """Return a planner with options of the solver, such as ``mode="despot", time=0.05``.

        An option's dashes become underscores, and one without a value is True. ``params`` sets the
        model's params. ``settings`` is a file that ``hypgen tune`` has written, or what it says; options
        go first.
        """
        words = [_setting(name.replace("_", "-"), value) for name, value in options.items()]
        if settings is not None:
            words.append(f"settings={_settings_text(settings)}")
        return Planner(self._library, " ".join(word for word in words if word), _text(params))

    def worlds(
        self,
        count: int = 1,
        *,
        seed: int = 0,
        params: Mapping[str, Any] | None = None,
        start: Mapping[str, Any] | None = None,
        device: str = "cpu",
    ) -> Worlds:
        """Return so many simulated worlds side by side, which one call moves.

        ``params`` sets the model's params, and ``start`` what episodes start with, as ``Worlds.start`` does.
        ``device`` is ``cpu``, or where the model was compiled for GPUs ``cuda``, the first one, or
        ``cuda:N``. Results are the same on each. ``PlannerError`` with the status ``no_gpu`` says why a GPU
        cannot be used, or that it has failed.
        """
        return Worlds(self._library, count, seed, _text(params), start, device)

    def env(
        self,
        *,
        seed: int = 0,
        steps: int | None = None,
        params: Mapping[str, Any] | None = None,
        start: Mapping[str, Any] | None = None,
    ) -> WorldEnv:
        """Return a simulated world as an environment of Gymnasium.

        Episodes are truncated at the model's horizon, or after ``steps`` if that comes first. ``start`` is
        that of ``worlds``.
        """
        _need_gymnasium()
        from hypgen.api.environments import WorldEnv

        return WorldEnv(self.worlds(1, seed=seed, params=params, start=start), steps)

    def vector_env(
        self,
        count: int,
        *,
        seed: int = 0,
        steps: int | None = None,
        params: Mapping[str, Any] | None = None,
        start: Mapping[str, Any] | None = None,
        device: str = "cpu",
    ) -> WorldVectorEnv:
        """Return so many simulated worlds as a vectorised environment of Gymnasium, one call of C a step.

        ``device`` is that of ``worlds``.
        """
        _need_gymnasium()
        from hypgen.api.environments import WorldVectorEnv

        worlds = self.worlds(count, seed=seed, params=params, start=start, device=device)
        return WorldVectorEnv(worlds, steps)

    def simulate(
        self,
        planner: Planner | Policy,
        *,
        runs: int,
        seed: int | None = None,
        first_run: int = 0,
        steps: int | None = None,
        params: Mapping[str, Any] | None = None,
        start: Mapping[str, Any] | None = None,
    ) -> Iterator[StepRecord | EpisodeRecord]:
        """Play episodes in a simulated world; yield a record for each step, and one for each episode.

        ``planner`` is a planner, or a function from an ``Observation`` to an action's number or name. The
        arguments are those of the solver's command line, which plays the same episodes. Without ``seed``,
        it is the planner's, or 0. ``params`` and ``start`` are the world's: the planner knows neither.
        """
        count = in_range("runs", runs, 1, 1_000_000)
        first = in_range("first_run", first_run, 0, 1_000_000_000)
        limit = None if steps is None else in_range("steps", steps, 1, 1_000_000)
        if not callable(planner) and not isinstance(planner, Planner):
            raise PlannerError(
                "wrong_argument", f"planner: expected a planner or a policy, found {planner!r}"
            )
        if seed is None:
            seed = planner.info["seed"] if isinstance(planner, Planner) else 0
        worlds = self.worlds(1, seed=seed, params=params, start=start)
        return simulate(worlds, planner, range(first, first + count), limit)


def _need_gymnasium() -> None:
    if importlib.util.find_spec("gymnasium") is None:
        text = "environments need Gymnasium: pip install 'hypgen[gym]'; Solver.worlds does without"
        raise ModuleNotFoundError(text, name="gymnasium")


def _text(params: Mapping[str, Any] | None) -> bytes | None:
    return None if params is None else encoded_object("params", params)


def _settings_text(settings: str | os.PathLike[str] | Mapping[str, Any]) -> str:
    """Return settings as a JSON text without spaces, which end a word."""
    if not isinstance(settings, Mapping):
        try:
            found = json.loads(Path(settings).read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise PlannerError("wrong_argument", f"settings: '{settings}' cannot be read: {error}") from None
        if not isinstance(found, dict):
            raise PlannerError("wrong_argument", f"settings: '{settings}' has no JSON object")
        settings = found
    return json.dumps(settings, separators=(",", ":")).replace(" ", "\\u0020")


def _setting(name: str, value: str | bool | int | float) -> str:
    if isinstance(value, bool):
        return name if value else ""
    return f"{name}={value}"
