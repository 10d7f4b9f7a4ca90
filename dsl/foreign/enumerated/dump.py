# SPDX-License-Identifier: Apache-2.0
"""An enumerated model, as the exact solver writes it: JSON lines, whose form ``exact/dump.hpp`` states."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, field

Outcome = tuple[int, int, float]  # observation, next state, probability


@dataclass
class Enumerated:
    """States, what each action leads to in each, and the beliefs that an episode may start with.

    ``starts`` are beliefs and their probabilities, ``classes[state]`` numbers states that look alike, which
    follow one another. ``rows[state]`` has (reward, outcomes) by action, for those that are legal. What the
    probabilities of a row lack of 1 ends the episode. ``policy_hash`` is how files of policies begin.
    """

    name: str
    discount: float
    variables: list[str]
    actions: list[str]
    observations: list[str]
    policy_hash: int
    starts: list[list[tuple[int, float]]] = field(default_factory=list)
    start_probabilities: list[float] = field(default_factory=list)
    classes: list[int] = field(default_factory=list)
    values: list[list[str]] = field(default_factory=list)
    steps: list[int] = field(default_factory=list)
    rows: list[dict[int, tuple[float, list[Outcome]]]] = field(default_factory=list)


def read(lines: Iterable[str]) -> Enumerated:
    """Return the model that the lines tell; raises ``ValueError`` if they end early."""
    model: Enumerated | None = None
    for line in lines:
        item = json.loads(line)
        if item["type"] == "model":
            model = Enumerated(
                item["name"],
                item["discount"],
                item["variables"],
                item["actions"],
                item["observations"],
                item["policy_hash"],
            )
            continue
        if model is None:
            break
        match item["type"]:
            case "start":
                model.starts.append([(s, p) for s, p in item["belief"]])
                model.start_probabilities.append(item["probability"])
            case "state":
                model.values.append(item["values"])
                model.classes.append(item["class"])
                model.rows.append({})
                if "step" in item:
                    model.steps.append(item["step"])
            case "row":
                outcomes = [(o, n, p) for o, n, p in item["outcomes"]]
                model.rows[item["state"]][item["action"]] = (item["reward"], outcomes)
            case "end":
                return model
    raise ValueError("the enumerated model is incomplete")
