# SPDX-License-Identifier: Apache-2.0
"""``hypgen explain``: what the compiler makes of a model."""

from __future__ import annotations

import json
from pathlib import Path

import click

from hypgen.cli.building import generating
from hypgen.cli.exit_codes import EXIT_CODES, Exit
from hypgen.cli.model_arguments import load, model_options
from hypgen.dsl.messages.diagnostic import did_you_mean

# The passes of the compiler in order, each with what is printed of it, and three names for larger pieces.
STAGES = {
    "parse": "the text's structure",
    "resolve-imports": "the same, with what libraries declare",
    "flatten-records": "where records of floats became their fields",
    "collect-symbols": "all names",
    "check-declarations": "types, consts, params, functions, variables, lets",
    "check-parts": "the action, inits, updates, observations, rewards ..",
    "check-visibility": "nothing: who reads what is checked",
    "stage-updates": "updates with their stages",
    "order-inits": "inits in their order",
    "collect-sites": "the names of draws",
    "mark-variables": "visible variables that need no weighing",
    "check-floats": "nothing: floats that the agent sees are checked",
    "derive-bounds": "bounds that follow from the rewards",
    "make-key": "the digits of the observation key",
    "assemble": "the typed model",
    "scale-rewards": "the fixed point of the rewards",
    "find-factors": "hidden state that is independent, or why it is not",
    "resolve-beliefs": "the factor of each belief(..)",
    "warn": "warnings",
    "tabulate": "the model with tables in the place of slow formulas",
    "relax": "the small models that bound the rewards",
    "pack": "the layout of states in words",
    "partition": "updates as units that threads share",
    "print": "all files of the generated project",
}
SUMMARIES = {
    "ast": "as resolve-imports",
    "ir": "the checked, typed model",
    "cpp": "the generated C++",
}


def _listed() -> str:
    rows = "\n".join(f"  {name:<20}{text}" for name, text in (STAGES | SUMMARIES).items())
    return f"\b\nStages, in order, and what is printed of each:\n{rows}"


class _Stage(click.Choice[str]):
    """The name of a stage."""

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the name; refuse what is none, and name the nearest or else all."""
        nearest = did_you_mean(value, self.choices)
        if nearest and value not in self.choices:
            message = f"there is no stage '{value}'. {nearest[:1].upper()}{nearest[1:]}"
            raise click.BadParameter(message, ctx, param)
        return super().convert(value, param, ctx)


@click.command(epilog=f"{_listed()}\n\n{EXIT_CODES}")
@model_options
@click.option("--json", "as_json", is_flag=True, help="Print everything as one JSON object.")
@click.option(
    "--stage",
    type=_Stage((*STAGES, *SUMMARIES)),
    metavar="NAME",
    help="Print what a stage of the compiler makes instead; the list below has their names.",
)
def command(
    model: Path, instance: Path | None, settings: tuple[str, ...], as_json: bool, stage: str | None
) -> int:
    """Print how MODEL is compiled.

    The order of its updates and which of them are independent, its draws, how states are packed, how many
    actions and observations there are, what rewards and bounds can be, what the policy knows, and which
    filter keeps the belief.

    \b
    Examples:
      hypgen explain examples/tiger.pomdp
      hypgen explain examples/rock_sample.pomdp --json
      hypgen explain examples/tag.pomdp --stage cpp | less
    """
    if stage is not None and as_json:
        raise click.UsageError("--json belongs to the explanation: leave out --stage.")
    if stage is not None:
        _print_stage(stage, model, instance, settings)
        return Exit.OK
    from hypgen.cli.show.explanation import describe
    from hypgen.codegen.model_report import explain

    loaded = load(model, instance, settings)
    with generating(model):
        facts = explain(loaded.model)
    if as_json:
        click.echo(json.dumps(facts, indent=2))
    else:
        for heading, lines in describe(facts):
            click.secho(heading, bold=True)
            click.echo("".join(f"  {line}\n" for line in lines))
    return Exit.OK


def _print_stage(stage: str, model: Path, instance: Path | None, settings: tuple[str, ...]) -> None:
    """Compile a model as far as ``stage``, and print what that made."""
    from hypgen.cli.show.node_dump import dump
    from hypgen.cli.show.stages import StagePrinter, print_files

    watch = StagePrinter(stage)
    loaded = load(model, instance, settings, watch)
    if stage == "ast":
        click.echo(dump(loaded.ast))
    elif stage == "ir":
        click.echo(dump(loaded.model))
    elif not watch.done:
        from hypgen.codegen.generate import generate

        with generating(model):
            files = generate(loaded.model, watch)
        if stage == "cpp":
            click.echo(print_files({name: text for name, text in files.items() if name.startswith("src/")}))
