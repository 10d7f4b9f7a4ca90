# SPDX-License-Identifier: Apache-2.0
"""``hypgen error``: what a diagnostic's code means."""

from __future__ import annotations

import textwrap

import click

from hypgen.cli.exit_codes import EXIT_CODES, Exit


@click.command(epilog=EXIT_CODES)
@click.argument("code", metavar="[CODE]", required=False)
def command(code: str | None) -> int:
    """Print what the CODE of a message means, with an example; without CODE, list all of them.

    \b
    Examples:
      hypgen error E0601
      hypgen error | grep -i unit
    """
    from hypgen.cli.show.error_index import Example, entries

    found = entries()
    if code is None:
        for entry in found.values():
            click.echo(f"{entry.code:5}  {entry.meaning}")
        return Exit.OK
    chosen = found.get(code.upper())
    if chosen is None:
        raise click.UsageError(f"there is no code '{code}': hypgen error lists all of them.")
    click.echo(textwrap.fill(f"{chosen.code}: {chosen.meaning}", 100))

    def show(heading: str, example: Example) -> None:
        click.echo(f"\n{heading}\n")
        if example.options:
            click.echo(f"    hypgen check example.pomdp {' '.join(example.options)}\n")
        click.echo(textwrap.indent(example.text.rstrip("\n"), "    "))
        for name, text in example.named_files().items():
            click.echo(textwrap.indent(f"\n# {name}\n{text.rstrip()}", "    "))

    show("Wrong:" if chosen.right else "For example:", chosen.wrong)
    if chosen.right:
        show("Right:", chosen.right)
    return Exit.OK
