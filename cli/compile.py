"""``hypgen compile``: from a model to a solver, or to a C++ project that builds one."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hypgen.cli.common import EXIT_CODES, Exit, load, model_options, say, say_warnings

if TYPE_CHECKING:
    from hypgen.dsl.driver import Loaded
    from hypgen.runtime.build import Step


@click.command(epilog=EXIT_CODES)
@model_options
@click.option(
    "-o",
    "--output",
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Write a project there that builds without hypgen, and the solver to DIR/bin.",
)
@click.option("--emit-only", is_flag=True, help="Write the project, compile nothing; needs -o.")
@click.option("--force", is_flag=True, help="Compile the model again even if nothing has changed.")
def command(
    model: Path,
    instance: Path | None,
    settings: tuple[str, ...],
    output: Path | None,
    emit_only: bool,
    force: bool,
) -> int:
    """Compile MODEL into a solver and print the path of what was made.

    Solvers are cached by content in HYPGEN_CACHE_DIR (or the user's cache folder); a model that has not
    changed is not compiled again.

    \b
    Examples:
      hypgen compile examples/tiger.pomdp
      hypgen compile examples/rock_sample.pomdp --set n=11 --set k=11 -o rock-solver
      hypgen compile examples/tag.pomdp -o tag --emit-only && cmake -S tag -B tag/build
    """
    from hypgen.codegen import driver
    from hypgen.runtime.export import check_target, export

    if emit_only and output is None:
        raise click.UsageError("--emit-only needs a folder to write to: add -o DIR.")
    if output is not None:
        check_target(output)
    loaded = load(model, instance, settings)
    say_warnings(loaded)
    files = driver.generate(loaded.model)
    if emit_only and output is not None:
        export(files, output)
        click.echo(output)
        return Exit.OK
    solver = build(loaded, files, model, instance, force)
    if output is not None:
        export(files, output, solver)
        solver = output / "bin" / solver.name
    click.echo(solver)
    return Exit.OK


def build(loaded: Loaded, files: dict[str, str], model: Path, instance: Path | None, force: bool) -> Path:
    """Return the project's executable, telling the user what is built and why."""
    from hypgen.runtime.build import build_solver

    origin = " ".join(str(path.absolute()) for path in (model, instance) if path is not None)
    with _spinner():
        return build_solver(files, origin, _report, model=loaded.model.source_hash, again=force)


def _report(step: Step) -> None:
    """Say what is built and why."""
    say(f"{step.what}: {'compiling (' + step.reason + ')' if step.reason else 'cached'}")


def _spinner() -> contextlib.AbstractContextManager[object]:
    """Return something that turns while the compiler runs, where a person watches."""
    if not sys.stderr.isatty():
        return contextlib.nullcontext()
    from rich.console import Console

    return Console(stderr=True).status("compiling")
