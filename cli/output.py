# SPDX-License-Identifier: Apache-2.0
"""What all commands print to standard error, and how they write files."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING

import click

from hypgen.whole_files import write_whole

if TYPE_CHECKING:  # at run time only where a command needs them: `check` answers in a fraction of a second
    from hypgen.dsl.load import Loaded
    from hypgen.dsl.messages.diagnostic import Diagnostic, ModelError
    from hypgen.dsl.messages.source import Source


def say(text: str, nl: bool = True) -> None:
    """Print a line about what hypgen does; standard output stays free for results."""
    with contextlib.suppress(OSError):  # what nobody can read ends no command
        click.echo(text, err=True, nl=nl)


def say_warnings(loaded: Loaded) -> None:
    """Print a model's warnings, a line each."""
    if loaded.warnings:
        from hypgen.dsl.messages.render import render_line

        for warning in loaded.warnings:
            say(render_line(warning))


def show_model_error(error: ModelError) -> None:
    """Print every diagnostic of a model to standard error, and where to read more of the first."""
    show_diagnostics(error.diagnostics, error.sources)
    say(f"\n`hypgen error {error.diagnostics[0].code}` has an example")


def show_diagnostics(diagnostics: Sequence[Diagnostic], sources: Mapping[str, Source]) -> None:
    """Print diagnostics to standard error, coloured where a person reads it."""
    from hypgen.dsl.messages.render import render_all

    text = render_all(diagnostics, sources)
    if not sys.stderr.isatty() or os.environ.get("NO_COLOR"):
        say(text, nl=False)
        return
    from rich.console import Console
    from rich.text import Text

    styled = Text(text)
    styled.highlight_regex(r"(?m)^error\[\w+\]:.*$", "bold red")
    styled.highlight_regex(r"(?m)^warning\[\w+\]:.*$", "bold yellow")
    styled.highlight_regex(r"(?m)^help:", "bold cyan")
    styled.highlight_regex(r"\^+", "bold red")
    Console(stderr=True, highlight=False).print(styled, end="", soft_wrap=True)


def write_file(
    path: Path, content: str | bytes, replace: bool = True, taken: str = "choose another name, or add --force"
) -> None:
    """Write a file whole or not at all; refuse to replace one unless told to, and say what is ``taken``."""
    try:
        write_whole(path, content, replace=replace)
    except FileExistsError:
        raise click.ClickException(f"{path} is there already: {taken}.") from None
    except OSError as error:
        raise click.ClickException(f"{path} cannot be written: {error.strerror}.") from None


def keep_unwritten() -> None:
    """Let standard output keep what it could not write, which `python -u` would not, for ``last_words``.

    It stays open.
    """
    if (out := sys.stdout) is not None:  # it is, where the shell has closed it
        handle, form = out.fileno(), out.encoding
        sys.stdout = open(handle, "w", encoding=form, errors=out.errors, closefd=False)  # noqa: SIM115


def last_words(stream: IO[str] | None) -> OSError | None:
    """Write what waits in a standard stream; return why that fails.

    The stream then loses it, so that the interpreter does not try again at its end and fail.
    """
    if stream is None:
        return None
    try:
        stream.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        return error
    return None
