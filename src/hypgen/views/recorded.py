# SPDX-License-Identifier: Apache-2.0
"""What a page shows of an episode that a solver has recorded."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hypgen.dsl import ir
from hypgen.dsl.interpret.scenes import Scenes
from hypgen.recordings import (
    End,
    Header,
    Recording,
    RecordingError,
    Start,
    Step,
    params_of,
    reward_terms,
)
from hypgen.views.view import entries_of, most_nodes, shown_step, view_of

_APART = ("action", "action_name", "type", "episode", "sampled", "particles_total")


def view_of_recording(
    recording: Recording, model: ir.Model, episode: int, *, first: int = 0, file: str = ""
) -> dict[str, Any]:
    """Return what a page shows of an episode of a recording of ``model``.

    ``first`` is the step that is shown first, and ``file`` is the name of the model's file. One episode is
    kept in memory. ``RecordingError`` where the file lacks the episode, its steps, or step ``first``, and
    where a line of it is broken.
    """
    shown = RecordedEpisode(model, recording.header, episode, recording.steps(episode), file)
    for part in recording.read(episode):
        shown.add(part)
    steps = shown.steps
    if not steps:
        raise RecordingError(f"{recording.path}: episode {episode} has no whole step")
    if not any(step["step"] == first for step in steps):
        raise RecordingError(
            f"--step {first}: the episode has the steps {steps[0]['step']} to {steps[-1]['step']}"
        )
    if not shown.has_ended:
        shown.notes.append(
            f"The recording ends after step {steps[-1]['step']}: "
            "what came later, and what it earned, is not known."
        )
    return shown.view(first)


class RecordedEpisode:
    """An episode whose parts come one by one. A step is kept as it is shown.

    ``length`` is how many steps may come: their trees share the room of a page. ``notes`` say what is
    missing.
    """

    def __init__(self, model: ir.Model, header: Header, episode: int, length: int, file: str = "") -> None:
        self.episode = episode
        self.steps: list[dict[str, Any]] = []
        self.notes: list[str] = []
        self._model, self._header, self._file = model, header, file
        self._scenes = Scenes(model, params_of(model, header))
        self._scene = self._scenes.scene()
        self._entries = entries_of(model)
        self._most = most_nodes(length)
        self._end: End | None = None
        self._has_terms = True

    @property
    def has_ended(self) -> bool:
        """Return whether the end has come."""
        return self._end is not None

    def add(self, part: Start | Step | End) -> None:
        """Take the next part."""
        if isinstance(part, Step):
            step = self._with_shapes(part) | self._terms(part)
            self.steps.append(shown_step(step, self._most, self._entries))
        elif isinstance(part, End):
            self._end = part

    def view(self, first: int = 0) -> dict[str, Any]:
        """Return what a page shows of the parts that have come; ``first`` is the step that is shown first."""
        header, end = self._header, self._end
        return view_of(
            {
                "name": header.model,
                "hash": header.hash,
                "file": self._file or header.file,
                "discount": header.discount,
                "options": _options(header),
                "episode": self.episode,
                "ended": None if end is None else _ending(end, header),
                "first": first,
            },
            self.steps,
            None if end is None else {"state": end.state, "truth": self._scenes.truth(end.state)},
            scene=self._scene,
            notes=self.notes,
        )

    def _with_shapes(self, step: Step) -> dict[str, Any]:
        """Return a step with its shapes instead of its sampled states."""
        kept = {name: value for name, value in step.line.items() if name not in _APART}
        belief = {} if step.sampled is None else self._scenes.belief(step.state, step.sampled)
        return kept | belief | {"action": step.action_name, "truth": self._scenes.truth(step.state)}

    def _terms(self, step: Step) -> dict[str, Any]:
        """Return the rewards of a step by term, or say once why they are not known."""
        if not self._has_terms:
            return {}
        try:
            return {"terms": reward_terms(self._model, self._header, step)}
        except RecordingError as error:
            self._has_terms = False
            self.notes.append(f"Rewards by term are missing from step {step.step} on: {error}.")
            return {}


def _ending(end: End, header: Header) -> str | None:
    if end.terminal:
        return "terminal"
    if end.status == "interrupted":
        return None
    return "horizon" if end.steps == header.horizon else "step_limit"


def _options(header: Header) -> Mapping[str, Any]:
    """Return the options that say how the episode was played: no machine's, and none of the run's length."""
    kept = ("mode", "time", "period", "trials", "scenarios", "particles", "depth", "seed", "belief")
    return {name: header.options[name] for name in kept if header.options.get(name) is not None}
