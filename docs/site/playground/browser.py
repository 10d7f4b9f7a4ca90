# SPDX-License-Identifier: Apache-2.0
"""What the playground calls, in the browser: each function takes a model's text and returns plain data."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any

from hypgen.cli.commands.check import describe as sizes
from hypgen.cli.commands.check import summary
from hypgen.cli.show.explanation import describe
from hypgen.codegen.model_report import explain as facts_of
from hypgen.dsl import load
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.render import to_json
from hypgen.dsl.messages.source import Source


def check(text: str, path: str) -> dict[str, Any]:
    """Return the diagnostics of ``text``, which stands for the file ``path``, and a line about it."""
    try:
        loaded = _load(text, path)
    except ModelError as error:
        found = [to_json(d) for d in error.diagnostics]
        return {"line": f"{len(found)} mistake{'' if len(found) == 1 else 's'}", "diagnostics": found}
    if isinstance(loaded, load.LoadedLibrary):
        return {"line": f"OK: library {loaded.ast.name}", "diagnostics": []}
    return {
        "line": f"OK: {sizes(summary(loaded.model))}",
        "diagnostics": [to_json(d) for d in loaded.warnings],
    }


def explain(text: str, path: str) -> str:
    """Return what ``hypgen explain`` prints, or what is wrong."""
    try:
        model = load.load(path, given=_given(text, path)).model
    except ModelError as error:
        return _wrong(error)
    parts = (
        "\n".join((heading, *(f"  {line}" for line in lines))) for heading, lines in describe(facts_of(model))
    )
    return "\n".join(parts)


class Play:
    """An episode on the page: what ``hypgen sim`` prints, what the model draws, and the legal actions."""

    def __init__(self, text: str, path: str, seed: int) -> None:
        # These need NumPy, which comes when it is asked for.
        from hypgen.cli.show.episode_drawing import EpisodeDrawing
        from hypgen.cli.show.sim_report import TextReport
        from hypgen.dsl.interpret.episode import Episode

        self._episode = Episode(load.load(path, given=_given(text, path)).model, seed)
        self._report = TextReport(self._episode, show_hidden=True)
        self._drawing = EpisodeDrawing(self._episode, hidden=True)
        self._seed = seed

    def start(self) -> dict[str, Any]:
        """Return how the episode starts."""
        return self._told(lambda: self._report.start(self._seed, 0))

    def act(self, what: str) -> dict[str, Any]:
        """Take the action of code ``what``, or do ``policy``, ``random``, ``undo`` or ``belief``; tell it."""
        episode = self._episode
        if what == "undo":
            return self._told(self._report.undone if episode.undo() else lambda: None)
        if what == "belief":
            return self._told(self._report.belief)
        chosen = {"policy": episode.policy_action, "random": episode.random_action}.get(
            what, lambda: int(what)
        )()
        before = episode.values()
        outcome = episode.step(chosen)
        return self._told(lambda: self._report.step(before, outcome))

    def _told(self, tell: Any) -> dict[str, Any]:
        from hypgen.dsl.interpret.value_text import action_text

        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            tell()
        action = self._episode.model.action
        legal = [[str(code), action_text(code, action)] for code in self._episode.legal()]
        scene = self._drawing.scene
        return {
            "text": printed.getvalue(),
            "legal": legal,
            "ended": self._episode.now.terminal,
            "scene": scene,
            "moment": None if scene is None else self._drawing.moment(),
        }


_played: list[Play] = []


def play(text: str, path: str, seed: int) -> dict[str, Any]:
    """Start an episode, in place of the one before; a wrong model gives its mistakes as text."""
    _played.clear()
    try:
        _played.append(Play(text, path, seed))
    except ModelError as error:
        return {"text": _wrong(error), "legal": [], "ended": True, "scene": None, "moment": None}
    return _played[0].start()


def act(what: str) -> dict[str, Any]:
    """Go on with the episode, as ``Play.act`` says."""
    return _played[0].act(what)


def _given(text: str, path: str) -> Source:
    return Source(path, text)


def _load(text: str, path: str) -> load.Loaded | load.LoadedLibrary:
    if not text.strip():
        Path(path).write_text(text, encoding="utf-8")  # an empty file has a message of its own
        return load.load_any(path)
    return load.load_any(path, given=_given(text, path))


def _wrong(error: ModelError) -> str:
    from hypgen.dsl.messages.render import render_all

    return render_all(error.diagnostics, error.sources)
