# SPDX-License-Identifier: Apache-2.0
"""Finds nvcc and the GPUs of this machine, and decides whether and for which GPUs a solver gets CUDA code."""

from __future__ import annotations

import functools
import importlib.util
import os
import platform
import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.tools import numbers, run

# The first that takes the g++ of the current long-term distributions (13) as its host compiler. C++17 and
# sm_90 came earlier.
MINIMUM_NVCC = (12, 4)
SYSTEM_TOOLKIT = Path("/usr/local/cuda")
WSL_SMI = Path("/usr/lib/wsl/lib/nvidia-smi")  # where Windows puts it, on nobody's PATH
RUNTIME_LIBRARY = "libcudart_static.a"
# Every GPU runs the code of its own generation, and newer ones the last of these, translated by their driver.
GENERATIONS = (75, 80, 90)
ALL_ARCHITECTURES = (75, 80, 86, 89, 90, 100, 120)
REMEDY = (
    "run `pip install 'hypgen[cuda]'` (in a clone: `pip install '.[cuda]'`), or install CUDA {}.{} or newer"
)


@dataclass(frozen=True)
class Nvcc:
    """A CUDA compiler, the folder of its static runtime library, and the architectures that it knows."""

    path: Path
    version: str
    library: Path
    architectures: tuple[int, ...]


@dataclass(frozen=True)
class Gpu:
    """A GPU as its driver describes it; ``architecture`` is 90 for compute capability 9.0."""

    name: str
    driver: str
    memory: str
    architecture: int


@dataclass(frozen=True)
class CudaBuild:
    """What a solver is compiled with besides the C++ compiler: ``nvcc``, and for which GPUs."""

    nvcc: Nvcc
    architectures: tuple[int, ...]


@dataclass(frozen=True)
class Choice:
    """Whether to compile for GPUs; ``note`` says why not where a GPU could have been used."""

    build: CudaBuild | None
    note: str = ""


def choose(target: str = "auto", arch: str = "", nvcc: str = "") -> Choice:
    """Return how to compile for ``cpu``, ``cuda`` (also called ``both``) or ``auto``.

    ``auto`` is ``cuda`` where this machine has a GPU and an nvcc that can be used, or where ``arch`` or
    ``nvcc`` is named. The CPU's code is always built in.
    """
    wanted = _is_wanted(target, arch, nvcc)
    if target == "cpu" or not (wanted or find_gpus()):
        return Choice(None)
    try:
        compiler = find_nvcc(nvcc)
        return Choice(CudaBuild(compiler, architectures_of(arch, compiler)))
    except ToolchainError as error:
        if wanted:
            raise
        return Choice(None, f"the GPU is left unused: {error.message}; to use it, {error.remedy}")


def architectures_to_emit(target: str = "auto", arch: str = "") -> tuple[int, ...] | None:
    """Return the GPUs of a project that is compiled elsewhere; None where ``choose`` has to decide.

    An nvcc of this machine says what it knows; without one, what is asked for is taken as it is.
    """
    if not _is_wanted(target, arch, ""):
        return None
    try:
        compiler = find_nvcc()
    except ToolchainError:
        return architectures_of(arch, None)
    return architectures_of(arch, compiler)


def _is_wanted(target: str, arch: str, nvcc: str) -> bool:
    return target in ("cuda", "both") or (target == "auto" and bool(arch or nvcc))


def find_nvcc(wanted: str = "") -> Nvcc:
    """Return ``wanted`` if it is given, otherwise the first nvcc that can be used.

    It is looked for in ``$CUDA_HOME``, ``$CUDA_PATH``, on PATH, in the system's usual place and in the wheel.
    """
    remedy = REMEDY.format(*MINIMUM_NVCC)
    if wanted:
        path = shutil.which(wanted)
        found = _nvcc(Path(path)) if path else f"'{wanted}' is not a program"
        if isinstance(found, str):
            raise ToolchainError(f"--nvcc: {found}", f"name another, or leave out --nvcc and {remedy}")
        return found
    reasons = []
    for candidate in dict.fromkeys(_candidates()):
        found = _nvcc(candidate)
        if not isinstance(found, str):
            return found
        reasons.append(found)
    raise ToolchainError("; ".join(reasons) or "no nvcc (the CUDA compiler) found", remedy)


def architectures_of(arch: str, nvcc: Nvcc | None) -> tuple[int, ...]:
    """Return the architectures, in ascending order, that an ``--arch`` stands for.

    None given is ``native`` where there is a GPU, and otherwise one of each generation. They are those that
    ``nvcc`` knows; None stands for a compiler that is not here.
    """
    if arch == "native" or (not arch and find_gpus()):
        return tuple(sorted({_native(gpu, nvcc) for gpu in _gpus_here()}))
    if arch in ("", "all"):
        listed = ALL_ARCHITECTURES if arch else GENERATIONS
        return tuple(a for a in listed if nvcc is None or a in nvcc.architectures)
    named = parse_architectures(arch)
    if nvcc is not None and (unknown := [a for a in named if a not in nvcc.architectures]):
        known = ", ".join(f"sm_{a}" for a in nvcc.architectures)
        raise ToolchainError(
            f"--arch: {nvcc.version} does not support sm_{unknown[0]}", f"choose among {known}"
        )
    return named


