# SPDX-License-Identifier: Apache-2.0
"""The arguments that many commands take, as decorators, and what they stand for: a model, GPUs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from hypgen.cli.foreign_models import describe_import, import_foreign
from hypgen.cli.output import say
from hypgen.cli.progress import notice

if TYPE_CHECKING:  # at run time only where a command needs them: `check` answers in a fraction of a second
    from hypgen.dsl.load import Loaded
    from hypgen.dsl.messages.watch import Watch
    from hypgen.runtime.builder.cuda_tools import CudaBuild

Command = TypeVar("Command", bound=Callable[..., Any])

TARGETS = ("auto", "cpu", "cuda", "both")


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


def param_option(command: Command) -> Command:
    """Give a command the option for a file with values of the model's params."""
    return click.option(
        "--param",
        metavar="FILE",
        type=click.Path(path_type=Path),
        help="JSON file that sets the model's params.",
    )(command)


def choose_cuda(target: str, arch: str, nvcc: str) -> CudaBuild | None:
    """Return how to compile for what ``target_options`` describe, None for the CPU alone."""
    from hypgen.runtime.builder.cuda_tools import choose

    if target == "cpu" and (arch or nvcc):
        raise click.UsageError("--arch and --nvcc are for GPUs: leave out --target cpu.")
    choice = choose(target, arch, nvcc)
    if choice.note:
        say(f"note: {choice.note}")
    return choice.build


def choose_architectures(target: str, arch: str, nvcc: str) -> tuple[int, ...]:
    """Return the GPUs for which a project is written that is compiled elsewhere, where nvcc may be."""
    from hypgen.runtime.builder.cuda_tools import architectures_to_emit

    found = None if target == "cpu" or nvcc else architectures_to_emit(target, arch)
    if found is None:
        cuda = choose_cuda(target, arch, nvcc)
        found = cuda.architectures if cuda else ()
    return found


def load(model: Path, instance: Path | None, settings: tuple[str, ...], watch: Watch | None = None) -> Loaded:
    """Return the checked model that the options of ``model_options`` describe.

    A file in another format is imported on the way, and the user told so. ``watch`` sees each pass.
    """
    from hypgen.dsl import load as driver
    from hypgen.dsl.messages.source import Source
    from hypgen.dsl.messages.watch import nobody

    given = None
    imported = import_foreign(model, None, None, None)
    if imported is not None:
        say(f"note: {model}: {describe_import(imported)}; imported (`hypgen import` writes the model)")
        given = Source(f"{model} (imported)", imported.text)
    with notice(f"{model}: checking"):
        return driver.load(model, instance=instance, settings=settings, given=given, watch=watch or nobody)


def require_params(loaded: Loaded, more: str = "") -> None:
    """Refuse a model with a param that has no value; ``more`` names other ways to give one."""
    for param in loaded.model.params:
        if param.default is None:
            name = param.name
            raise click.UsageError(
                f"The param '{name}' has no value: add --set {name}=.., --instance FILE{more}."
            )
