# SPDX-License-Identifier: Apache-2.0
"""A planner and its belief, over a library of the model."""

from __future__ import annotations

import ctypes
import math
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

from hypgen.api import html
from hypgen.api.arguments import encoded, encoded_object, in_range, real, words
from hypgen.api.c_interface import CDecision, CLibrary, COptions, PlannerError
from hypgen.api.fields import read_fields


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

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the action, the bounds and the work of the search."""
        rows = (
            ("action", f"{self.name} (number {self.action})"),
            ("status", self.status),
            ("bounds", f"{self.lower:.6g} .. {self.upper:.6g}"),
            ("time", f"{self.seconds:.3g} s"),
            ("trials", self.trials),
            ("expansions", self.expansions),
            ("scenarios", self.scenarios),
            ("depth", self.max_depth),
        )
        return html.table("decision", rows)


@dataclass(frozen=True)
class Moments:
    """The belief in a float."""

    mean: float
    deviation: float


class Planner:
    """A planner and its belief; ``Solver.planner`` makes one.

    A wrong call raises ``PlannerError``. One thread uses a planner at a time.
    """

    def __init__(self, library: CLibrary, settings: str, params: bytes | None) -> None:
        self._library = library
        self._handle: ctypes.c_void_p | None = None
        self._lock = threading.Lock()  # held by each call that has the handle
        self._life = threading.RLock()  # held while the handle is freed, or used beside a call
        handle = ctypes.c_void_p()
        options = COptions(ctypes.sizeof(COptions), encoded("settings", settings), params)
        description = library.json("describe", library.model)
        self._variables: int = description["variables"]
        self._hidden: list[dict[str, Any]] = description["hidden"]
        self.actions: tuple[str, ...] = tuple(description["actions"])
        self.visible_fields = read_fields(description["visible"])
        self.seen_fields = read_fields(description["seen"])
        library.call("create", library.model, ctypes.byref(options), ctypes.byref(handle))
        self._handle = handle

    def reset(self, visible: Mapping[str, Any] | Sequence[int] | None = None, *, episode: int = 0) -> str:
        """Start an episode; ``visible`` has first values that the model draws, or all. Return the status.

        They come by name, or all of them as the numbers of the C interface. ``episode`` names the random
        numbers of belief and search.
        """
        number = ctypes.c_uint64(in_range("episode", episode, 0, 2**64 - 1))
        if isinstance(visible, Sequence):
            codes = [in_range("visible", value, -(2**31), 2**31 - 1) for value in visible]
            return self._status(
                "reset", (ctypes.c_int32 * len(codes))(*codes), ctypes.c_size_t(len(codes)), number
            )
        text = encoded_object("visible", {} if visible is None else visible)
        return self._status("reset_named", ctypes.c_char_p(text), number)

    def plan(self, seconds: float = 0.0, *, deadline: float | None = None) -> Decision:
        """Decide within so many seconds; 0: the settings' time, or what an update left of their period.

        Ctrl-C is heard when the plan has ended; a plan without a limit belongs in a thread of its own.
        ``deadline`` is a time of ``time.monotonic()``, and goes before ``seconds``.
        """
        found = CDecision(size=ctypes.sizeof(CDecision))
        if deadline is None:
            status = self._status("plan", ctypes.c_double(real("seconds", seconds)), ctypes.byref(found))
        else:
            end = in_range("deadline", int(real("deadline", deadline) * 1e9), -(2**63), 2**63 - 1)
            status = self._status("plan_until", ctypes.c_int64(end), ctypes.byref(found))
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

    def cancel(self) -> None:
        """End the plan that another thread has under way, as its deadline would. From any thread.

        Before the plan has begun this does nothing, so repeat it until the plan returns.
        """
        with self._life:
            if self._handle is not None:
                self._library.cancel(self._handle)

    def warm_up(self, seconds: float = 0.0) -> str:
        """Play a step that counts nowhere, before an episode; return its plan's status.

        Memory has been touched then, and the device is awake: the first plan takes no longer than later ones.
        """
        return self._status("warm_up", ctypes.c_double(real("seconds", seconds)))

    def update(self, action: int | str, seen: Mapping[str, Any] | Sequence[int] | int) -> str:
        """Take in an action, by number or name, and what was seen, as values by name or as a key.

        Return the status: ``ok``, or that nothing explains what was seen; the belief has moved on even so.
        """
        number = self.action(action) if isinstance(action, str) else action
        done = ctypes.c_int32(in_range("action", number, 0, len(self.actions) - 1))
        if isinstance(seen, Mapping):
            return self._status("update_named", done, ctypes.c_char_p(encoded_object("seen", seen)))
        return self._status("update", done, *_key("seen", seen))

    def action(self, name: str) -> int:
        """Return the number of an action."""
        found = ctypes.c_int32()
        self._status("find_action", ctypes.c_char_p(encoded("action", name)), ctypes.byref(found))
        return found.value

    def seen(self, key: Sequence[int] | int) -> dict[str, Any]:
        """Return the values by name that a key stands for."""
        given = _key("key", key)
        with self._open() as handle:
            found: dict[str, Any] = self._library.json("decode", handle, *given)
        return found

    def probability(self, variable: str, value: str | bool | int) -> float:
        """Return the probability of a value of a hidden variable, such as ``rock.good[3]``."""
        text = str(value).lower() if isinstance(value, bool) else str(value)
        found = ctypes.c_double()
        given = encoded("variable", variable), encoded("value", text)
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

    def tree(self, *, depth: int = 2, top: int = 10, nodes: int = 5000) -> dict[str, Any]:
        """Return the tree that the last plan decided by, to so many levels of actions.

        It has at most so many ``nodes``, beliefs and actions: what is below the beliefs that most trials
        entered. What is left out is counted by ``actions_left_out`` and ``groups_left_out``.

        Each node has ``lower`` and ``upper``, the bounds of what it is worth itself, ``scenarios`` and
        ``visits``. It has ``actions``, the ``top`` that trials took most. An action has ``groups``: nodes by
        what is ``seen``, those that most scenarios see, with their ``share``. Where ``pruning`` is above 0,
        bounds are less that for each node below, divided by the node's discount and share of all scenarios.
        """
        levels = ctypes.c_int32(in_range("depth", depth, 0, 2**31 - 1))
        most = ctypes.c_int32(in_range("top", top, 1, 2**31 - 1))
        room = ctypes.c_int32(in_range("nodes", nodes, 1, 2**31 - 1))
        with self._open() as handle:
            found: dict[str, Any] = self._library.json("tree", handle, levels, most, room)
        return found

    def sample_belief(self, count: int, *, seed: int = 0) -> dict[str, npt.NDArray[Any]]:
        """Draw states from the belief; return the values of each hidden variable, an array by state.

        An array variable has its dimensions after that of the states. Values of enums and records are
        codes: places in the "values" of ``Solver.description``.
        """
        number = in_range("count", count, 1, 2**31 - 1)
        size = number * self._variables
        values = np.empty(size, np.int32)
        self._status(
            "sample_belief",
            ctypes.c_uint64(in_range("seed", seed, 0, 2**64 - 1)),
            ctypes.c_size_t(number),
            values.ctypes.data_as(ctypes.POINTER(ctypes.c_int32)),
            ctypes.c_size_t(size),
        )
        return columns(values.reshape(number, self._variables), self._hidden)

    @property
    def info(self) -> dict[str, Any]:
        """The mode, threads and device of this planner, and why that is no GPU where one was asked for.

        ``units`` has the health of each part of the belief: its particles, their effective number, their
        distinct values, the last surprise in bits, and whether it is depleted.
        """
        with self._open() as handle:
            found: dict[str, Any] = self._library.json("info", handle)
        return found

    def close(self) -> None:
        """Free the planner's memory; no call may follow but this one."""
        if self._handle is not None:
            with self._open() as handle, self._life:
                self._handle = None  # first: an interrupt must not free it twice
                self._library.destroy(handle)

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


def columns(
    values: npt.NDArray[np.int32], fields: Sequence[Mapping[str, Any]]
) -> dict[str, npt.NDArray[Any]]:
    """Return the values of each field of a description, of rows that have all variables."""
    found: dict[str, npt.NDArray[Any]] = {}
    for field in fields:
        dims: list[int] = field["dims"]
        part = values[:, field["first"] : field["first"] + math.prod(dims)].reshape(-1, *dims)
        match field["type"]:
            case "float":
                found[field["name"]] = np.ascontiguousarray(part).view(np.float32)
            case "bool":
                found[field["name"]] = part != 0
            case _:
                found[field["name"]] = part.copy()
    return found


def _key(name: str, key: Sequence[int] | int) -> tuple[Any, ctypes.c_size_t]:
    checked = words(name, key)
    return (ctypes.c_uint64 * len(checked))(*checked), ctypes.c_size_t(len(checked))
