# SPDX-License-Identifier: Apache-2.0
"""``hypgen check``: is the model right, and how large is it?"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hypgen.cli.exit_codes import Exit, exit_codes
from hypgen.cli.model_arguments import model_options
from hypgen.cli.output import show_diagnostics
from hypgen.cli.progress import notice

if TYPE_CHECKING:
    from hypgen.dsl import ir


_SAMPLING_SECONDS = 10.0


@click.command(epilog=exit_codes("with --strict: there are warnings"))
@model_options
@click.option("--strict", is_flag=True, help="End with 1 if there are warnings.")
@click.option("--json", "as_json", is_flag=True, help="Print the result, mistakes included, as JSON.")
@click.option(
    "--samples",
    type=click.IntRange(min=1),
    metavar="N",
    help="Visit N states in random episodes and check what no reading can prove.",
)
@click.option(
    "--seed", type=click.IntRange(min=0), default=0, help="Of the random episodes.", show_default=True
)
@click.option(
    "--beliefs",
    metavar="N",
    type=click.IntRange(50, 1_000_000),
    help="Compile the model, play N episodes, and check where true values lie in the solver's belief.",
)
@click.option(
    "--bounds",
    metavar="N",
    type=click.IntRange(1, 1_000_000_000),
    help="Compile the model, and compare its bounds at N beliefs with what the default policy earns.",
)
@click.option(
    "--belief",
    type=click.Choice(("auto", "factored", "particle")),
    help="With --beliefs: the belief to check.  [default: auto]",
)
@click.option(
    "--particles",
    metavar="N",
    type=click.IntRange(1, 10_000_000),
    help="With --beliefs: of the belief, as for `run`.  [default: 5000]",
)
@click.option(
    "--time",
    metavar="S",
    type=click.FloatRange(0, 1e6),
    help="Seconds to sample or to play; what was found until then counts.  "
    "[default: 10 for --samples, none for --beliefs]",
)
def command(
    model: Path,
    instance: Path | None,
    settings: tuple[str, ...],
    as_json: bool,
    samples: int | None,
    seed: int,
    beliefs: int | None,
    bounds: int | None,
    belief: str | None,
    particles: int | None,
    time: float | None,
    strict: bool,
) -> int:
    """Check MODEL and print one line about it, or every mistake that is found.

    \b
    Examples:
      hypgen check examples/tiger.pomdp
      hypgen check examples/rs_11_11.pomdp
      hypgen check examples/rock_sample.pomdp --set n=5 --json
      hypgen check examples/tag.pomdp --samples 100000 --time 60
      hypgen check examples/tag.pomdp --beliefs 1000
      hypgen check examples/tag.pomdp --bounds 10000
      hypgen check examples/light_dark.pomdp --beliefs 500 --particles 20000 --time 60
    """
    from hypgen.dsl import load
    from hypgen.dsl.messages.diagnostic import ModelError

    if sum(count is not None for count in (samples, beliefs, bounds)) > 1:
        raise click.UsageError("--samples, --beliefs and --bounds are three checks: run one after the other.")
    for name, value in (("belief", belief), ("particles", particles)):
        if value is not None and beliefs is None:
            raise click.UsageError(f"--{name} is for checks of beliefs: add --beliefs N.")
    if time is not None and beliefs is None and samples is None:
        raise click.UsageError("--time is for --samples N and --beliefs N: add one of them.")
    try:
        with notice(f"{model}: checking"):
            checked = load.load_any(model, instance=instance, settings=settings)
    except ModelError as error:
        if not as_json:
            raise
        from hypgen.dsl.messages.render import to_json

        click.echo(
            json.dumps({"ok": False, "diagnostics": [to_json(d) for d in error.diagnostics]}, indent=2)
        )
        return Exit.MISTAKE
    if isinstance(checked, load.LoadedLibrary):
        name = checked.ast.name
        fine = {"ok": True, "diagnostics": [], "library": name}
        click.echo(json.dumps(fine, indent=2) if as_json else f"{model}: OK: library {name}")
        return Exit.OK
    facts, warned = summary(checked.model), len(checked.warnings)
    if not as_json:
        show_diagnostics(checked.warnings, checked.sources)
    if samples is not None:
        from hypgen.cli.show import sampled_findings

        seconds = _SAMPLING_SECONDS if time is None else time
        return sampled_findings.run(checked, samples, seed, seconds, facts if as_json else None, strict)
    if beliefs is not None:
        from hypgen.cli.show import belief_findings

        asked = belief_findings.Asked(beliefs, belief or "auto", particles or 5000, seed, time)
        return belief_findings.run(checked, model, instance, asked, facts if as_json else None, strict)
    if bounds is not None:
        from hypgen.cli.show import bound_findings

        figures = facts if as_json else None
        return bound_findings.run(checked, model, instance, bounds, seed, figures, strict)
    if as_json:
        from hypgen.dsl.messages.render import to_json

        shown = [to_json(w) for w in checked.warnings]
        click.echo(json.dumps({"ok": True, "diagnostics": shown, **facts}, indent=2))
    else:
        counted = f"; {warned} warning{'' if warned == 1 else 's'}" if warned else ""
        click.echo(f"{model}: OK: {describe(facts)}{counted}")
    return Exit.DIFFERENT if strict and warned else Exit.OK


def summary(model: ir.Model) -> dict[str, Any]:
    """Return the model's size in figures."""
    from hypgen.dsl.types import digits_of, length_of

    def bits(variable: ir.Variable) -> int:
        return (digits_of(variable.type) - 1).bit_length() * length_of(variable.indices)

    seen = math.prod(field.size**field.length for field in model.key)
    return {
        "model": model.name,
        "state_bits": sum(map(bits, model.variables)),
        "hidden_bits": sum(bits(v) for v in model.variables if not v.visible),
        "actions": model.action.count,
        "observations": seen if seen <= 2**64 else None,
        "observation_bits": (seen - 1).bit_length(),
        "stages": len(model.stages()),
    }


def describe(facts: dict[str, Any]) -> str:
    """Return ``summary``'s figures in words."""

    def some(number: int, noun: str) -> str:
        return f"{number} {noun}{'' if number == 1 else 's'}"

    seen = f"observations of {facts['observation_bits']} bits"
    if facts["observation_bits"] < 32:  # a float has 32, and nobody counts its values
        seen = some(facts["observations"], "observation")
    return (
        f"{facts['model']}: {some(facts['state_bits'], 'bit')} of state ({facts['hidden_bits']} hidden), "
        f"{some(facts['actions'], 'action')}, {seen}, "
        f"{some(facts['stages'], 'stage')} of updates"
    )
