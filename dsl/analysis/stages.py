# SPDX-License-Identifier: Apache-2.0
"""Conclusions from who reads what: stages, the observation key, the filter's rules."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from graphlib import TopologicalSorter

from hypgen.dsl import ir
from hypgen.dsl.analysis.owners import Owner
from hypgen.dsl.analysis.uses import Reach, Uses
from hypgen.dsl.ir import key_digits
from hypgen.dsl.messages import e04_variables, e08_parts
from hypgen.dsl.messages.report import Mistake, Report
from hypgen.dsl.messages.source import Span

Edges = dict[str, dict[str, Reach]]

# Of 64 bits: 32 KiB for each step that a search simulates at once.
MOST_KEY_WORDS = 4096


def stage_updates(updates: Sequence[ir.Assign], uses: Uses, report: Report) -> tuple[ir.Assign, ...]:
    """Return the updates with ``reads`` and ``stage``: the longest path of primed reads that leads there."""
    names = {u.variable for u in updates}
    edges: Edges = {
        u.variable: {
            r.name: r
            for r in reversed(uses.closure(Owner("update", u.variable)))
            if r.kind == "variable" and r.primed and r.name in names
        }
        for u in updates
    }
    cycle = find_cycle(edges)
    if cycle:
        report.add(_cyclic_updates(cycle, edges))
        return tuple(updates)
    stages: dict[str, int] = {}
    order = TopologicalSorter(edges)
    order.prepare()
    stage = 0
    while order.is_active():
        ready = order.get_ready()
        stages |= dict.fromkeys(ready, stage)
        order.done(*ready)
        stage += 1
    return tuple(replace(u, stage=stages[u.variable], reads=frozenset(edges[u.variable])) for u in updates)


def find_cycle(edges: Mapping[str, Iterable[str]]) -> list[str]:
    """Return the names on a cycle in order, or an empty list."""
    done: set[str] = set()
    for start in edges:
        path: list[str] = []
        stack = [(start, iter(edges[start]))] if start not in done else []
        path += [start] if stack else []
        while stack:
            name, rest = stack[-1]
            following = next(rest, None)
            if following is None:
                done.add(name)
                stack.pop()
                path.pop()
            elif following in path:
                return path[path.index(following) :]
            elif following not in done:
                stack.append((following, iter(edges[following])))
                path.append(following)
    return []


def _cyclic_updates(cycle: list[str], edges: Edges) -> Mistake:
    reads = [edges[a][b] for a, b in zip(cycle, [*cycle[1:], cycle[0]], strict=True)]
    places = [r.path[-1].span for r in reads]
    return Mistake(e04_variables.circular_updates(cycle, reads[0].span, places))


def mark_variables(
    variables: Sequence[ir.Variable],
    updates: Sequence[ir.Assign],
    uses: Uses,
    others: Sequence[Owner],
) -> tuple[ir.Variable, ...]:
    """Return the variables with ``determined``, ``copied`` and ``informative``; ``updates`` are staged.

    ``others`` are the declarations besides updates whose draws the agent learns something of.
    """
    visible = {v.name for v in variables if v.visible}
    reach = {u.variable: uses.closure(Owner("update", u.variable)) for u in updates}
    determined = {v.name for v in variables if v.visible and v.fixed}
    for update in sorted(updates, key=lambda u: u.stage):
        certain = update.variable in visible and isinstance(update.dist, ir.Certain)
        if certain and all(_known(r, visible, determined) for r in reach[update.variable]):
            determined.add(update.variable)
    copied = {
        n
        for n, reads in reach.items()
        if n in visible and n not in determined and not any(_hidden(r, visible) for r in reads)
    }
    # A draw that something hidden or observed reads too would tie them together: then the value is weighed.
    shared = set().union(*(_draws(uses.closure(o)) for o in others)) if others else set()
    while True:
        tied = shared.union(*(_draws(r) for n, r in reach.items() if n not in copied))
        kept = {n for n in copied if not _draws(reach[n]) & tied}
        if kept == copied:
            break
        copied = kept
    informative = {n for n in visible if any(_hidden(r, visible) for r in uses.closure(Owner("init", n)))}
    return tuple(
        replace(
            v, determined=v.name in determined, copied=v.name in copied, informative=v.name in informative
        )
        for v in variables
    )


def _known(reach: Reach, visible: set[str], determined: set[str]) -> bool:
    if reach.kind == "draw":
        return False
    return reach.kind != "variable" or reach.name in (determined if reach.primed else visible)


def _hidden(reach: Reach, visible: set[str]) -> bool:
    return reach.kind == "variable" and reach.name not in visible


def _draws(reads: list[Reach]) -> set[str]:
    return {r.name for r in reads if r.kind == "draw"}


def key_fields(
    observations: Sequence[ir.Observation], variables: Sequence[ir.Variable]
) -> tuple[ir.KeyField, ...]:
    """Return the digits of the observation key."""
    observed = [ir.KeyField(o.name, True, o.type, tuple(b.type for b in o.binders)) for o in observations]
    seen = [
        ir.KeyField(v.name, False, v.type, v.indices) for v in variables if v.visible and not v.determined
    ]
    return (*observed, *seen)


def check_key(key: tuple[ir.KeyField, ...], model_span: Span, report: Report) -> None:
    """Report a key of too many words to keep one for each simulated step."""
    if key_digits.word_count(key, most=MOST_KEY_WORDS) <= MOST_KEY_WORDS:
        return
    largest = max(key, key=lambda f: f.size.bit_length() * f.length).name
    report.add(Mistake(e08_parts.large_observation(MOST_KEY_WORDS * 64, largest, model_span)))


def check_sites(sites: Iterable[tuple[ir.Site, Span]], report: Report) -> None:
    """Report draws whose names hash to the same id: they would share their random numbers."""
    seen: dict[int, ir.Site] = {}
    for site, span in sites:
        other = seen.setdefault(site.id, site)
        if other.path != site.path:
            report.add(Mistake(e08_parts.same_draw_id(site.path, other.path, span)))
