# SPDX-License-Identifier: Apache-2.0
"""The text of ``hypgen explain``: the compiler's facts as headings and tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

Facts = dict[str, Any]

_WORD = 32
_SURELY_FEW = 19  # bits of fewer states than `hypgen solve` takes


def describe(facts: Facts) -> Iterator[tuple[str, list[str]]]:
    """Yield headings and the lines under them."""
    yield _title(facts), []
    if facts["params"]:
        yield "Params, read when the solver starts", list(_params(facts["params"]))
    yield _actions(facts["actions"]), []
    yield _observations(facts["observations"]), _digits(facts["observations"]["digits"])
    for name, note in (("fixed", "stored once a scenario"), ("dynamic", "copied by every step")):
        block = facts["state"][name]
        if block["variables"]:
            yield f"State, {name}: {block['bytes']} bytes, {note}", _layout(block["variables"])
    yield f"A scenario: {facts['state']['bytes']} bytes for {facts['state']['bits']} bits of state", []
    for number, stage in enumerate(facts["stages"]):
        note = ", independent of each other" if len(stage) > 1 else ""
        yield f"Stage {number}: {_some(len(stage), 'task')}{note}", _tasks(stage)
    most = facts["warps"]["most"]
    yield f"Warps that share a step: {most} at most", _warps(facts["warps"]["shares"]) if most > 1 else []
    if facts["draws"]:
        yield "Draws: one random number each, named by its site", _draws(facts["draws"])
    yield f"Reward of a step: {_range(facts['rewards'])}", _terms(facts["rewards"]["terms"])
    yield "Bounds", _bounds(facts)
    yield _relaxation(facts), _groups(facts["relaxation"]["groups"])
    yield _exact(facts["exact"]), []
    yield _lanes(facts["lanes"]), []
    yield _policy(facts["policy"]), _layout(facts["policy"]["history"]["variables"])
    yield _belief(facts["belief"]), _factors(facts["belief"])
    if facts["drawings"]:
        yield "Picture: what `hypgen view` and `hypgen sim` draw", _drawings(facts["drawings"])


def _title(facts: Facts) -> str:
    horizon = f", {_some(facts['horizon'], 'step')} at most" if facts["horizon"] is not None else ""
    return f"{facts['model']}: discount {facts['discount']:g}{horizon}"


def _params(params: list[Facts]) -> Iterator[str]:
    rows = [
        (p["name"], p["type"], _some(p["entries"], "entry"), "" if p["has_default"] else "has to be given")
        for p in params
    ]
    return iter(_table(("param", "type", "", ""), rows))


def _actions(actions: Facts) -> str:
    indices = f", one for each of {', '.join(actions['indices'])}" if actions["indices"] else ""
    legal = ", not all legal everywhere" if actions["legal"] == "declared" else ""
    return f"Actions: {actions['count']} ({actions['name']}: {actions['type']}{indices}){legal}"


def _observations(observations: Facts) -> str:
    bits, words = observations["bits"], observations["words"]
    key = f"a key of {_some(bits, 'bit')} in {_some(words, 'word')}"
    count = f"about 2^{bits}" if observations["count"] is None else observations["count"]
    return f"Observations: {count}, {key}"


def _digits(digits: list[Facts]) -> list[str]:
    rows = [(d["name"], d["kind"], d["type"], f"{d['entries']} x {d['values']}") for d in digits]
    return _table(("digit", "kind", "type", "values"), rows)


def _layout(variables: list[Facts]) -> list[str]:
    rows = []
    for v in variables:
        last = v["shift"] + (v["entries"] - 1) * v["stride"] + v["width"] - 1
        name = f"{v['name']}[{', '.join(v['indices'])}]" if v["indices"] else v["name"]
        if v["width"] == 0:
            word, bits = "-", "none: one value"
        elif last < _WORD:
            word, bits = str(v["word"]), f"{v['shift']} .. {last}" if last > v["shift"] else str(last)
        else:
            word, bits = f"{v['word']} .. {v['word'] + last // _WORD}", f"{_WORD // v['stride']} a word"
            bits += f" from {v['shift']}" if v["shift"] and v["stride"] == _WORD else ""
        if v["indices"] and v["width"]:
            bits += f", {v['entries']} x {v['width']}"
        rows.append((name, "visible" if v["visible"] else "hidden", v["type"], word, bits))
    return _table(("variable", "", "type", "word", "bits"), rows)


def _tasks(stage: list[Facts]) -> list[str]:
    rows = []
    for task in stage:
        members = f" x {task['members']}" if task["members"] > 1 else ""
        own = [f"{name.removeprefix(task['element'] + '.')}'" for name in task["writes"]]
        after = ", ".join(f"{name}'" for name in task["after"]) or "-"
        runs = f"{task['runs']} of {task['grain']}" if task["members"] > 1 else "1"
        seen = "taken from what was seen by the filter" if task["from_key"] else ""
        rows.append((f"{task['element']}{members}", ", ".join(own), after, _words(task["words"]), runs, seen))
    return _table(("element", "writes", "reads primed", "words", "runs", ""), rows)


def _words(words: list[int]) -> str:
    """Return ascending numbers with ranges for neighbours: ``0, 2 .. 5``."""
    ranges: list[list[int]] = []
    for word in words:
        if ranges and word == ranges[-1][1] + 1:
            ranges[-1][1] = word
        else:
            ranges.append([word, word])
    return ", ".join(str(low) if low == high else f"{low} .. {high}" for low, high in ranges) or "-"


def _warps(shares: list[Facts]) -> list[str]:
    rows = [(str(s["warps"]), *(" ".join(map(str, runs)) for runs in s["runs"])) for s in shares]
    stages = range(len(shares[0]["runs"]))
    return _table(("warps", *(f"runs of stage {number} for each" for number in stages)), rows)


def _draws(draws: list[Facts]) -> list[str]:
    rows = [(d["site"], str(d["draws"]), d["when"], f"line {d['line']}") for d in draws]
    return _table(("site", "draws", "when", ""), rows)


def _drawings(drawings: list[Facts]) -> list[str]:
    rows = [
        (
            d["name"] + (f" x {d['members']}" if d["members"] > 1 else ""),
            d["shape"],
            ", ".join(d["reads"]) or "nothing: it is static",
            "truth and belief" if d["believed"] else "",
            f"line {d['line']}",
        )
        for d in drawings
        if d["shape"] != "area"
    ]
    return _table(("drawing", "shape", "reads", "shows", ""), rows)


def _terms(terms: list[Facts]) -> list[str]:
    rows = [(t["name"] + (f" x {t['members']}" if t["members"] > 1 else ""), _range(t)) for t in terms]
    return _table(("term", "each"), rows)


def _bounds(facts: Facts) -> list[str]:
    rows = []
    for name, bound in facts["bounds"].items():
        if bound["origin"] == "rollout":
            known = facts["relaxation"]["holds_policy"]
            rollout = "the default policy's rollout"
            rows.append((name, "what the default policy earns, looked up" if known else rollout, ""))
            continue
        origin = "derived from the rewards" if bound["line"] is None else f"declared in line {bound['line']}"
        rows.append((name, _range(bound), origin))
    return _table(("bound", "value", ""), rows)


def _relaxation(facts: Facts) -> str:
    """Say what the upper bound in use is, and why it is no better."""
    relaxation, written = facts["relaxation"], facts["bounds"]["upper"]["line"] is not None
    note = f"; agents are not taken apart, as {why}" if (why := relaxation["agents_together"]) else ""
    if relaxation["reason"]:
        return f"Upper bound in use: the one above alone, as {relaxation['reason']}{note}"
    count = len(relaxation["groups"])
    worth = "what the rewards are worth to who knows the state"
    if count > 1:
        worth = f"what {count} groups of rewards are worth, each alone, to who knows the state"
    if agents := relaxation["agents_apart"]:
        worth = f"what {agents} agents that act apart and share what there is in the best way are worth"
        worth += f", in {_some(count // agents, 'group')} of rewards"
    other = "the declared bound" if written else "the one above"
    computed = f"{worth}, computed when the solver starts"
    return f"Upper bound in use: {computed}, or {other} where that is less{note}"


def _lanes(lanes: Facts) -> str:
    """Say whether CPUs roll out side by side, and why not."""
    if lanes["reason"]:
        return f"Rollouts on a CPU: one at a time, as {lanes['reason']}"
    return "Rollouts on a CPU: side by side where that is sooner done, 8 with AVX2 and 16 with AVX-512"


def _groups(groups: list[Facts]) -> list[str]:
    rows = [
        (g["rewards"], ", ".join(g["knows"]), _some(g["states"], "state"), _some(g["actions"], "action"))
        for g in groups
    ]
    return _table(("rewards", "know", "", ""), rows)


def _exact(exact: Facts) -> str:
    """Say whether the model can be solved exactly, or what is in the way first."""
    if exact["obstacles"]:
        first, *others = exact["obstacles"]
        line = "" if first["line"] is None else f" in line {first['line']}"
        more = f", and {len(others)} more" if others else ""
        return f"Exact solution: none, as {first['reason']}{line}{more}"
    bits = exact["most_states_log2"]
    if bits <= _SURELY_FEW:
        return f"Exact solution: `hypgen solve` applies, there are at most 2^{bits} states"
    return f"Exact solution: `hypgen solve` applies if at most a million of 2^{bits} states can be reached"


def _policy(policy: Facts) -> str:
    if policy["origin"] == "uniform":
        return "Default policy: uniform over the legal actions, as none is declared"
    kept = policy["history"]
    known = f"and {kept['bytes']} bytes of history" if kept["variables"] else "only"
    return f"Default policy: declared in line {policy['line']}; it knows visible state {known}"


def _belief(belief: Facts) -> str:
    first = ", ".join(belief["seen_first"])
    given = f"; the first one is given what is seen of {first}" if first else ""
    if belief["filter"] == "factored":
        return f"Belief: factored, each factor independent of the others given what was seen{given}"
    lazily = ", ".join(belief["drawn_when_read"])
    copies = f"; copies draw anew what they have not read of {lazily}" if lazily else ""
    moved = ", ".join(belief["moved"])
    moves = f"; moves change single values of {moved}" if moved else ""
    return f"Belief: particles of the whole state{copies}{moves}{given}"


def _factors(belief: Facts) -> list[str]:
    rows = []
    for factor in belief["factors"]:
        members = f" x {factor['members']}" if factor["members"] > 1 else ""
        kept = (
            f"exact: {_some(factor['values'], 'value')}"
            if factor["exact"]
            else f"particles: {factor['inexact']}"
        )
        if factor["moments"]:
            kept += "; the policy knows mean and deviation"
        rows.append((f"{factor['element']}{members}", ", ".join(factor["variables"]), kept))
    lines = _table(("factor", "variables", "kept as"), rows)
    for o in belief["obstacles"]:
        lines.append(f"{o['element']} is no factor: {o['reason']} ({o['file']}:{o['line']}:{o['column']})")
    return lines


# Text ----------------------------------------------------------------------------------------------


def _range(facts: Facts) -> str:
    low, high = facts["low"], facts["high"]
    if low == high and low is not None:
        return f"{low:.6g}"
    return f"{'-inf' if low is None else f'{low:.6g}'} .. {'inf' if high is None else f'{high:.6g}'}"


def _some(number: int, noun: str) -> str:
    plural = f"{noun[:-1]}ies" if noun.endswith("y") else f"{noun}s"
    return f"{number} {noun if number == 1 else plural}"


def _table(heading: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the rows under a heading, columns aligned; empty columns are left out."""
    if not rows:
        return []
    used = [column for column in range(len(heading)) if any(row[column] for row in rows)]
    kept = [[row[column] for column in used] for row in (heading, *rows)]
    widths = [max(len(row[column]) for row in kept) for column in range(len(used))]
    return ["  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in kept]
