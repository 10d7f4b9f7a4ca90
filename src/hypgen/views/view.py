# SPDX-License-Identifier: Apache-2.0
"""All that a page shows of an episode, as plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hypgen.dsl import ir
from hypgen.dsl.interpret.value_text import index_texts
from hypgen.views import trees
from hypgen.views.why import why

VERSION = 1
MOST_NODES = 5_000  # of a decision
ALL_NODES = 60_000  # of a page, which has some 10 MB then
_MARGINALS, _LIKELIEST = 400, 5  # of a step, and values of one

_KEPT = (
    "step",
    "action",
    "default_action",
    "reward",
    "terms",
    "seen",
    "state",
    "status",
    "looked",
    "lower",
    "upper",
    "trials",
    "nodes",
    "expansions",
    "max_depth",
    "scenarios",
    "truth",
    "belief",
    "belief_shown",
    "belief_total",
    "marginals_left_out",
)


def view_of(
    header: Mapping[str, Any],
    steps: Sequence[Mapping[str, Any]],
    end: Mapping[str, Any] | None = None,
    *,
    scene: Mapping[str, Any] | None = None,
    notes: Sequence[str] = (),
) -> dict[str, Any]:
    """Return what a page shows of an episode.

    ``header`` is that of a recording, and ``steps`` are those of ``shown_step``. ``end`` has the ``state``
    and shapes after the last step. Without ``scene`` the page shows variables alone. ``notes`` say what is
    missing.
    """
    discount = header.get("discount", 1.0)
    later = None if header.get("ended") is None else 0.0  # what is not recorded is not known
    earned = _earned([step.get("reward") for step in steps], discount, later)
    shown = [{**step, "earned": one} for step, one in zip(steps, earned, strict=True)]
    said = list(notes)
    if cut := [one["tree_shown"] for one in shown if one["tree"] and one["tree_shown"] < one["tree_total"]]:
        said.append(f"Trees are cut to their most visited nodes, {max(cut)} at most.")
    if header.get("ended") == "step_limit":
        said.append("The episode was cut off by its step limit: what it would have earned later is missing.")
    if not any(one["tree"] for one in shown):
        said.append("No step has a search tree.")
    if scene is None:
        said.append("The model has no draw declarations: its variables stand in a table.")
    said.append("Bounds are those of the search: they hold up to the error of its scenarios.")
    return {
        "version": VERSION,
        "model": {key: header.get(key) for key in ("name", "hash", "file")},
        "options": header.get("options", {}),
        "discount": discount,
        "episode": header.get("episode", 0),
        "ended": header.get("ended"),
        "first": header.get("first", 0),
        "scene": scene,
        "steps": shown,
        "end": dict(end) if end is not None else None,
        "notes": said,
    }


def most_nodes(steps: int) -> int:
    """Return to how many nodes each tree of a page of so many steps is cut."""
    return max(1, min(MOST_NODES, ALL_NODES // max(1, steps)))


def shown_step(
    step: Mapping[str, Any], most: int, entries: Mapping[str, Sequence[str]] | None = None
) -> dict[str, Any]:
    """Return what a page shows of a step: its tree cut to ``most`` nodes, its marginals beside what is true.

    ``step`` is that of a recording, with the shapes of the scene as ``truth`` and ``belief``. ``entries`` has
    the names of each array's entries, row-major.
    """
    found: dict[str, Any] = {key: step[key] for key in _KEPT if key in step}
    tree = step.get("tree")
    size = trees.size(tree) if tree else 0
    truth = _truth(step.get("state", {}), entries or {})
    found["tree"] = tree if tree is None or size <= most else trees.cut(tree, most)
    found["tree_total"], found["tree_shown"] = max(size, step.get("tree_total", 0)), min(size, most)
    marginals = [_beside_truth(one, truth) for one in step.get("marginals") or ()]
    found["believed"] = _believed(marginals)
    found["marginals"] = [_likeliest(one) for one in marginals[:_MARGINALS]]
    if len(marginals) > _MARGINALS:
        found["marginals_left_out"] = len(marginals) - _MARGINALS
    found["seconds"] = {"update": step.get("update_seconds"), "search": step.get("search_seconds")}
    found["effective"] = step.get("effective_sample_size")
    found["why"] = why(step)
    return found


def _beside_truth(marginal: Mapping[str, Any], truth: Mapping[str, Any]) -> dict[str, Any]:
    """Return a marginal with what is ``true`` and the probability ``believed`` of that.

    A float has no such probability. A value that the marginal lacks counts as impossible.
    """
    if marginal["variable"] not in truth:
        return dict(marginal)
    found = {**marginal, "true": truth[marginal["variable"]]}
    if "values" in marginal:
        same = [one["probability"] for one in marginal["values"] if _same(one["value"], found["true"])]
        found["believed"] = sum(same)
    return found


def _likeliest(marginal: Mapping[str, Any]) -> dict[str, Any]:
    """Return a marginal with its likeliest values, likeliest first."""
    found = dict(marginal)
    if "values" in found:
        found["values"] = sorted(found["values"], key=lambda one: -one["probability"])[:_LIKELIEST]
        if (left_out := len(marginal["values"]) - _LIKELIEST) > 0:
            found["values_left_out"] = left_out
    return found


def _believed(marginals: Sequence[Mapping[str, Any]]) -> dict[str, Any] | None:
    """Return how probable the belief holds the true values: their mean, the least, and whose that is."""
    found = [(one["believed"], one["variable"]) for one in marginals if "believed" in one]
    if not found:
        return None
    least, variable = min(found)
    return {"mean": sum(p for p, _ in found) / len(found), "least": least, "variable": variable}


def _same(value: Any, truth: Any) -> bool:
    """Return whether a value of a marginal, as solvers print it, is the true one."""
    return str(value) == (str(truth).lower() if isinstance(truth, bool) else str(truth))


def _earned(rewards: Sequence[float | None], discount: float, later: float | None) -> list[float | None]:
    """Return the discounted return from each step on; ``later`` follows, and None is unknown."""
    found: list[float | None] = []
    for reward in reversed(rewards):
        later = None if reward is None or later is None else reward + discount * later
        found.append(later)
    return found[::-1]


def _truth(state: Mapping[str, Any], entries: Mapping[str, Sequence[str]]) -> dict[str, Any]:
    """Return the true value of each variable and of each array's entry, by name."""
    found = dict(state)
    for name, names in entries.items():
        if isinstance(state.get(name), list):
            found |= zip(names, state[name], strict=False)
    return found


def entries_of(model: ir.Model) -> dict[str, list[str]]:
    """Return the names of the entries of each array variable, row-major, as solvers print them."""
    return {
        v.name: [f"{v.name}[{', '.join(place)}]" for place in index_texts(v.indices)]
        for v in model.variables
        if v.indices
    }
