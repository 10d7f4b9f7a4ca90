"""What the commands share: options, exit codes, and how mistakes reach the user."""

from __future__ import annotations

import contextlib
import enum
import math
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from hypgen.dsl.foreign.reader import Imported
    from hypgen.dsl.load import Loaded
    from hypgen.dsl.messages.diagnostic import Diagnostic, ModelError
    from hypgen.dsl.messages.source import Source
    from hypgen.dsl.messages.watch import Watch
    from hypgen.runtime.builder.cuda_tools import CudaBuild

Command = TypeVar("Command", bound=Callable[..., Any])


class Exit(enum.IntEnum):
    """How a command ends; ``run`` gives the solver's own code where the solver was started."""

    OK = 0
    DIFFERENT = 1  # `fmt --check` found something to do, `check --strict` a warning
    MISTAKE = 2  # the model, an option or the machine: the user can do something about it
    BUG = 70  # hypgen's own (sysexits' EX_SOFTWARE)
    INTERRUPTED = 130


TARGETS = ("auto", "cpu", "cuda", "both")

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


def target_options(command: Command) -> Command:
    """Give a command the options that say which machine a solver is for."""
    target = click.option(
        "--target",
        type=click.Choice(TARGETS),
        default="auto",
        help="cuda (or both): for GPUs too, the CPU as well. auto: so where there is a GPU and an nvcc.",
    )
    arch = click.option(
        "--arch",
        metavar="ARCH",
        default="",
        help="GPUs to compile for: native, all, or a list such as sm_80,sm_90; implies --target cuda.",
    )
    nvcc = click.option(
        "--nvcc", metavar="FILE", default="", help="The CUDA compiler to use; implies --target cuda."
    )
    return target(arch(nvcc(command)))


def choose_cuda(target: str, arch: str, nvcc: str) -> CudaBuild | None:
    """Return how to compile for what ``target_options`` describe, None for the CPU alone."""
    from hypgen.runtime.builder.cuda_tools import choose

    if target == "cpu" and (arch or nvcc):
        raise click.UsageError("--arch and --nvcc are for GPUs: leave out --target cpu.")
    choice = choose(target, arch, nvcc)
    if choice.note:
        say(f"note: {choice.note}")
    return choice.build


def load(model: Path, instance: Path | None, settings: tuple[str, ...], watch: Watch | None = None) -> Loaded:
    """Return the checked model that the options of ``model_options`` describe.

    A file in another format is imported on the way, and the user told so. ``watch`` sees each pass.
    """
    from hypgen.dsl import load as driver
    from hypgen.dsl.messages.source import Source
    from hypgen.dsl.messages.watch import nobody

    given = None
    imported = import_foreign(model, None, None)
    if imported is not None:
        say(f"note: {model}: {describe_import(imported)}; imported (`hypgen import` writes the model)")
        given = Source(f"{model} (imported)", imported.text)
    return driver.load(model, instance=instance, settings=settings, given=given, watch=watch or nobody)


def import_foreign(path: Path, name: str | None, horizon: int | None) -> Imported | None:
    """Return what a file in another format comes to, None for any other file."""
    from hypgen.dsl.foreign import files

    content = files.read(path)
    if content is None:
        return None
    from hypgen.dsl.foreign.reader import import_text

    return import_text(str(path), content, name, horizon)


def describe_import(imported: Imported) -> str:
    """Return in words what was imported."""
    model = imported.model
    sizes = []
    for variables, noun in (
        (model.states, "state"),
        (model.actions, "action"),
        (model.observations, "observation"),
    ):
        number = math.prod(v.size for v in variables)
        sizes.append(f"{number} {noun}{'' if number == 1 else 's'}")
    return " ".join(
        [f"{model.format}, {', '.join(sizes)}", *(f"({note.rstrip('.')})" for note in model.notes)]
    )


def write_whole(path: Path, text: str, force: bool) -> None:
    """Write a file whole or not at all; refuse to replace one unless told to."""
    taken = click.ClickException(f"{path} is there already: choose another name, or add --force.")
    if path.exists() and not force:
        raise taken
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        temporary.write_text(text, encoding="utf-8", newline="\n")
        if force:
            temporary.replace(path)
        else:
            os.link(temporary, path)  # fails where a file has come to be in the meantime
    except FileExistsError:
        raise taken from None
    except OSError as error:
        raise click.ClickException(f"{path} cannot be written: {error.strerror}.") from None
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def require_params(loaded: Loaded, more: str = "") -> None:
    """Refuse a model with a param that has no value; ``more`` names other ways to give one."""
    for param in loaded.model.params:
        if param.default is None:
            name = param.name
            raise click.UsageError(
                f"The param '{name}' has no value: add --set {name}=.., --instance FILE{more}."
            )


def say(text: str) -> None:
    """Print a line about what hypgen does; standard output stays free for results."""
    click.echo(text, err=True)


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
