"""What the commands share: options, exit codes, and how mistakes reach the user."""

from __future__ import annotations

import enum
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from hypgen.dsl.diagnostics import Diagnostic, ModelError
    from hypgen.dsl.driver import Loaded
    from hypgen.dsl.source import Source

Command = TypeVar("Command", bound=Callable[..., Any])


class Exit(enum.IntEnum):
    """How a command ends; ``run`` gives the solver's own code where the solver was started."""

    OK = 0
    DIFFERENT = 1  # `fmt --check` found something to do, `check --strict` a warning
    MISTAKE = 2  # the model, an option or the machine: the user can do something about it
    BUG = 70  # hypgen's own (sysexits' EX_SOFTWARE)
    INTERRUPTED = 130


EXIT_CODES = """\b
Exit codes:
  0    fine
  2    a mistake in the model or the options, or a missing tool
  70   a bug of hypgen; HYPGEN_DEBUG=1 shows where
  130  interrupted"""


def exit_codes(one: str) -> str:
    """Return the exit codes of a command that also ends with 1, and when it does."""
    return EXIT_CODES.replace("  2 ", f"  1    {one}\n  2 ", 1)


def model_options(command: Command) -> Command:
    """Give a command its MODEL argument and the options that change what the model says."""
    model = click.argument("model", metavar="MODEL", type=click.Path(path_type=Path))
    instance = click.option(
        "--instance",
        metavar="FILE",
        type=click.Path(path_type=Path),
        help="Take values from an instance file.",
    )
    settings = click.option(
        "--set",
        "settings",
        metavar="NAME=VALUE",
        multiple=True,
        help="Give a const or param another value; may be repeated.",
    )
    return model(instance(settings(command)))


def load(model: Path, instance: Path | None, settings: tuple[str, ...]) -> Loaded:
    """Return the checked model that the options of ``model_options`` describe."""
    from hypgen.dsl import driver

    return driver.load(model, instance=instance, settings=settings)


def say(text: str) -> None:
    """Print a line about what hypgen does; standard output stays free for results."""
    click.echo(text, err=True)


def say_warnings(loaded: Loaded) -> None:
    """Print a model's warnings, a line each."""
    if loaded.warnings:
        from hypgen.dsl.snippet import render_line

        for warning in loaded.warnings:
            say(render_line(warning))


def show_model_error(error: ModelError) -> None:
    """Print every diagnostic of a model to standard error, and where to read more of the first."""
    show_diagnostics(error.diagnostics, error.sources)
    say(f"\n`hypgen error {error.diagnostics[0].code}` has an example")


def show_diagnostics(diagnostics: Sequence[Diagnostic], sources: Mapping[str, Source]) -> None:
    """Print diagnostics to standard error, coloured where a person reads it."""
    from hypgen.dsl.snippet import render_all

    text = render_all(diagnostics, sources)
    if not sys.stderr.isatty() or os.environ.get("NO_COLOR"):
        click.echo(text, err=True, nl=False)
        return
    from rich.console import Console
    from rich.text import Text

    styled = Text(text)
    styled.highlight_regex(r"(?m)^error\[\w+\]:.*$", "bold red")
    styled.highlight_regex(r"(?m)^warning\[\w+\]:.*$", "bold yellow")
    styled.highlight_regex(r"(?m)^help:", "bold cyan")
    styled.highlight_regex(r"\^+", "bold red")
    Console(stderr=True, highlight=False).print(styled, end="", soft_wrap=True)
