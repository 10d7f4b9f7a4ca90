# SPDX-License-Identifier: Apache-2.0
"""Runs the commands of a build, and tells the machine's faults from hypgen's own."""

from __future__ import annotations

import re
import shlex
import subprocess
import tempfile
from pathlib import Path

from hypgen.cache_folder import cache_folder
from hypgen.runtime.builder import cache
from hypgen.runtime.builder.cuda_tools import CudaBuild, nvcc_command
from hypgen.runtime.builder.errors import BuildError, ToolchainError
from hypgen.runtime.builder.process_group import ProcessGroup
from hypgen.runtime.builder.tools import Tools, user_flags

PROBE = "#include <thread>\n#include <variant>\nint main() { return (int)std::variant<int>{0}.index(); }\n"
CUDA_PROBE = f"#include <cuda_runtime.h>\n__global__ void probe_kernel() {{}}\n{PROBE}"


def call(
    group: ProcessGroup, command: list[str], what: str, tools: Tools, cuda: CudaBuild | None = None
) -> None:
    """Run one build command. Its output goes to a log that the user sees only the path of."""
    done = group.run(command)
    if done.returncode == 0:
        return
    log = cache.write_log(cache.digest(*command), f"{shlex.join(command)}\n\n{done.stdout}")
    with tempfile.TemporaryDirectory(prefix="hypgen-") as folder:
        _blame_machine(group, done, tools, log, Path(folder))
        if cuda is not None and command[0] == str(cuda.nvcc.path):
            _blame_nvcc(group, cuda, tools, log, Path(folder))
    raise BuildError(what, log)


# What compilers, CMake and the system say where the machine lacks something: what it is, and what to do.
LACKS = (
    (  # nvcc reports a signal that ended one of its parts in words of its own
        r"Killed signal|died due to signal 9|\bKilled\b",
        "the compiler was killed",
        "free some memory and try again",
    ),
    (
        r"virtual memory exhausted|[Oo]ut of memory|[Cc]annot allocate memory|std::bad_alloc",
        "the compiler had not enough memory",
        "free some memory, or raise the limit that `ulimit -v` or the container sets",
    ),
    (
        r"Too many open files|Resource temporarily unavailable",
        "the compiler could not open a file or start a program",
        "raise the limits that `ulimit -n` and `ulimit -u` set, or close other programs",
    ),
    (
        r"Cannot create temporary file|unable to make temporary file|Read-only file system",
        "the compiler could not write its temporary files",
        "let the environment variable TMPDIR name a folder that you may write to",
    ),
    (
        r"unable to find a build program",
        "neither Ninja nor make found",
        "run `pip install ninja`",
    ),
)


def require_compiler(group: ProcessGroup, compiler: Path, source: Path, program: Path) -> None:
    """Compile a small C++17 program; raise a ``ToolchainError`` that says why it cannot be done."""
    command = [str(compiler), "-std=c++17", str(source), "-pthread", "-o", str(program)]
    own = [*user_flags("CXXFLAGS"), *user_flags("LDFLAGS")]
    done = group.run([*command, *own])
    if done.returncode == 0:
        return
    _blame_system(done, "")
    if own and group.run(command).returncode == 0:
        raise ToolchainError(
            f"nothing compiles with the flags {' '.join(own)}", "mend or unset CXXFLAGS and LDFLAGS"
        )
    raise ToolchainError(
        f"'{compiler}' cannot build a C++17 program",
        "install g++ 9 or newer with its standard library, or name another compiler in CXX",
    )


def _blame_machine(
    group: ProcessGroup, done: subprocess.CompletedProcess[str], tools: Tools, log: Path, folder: Path
) -> None:
    """Raise a ``ToolchainError`` where the machine, not hypgen's C++, made the command fail."""
    see = f"; see {log}"
    _blame_system(done, see)
    probe = folder / "probe.cpp"
    probe.write_text(PROBE, encoding="utf-8")
    try:
        require_compiler(group, tools.compiler.path, probe, folder / "probe")
    except ToolchainError as error:
        raise ToolchainError(error.message + see, error.remedy) from None


def _blame_system(done: subprocess.CompletedProcess[str], see: str) -> None:
    """Raise a ``ToolchainError`` where a command failed by what the system refused; ``see`` names a log."""
    if re.search(r"No space left on device|Disk quota exceeded", done.stdout):
        raise ToolchainError(
            "the disk is full", f"make room in '{cache_folder()}' and in the temporary folder"
        )
    for pattern, lack, remedy in LACKS:
        if re.search(pattern, done.stdout):
            raise ToolchainError(lack + see, remedy)
    if done.returncode < 0:
        raise ToolchainError(f"the compiler was killed{see}", "free some memory and try again")


def _blame_nvcc(group: ProcessGroup, cuda: CudaBuild, tools: Tools, log: Path, folder: Path) -> None:
    """Raise a ``ToolchainError`` if nvcc cannot compile anything with its host compiler."""
    probe = folder / "probe.cu"
    probe.write_text(CUDA_PROBE, encoding="utf-8")
    command = nvcc_command(cuda, ["-std=c++17"], tools.compiler.path, [])
    done = group.run([*command, "-c", str(probe), "-o", str(folder / "probe.o")])
    if done.returncode == 0:
        return
    errors = [line for line in done.stdout.splitlines() if re.search(r"error|fatal", line, re.IGNORECASE)]
    message = re.sub(r"^.*?(?:#error --|error:|fatal *:)\s*", "", errors[0]) if errors else "no message"
    short = message.split("!")[0].rstrip(".")
    raise ToolchainError(
        f"'{cuda.nvcc.path}' cannot compile with its host compiler: {short}; see {log}",
        f"let NVCC_CCBIN name a g++ that {cuda.nvcc.version} takes, or name another nvcc with --nvcc",
    )
