# SPDX-License-Identifier: Apache-2.0
"""Simulated worlds as environments of Gymnasium, alone and side by side.

Gymnasium is the extra ``gym`` of hypgen. Its wrappers and checkers ask for its own classes, so that an
environment without it would be of little use; ``Worlds`` needs numpy alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Box, Discrete
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from hypgen.api.c_interface import PlannerError
from hypgen.api.worlds import NEXT_EPISODE, Worlds

Array = npt.NDArray[Any]


class Observations:
    """Observations as arrays: a row of all visible variables, then all that was seen, each in order.

    Rows are of int32 where no value is a float, otherwise of float64, which has all values exactly. Bools are
    0 and 1, and enums are codes. Where nothing was seen, at the start and at the end, each value is the least
    of its type.
    """

    def __init__(self, worlds: Worlds) -> None:
        fields = (*worlds.visible_fields, *worlds.seen_fields)
        self.names = [name for field in fields for name in field.names]
        each = [field for field in fields for _ in range(field.length)]
        self._is_float = np.array([field.type == "float" for field in each], bool)
        self._type: type[Any] = np.float64 if self._is_float.any() else np.int32
        low = np.array([field.low for field in each], self._type)
        self.space = Box(low, np.array([field.high for field in each], self._type), dtype=self._type)

    def of(self, worlds: Worlds) -> Array:
        """Return what each world shows, in a new array."""
        codes = np.empty((worlds.count, len(self.names)), np.int32)
        width = worlds.visible.shape[1]
        if worlds.count > len(self.names):  # rows are short: numpy copies columns several times as fast
            for i, column in enumerate((*worlds.visible.T, *worlds.seen.T)):
                codes[:, i] = column
        else:
            codes[:, :width], codes[:, width:] = worlds.visible, worlds.seen
        if self._type is np.int32:
            return codes
        return np.where(self._is_float, codes.view(np.float32), codes).astype(np.float64)


class WorldEnv(gymnasium.Env[Array, int]):
    """A simulated world as an environment; ``Solver.env`` makes it.

    ``info["action_mask"]`` has 1 for each legal action. Others raise ``PlannerError`` and change nothing.
    An episode is truncated at its last step, or where no action is legal.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, worlds: Worlds, steps: int | None) -> None:
        self._worlds = worlds
        self._limit = _limit(worlds, steps)
        self._elapsed = 0
        self._observations = Observations(worlds)
        self.observation_space = self._observations.space
        self.action_space = Discrete(len(worlds.actions))

    @property
    def actions(self) -> tuple[str, ...]:
        """The names of the actions."""
        return self._worlds.actions

    @property
    def names(self) -> list[str]:
        """The name of each value of an observation."""
        return self._observations.names

    @property
    def visible(self) -> dict[str, Any]:
        """The visible variables by name, as ``Planner.reset`` takes them."""
        return self._worlds.visible_by_name()

    @property
    def seen(self) -> dict[str, Any]:
        """What the last step has shown by name, as ``Planner.update`` takes it."""
        return self._worlds.seen_by_name()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start the next episode; with a seed, its first. ``options={"episode": e}`` chooses one."""
        super().reset(seed=seed)
        episode = _option("episode", options)
        if seed is not None:
            self._worlds.seed(seed)
        self._worlds.reset(None if episode is None else [episode])
        self._elapsed = 0
        return self._observations.of(self._worlds)[0], self._info()

    def step(self, action: int) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Do an action, by its number."""
        worlds = self._worlds
        worlds.step([worlds.action(action)])
        self._elapsed += 1
        terminated = bool(worlds.terminal[0])
        is_over = self._elapsed >= self._limit or not worlds.legal.any()
        info = {**self._info(), "success": bool(worlds.success[0])}
        observation = self._observations.of(worlds)[0]
        return observation, float(worlds.rewards[0]), terminated, is_over and not terminated, info

    def close(self) -> None:
        """Free the world."""
        self._worlds.close()

    def _info(self) -> dict[str, Any]:
        return {"action_mask": self._worlds.legal[0].copy()}


