"""``hypgen explain``: what the compiler makes of a model."""

from __future__ import annotations

import json
from pathlib import Path

import click

from hypgen.cli.exit_codes import EXIT_CODES, Exit
from hypgen.cli.model_arguments import load, model_options


@click.command(epilog=EXIT_CODES)
@model_options
@click.option("--json", "as_json", is_flag=True, help="Print everything as one JSON object.")
@click.option(
    "--stage",
    type=click.Choice(("ast", "ir", "cpp")),
    help="Print what a stage of the compiler makes instead. ast: the text's structure. ir: the checked, "
    "typed model. cpp: the generated C++.",
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
    loaded = load(model, instance, settings)
    if stage in ("ast", "ir"):
        from hypgen.cli.show.node_dump import dump

        click.echo(dump(loaded.ast if stage == "ast" else loaded.model))
    elif stage == "cpp":
        from hypgen.codegen import generate

        files = sorted(generate.generate(loaded.model).items())
        texts = [f"// {name}\n\n{text}" for name, text in files if name.startswith("src/")]
        click.echo("\n".join(texts).rstrip("\n"))
    else:
        from hypgen.cli.show.explanation import describe
        from hypgen.codegen.model_report import explain

        facts = explain(loaded.model)
        if as_json:
            click.echo(json.dumps(facts, indent=2))
        else:
            for heading, lines in describe(facts):
                click.secho(heading, bold=True)
                click.echo("".join(f"  {line}\n" for line in lines))
    return Exit.OK
