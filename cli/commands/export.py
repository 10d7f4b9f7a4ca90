# SPDX-License-Identifier: Apache-2.0
"""``hypgen export``: a small model in Cassandra's format, for other solvers."""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path

import click

from hypgen.cli.building import build
from hypgen.cli.exit_codes import EXIT_CODES, Exit, code_of_program
from hypgen.cli.model_arguments import load, model_options, require_params
from hypgen.cli.output import say, say_warnings, write_file


@click.command(epilog=EXIT_CODES)
@model_options
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Where to write the file; standard output without it.",
)
@click.option("--format", type=click.Choice(["cassandra"]), default="cassandra", help="What to write.")
@click.option("--max-states", metavar="N", type=click.IntRange(1), help="Most states; 1,000,000 by default.")
@click.option("--force", is_flag=True, help="Replace a file that is there.")
def command(
    model: Path,
    instance: Path | None,
    settings: tuple[str, ...],
    output: Path | None,
    format: str,
    max_states: int | None,
    force: bool,
) -> int:
    """Write MODEL in Cassandra's format, with every state that can be reached.

    It takes the models that `hypgen solve` takes, as long as all episodes start alike to the eye.

    \b
    Examples:
      hypgen export examples/tiger.pomdp
      hypgen export examples/rock_sample.pomdp -o rock_sample.POMDP
    """
    from hypgen.dsl.foreign.enumerated import dump
    from hypgen.dsl.foreign.enumerated.write_cassandra import SeveralStartsError, export

    loaded = load(model, instance, settings)
    say_warnings(loaded)
    require_params(loaded)
    if output is not None and output.exists() and not force:
        raise click.ClickException(f"{output} is there already: choose another name, or add --force.")
    program = build("exact", loaded, model, instance)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.jsonl"
        limit = [] if max_states is None else [f"--max-states={max_states}"]
        done = subprocess.run([program, f"--dump={path}", "--quiet", *limit], check=False)
        if done.returncode:  # the program has said why
            return code_of_program(done.returncode)
        with path.open(encoding="utf-8") as lines:
            enumerated = dump.read(lines)
    try:
        text = "\n".join(export(enumerated, model.name)) + "\n"
    except SeveralStartsError:
        raise click.ClickException(
            f"{model} starts in {len(enumerated.starts)} ways that the agent can tell apart, and in "
            "Cassandra's format nothing is seen before the first action: give visible variables one start, "
            "and let the first step show what is seen now before it."
        ) from None
    if output is None:
        click.echo(text, nl=False)
    else:
        write_file(output, text, force)
        say(f"{model}: {len(enumerated.values)} states; written to {output}")
    return Exit.OK
