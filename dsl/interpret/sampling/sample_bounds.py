# SPDX-License-Identifier: Apache-2.0
"""Checking the bounds in visited states, each state once and many at a time: bounds may cost a lot."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.values import Array, History, State
from hypgen.dsl.interpret.sampling.findings import Findings
from hypgen.dsl.interpret.sampling.watched_interpreter import WatchedInterpreter
from hypgen.dsl.messages import c_sampling

_BATCH = 16_384  # states that are evaluated at once
_MOST_REMEMBERED = 1_000_000  # states that are known to be checked


class BoundsCheck:
    """Takes visited states and finds bounds that are not numbers, or lie on the wrong side of each other."""

    def __init__(self, model: ir.Model, findings: Findings) -> None:
        self._model = model
        self._findings = findings
        self._seen: set[bytes] = set()
        self._waiting: list[tuple[State, History]] = []
        self._count = 0

    def add(self, state: State, history: History, active: Array) -> None:
        """Take the active lanes' states, and what the policy knew in them."""
        chosen = np.flatnonzero(np.broadcast_to(active, len(history["started"])))
        kept = history if self._model.lower is not None else {"started": history["started"]}
        self._waiting.append(
            ({n: v[chosen] for n, v in state.items()}, {n: v[chosen] for n, v in kept.items()})
        )
        self._count += len(chosen)
        if self._count >= _BATCH:
            self.flush()

    def flush(self) -> None:
        """Check what has been taken since the last time."""
        if not self._count:
            return
        states, histories = (_joined([pair[i] for pair in self._waiting]) for i in (0, 1))
        self._waiting, self._count = [], 0
        new = self._new([*states.values(), *(histories.values() if self._model.lower is not None else ())])
        if not len(new):
            return
        state = {name: values[new] for name, values in states.items()}
        history = {name: values[new] for name, values in histories.items()}
        run = WatchedInterpreter(self._model, self._findings, lanes=len(new))
        upper = run.upper(state)
        run.tail(state)
        if self._model.lower is None:
            return
        lower = run.lower(state, history)
        run.note(
            "lower",
            lambda lane, span: c_sampling.crossed_bounds(lower[lane], upper[lane], span),
            lower > upper,
            state,
            history,
        )

    def _new(self, arrays: list[Array]) -> npt.NDArray[np.int64]:
        """Return the lanes whose states were not checked before, one of each."""
        rows = np.concatenate([_bytes(a) for a in arrays], axis=1)
        if len(self._seen) > _MOST_REMEMBERED:
            self._seen.clear()
        new = []
        for lane, row in enumerate(rows):
            key = row.tobytes()
            if key not in self._seen:
                self._seen.add(key)
                new.append(lane)
        return np.asarray(new, dtype=np.int64)


def _bytes(values: Array) -> npt.NDArray[np.uint8]:
    rows = np.ascontiguousarray(values).reshape(len(values), -1)
    return rows.view(np.uint8)


def _joined(parts: list[State]) -> State:
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
