# SPDX-License-Identifier: Apache-2.0
"""``hypgen compile``: from a model to a solver, or to a C++ project that builds one."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hypgen.cli.building import build, generating
from hypgen.cli.exit_codes import EXIT_CODES, Exit
from hypgen.cli.model_arguments import choose_architectures, choose_cuda, load, model_options, target_options
from hypgen.cli.output import say, say_warnings

if TYPE_CHECKING:
    from hypgen.runtime.builder.exported_project import Kept


@click.command(epilog=EXIT_CODES)
@model_options
@target_options
@click.option(
    "-o",
    "--output",
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Write a project there that builds without hypgen, and the solver to DIR/bin.",
)
@click.option(
    "--library",
    is_flag=True,
    help="Compile libraries with a C interface for programs of your own; -o takes them with headers.",
)
@click.option(
    "--name",
    metavar="NAME",
    help="Call the model so, and its files and functions: for a program with two settings of one model.",
)
@click.option(
    "--emit",
    type=click.Choice(("project", "ros2")),
    help="Write sources, compile nothing; needs -o. project: what -o writes else. ros2: packages for ROS 2.",
)
@click.option("--emit-only", "emit", flag_value="project", default=None, help="The same as --emit project.")
@click.option("--force", is_flag=True, help="Compile the model again even if nothing has changed.")
def command(
    model: Path,
    instance: Path | None,
    settings: tuple[str, ...],
    target: str,
    arch: str,
    nvcc: str,
    output: Path | None,
    library: bool,
    name: str | None,
    emit: str | None,
    force: bool,
) -> int:
    """Compile MODEL into a solver, or libraries, and print the path of what was made.

    Solvers are cached by content in HYPGEN_CACHE_DIR (or the user's cache folder); a model that has not
    changed is not compiled again.

    A solver for GPUs needs CUDA's nvcc, 12.4 or newer, to compile and a driver to run; it plans on the CPU
    where there is none. Without --arch it is for this machine's GPU, and for every one from sm_75 on where
    this machine has none. GPUs newer than those that are named run the code of the newest. What --emit
    writes needs nvcc only where it is compiled.

    \b
    Examples:
      hypgen compile examples/tiger.pomdp
      hypgen compile examples/rock_sample.pomdp --set n=11 --set k=11 -o rock-solver
      hypgen compile examples/tag.pomdp --emit project -o tag && cmake -S tag -B tag/build
      hypgen compile examples/tag.pomdp --emit ros2 -o workspace/src/tag
      hypgen compile examples/rock_sample.pomdp --library -o rock-library
      hypgen compile examples/rs_11_11.pomdp --library --name LargeRocks -o large-rock-library
      hypgen compile examples/tag.pomdp --target cuda
      hypgen compile examples/tag.pomdp --arch sm_80,sm_90 --nvcc /opt/cuda/bin/nvcc -o tag-solver
    """
    from hypgen.codegen import generate
    from hypgen.runtime.builder.exported_project import check_target, export, export_library

    if emit and output is None:
        raise click.UsageError("--emit needs a folder to write to: add -o DIR.")
    if emit and library:
        raise click.UsageError("--emit compiles nothing: leave out --library.")
    if name is not None and not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name):
        raise click.UsageError(f"--name: expected a name such as LargeRocks, found '{name}'.")
    if output is not None:
        check_target(output)
    cuda = None if emit else choose_cuda(target, arch, nvcc)
    architectures = cuda.architectures if cuda else ()
    if emit:
        architectures = choose_architectures(target, arch, nvcc)
    loaded = load(model, instance, settings)
    if name is not None:
        loaded = replace(loaded, model=replace(loaded.model, name=name))
    say_warnings(loaded)
    if library:
        built = build("library", loaded, model, instance, cuda, force)
        if output is not None:
            built, kept = export_library(built, output)
            _tell(kept)
        click.echo(built)
        return Exit.OK
    if emit == "ros2" and output is not None:
        with generating(model):
            project, files = generate.generate_ros2(loaded.model)
        _tell(export(files, output, architectures=architectures, project=project))
        click.echo(output)
        return Exit.OK
    with generating(model):
        files = generate.generate(loaded.model)
    if emit and output is not None:
        _tell(export(files, output, architectures=architectures))
        click.echo(output)
        return Exit.OK
    solver = build("solver", loaded, model, instance, cuda, force, files)
    if output is not None:
        _tell(export(files, output, solver, architectures))
        solver = output / "bin" / solver.name
    click.echo(solver)
    return Exit.OK


def _tell(kept: Sequence[Kept]) -> None:
    """Say which files are not hypgen's any more."""
    for file in kept:
        rest = f"the new one is {file.new}" if file.new else "the project has no such file any more"
        say(f"note: {file.path} was changed and stays as it is; {rest}")
