# SPDX-License-Identifier: Apache-2.0
"""Finds the programs and headers that building a solver takes.

Each is looked for where the user would expect it first (an environment variable, then PATH) and then
among the wheels of this Python environment, which need not be activated.
"""

from __future__ import annotations

import errno
import functools
import hashlib
import importlib.metadata
import importlib.util
import os
import platform
import re
import shlex
import shutil
import subprocess
import sysconfig
from dataclasses import dataclass
from pathlib import Path

from hypgen.runtime.builder.errors import ToolchainError

MINIMUM_CMAKE = (3, 21)
LANES_COMPILER = (12,)  # g++ or clang++: older ones know no such kinds of processors
COMPILERS = ("c++", "g++", "clang++")


@dataclass(frozen=True)
class Program:
    """An executable, and the first line that it prints when asked for its version."""

    path: Path
    version: str


@dataclass(frozen=True)
class Tools:
    """All that a build needs. Without ``ninja`` CMake chooses a generator itself."""

    compiler: Program
    cmake: Program
    ninja: Program | None
    json_include: Path


def find_tools() -> Tools:
    """Return this machine's tools; a ``ToolchainError`` names the first that is missing."""
    return Tools(find_compiler(), find_cmake(), find_ninja(), find_json())


def find_compiler() -> Program:
    """Return the C++ compiler: ``$CXX`` if set, otherwise the first of ``COMPILERS`` on PATH."""
    wanted = os.environ.get("CXX")
    for name in (wanted,) if wanted else COMPILERS:
        program = _program(shutil.which(name))
        if program is not None:
            return program
    missing = f"CXX names '{wanted}', which does not run" if wanted else "no C++ compiler found"
    raise ToolchainError(
        missing,
        "unset CXX or let it name one C++17 compiler, without options"
        if wanted
        else "install g++ 9 or newer, for example with `sudo apt-get install g++`",
    )


def find_cmake() -> Program:
    """Return the first CMake that is new enough."""
    found = ""
    for candidate in _candidates("cmake"):
        program = _program(candidate)
        if program is not None and numbers(program.version) >= MINIMUM_CMAKE:
            return program
        found = f" (too old: {program.version})" if program is not None else found
    minimum = ".".join(map(str, MINIMUM_CMAKE))
    raise ToolchainError(f"no CMake {minimum} or newer found{found}", "run `pip install cmake`")


def find_ninja() -> Program | None:
    """Return Ninja if there is one."""
    return next((p for c in _candidates("ninja") if (p := _program(c)) is not None), None)


def require_builder() -> str:
    """Return what runs the commands of a CMake build."""
    found = find_ninja()
    if found is not None:
        return f"{found.version} ({found.path})"
    make = shutil.which("make") or shutil.which("gmake")
    if make is None:
        raise ToolchainError("neither Ninja nor make found", "run `pip install ninja`")
    return f"not found; {make} is used"


def find_archiver() -> Path:
    """Return the program that makes static libraries."""
    found = shutil.which("ar")
    if found is None:
        raise ToolchainError("no ar found", "install it, for example with `sudo apt-get install binutils`")
    return Path(found)


def find_json() -> Path:
    """Return the folder that holds ``nlohmann/json.hpp``."""
    spec = importlib.util.find_spec("nlohmann_json")
    wheels = [Path(p) / "include" for p in (spec.submodule_search_locations or ())] if spec else []
    for folder in (*wheels, Path("/usr/local/include"), Path("/usr/include")):
        if (folder / "nlohmann" / "json.hpp").is_file():
            return folder
    raise ToolchainError("the headers of nlohmann-json are missing", "run `pip install nlohmann-json`")


def find_eigen() -> Path:
    """Return the folder that holds ``Eigen/Core``, which only the exact solver takes."""
    try:
        listed = importlib.metadata.files("cmeel-eigen") or []
    except importlib.metadata.PackageNotFoundError:
        listed = []
    wheels = [Path(str(f.locate())).parent.parent for f in listed if f.match("*/eigen3/Eigen/Core")]
    for folder in (Path("/usr/local/include/eigen3"), Path("/usr/include/eigen3"), *wheels):
        if (folder / "Eigen" / "SparseCore").is_file():
            return folder
    raise ToolchainError("the headers of Eigen are missing", "run `pip install cmeel-eigen`")


@functools.cache
def cpu_features() -> str:
    """Return a name for what ``-march=native`` means here: machine and a hash of the CPU's feature flags."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        text = platform.processor()
    wanted = re.findall(r"^(?:flags|Features|model name|CPU part)\s*:(.*)$", text, re.MULTILINE)
    # Cores may differ in order of lines, never in kind: a set makes the name stable.
    digest = hashlib.sha256("\n".join(sorted(set(wanted))).encode()).hexdigest()
    return f"{platform.machine()}-{digest[:12]}"


def widest_lanes(compiler: Program) -> str:
    """Return the widest lanes that this machine runs, a name of cmake/lanes.txt; empty if there are none."""
    if platform.machine() != "x86_64" or numbers(compiler.version) < LANES_COMPILER:
        return ""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
    line = re.search(r"^flags\s*:(.*)$", text, re.MULTILINE)
    flags = set(line.group(1).split()) if line else set()
    if not flags >= {"avx2", "fma", "bmi1", "bmi2"}:
        return ""
    return "avx512" if flags >= {f"avx512{part}" for part in ("f", "bw", "cd", "dq", "vl")} else "avx2"


def user_flags(variable: str) -> list[str]:
    """Return the words of CXXFLAGS or LDFLAGS."""
    try:
        return shlex.split(os.environ.get(variable, ""))
    except ValueError as error:
        problem = str(error).lower()  # "no closing quotation"
        raise ToolchainError(f"{variable} has {problem}", f"mend or unset {variable}") from None


def run(command: list[str]) -> str | None:
    """Return the standard output of a short command, or None if it cannot run or fails.

    Raises ``OSError`` where the system has nothing left to start a program with.
    """
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=30, check=True
        )
    except OSError as error:
        if error.errno in (errno.EMFILE, errno.ENFILE, errno.ENOMEM, errno.EAGAIN):
            raise
        return None
    except subprocess.SubprocessError:
        return None
    return done.stdout


def _candidates(name: str) -> list[str]:
    """Return PATH's program of this name and the one beside this Python."""
    beside = Path(sysconfig.get_path("scripts")) / name
    return [c for c in (shutil.which(name), str(beside) if beside.is_file() else None) if c]


def _program(path: str | None) -> Program | None:
    """Return the program at ``path`` if it runs."""
    output = run([path, "--version"]) if path else None
    if path is None or not output:
        return None
    # Not resolved: a compiler may be a link to ccache, which goes by the name that it is called under.
    return Program(Path(path).absolute(), output.splitlines()[0])


def numbers(version: str) -> tuple[int, ...]:
    """Return the first dotted number in a version line."""
    match = re.search(r"\d+(?:\.\d+)+", version)
    return tuple(map(int, match.group().split("."))) if match else ()