class WorldVectorEnv(VectorEnv[Array, Array, Array]):
    """Simulated worlds as a vectorised environment; ``Solver.vector_env`` makes it. A step is one call of C.

    The step after an episode's last one starts the world's next episode, whatever the action
    (``AutoresetMode.NEXT_STEP``). ``info`` has ``action_mask``, a row for each world, and ``success``. An
    illegal action raises ``PlannerError``, and no world moves.
    """

    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": []}

    def __init__(self, worlds: Worlds, steps: int | None) -> None:
        self._worlds = worlds
        self._limit = _limit(worlds, steps)
        self._observations = Observations(worlds)
        self.num_envs = worlds.count
        self.single_observation_space = self._observations.space
        self.single_action_space = Discrete(len(worlds.actions))
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._elapsed = np.zeros(self.num_envs, np.int64)
        self._is_over = np.zeros(self.num_envs, bool)
        self._all = np.ones(self.num_envs, bool)

    @property
    def actions(self) -> tuple[str, ...]:
        """The names of the actions."""
        return self._worlds.actions

    @property
    def names(self) -> list[str]:
        """The name of each value of an observation."""
        return self._observations.names

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start the next episode of each world. With a seed, world i starts episode i of that seed.

        ``options={"episodes": [..]}`` chooses them by number.
        """
        episodes = _option("episodes", options)
        if seed is not None:
            if not isinstance(seed, int):
                raise ValueError("seed: expected one integer for all worlds, which differ by episode")
            super().reset(seed=seed)
            self._worlds.seed(seed)
        self._worlds.reset(episodes)
        self._elapsed[:] = 0
        self._is_over[:] = False
        return self._observations.of(self._worlds), self._info()

    def step(self, actions: Array) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        """Do an action in each world, by its number."""
        worlds = self._worlds
        if np.shape(actions) != (self.num_envs,):  # which numpy would repeat for all worlds
            text = f"actions: expected {self.num_envs} integers, found shape {np.shape(actions)}"
            raise PlannerError("wrong_argument", text)
        given = np.where(self._is_over, NEXT_EPISODE, actions)
        if np.count_nonzero(given == NEXT_EPISODE) != np.count_nonzero(self._is_over):
            raise PlannerError(
                "wrong_argument", "actions: NEXT_EPISODE is for Worlds: an environment starts episodes itself"
            )
        worlds.step(given)
        self._elapsed = np.where(self._is_over, 0, self._elapsed + 1)
        terminated = worlds.terminal.copy()
        truncated = ~terminated & ((self._elapsed >= self._limit) | ~self._can_go_on(terminated))
        self._is_over = terminated | truncated
        info = {**self._info(), "success": worlds.success.copy(), "_success": self._all.copy()}
        return self._observations.of(worlds), worlds.rewards.copy(), terminated, truncated, info

    def close_extras(self, **kwargs: Any) -> None:
        """Free the worlds."""
        self._worlds.close()

    def _can_go_on(self, terminated: Array) -> Array:
        """Return which worlds have a legal action, or have ended. Most have one among the first."""
        found = terminated.copy()
        for is_legal in self._worlds.legal.T:
            if found.all():
                break
            found |= is_legal.view(bool)
        return found

    def _info(self) -> dict[str, Any]:
        return {"action_mask": self._worlds.legal.copy(), "_action_mask": self._all.copy()}


def _limit(worlds: Worlds, steps: int | None) -> float:
    """Return the number of an episode's last step: the model's horizon, or less."""
    if steps is not None and steps < 1:
        raise ValueError(f"steps: expected at least 1, found {steps}")
    return min(steps or np.inf, worlds.horizon or np.inf)


def _option(name: str, options: dict[str, Any] | None) -> Any:
    """Return the only option of a reset, None where it is not given."""
    wrong = set(options or {}) - {name}
    if wrong:
        raise ValueError(f"options: expected {name}, found {', '.join(sorted(wrong))}")
    return (options or {}).get(name)
