# SPDX-License-Identifier: Apache-2.0
"""The work of ``hypgen check --samples``: walks, watches, and says what it found."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from hypgen.cli.exit_codes import Exit
from hypgen.cli.interrupts import interrupt_code
from hypgen.cli.model_arguments import require_params
from hypgen.cli.output import say
from hypgen.cli.progress import phases
from hypgen.dsl.interpret.sampling.sample_laws import check_densities, check_returns
from hypgen.dsl.interpret.sampling.sample_model import Walk
from hypgen.dsl.messages.render import to_json

if TYPE_CHECKING:
    from hypgen.dsl.load import Loaded


def run(
    loaded: Loaded, samples: int, seed: int, seconds: float, facts: dict[str, Any] | None, strict: bool
) -> int:
    """Check a model by sampling; print findings, or with ``facts`` everything, warnings too, as JSON.

    What was found until ``seconds`` have passed, or until an interrupt, is printed too.
    """
    require_params(loaded)
    walk = Walk(loaded.model, samples, seed, seconds)
    interrupted: KeyboardInterrupt | None = None
    try:
        with phases() as progress:
            walk.run(progress)
            check_densities(walk, progress)
            check_returns(walk, progress)
    except KeyboardInterrupt as error:
        interrupted = error
    findings = walk.findings
    wrong = any(not f.is_warning for f in findings)
    if facts is not None:
        sampled = {
            "states": walk.visited,
            "episodes": walk.episodes,
            "seed": seed,
            "cut": walk.cut,
            "interrupted": interrupted is not None,
        }
        found = [*map(to_json, loaded.warnings), *(f.to_json() for f in findings)]
        click.echo(json.dumps({"ok": not wrong, "diagnostics": found, **facts, "samples": sampled}, indent=2))
    else:
        for finding in findings:
            say(finding.render(loaded.sources))
        visited = f"{walk.visited:,} states in {walk.episodes:,} episodes, seed {seed}"
        mistakes = sum(not f.is_warning for f in findings)
        warnings = len(findings) - mistakes
        counts = [_some(mistakes, "mistake")] * bool(mistakes) + [_some(warnings, "warning")] * bool(warnings)
        verdict = " and ".join(counts) if counts else "nothing wrong"
        click.echo(f"{loaded.model.file}: {visited}: {verdict}")
        if walk.cut:
            say(f"note: {seconds:g} s are over: {'; '.join(walk.cut)}. --time gives it more")
    if interrupted:
        say("interrupted")
        return interrupt_code(interrupted)
    if strict and not wrong and (findings or loaded.warnings):
        return Exit.DIFFERENT
    return Exit.MISTAKE if wrong else Exit.OK


def _some(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"
