# SPDX-License-Identifier: Apache-2.0
"""From a syntax tree to a checked model: the list of passes, and the driver that runs them.

``load`` parses and resolves imports before; ``codegen.generate`` makes C++ of the model after.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from hypgen.dsl import ir
from hypgen.dsl.check import passes
from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.report import Report
from hypgen.dsl.messages.source import Source
from hypgen.dsl.messages.watch import Watch, nobody
from hypgen.dsl.syntax import ast

# The parser limits nesting; each level takes some ten frames here.
_RECURSION_LIMIT = 20_000


@dataclass(frozen=True)
class Pass:
    """A step of the compiler: ``run`` takes what the pass before gave.

    ``last``: what comes after needs a model without mistakes, so that those found so far end the run here.
    """

    name: str
    run: Callable[[Any], Any]
    last: bool = False


PASSES = (
    Pass("flatten-records", passes.flatten, last=True),
    Pass("collect-symbols", passes.collect_symbols),
    Pass("check-declarations", passes.check_declarations),
    Pass("check-parts", passes.check_parts),
    Pass("check-visibility", passes.check_visibility),
    Pass("stage-updates", passes.stage_updates),
    Pass("order-inits", passes.order_inits),
    Pass("collect-sites", passes.collect_sites),
    Pass("mark-variables", passes.mark_variables),
    Pass("check-floats", passes.check_floats),
    Pass("derive-bounds", passes.derive_bounds),
    Pass("make-key", passes.make_key, last=True),
    Pass("assemble", passes.assemble),
    Pass("scale-rewards", passes.scale_rewards),
    Pass("find-factors", passes.find_factors),
    Pass("resolve-beliefs", passes.resolve_beliefs, last=True),
    Pass("warn", passes.warn),
)
# A library has no action, no discount and no updates.
_OF_LIBRARIES = PASSES[:3]


def lower(
    file: ast.ModelFile,
    overrides: Mapping[str, ast.Expr],
    source: Source,
    imported: Sequence[Source] = (),
    warned: list[Diagnostic] | None = None,
    watch: Watch = nobody,
) -> ir.Model:
    """Return the checked model; raises ``ModelError`` with every independent mistake.

    ``imported`` are the texts of the libraries whose items ``file`` has taken in. Warnings go to ``warned``.
    """
    report = Report()
    written = passes.Written(file, file, overrides, (source, *imported), report)
    whole = _run(PASSES, written, report, watch)
    assert isinstance(whole, passes.Whole)
    if warned is not None:
        warned += whole.warnings
    return whole.model


def check_library(file: ast.LibraryFile, watch: Watch = nobody) -> None:
    """Check a library by itself; raises ``ModelError`` with every independent mistake."""
    report = Report()
    alone = ast.ModelFile(file.span, file.name, file.items)
    _run(_OF_LIBRARIES, passes.Written(alone, alone, {}, (), report), report, watch)


def _run(listed: Sequence[Pass], state: object, report: Report, watch: Watch) -> object:
    """Return what the last of the passes gives; raises ``ModelError`` where mistakes end the run."""
    with _deep_recursion():
        for step in listed:
            state = step.run(state)
            watch(step.name, state)
            if step.last:
                report.raise_if_any()
        report.raise_if_any()
    return state


@contextmanager
def _deep_recursion() -> Iterator[None]:
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(max(before, _RECURSION_LIMIT))
    try:
        yield
    finally:
        sys.setrecursionlimit(before)
