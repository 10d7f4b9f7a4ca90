# SPDX-License-Identifier: Apache-2.0
"""``hypgen import``: a model in another format as a model of this language."""

from __future__ import annotations

import re
from pathlib import Path

import click

from hypgen.cli.exit_codes import EXIT_CODES, Exit
from hypgen.cli.foreign_models import describe_import, import_foreign
from hypgen.cli.output import say, write_file


@click.command("import", epilog=EXIT_CODES)
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Where to write the model; standard output without it.",
)
@click.option("--name", metavar="NAME", help="The model's name; by default it follows from the file's.")
@click.option(
    "--horizon",
    metavar="N",
    type=click.IntRange(1, 2**31 - 1),
    help="End episodes after N steps; a discount of 1 may need it.",
)
@click.option("--normalise", is_flag=True, help="Scale rows of rounded probabilities to sum to 1.")
@click.option(
    "--tolerance",
    metavar="X",
    type=click.FloatRange(0, 1, max_open=True),
    help="By how much --normalise lets a row be off 1.  [default: 0.01]",
)
@click.option("--force", is_flag=True, help="Replace a file that is there.")
def command(
    file: Path,
    output: Path | None,
    name: str | None,
    horizon: int | None,
    normalise: bool,
    tolerance: float | None,
    force: bool,
) -> int:
    """Write FILE, in Cassandra's format or POMDPX, as a model of this language.

    The format is told by the content. The other commands take such a file as it is and import it on the way.

    \b
    Examples:
      hypgen import tiger.95.POMDP
      hypgen import hallway.POMDP -o hallway.pomdp --name Hallway
      hypgen import line.POMDP --horizon 100 -o line.pomdp
      hypgen import rounded.POMDP --normalise --tolerance 0.001
    """
    from hypgen.dsl import load
    from hypgen.dsl.foreign import files
    from hypgen.dsl.foreign.tables.rows import ROUGH, TOLERANCE
    from hypgen.dsl.messages.source import Source

    if name is not None and not re.fullmatch(r"[A-Za-z_]\w*", name, re.ASCII):
        raise click.UsageError(f"'{name}' cannot name a model: use letters, digits and _, a letter first.")
    if tolerance is not None and not normalise:
        raise click.UsageError("--tolerance says what --normalise scales: give that too.")
    if normalise:
        tolerance = ROUGH if tolerance is None else max(tolerance, TOLERANCE)
    imported = import_foreign(file, name, horizon, tolerance)
    if imported is None:
        load.read_source(str(file))  # a file that cannot be read is told as everywhere
        raise files.refusal(str(file))
    load.load(file, given=Source(f"{file} (imported)", imported.text))
    if output is None:
        click.echo(imported.text, nl=False)
    else:
        write_file(output, imported.text, force)
    say(f"{file}: {describe_import(imported)}" + (f"; written to {output}" if output else ""))
    return Exit.OK
