"""Which initial draws particles may make anew as long as nothing has read them (``hypgen/unread.hpp``)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from hypgen.codegen import views
from hypgen.codegen.naming import Names, takes_word
from hypgen.dsl import ir
from hypgen.dsl.ir_walk import Node, walk


def redrawn(model: ir.Model) -> tuple[ir.Assign, ...]:
    """Return the inits whose draws belong to one entry of a hidden fixed variable each.

    Not of a variable that inits of fixed ones come to read: a particle keeps what was read, so what depends
    on it has to be drawn given that same value. None without a variable that has entries: what is a single
    value is soon read. None either where the belief is a product of posteriors.
    """
    if model.factored:
        return ()
    variables = {v.name: v for v in model.variables}
    read = _read_for(model, [a.dist for a in model.inits if variables[a.variable].fixed])
    times = Counter(a.site.path for a in model.inits)
    found = tuple(
        a
        for a in model.inits
        if variables[a.variable].fixed
        and not variables[a.variable].visible
        and a.variable not in read
        and takes_word(a.dist)
        and times[a.site.path] == 1
    )
    return found if any(a.binders for a in found) else ()


def _read_for(model: ir.Model, nodes: Iterable[Node]) -> set[str]:
    """Return the variables whose initial values the nodes depend on, through functions, lets and inits."""
    functions = {f.name: f.body for f in model.functions}
    lets = {x.name: x.dist for x in model.all_lets}
    inits = {a.variable: a.dist for a in model.inits}
    seen: set[tuple[str, str]] = set()
    body: Node
    left = list(nodes)
    while left:
        for node in walk(left.pop()):
            match node:
                case ir.StateRead(variable=name):
                    place, body = ("variable", name), inits[name]
                case ir.Call(function=name):
                    place, body = ("function", name), functions[name]
                case ir.LetRead(let=name):
                    place, body = ("let", name), lets[name]
                case _:
                    continue
            if place not in seen:
                seen.add(place)
                left.append(body)
    return {name for kind, name in seen if kind == "variable"}


def is_redrawn(model: ir.Model, names: Names) -> views.Function | None:
    """Return the test whether a site's draws may be made anew, if any may."""
    found = redrawn(model)
    if not found:
        return None
    tests = " || ".join(f"site == Site::{names.sites[a.site.path]}" for a in found)
    return views.Function(
        (), ("HYPGEN_FN static bool is_redrawn(std::uint32_t site) {",), (f"return {tests};",)
    )
