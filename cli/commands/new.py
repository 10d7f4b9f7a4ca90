# SPDX-License-Identifier: Apache-2.0
"""``hypgen new``: a model to start from."""

from __future__ import annotations

import re
from importlib import resources
from pathlib import Path

import click

from hypgen.cli.exit_codes import EXIT_CODES, Exit
from hypgen.cli.output import say, write_file

TEMPLATES = ("minimal", "robot", "memory")


@click.command(epilog=EXIT_CODES)
@click.argument("name")
@click.option(
    "--template",
    type=click.Choice(TEMPLATES),
    default="minimal",
    show_default=True,
    help="minimal: a machine to run, look at or repair. robot: a grid, a family of plants, a policy. "
    "memory: a search, with a policy that remembers.",
)
@click.option(
    "-o",
    "--output",
    metavar="DIR",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path(),
    help="The folder to write to (the current one); made if it is not there.",
)
def command(name: str, template: str, output: Path) -> int:
    """Write a commented model called NAME to start from.

    \b
    Examples:
      hypgen new patrol
      hypgen new garden_robot --template robot -o models
    """
    words = re.findall(r"[A-Z]*[a-z0-9]+|[A-Z]+", name.removesuffix(".pomdp"))
    if not re.fullmatch(r"[A-Za-z][\w-]*(\.pomdp)?", name, re.ASCII) or not words:
        raise click.UsageError(f"'{name}' cannot name a model: use letters, digits and _, a letter first.")
    model = "".join(word[0].upper() + word[1:] for word in words)
    path = output / f"{'_'.join(words).lower()}.pomdp"
    text = resources.files("hypgen.cli").joinpath(f"templates/{template}.pomdp").read_text(encoding="utf-8")
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise click.ClickException(f"{path} cannot be written: {error.strerror}.") from None
    taken = "choose another name or folder"
    write_file(path, text.replace("model Template\n", f"model {model}\n", 1), replace=False, taken=taken)
    click.echo(path)
    say(
        f"""
Now:
  hypgen check {path}    names mistakes, with a remedy for each
  hypgen sim {path}      plays an episode with you
  hypgen run {path}      compiles a solver and lets it play"""
    )
    return Exit.OK
