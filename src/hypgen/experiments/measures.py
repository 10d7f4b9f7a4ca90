# SPDX-License-Identifier: Apache-2.0
"""Quantities of an episode that a study shows beside its return."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hypgen.dsl import ir
from hypgen.dsl.interpret.value_text import action_text
from hypgen.dsl.messages.diagnostic import did_you_mean
from hypgen.experiments.suite_values import SuiteError, check_keys, is_number, text_of

_KINDS = ("visible", "action", "failure")
_MEASURE = ("name", *_KINDS, "times")


@dataclass(frozen=True)
class Measure:
    """A number of each episode, multiplied by ``times``.

    ``visible`` names a variable: its value at the end. ``action`` names an action: the steps that take it.
    Without both it is 1 where the episode ended by itself and without success, and else 0.
    """

    name: str
    visible: str = ""
    action: str = ""
    times: float = 1.0

    def of(self, actions: Mapping[str, int], episode: Mapping[str, Any]) -> float:
        """Return it for an episode: how often each action was taken, and the solver's line at the end."""
        if self.visible:
            return self.times * float(episode["visible"][self.visible])
        if self.action:
            return self.times * actions.get(self.action, 0)
        return self.times * (episode["terminal"] and not episode["success"])

    def check(self, model: ir.Model, where: str) -> None:
        """Refuse what a model does not have."""
        if self.visible:
            known = tuple(one.name for one in model.variables if one.visible and not one.indices)
            if self.visible not in known:
                nearest = did_you_mean(self.visible, known) or f"there are {', '.join(known) or 'none'}"
                raise SuiteError(
                    f"{where}: {model.name} has no visible variable `{self.visible}` of one value: {nearest}"
                )
        elif self.action:
            names = tuple(action_text(code, model.action) for code in range(model.action.count))
            if self.action not in names:
                nearest = did_you_mean(self.action, names)
                raise SuiteError(f"{where}: {model.name} has no action `{self.action}`. {nearest}".strip())
        elif model.success is None:
            raise SuiteError(f"{where}: {model.name} does not say what success is: `success when ..`")


def measure_of(text: Any, where: str) -> Measure:
    """Return the measure of an entry of a suite."""
    if not isinstance(text, dict):
        raise SuiteError(f"{where}: measures are written as [[study.measure]]")
    check_keys(text, _MEASURE, where)
    kinds = [kind for kind in _KINDS if kind in text]
    if len(kinds) != 1:
        raise SuiteError(f"{where}: expected one of `visible`, `action` and `failure = true`")
    if text.get("failure", True) is not True:
        raise SuiteError(f"{where}: `failure` is true")
    times = text.get("times", 1.0)
    if not is_number(times):
        raise SuiteError(f"{where}: `times` is a number")
    own = {kind: text_of(text, kind, where) for kind in kinds if kind != "failure"}
    return Measure(text_of(text, "name", where), **own, times=float(times))
