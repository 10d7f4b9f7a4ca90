# SPDX-License-Identifier: Apache-2.0
"""A planner and its belief, over a library of the model."""

from __future__ import annotations

import ctypes
import json
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from hypgen.api.c_interface import CDecision, CLibrary, COptions, PlannerError


@dataclass(frozen=True)
class Decision:
    """An action, by its number and its name, and what the search found out.

    ``status`` says how the plan ended: ``converged``, ``deadline``, and so on (docs/guide/embedding.md).
    ``lower`` and ``upper`` bound what the belief is worth, less lambda for each node of the policy's tree
    where scenarios part (``pruning``). They are NaN where nothing was searched.
    """

    action: int
    name: str
    status: str
    lower: float
    upper: float
    seconds: float
    trials: int
    expansions: int
    scenarios: int
    max_depth: int


@dataclass(frozen=True)
class Moments:
    """The belief in a float."""

    mean: float
    deviation: float


class Planner:
    """A planner and its belief; ``Solver.planner`` makes one.

    A wrong call raises ``PlannerError``. One thread uses a planner at a time.
    """

    def __init__(self, library: CLibrary, settings: str, params: str | None) -> None:
        self._library = library
        self._handle: ctypes.c_void_p | None = None
        self._lock = threading.Lock()  # held by each call that has the handle
        handle = ctypes.c_void_p()
        text = None if params is None else params.encode()
        options = COptions(ctypes.sizeof(COptions), _encoded("settings", settings), text)
        library.call("create", library.model, ctypes.byref(options), ctypes.byref(handle))
        self._handle = handle

    def reset(self, visible: Mapping[str, Any] | Sequence[int] | None = None, *, episode: int = 0) -> str:
        """Start an episode; ``visible`` has first values that the model draws, or all. Return the status.

        They come by name, or all of them as the numbers of the C interface. ``episode`` names the random
        numbers of belief and search.
        """
        number = ctypes.c_uint64(_in_range("episode", episode, 0, 2**64 - 1))
        if isinstance(visible, Sequence):
            codes = [_in_range("visible", value, -(2**31), 2**31 - 1) for value in visible]
            return self._status(
                "reset", (ctypes.c_int32 * len(codes))(*codes), ctypes.c_size_t(len(codes)), number
            )
        text = json.dumps(dict(visible or {})).encode()
        return self._status("reset_named", ctypes.c_char_p(text), number)

    def plan(self, seconds: float = 0.0) -> Decision:
        """Decide within so many seconds; 0: the settings' time, or what an update left of their period."""
        found = CDecision(size=ctypes.sizeof(CDecision))
        status = self._status("plan", ctypes.c_double(seconds), ctypes.byref(found))
        return Decision(
            found.action,
            (found.action_name or b"").decode(),
            status,
            found.lower,
            found.upper,
            found.seconds,
            found.trials,
            found.expansions,
            found.scenarios,
            found.max_depth,
        )

    def update(self, action: int | str, seen: Mapping[str, Any] | Sequence[int] | int) -> str:
        """Take in an action, by number or name, and what was seen, as values by name or as a key.

        Return the status: ``ok``, or that nothing explains what was seen; the belief has moved on even so.
        """
        number = self.action(action) if isinstance(action, str) else action
        done = ctypes.c_int32(_in_range("action", number, -(2**31), 2**31 - 1))
        if isinstance(seen, Mapping):
            return self._status("update_named", done, ctypes.c_char_p(json.dumps(dict(seen)).encode()))
        return self._status("update", done, *_key(seen))

    def action(self, name: str) -> int:
        """Return the number of an action."""
        found = ctypes.c_int32()
        self._status("find_action", ctypes.c_char_p(_encoded("action", name)), ctypes.byref(found))
        return found.value

    def seen(self, key: Sequence[int] | int) -> dict[str, Any]:
        """Return the values by name that a key stands for."""
        words = _key(key)
        with self._open() as handle:
            found: dict[str, Any] = self._library.json("decode", handle, *words)
        return found

    def probability(self, variable: str, value: str | bool | int) -> float:
        """Return the probability of a value of a hidden variable, such as ``rock.good[3]``."""
        text = str(value).lower() if isinstance(value, bool) else str(value)
        found = ctypes.c_double()
        given = _encoded("variable", variable), _encoded("value", text)
        self._status("probability", *given, ctypes.byref(found))
        return found.value

    @property
    def belief(self) -> dict[str, dict[str, float] | Moments]:
        """The belief in each hidden variable: the probability of each value, or the moments of a float."""
        with self._open() as handle:
            found = self._library.json("belief", handle)
        return {
            one["variable"]: Moments(one["mean"], one["deviation"])
            if "mean" in one
            else {v["value"]: v["probability"] for v in one["values"]}
            for one in found
        }

    @property
    def info(self) -> dict[str, Any]:
        """The mode, threads and device of this planner, and why that is no GPU where one was asked for."""
        with self._open() as handle:
            found: dict[str, Any] = self._library.json("info", handle)
        return found

    def close(self) -> None:
        """Free the planner's memory; no call may follow but this one."""
        if self._handle is not None:
            with self._open() as handle:
                self._library.destroy(handle)
                self._handle = None

    def __enter__(self) -> Planner:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_handle", None) is not None:
            self.close()

    @contextmanager
    def _open(self) -> Iterator[ctypes.c_void_p]:
        """Give the handle, which no other thread can use or free meanwhile."""
        if not self._lock.acquire(blocking=False):
            raise PlannerError("busy", "planner: another thread's call is under way")
        try:
            if self._handle is None:
                raise PlannerError("wrong_argument", "the planner is closed")
            yield self._handle
        finally:
            self._lock.release()

    def _status(self, name: str, *arguments: Any) -> str:
        with self._open() as handle:
            return self._library.status_name(self._library.call(name, handle, *arguments))


def _key(key: Sequence[int] | int) -> tuple[Any, ctypes.c_size_t]:
    words = [key] if isinstance(key, int) else list(key)
    checked = [_in_range("key", word, 0, 2**64 - 1) for word in words]
    return (ctypes.c_uint64 * len(checked))(*checked), ctypes.c_size_t(len(checked))


def _encoded(name: str, text: str) -> bytes:
    """Return ``text`` for C, where it would end at a NUL."""
    if "\0" in text:
        raise PlannerError("wrong_argument", f"{name}: has a NUL")
    return text.encode()


def _in_range(name: str, value: int, low: int, high: int) -> int:
    """Return ``value``; ctypes would cut off what does not fit."""
    if not isinstance(value, int) or not low <= value <= high:
        raise PlannerError(
            "wrong_argument", f"{name}: expected an integer from {low} to {high}, found {value!r}"
        )
    return value
