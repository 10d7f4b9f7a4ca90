# SPDX-License-Identifier: Apache-2.0
"""What a page shows of an episode that a solver has recorded."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hypgen.dsl import ir
from hypgen.dsl.interpret.scenes import Scenes
from hypgen.recordings import End, Header, Recording, RecordingError, Step, params_of, reward_terms
from hypgen.views.view import entries_of, view_of

_APART = ("action", "action_name", "type", "episode", "sampled", "particles_total")


def view_of_recording(
    recording: Recording, model: ir.Model, episode: int, *, first: int = 0, file: str = ""
) -> dict[str, Any]:
    """Return what a page shows of an episode of a recording of ``model``.

    ``first`` is the step that is shown first, and ``file`` is the name of the model's file. One episode is
    kept in memory. ``RecordingError`` where the file lacks the episode, its steps, or step ``first``, and
    where a line of it is broken.
    """
    header = recording.header
    scenes = Scenes(model, params_of(model, header))
    steps: list[dict[str, Any]] = []
    notes: list[str] = []
    end: End | None = None
    for part in recording.read(episode):
        if isinstance(part, Step):
            steps.append(_step(part, scenes) | _terms(part, model, header, notes))
        elif isinstance(part, End):
            end = part
    if not steps:
        raise RecordingError(f"{recording.path}: episode {episode} has no whole step")
    if not any(step["step"] == first for step in steps):
        raise RecordingError(
            f"--step {first}: the episode has the steps {steps[0]['step']} to {steps[-1]['step']}"
        )
    if end is None:
        notes.append(
            f"The recording ends after step {steps[-1]['step']}: "
            "what came later, and what it earned, is not known."
        )
    return view_of(
        {
            "name": header.model,
            "hash": header.hash,
            "file": file or header.file,
            "discount": header.discount,
            "options": _options(header),
            "episode": episode,
            "ended": None if end is None else _ending(end, header),
            "first": first,
        },
        steps,
        None if end is None else {"state": end.state, "truth": scenes.truth(end.state)},
        scene=scenes.scene(),
        entries=entries_of(model),
        notes=notes,
    )


def _step(step: Step, scenes: Scenes) -> dict[str, Any]:
    """Return a step with its shapes instead of its sampled states."""
    kept = {name: value for name, value in step.line.items() if name not in _APART}
    belief = {} if step.sampled is None else scenes.belief(step.state, step.sampled)
    return kept | belief | {"action": step.action_name, "truth": scenes.truth(step.state)}


def _terms(step: Step, model: ir.Model, header: Header, notes: list[str]) -> dict[str, Any]:
    """Return the rewards of a step by term, or say once why they are not known."""
    if any(note.startswith(_NO_TERMS) for note in notes):
        return {}
    try:
        return {"terms": reward_terms(model, header, step)}
    except RecordingError as error:
        notes.append(f"{_NO_TERMS} from step {step.step} on: {error}.")
        return {}


_NO_TERMS = "Rewards by term are missing"


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
