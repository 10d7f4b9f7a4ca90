"""Which initial draws particles may make anew as long as nothing has read them (``hypgen/unread.hpp``)."""

from __future__ import annotations

from collections import Counter

from hypgen.codegen import views
from hypgen.codegen.naming import Names, takes_word
from hypgen.dsl import ir


def redrawn(model: ir.Model) -> tuple[ir.Assign, ...]:
    """Return the inits whose draws belong to one entry of a hidden fixed variable each.

    None without a variable that has entries: what is a single value is soon read. None either where the
    belief is a product of posteriors.
    """
    if model.factored:
        return ()
    variables = {v.name: v for v in model.variables}
    times = Counter(a.site.path for a in model.inits)
    found = tuple(
        a
        for a in model.inits
        if variables[a.variable].fixed
        and not variables[a.variable].visible
        and takes_word(a.dist)
        and times[a.site.path] == 1
    )
    return found if any(a.binders for a in found) else ()


def is_redrawn(model: ir.Model, names: Names) -> views.Function | None:
    """Return the test whether a site's draws may be made anew, if any may."""
    found = redrawn(model)
    if not found:
        return None
    tests = " || ".join(f"site == Site::{names.sites[a.site.path]}" for a in found)
    return views.Function(
        (), ("HYPGEN_FN static bool is_redrawn(std::uint32_t site) {",), (f"return {tests};",)
    )
