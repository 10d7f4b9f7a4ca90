"""``hypgen doctor``: what this machine has, and what to install."""

from __future__ import annotations

import platform
import shutil
import sys
from collections.abc import Callable
from typing import Any

import click

from hypgen import __version__
from hypgen.cli.common import EXIT_CODES, Exit


@click.command(epilog=EXIT_CODES)
def command() -> int:
    """Print what hypgen finds on this machine, and what is missing.

    Ends with 0 if models can be compiled, with 2 if something has to be installed first.

    \b
    Examples:
      hypgen doctor
      CXX=clang++ hypgen doctor
    """
    from hypgen.runtime import cache, toolchain
    from hypgen.runtime.errors import ToolchainError

    remedies = []

    def line(name: str, find: Callable[[], Any]) -> None:
        try:
            found = find()
        except ToolchainError as error:
            found = f"MISSING: {error.message}"
            remedies.append(error.remedy)
        click.echo(f"{name:14}{found}")

    def program(find: Callable[[], toolchain.Program | None]) -> Callable[[], str]:
        def show() -> str:
            found = find()
            return f"{found.version} ({found.path})" if found else "not found; CMake's own choice is used"

        return show

    line("hypgen", lambda: __version__)
    line("Python", lambda: f"{platform.python_version()} ({sys.executable})")
    line("system", lambda: f"{platform.system()} {platform.release()}, {platform.machine()}")
    line("C++ compiler", program(toolchain.find_compiler))
    line("CMake", program(toolchain.find_cmake))
    line("Ninja", program(toolchain.find_ninja))
    line("nlohmann-json", toolchain.find_json)
    line("cache", lambda: cache.folder("solvers").parent)
    line("CUDA", _cuda)
    line("GPU", _gpu)
    for remedy in remedies:
        click.echo(f"help: {remedy}")
    return Exit.MISTAKE if remedies else Exit.OK


def _cuda() -> str:
    """Return the CUDA compiler's version."""
    from hypgen.runtime.toolchain import run

    path = shutil.which("nvcc")
    output = run([path, "--version"]) if path else None
    lines = [line for line in (output or "").splitlines() if "release" in line]
    return f"{lines[0]} ({path})" if lines else "no nvcc; solvers run on the CPU"


def _gpu() -> str:
    """Return the GPUs that the driver lists."""
    from hypgen.runtime.toolchain import run

    path = shutil.which("nvidia-smi")
    query = "--query-gpu=name,driver_version,memory.total"
    output = run([path, query, "--format=csv,noheader"]) if path else None
    return "; ".join((output or "").strip().splitlines()) or "none"
