# SPDX-License-Identifier: Apache-2.0
"""``hypgen doctor``: what this machine has, and what to install."""

from __future__ import annotations

import platform
import sys
from collections.abc import Callable
from typing import Any

import click

from hypgen import __version__
from hypgen.cli.exit_codes import EXIT_CODES, Exit


@click.command(epilog=EXIT_CODES)
def command() -> int:
    """Print what hypgen finds on this machine, and what is missing.

    Ends with 0 if models can be compiled, with 2 if something has to be installed first. CUDA and a GPU may
    be missing: solvers then run on the CPU.

    \b
    Examples:
      hypgen doctor
      CXX=clang++ hypgen doctor
    """
    from hypgen.runtime.builder import cache, tools
    from hypgen.runtime.builder.errors import ToolchainError

    remedies = []

    def line(name: str, find: Callable[[], Any]) -> None:
        try:
            found = find()
        except ToolchainError as error:
            found = f"MISSING: {error.message}"
            remedies.append(error.remedy)
        click.echo(f"{name:14}{found}")

    def program(find: Callable[[], tools.Program | None]) -> Callable[[], str]:
        def show() -> str:
            found = find()
            return f"{found.version} ({found.path})" if found else "not found; CMake's own choice is used"

        return show

    line("hypgen", lambda: __version__)
    line("Python", lambda: f"{platform.python_version()} ({sys.executable})")
    line("system", lambda: f"{platform.system()} {platform.release()}, {platform.machine()}")
    line("C++ compiler", program(tools.find_compiler))
    line("CMake", program(tools.find_cmake))
    line("Ninja", program(tools.find_ninja))
    line("nlohmann-json", tools.find_json)
    line("Eigen", tools.find_eigen)
    line("cache", lambda: cache.folder("solvers").parent)
    hints: list[str] = []
    line("CUDA", lambda: _cuda(hints))
    line("GPU", _gpu)
    for remedy in (*remedies, *hints):
        click.echo(f"help: {remedy}")
    return Exit.MISTAKE if remedies else Exit.OK


def _cuda(hints: list[str]) -> str:
    """Return the CUDA compiler that solvers for GPUs are compiled with, or why there is none."""
    from hypgen.runtime.builder.cuda_tools import find_nvcc
    from hypgen.runtime.builder.errors import ToolchainError

    try:
        found = find_nvcc()
    except ToolchainError as error:
        hints.append(f"for solvers that use a GPU, {error.remedy}")
        return f"{error.message}; solvers run on the CPU"
    return f"{found.version} ({found.path}), for sm_{found.architectures[0]} .. sm_{found.architectures[-1]}"


def _gpu() -> str:
    """Return the GPUs that the driver lists."""
    from hypgen.runtime.builder.cuda_tools import find_gpus

    shown = [f"{g.name}, sm_{g.architecture}, {g.memory}, driver {g.driver}" for g in find_gpus()]
    return "; ".join(shown) or "none that nvidia-smi lists"
