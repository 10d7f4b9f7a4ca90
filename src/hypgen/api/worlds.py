# SPDX-License-Identifier: Apache-2.0
"""Simulated worlds of a model, beside each other in arrays of numpy."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

from hypgen.api.arguments import encoded, encoded_object, in_range
from hypgen.api.c_interface import CLibrary, CWorldsOptions, CWorldsResults, PlannerError
from hypgen.api.fields import Codes, named, read_fields

NEXT_EPISODE = -(2**31)  # HYPGEN_NEXT_EPISODE: in place of an action, starts a world's next episode


class Worlds:
    """Simulated worlds of one model, moved by one call; ``Solver.worlds`` makes them.

    Episode e of a seed is run e of the solver with that seed. World i of n plays the episodes i, i + n, and
    so on. A wrong call raises ``PlannerError``, and moves no world. One thread uses them at a time.

    A call leaves its results in the arrays below, which have an entry or a row for each world. The next call
    overwrites them.
    """

    NEXT_EPISODE = NEXT_EPISODE

    def __init__(
        self,
        library: CLibrary,
        count: int,
        seed: int,
        params: bytes | None,
        start: Mapping[str, Any] | None = None,
        device: str = "cpu",
    ) -> None:
        self._library = library
        self._handle: ctypes.c_void_p | None = None
        self._lock = threading.Lock()  # held by each call that has the handle
        description = library.json("describe", library.model)
        self.actions: tuple[str, ...] = tuple(description["actions"])
        self.discount: float = description["discount"]
        self.horizon: int | None = description["horizon"]
        self.visible_fields = read_fields(description["visible"])
        self.seen_fields = read_fields(description["seen"])
        self.count = in_range("count", count, 1, 2**24)

        def rows(width: int, kind: type[Any]) -> npt.NDArray[Any]:
            return np.zeros((count, width), kind)

        self.rewards: npt.NDArray[np.float64] = np.zeros(count)  # NaN where the model's reward is none
        self.seen: Codes = rows(sum(f.length for f in self.seen_fields), np.int32)
        self.keys: npt.NDArray[np.uint64] = rows(description["key_words"], np.uint64)
        self.visible: Codes = rows(sum(f.length for f in self.visible_fields), np.int32)
        self.legal: npt.NDArray[np.int8] = rows(len(self.actions), np.int8)  # 1: allowed next
        self.terminal: npt.NDArray[np.bool_] = np.zeros(count, bool)
        self.success: npt.NDArray[np.bool_] = np.zeros(count, bool)
        self._actions: Codes = np.zeros(count, np.int32)

        least = [0 if f.type == "float" else int(f.low) for f in self.seen_fields for _ in range(f.length)]
        self._nothing = np.array(least, np.int32)  # what `seen` is where nothing was seen
        # C writes there by address: the arrays stay, even where a caller puts others in their place.
        self._arrays = arrays = (
            self.rewards,
            self.seen,
            self.keys,
            self.visible,
            self.legal,
            self.terminal,
            self.success,
        )
        self._results = CWorldsResults(ctypes.sizeof(CWorldsResults), *(a.ctypes.data for a in arrays))
        self._count = ctypes.c_size_t(count)
        self._step_arguments = _pointer(self._actions), self._count, ctypes.byref(self._results)

        options = CWorldsOptions(
            # Libraries of before GPUs had worlds know the options up to that.
            CWorldsOptions.device.offset if device == "cpu" else ctypes.sizeof(CWorldsOptions),
            count,
            in_range("seed", seed, 0, 2**64 - 1),
            params,
            encoded("device", device),
        )
        handle = ctypes.c_void_p()
        library.call("worlds_create", library.model, ctypes.byref(options), ctypes.byref(handle))
        self._handle = handle
        if start is not None:
            self.start(start)

    def start(self, values: Mapping[str, Any] | None) -> None:
        """Let episodes that begin later start with these values of variables, hidden ones too, by name.

        A name is a variable's or an entry's, ``rock.good[3]``. What is left out is drawn, and what depends
        on given values follows from these. None: as the model says.
        """
        text = None if values is None else encoded_object("start", values)
        with self._open() as handle:
            self._library.call("worlds_start", handle, ctypes.c_char_p(text))

    def seed(self, seed: int) -> None:
        """End all episodes. Later ones draw by this seed, and are numbered afresh."""
        number = ctypes.c_uint64(in_range("seed", seed, 0, 2**64 - 1))
        with self._open() as handle:
            self._library.call("worlds_seed", handle, number)
        self.legal[:] = 0

    def reset(self, episodes: Sequence[int] | None = None, mask: npt.NDArray[np.bool_] | None = None) -> None:
        """Start an episode in each world, or in those of ``mask``.

        ``episodes`` has the number for each world, from which its next ones count on. Without it, each
        starts its next one.
        """
        chosen = None if mask is None else np.ascontiguousarray(np.broadcast_to(mask, self.count), bool)
        numbers = None
        if episodes is not None:
            checked = [in_range("episode", number, 0, 2**32 - 1) for number in episodes]
            if len(checked) != self.count:
                text = f"episodes: expected {self.count} numbers, found {len(checked)}"
                raise PlannerError("wrong_argument", text)
            numbers = np.array(checked, np.uint64)
        with self._open() as handle:
            call = self._library.call
            call("worlds_reset", handle, _pointer(chosen), _pointer(numbers), self._count)
            call("worlds_visible", handle, _pointer(self.visible), self._count)
            call("worlds_legal", handle, _pointer(self.legal), self._count)
        begun = slice(None) if chosen is None else chosen
        self.seen[begun] = self._nothing
        for array in (self.rewards, self.keys, self.terminal, self.success):
            array[begun] = 0

    def step(self, actions: npt.ArrayLike) -> None:
        """Do an action in each world; ``Worlds.NEXT_EPISODE`` starts its next episode instead."""
        given = np.asarray(actions)
        if given.shape != (self.count,) or given.dtype.kind not in "iu":
            text = f"actions: expected {self.count} integers, found shape {given.shape} of {given.dtype}"
            raise PlannerError("wrong_argument", text)
        if (
            given.dtype.itemsize > 4 or given.dtype == np.uint32
        ):  # which could change their meaning in 32 bits
            limits = np.iinfo(np.int32)
            if given.min() < limits.min or given.max() > limits.max:
                raise PlannerError("wrong_argument", "actions: one of them is no number of an action")
        with self._open() as handle:
            np.copyto(self._actions, given, casting="unsafe")
            self._library.call("worlds_step", handle, *self._step_arguments)

    def action(self, action: int | str) -> int:
        """Return the number of an action that is given by number or name."""
        if not isinstance(action, str):
            return in_range("action", action, 0, len(self.actions) - 1)
        if action not in self.actions:
            some = ", ".join(self.actions[:10]) + (", ..." if len(self.actions) > 10 else "")
            raise PlannerError("wrong_argument", f"no action is named {action}; the actions are: {some}")
        return self.actions.index(action)

    def visible_by_name(self, world: int = 0) -> dict[str, Any]:
        """Return a world's visible variables, as ``Planner.reset`` takes them."""
        return named(self.visible_fields, self.visible[world])

    def seen_by_name(self, world: int = 0) -> dict[str, Any]:
        """Return what a world's last step has shown, as ``Planner.update`` takes it."""
        return named(self.seen_fields, self.seen[world])

    def close(self) -> None:
        """Free the worlds' memory; no call may follow but this one."""
        if self._handle is not None:
            with self._open() as handle:
                self._handle = None  # first: an interrupt must not free it twice
                self._library.destroy(handle, "worlds_destroy")

    def __enter__(self) -> Worlds:
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
            raise PlannerError("busy", "worlds: another thread's call is under way")
        try:
            if self._handle is None:
                raise PlannerError("wrong_argument", "the worlds are closed")
            yield self._handle
        finally:
            self._lock.release()


def _pointer(array: npt.NDArray[Any] | None) -> ctypes.c_void_p | None:
    """Return where an array's values lie; it must outlive the call."""
    return None if array is None else ctypes.c_void_p(array.ctypes.data)
