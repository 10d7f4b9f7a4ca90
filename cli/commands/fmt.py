# SPDX-License-Identifier: Apache-2.0
"""``hypgen fmt``: lay out model files the one way."""

from __future__ import annotations

import difflib
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hypgen.cli.exit_codes import Exit, exit_codes
from hypgen.cli.output import say, show_model_error, write_file

if TYPE_CHECKING:
    from hypgen.dsl.messages.source import Source

STDIN = "-"


@click.command(epilog=exit_codes("with --check: a file is not formatted"))
@click.argument("files", metavar="FILE...", nargs=-1, required=True)
@click.option("--check", is_flag=True, help="Write nothing; end with 1 if a file is laid out otherwise.")
@click.option("--diff", is_flag=True, help="Write nothing; print what would change.")
def command(files: tuple[str, ...], check: bool, diff: bool) -> int:
    """Lay out model, instance and library files.

    Spaces and indentation become uniform, and lines over 100 columns are broken. Tokens, comments and other
    line breaks stay, and what is aligned stays aligned. With `-` for FILE, standard input is formatted to
    standard output.

    \b
    Examples:
      hypgen fmt model.pomdp
      hypgen fmt --check examples/*.pomdp
      hypgen fmt --diff model.pomdp
      hypgen fmt - < model.pomdp
    """
    from hypgen.dsl.format.formatter import format_source
    from hypgen.dsl.messages.diagnostic import ModelError

    failed, changed = False, 0
    for name in files:
        try:
            before, source = _read(name)
            after = format_source(source)
        except ModelError as error:
            show_model_error(error)
            failed = True
            continue
        differs = after.encode() != before
        changed += differs
        if diff and differs:
            click.echo(_difference(name, source.text, after), nl=False)
        if check and differs:
            say(f"{name}: not formatted")
        if diff or check:
            continue
        if name == STDIN:
            click.echo(after, nl=False)
        elif differs:
            write_file(Path(name), after)
            say(f"{name}: formatted")
    if failed:
        return Exit.MISTAKE
    if not changed and STDIN not in files:
        say(f"{len(files)} file{'s' if len(files) > 1 else ''} already formatted")
    return Exit.DIFFERENT if check and changed else Exit.OK


def _read(name: str) -> tuple[bytes, Source]:
    """Return a file's bytes and its text."""
    from hypgen.dsl.load import MAX_BYTES, decode_source, read_content

    if name != STDIN:
        content = read_content(name)
        return content, decode_source(name, content)
    content = sys.stdin.buffer.read(MAX_BYTES + 1)
    return content, decode_source("<stdin>", content)


def _difference(name: str, before: str, after: str) -> str:
    lines = difflib.unified_diff(
        before.splitlines(keepends=True), after.splitlines(keepends=True), name, f"{name} (formatted)"
    )
    return "".join(
        line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in lines
    )
