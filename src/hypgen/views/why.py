# SPDX-License-Identifier: Apache-2.0
"""Why a step's action was taken, in words made from the numbers that the search compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hypgen.views.texts import number


def why(step: Mapping[str, Any]) -> str:
    """Return why a step's action was taken, and what its bounds leave open.

    ``step`` is a step of a recording. Bounds of actions are those of its tree's root. Gains are in units of
    the reward.
    """
    chosen, default = step["action"], step.get("default_action")
    root = step.get("tree") or {}
    actions: Sequence[Mapping[str, Any]] = root.get("actions", ())
    own = next((one for one in actions if one["name"] == chosen), None)
    if own is None:
        return " ".join([_without_tree(step), *_compared(step)])
    others = [one for one in actions if one is not own]
    said = [*_first(own, others, default), *_default(chosen, default, own, others), *_compared(step)]
    if left_out := root.get("actions_left_out", 0):
        said.append(
            f"{_count(left_out, 'action')} that fewer trials took {_are(left_out)} not compared here."
        )
    return " ".join(said)


def _without_tree(step: Mapping[str, Any]) -> str:
    chosen, default = step["action"], step.get("default_action")
    ended = f" The search ended with the status {step['status']}." if step.get("status", "ok") != "ok" else ""
    if step.get("looked") == "one_step" or (chosen != default and step.get("lower") is not None):
        return f"{chosen} came first among actions before the default policy. No tree decided.{ended}"
    if chosen == default:
        return f"{chosen} is what the default policy does. No tree was searched.{ended}"
    return f"There is no tree that says why {chosen} was taken.{ended}"


def _compared(step: Mapping[str, Any]) -> list[str]:
    """Say what paired rollouts found: gains over the default policy's action, in units of their errors."""
    default = step.get("default_action")
    compared = [one for one in step.get("compared") or () if one["name"] != default]
    if not compared or default is None:
        return []
    order = sorted(compared, key=lambda one: float(one["gain"]), reverse=True)
    own = next((one for one in compared if one["name"] == step["action"]), None)
    second = next((one for one in order if one is not own), None)
    said = []
    if own is not None:
        said.append(f"In paired rollouts it earned {_gain(own)} than {default}.")
    if second is not None:
        said.append(f"{second['name']} earned {_gain(second)} than {default}.")
    return said


def _gain(one: Mapping[str, Any]) -> str:
    gain, error = float(one["gain"]), one.get("standard_error")
    size = f"{number(abs(gain))} {'more' if gain >= 0 else 'less'}"
    return f"{size} ({number(abs(gain) / error)} standard errors)" if error else size


def _first(own: Mapping[str, Any], others: Sequence[Mapping[str, Any]], default: str | None) -> list[str]:
    """Compare an action with the second best, and say whether the bounds decide between all."""
    name = own["name"]
    if not others:
        return [f"{name} is the only action that was compared."]
    quantity, key = _quantity(own)
    known = [one for one in others if one.get(key) is not None]
    if own.get(key) is None or not known:
        return [f"The {quantity} of {name} is not known."]
    second = max(known, key=lambda one: float(one[key]))
    gain = own[key] - second[key]
    if gain > 0:
        said = f"{name} has the largest {quantity}: {number(own[key])}, which is {number(gain)} more than"
        said += f" that of the second, {second['name']}."
    elif gain == 0:
        said = f"{name} and {second['name']} have the same {quantity}, {number(own[key])}."
        if name == default:
            said += " Ties go to the default policy's action."
    else:
        said = f"{name} was taken, though the {quantity} of {second['name']} is {number(-gain)} larger:"
        said += " what was compared before the tree grew counts, too."
    return [said, *_decided(own, others)]


def _decided(own: Mapping[str, Any], others: Sequence[Mapping[str, Any]]) -> list[str]:
    bounded = [one for one in others if one.get("upper") is not None]
    if own.get("lower") is None or not bounded:
        return []
    rival = max(bounded, key=lambda one: float(one["upper"]))
    room = rival["upper"] - own["lower"]
    if room <= 0:
        return ["The bounds decide: no other action here has an upper bound above that."]
    return [
        f"The bounds do not decide: {rival['name']} may be worth up to {number(rival['upper'])}, "
        f"{number(room)} above the lower bound of {own['name']}."
    ]


def _default(
    chosen: str, default: str | None, own: Mapping[str, Any], others: Sequence[Mapping[str, Any]]
) -> list[str]:
    if default is None:
        return []
    if chosen == default:
        return ["The default policy would do the same."]
    its = next((one for one in others if one["name"] == default), None)
    quantity, key = _quantity(own)
    if its is None or its.get(key) is None or own.get(key) is None:
        return [f"The default policy would do {default}, which is not among the actions compared here."]
    gain = own[key] - its[key]
    side = "more" if gain >= 0 else "less"
    return [f"The default policy would do {default}: the {quantity} promises {number(abs(gain))} {side}."]


def _quantity(action: Mapping[str, Any]) -> tuple[str, str]:
    """Return by what actions were compared, in words and in the tree: `pomcp` has means."""
    return ("mean return", "mean") if action.get("mean") is not None else ("lower bound", "lower")


def _count(many: int, what: str) -> str:
    return f"{many} {what}{'' if many == 1 else 's'}"


def _are(many: int) -> str:
    return "is" if many == 1 else "are"
