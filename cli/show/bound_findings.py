# SPDX-License-Identifier: Apache-2.0
"""The work of ``hypgen check --bounds``: compares bounds with what is earned, and says what it found."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hypgen.cli.building import build
from hypgen.cli.exit_codes import Exit
from hypgen.cli.model_arguments import require_params
from hypgen.cli.output import say
from hypgen.dsl.messages import c_sampling
from hypgen.dsl.messages.render import render, to_json

if TYPE_CHECKING:
    from hypgen.dsl import ir
    from hypgen.dsl.load import Loaded
    from hypgen.dsl.messages.diagnostic import Diagnostic

DECLARED = "declared upper"  # the text's, where one that the compiler derives is in use
COLUMNS = ("bound", "beliefs", "violations", "mean room")

Compared = Mapping[str, Mapping[str, Any]]  # by bound: `beliefs`, `violations` and `mean_room`


def run(
    loaded: Loaded,
    model: Path,
    instance: Path | None,
    beliefs: int,
    seed: int,
    facts: dict[str, Any] | None,
    strict: bool,
) -> int:
    """Check the bounds of a model; print findings, or with ``facts`` everything, warnings too, as JSON."""
    require_params(loaded)
    compared = _compare(build("verify", loaded, model, instance), beliefs, seed)
    found = findings(loaded.model, compared)
    if facts is None:
        for finding in found:
            say(render(finding, loaded.sources))
        verdict = f"{len(found)} bound{'' if len(found) == 1 else 's'} wrong" if found else "nothing wrong"
        click.echo(f"{loaded.model.file}: bounds at {beliefs:,} beliefs, seed {seed}: {verdict}")
        click.echo(table(compared))
    else:
        shown = [to_json(d) for d in (*loaded.warnings, *found)]
        numbers = [{"name": name, **figures} for name, figures in compared.items()]
        checked = {"bounds": {"beliefs": beliefs, "seed": seed, "compared": numbers}}
        click.echo(json.dumps({"ok": not found, "diagnostics": shown, **facts, **checked}, indent=2))
    if found:
        return Exit.MISTAKE
    return Exit.DIFFERENT if strict and loaded.warnings else Exit.OK


def _compare(program: Path, beliefs: int, seed: int) -> Compared:
    command = [str(program), f"--check-bounds={beliefs}", f"--seed={seed}", "--json=-"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if not done.stdout:
        raise click.ClickException(done.stderr.strip() or f"{program.name} ended with {done.returncode}")
    compared: Compared = json.loads(done.stdout)["bounds"]
    return compared


def findings(model: ir.Model, compared: Compared) -> list[Diagnostic]:
    """Return what is wrong: the bounds of the text first, then those that the compiler derives."""
    found: list[Diagnostic] = []
    for name in (DECLARED, "upper", "lower", "tail"):
        figures = compared.get(name)
        if figures is None or figures["violations"] == 0:
            continue
        bound = name.removeprefix("declared ")
        derived = name == "upper" and DECLARED in compared
        if derived and found:
            continue  # the one in use is the less of the two
        span = None if derived else model.spans.get(bound)
        violations, beliefs = figures["violations"], figures["beliefs"]
        found.append(c_sampling.violated_bound(bound, violations, beliefs, model.endless, span))
    return found


def table(compared: Compared) -> str:
    """Return a row for each bound: where it was compared, where it failed, and how far it lies off."""
    rows = [COLUMNS]
    names = {"upper": "upper, in use", DECLARED: "upper, as written"} if DECLARED in compared else {}
    for name, figures in compared.items():
        rows.append(
            (
                names.get(name, name),
                f"{figures['beliefs']:,}",
                f"{figures['violations']:,}",
                f"{figures['mean_room']:.4g}",
            )
        )
    widths = [max(len(row[i]) for row in rows) for i in range(len(COLUMNS))]
    return "\n".join(
        "  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]) for row in rows
    )
