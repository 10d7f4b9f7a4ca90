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
from hypgen.runtime.builder.tools import Tools

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


def _blame_machine(
    group: ProcessGroup, done: subprocess.CompletedProcess[str], tools: Tools, log: Path, folder: Path
) -> None:
    """Raise a ``ToolchainError`` where the machine, not hypgen's C++, made the command fail."""
    # nvcc reports a signal that ended one of its parts in words of its own.
    if done.returncode < 0 or re.search(r"Killed signal|died due to signal 9|\bKilled\b", done.stdout):
        raise ToolchainError(f"the compiler was killed; see {log}", "free some memory and try again")
    if "No space left on device" in done.stdout:
        raise ToolchainError(
            "the disk is full", f"make room in '{cache_folder()}' and in the temporary folder"
        )
    probe = folder / "probe.cpp"
    probe.write_text(PROBE, encoding="utf-8")
    command = [str(tools.compiler.path), "-std=c++17", str(probe), "-pthread", "-o", str(folder / "probe")]
    if group.run(command).returncode != 0:
        raise ToolchainError(
            f"'{tools.compiler.path}' cannot build a C++17 program; see {log}",
            "install g++ 9 or newer with its standard library, or name another compiler in CXX",
        )


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
