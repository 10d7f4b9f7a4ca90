# SPDX-License-Identifier: Apache-2.0
"""``hypgen doctor``: what this machine has, and what to install."""

from __future__ import annotations

import platform
import shutil
import stat
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from hypgen import __version__
from hypgen.cli.exit_codes import EXIT_CODES, Exit
from hypgen.cli.machine_faults import explain_system_error

if TYPE_CHECKING:  # at run time only where a command needs them
    from hypgen.runtime.builder.cuda_tools import Nvcc

LITTLE_ROOM = 200_000_000  # bytes; with less, a build may end with a full disk


@click.command(epilog=EXIT_CODES)
def command() -> int:
    """Print what hypgen finds on this machine, and what is missing.

    Ends with 0 if models can be compiled, with 2 if something has to be installed or mended first. CUDA and a
    GPU may be missing: solvers then run on the CPU. Lines that begin with `help:` say what to do.

    \b
    Examples:
      hypgen doctor
      CXX=clang++ hypgen doctor
    """
    from hypgen.cli import machine_checks
    from hypgen.runtime.builder import tools
    from hypgen.runtime.builder.cuda_tools import find_gpus
    from hypgen.runtime.builder.errors import ToolchainError

    remedies = []

    def line(name: str, find: Callable[[], Any], fault: str = "MISSING") -> None:
        try:
            found = find()
        except ToolchainError as error:
            found = f"{fault}: {error.message}"
            remedies.append(error.remedy)
        except OSError as error:
            message, remedy = explain_system_error(error)
            found = f"MISSING: {message}"
            remedies.append(remedy)
        click.echo(f"{name:14}{found}")

    def program(find: Callable[[], tools.Program]) -> Callable[[], str]:
        def show() -> str:
            found = find()
            return f"{found.version} ({found.path})"

        return show

    line("hypgen", lambda: __version__)
    line("Python", lambda: f"{platform.python_version()} ({sys.executable})")
    line("system", lambda: f"{platform.system()} {platform.release()}, {platform.machine()}")
    line("C++ compiler", program(tools.find_compiler))
    line("CMake", program(tools.find_cmake))
    line("Ninja", tools.require_builder)
    line("nlohmann-json", tools.find_json)
    line("Eigen", tools.find_eigen)
    hints: list[str] = []
    line("cache", lambda: _cache(hints), "UNUSABLE")

    def show(finding: machine_checks.Finding) -> None:
        click.echo(f"{finding.name:14}{finding.found}")
        if finding.remedy:
            (remedies if finding.is_missing else hints).append(finding.remedy)

    for finding in machine_checks.findings():
        show(finding)
    nvcc = _find_nvcc(hints)
    line("GPU", _gpu)
    show(machine_checks.driver(find_gpus(), nvcc))
    for remedy in (*remedies, *hints):
        click.echo(f"help: {remedy}")
    return Exit.MISTAKE if remedies else Exit.OK


def _cache(hints: list[str]) -> str:
    """Return the cache's folder, who may do what there, what it holds, and how much room is left."""
    from hypgen.runtime.builder import cache
    from hypgen.runtime.builder.private_files import owner

    found = cache.contents()
    path = cache.root()
    status = path.stat()
    free = shutil.disk_usage(path).free
    if free < LITTLE_ROOM:
        hints.append(f"make room in '{path}': a build writes tens of megabytes")
    entries = f"{found.entries} entr{'y' if found.entries == 1 else 'ies'}"
    rights = f"{owner(status.st_uid)}, {stat.filemode(status.st_mode)}"
    return f"{path} ({rights}), {entries}, {_megabytes(found.size)}, {_megabytes(free)} free"


def _megabytes(size: int) -> str:
    return f"{size / 1e6:,.1f} MB" if size < 1e9 else f"{size / 1e9:,.1f} GB"


def _find_nvcc(hints: list[str]) -> Nvcc | None:
    """Show the CUDA compiler that solvers for GPUs are compiled with, or why there is none."""
    from hypgen.runtime.builder.cuda_tools import find_nvcc
    from hypgen.runtime.builder.errors import ToolchainError

    try:
        found = find_nvcc()
    except ToolchainError as error:
        hints.append(f"for solvers that use a GPU, {error.remedy}")
        click.echo(f"{'CUDA':14}{error.message}; solvers run on the CPU")
        return None
    first, last = found.architectures[0], found.architectures[-1]
    click.echo(f"{'CUDA':14}{found.version} ({found.path}), for sm_{first} .. sm_{last}")
    return found


def _gpu() -> str:
    """Return the GPUs that the driver lists."""
    from hypgen.runtime.builder.cuda_tools import find_gpus

    shown = [f"{g.name}, sm_{g.architecture}, {g.memory}, driver {g.driver}" for g in find_gpus()]
    return "; ".join(shown) or "none that nvidia-smi lists"