def parse_architectures(arch: str) -> tuple[int, ...]:
    """Return the numbers in ``sm_80,sm_90``, in ascending order."""
    matches = [re.fullmatch(r"sm_(\d{2,3})", word.strip()) for word in arch.split(",")]
    named = {int(match[1]) for match in matches if match}
    if None in matches:
        raise ToolchainError(
            f"--arch: '{arch}' is not understood", "write native, all, or a list such as sm_80,sm_90"
        )
    return tuple(sorted(named))


def driver_cuda() -> tuple[int, int] | None:
    """Return the newest version of CUDA that the driver of the GPU runs, None if it does not tell."""
    path = _smi()
    found = re.search(r"CUDA Version:\s*(\d+)\.(\d+)", (run([path]) or "") if path else "")
    return (int(found[1]), int(found[2])) if found else None


@functools.cache
def find_gpus() -> tuple[Gpu, ...]:
    """Return the GPUs that the driver lists."""
    path = _smi()
    query = "--query-gpu=name,driver_version,memory.total,compute_cap"
    output = run([path, query, "--format=csv,noheader"]) if path else None
    rows = [[cell.strip() for cell in line.split(",")] for line in (output or "").splitlines()]
    return tuple(
        Gpu(row[0], row[1], row[2], int(row[3].replace(".", "")))
        for row in rows
        if len(row) == 4 and re.fullmatch(r"\d+\.\d", row[3])
    )


def nvcc_command(build: CudaBuild, flags: list[str], compiler: Path, host_flags: list[str]) -> list[str]:
    """Return the start of an nvcc command: ``flags``, architectures, and the host compiler with its flags."""
    codes = [f"-gencode=arch=compute_{a},code=sm_{a}" for a in build.architectures]
    newest = build.architectures[-1]
    command = [str(build.nvcc.path), *flags, *codes, f"-gencode=arch=compute_{newest},code=compute_{newest}"]
    if len(codes) > 1:
        command.append("--threads=0")
    if not os.environ.get("NVCC_CCBIN"):
        command += ["-ccbin", str(compiler)]
    passed = (flag.replace(",", r"\,") for flag in host_flags if not flag.startswith("-std="))
    return command + [f"-Xcompiler={flag}" for flag in passed]  # which splits at commas


def _smi() -> str | None:
    return shutil.which("nvidia-smi") or (str(WSL_SMI) if WSL_SMI.is_file() else None)


def _gpus_here() -> tuple[Gpu, ...]:
    """Return this machine's GPUs; an error if there are none."""
    gpus = find_gpus()
    if not gpus:
        raise ToolchainError(
            "--arch native: this machine has no GPU (nvidia-smi lists none)",
            "name the GPU that the solver is for, for example --arch sm_90, or leave out --arch",
        )
    return gpus


def _native(gpu: Gpu, nvcc: Nvcc | None) -> int:
    """Return the newest architecture that the compiler knows and whose code or PTX this GPU runs."""
    if nvcc is None:
        return gpu.architecture
    older = [a for a in nvcc.architectures if a <= gpu.architecture]
    if not older:
        raise ToolchainError(
            f"{nvcc.version} no longer supports this machine's {gpu.name} (sm_{gpu.architecture})",
            "name an older nvcc with --nvcc, or compile with --target cpu",
        )
    return max(older)


def _candidates() -> Iterator[Path]:
    """Yield where an nvcc may be: the user's choice first."""
    for variable in ("CUDA_HOME", "CUDA_PATH"):
        if os.environ.get(variable):
            yield Path(os.environ[variable]) / "bin" / "nvcc"
    if path := shutil.which("nvcc"):
        yield Path(path)
    for folder in (SYSTEM_TOOLKIT, *_wheels()):
        if (folder / "bin" / "nvcc").exists():
            yield folder / "bin" / "nvcc"


def _wheels() -> list[Path]:
    """Return the toolkits among this Python environment's packages, the newest first."""
    spec = importlib.util.find_spec("nvidia")
    folders = [Path(p) for p in (spec.submodule_search_locations or ())] if spec else []
    return sorted((p for folder in folders for p in folder.glob("cu[0-9]*")), reverse=True)


def _nvcc(path: Path) -> Nvcc | str:
    """Return the compiler at ``path``, or why it cannot be used."""
    if not path.exists():
        return f"there is no '{path}'"
    output = run([str(path), "--version"])
    line = next((text for text in (output or "").splitlines() if "release" in text), "")
    if not line:
        return f"'{path}' does not run"
    version = re.sub(r".*(release .*)", r"nvcc \1", line)
    if numbers(line)[:2] < MINIMUM_NVCC:
        return f"'{path}' is too old ({version})"
    library = _library(path)
    if library is None:
        return f"'{path}' has no {RUNTIME_LIBRARY} with it"
    listed = run([str(path), "--list-gpu-arch"]) or ""
    known = sorted(int(number) for number in re.findall(r"^compute_(\d+)$", listed, re.MULTILINE))
    return Nvcc(path.absolute(), version, library, tuple(known))


def _library(nvcc: Path) -> Path | None:
    """Return the folder of the static runtime library: beside the compiler, or where distributions put it."""
    roots = dict.fromkeys((nvcc.absolute().parent.parent, nvcc.resolve().parent.parent))
    machine = platform.machine()
    folders = [root / name for root in roots for name in ("lib64", "lib", f"targets/{machine}-linux/lib")]
    folders.append(Path(f"/usr/lib/{machine}-linux-gnu"))
    return next((folder for folder in folders if (folder / RUNTIME_LIBRARY).is_file()), None)
