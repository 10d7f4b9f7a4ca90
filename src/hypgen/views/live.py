# SPDX-License-Identifier: Apache-2.0
"""The newest episode of a run that goes on: its recording comes line by line, pages ask for what is new."""

from __future__ import annotations

import html
import threading
import time
from pathlib import Path
from typing import Any

from hypgen.dsl import ir
from hypgen.recordings import Header, RecordingError, header_from, part_of, started
from hypgen.views.page import finite, page_of
from hypgen.views.recorded import RecordedEpisode

_PATIENCE = 2.0  # seconds in which a page that is open asks again

_WAITING = """<!doctype html><html lang="en"><meta charset="utf-8"><meta http-equiv="refresh" content="1">
<meta name="color-scheme" content="light dark"><title>hypgen</title>
<body style="font: 1rem/1.5 system-ui, sans-serif; margin: 2rem"><p>{}</p></body></html>
"""


class LiveEpisodes:
    """Takes the lines of a recording as they are written, and gives pages and news of the newest episode.

    Lines are taken apart when a page asks for them, so that a run that nobody watches is not slowed. Lines of
    earlier episodes are forgotten. All methods may be called by several threads.
    """

    def __init__(self, model: ir.Model, file: str) -> None:
        self._model, self._file = model, file
        self._lock = threading.Lock()
        self._header: Header | None = None
        self._number: int | None = None  # of the newest episode
        self._lines: list[bytes] = []  # of that, which are not yet taken apart
        self._shown: RecordedEpisode | None = None
        self._problem = ""
        self._is_over = False
        self._asked = -_PATIENCE
        self._told = threading.Event()

    def take(self, line: bytes) -> None:
        """Take the next line of the recording."""
        with self._lock:
            if self._header is None:
                self._header = header_from(line, Path(self._file))
            elif (number := started(line)) is not None:
                self._number, self._lines = number, []
            else:
                self._lines.append(line)

    def end(self) -> None:
        """Say that the run is over; wait, two seconds at most, until a page that is open has heard of it."""
        with self._lock:
            self._is_over = True
            is_watched = time.monotonic() - self._asked < _PATIENCE
        if is_watched:
            self._told.wait(_PATIENCE)

    def page(self) -> str:
        """Return the page of the newest episode, or one that waits for its first step."""
        with self._lock:
            self._catch_up()
            if self._shown is None:
                return _WAITING.format(html.escape(self._problem) or "The first decision is not made yet.")
            return page_of(self._shown.view() | {"live": True})

    def news(self, episode: int, count: int) -> dict[str, Any]:
        """Return what is new for a page that shows ``count`` steps of an episode.

        ``episode`` is the newest one that has a step, and ``over`` tells whether the run is. Of the episode
        asked for there are also the ``steps`` after those, ``earned`` for all steps, ``end``, ``ended`` and
        ``notes``.
        """
        with self._lock:
            self._catch_up()
            news: dict[str, Any] = {"episode": None, "over": self._is_over, "problem": self._problem}
            if self._shown is not None:
                news["episode"] = self._shown.episode
                if self._shown.episode == episode:
                    view = self._shown.view()
                    news |= {name: view[name] for name in ("end", "ended", "notes")}
                    news["steps"] = view["steps"][count:]
                    news["earned"] = [step["earned"] for step in view["steps"]]
            if self._is_over:
                self._told.set()
            found: dict[str, Any] = finite(news)
            return found

    def _catch_up(self) -> None:
        """Take the lines apart that have come."""
        self._asked = time.monotonic()
        if self._header is None or self._number is None or not self._lines or self._problem:
            return
        lines, self._lines = self._lines, []
        try:
            if self._shown is None or self._shown.episode != self._number:
                length = int(self._header.options.get("steps") or 0)
                self._shown = RecordedEpisode(self._model, self._header, self._number, length, self._file)
            for line in lines:
                self._shown.add(part_of(line, self._file))
        except RecordingError as error:
            self._problem = str(error)
