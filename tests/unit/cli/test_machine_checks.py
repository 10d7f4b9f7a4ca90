# SPDX-License-Identifier: Apache-2.0
"""What ``hypgen doctor`` says of machines that lack something."""

from __future__ import annotations

from pathlib import Path

import pytest

from hypgen.cli import machine_checks
from hypgen.runtime.builder import preflight
from hypgen.runtime.builder.cuda_tools import Gpu, Nvcc
from hypgen.runtime.builder.errors import ToolchainError

GPU = Gpu("NVIDIA X", "535.1", "80 GB", 90)
CUDA_13 = Nvcc(Path("nvcc"), "nvcc release 13.0, V13.0.88", Path("lib"), (75, 90))
SCALING = "/sys/devices/system/cpu/cpu{}/cpufreq/scaling_governor"


@pytest.fixture
def system(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """Return what the files of the system say, to be filled; all others are missing."""
    files: dict[str, str] = {}
    monkeypatch.setattr(machine_checks, "_read", lambda path: files.get(str(path), ""))
    monkeypatch.setattr("os.sched_getaffinity", lambda process: {0, 1, 2, 3})
    monkeypatch.setattr("os.cpu_count", lambda: 8)
    return files


def test_cores_that_save_power_are_told(system: dict[str, str]) -> None:
    assert machine_checks.cores().found == "4 of 8 usable, governor unknown"
    assert machine_checks.cores().remedy == ""
    system.update({SCALING.format(core): "performance" for core in (0, 1, 2, 3)})
    assert machine_checks.cores().found == "4 of 8 usable, governor performance"
    system[SCALING.format(2)] = "powersave"
    assert "governor performance, powersave" in machine_checks.cores().found
    assert "cpupower" in machine_checks.cores().remedy


@pytest.mark.parametrize(
    "files",
    [
        {"/proc/self/cgroup": "0::/box", "/sys/fs/cgroup/box/cpu.max": "250000 100000"},
        {"/proc/self/cgroup": "0::/box/inner", "/sys/fs/cgroup/cpu.max": "250000 100000"},
        {
            "/proc/self/cgroup": "3:cpu:/\n0::/",
            "/sys/fs/cgroup/cpu/cpu.cfs_quota_us": "250000",
            "/sys/fs/cgroup/cpu/cpu.cfs_period_us": "100000",
        },
    ],
)
def test_a_containers_cores_are_told(system: dict[str, str], files: dict[str, str]) -> None:
    system.update(files)
    assert "the container has the time of 2.5" in machine_checks.cores().found
    assert "--threads 2" in machine_checks.cores().remedy


@pytest.mark.parametrize(
    "files",
    [
        {"/proc/self/cgroup": "0::/box", "/sys/fs/cgroup/box/memory.max": "1000000000"},
        {"/proc/self/cgroup": "4:memory:/a", "/sys/fs/cgroup/memory/a/memory.limit_in_bytes": "1000000000"},
    ],
)
def test_a_containers_memory_is_told(system: dict[str, str], files: dict[str, str]) -> None:
    system["/proc/meminfo"] = "MemTotal:       16000000 kB\nMemAvailable:   12000000 kB\n"
    assert machine_checks.memory() == machine_checks.Finding("memory", "12000 of 16000 MB available")
    system.update(files)
    assert "the container's limit is 1000 MB" in machine_checks.memory().found
    assert machine_checks.memory().remedy == "raise the container's limit, or give solvers less by --memory"


def test_little_memory_is_told(system: dict[str, str]) -> None:
    system["/proc/meminfo"] = "MemTotal:       16000000 kB\nMemAvailable:   500000 kB\n"
    assert "close other programs" in machine_checks.memory().remedy


def test_no_room_for_temporary_files_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(preflight, "free_megabytes", lambda folder: 3)
    found = machine_checks.temporary()
    assert found.is_missing and "has 3 MB free" in found.found and "TMPDIR" in found.remedy


def test_a_folder_for_temporary_files_that_is_passed_over_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path / "none"))
    found = machine_checks.temporary()
    assert not found.is_missing and "which cannot be written" in found.remedy


@pytest.mark.parametrize(
    ("newest", "remedy"),
    [
        ((13, 0), ""),
        ((13, 1), ""),
        (None, ""),
        (
            (12, 2),
            "the driver is too old for nvcc release 13.0, V13.0.88: install one for CUDA 13.0 or newer",
        ),
    ],
)
def test_a_driver_that_is_too_old_is_told(
    newest: tuple[int, int] | None, remedy: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(machine_checks, "driver_cuda", lambda: newest)
    assert machine_checks.driver((GPU,), CUDA_13).remedy.startswith(remedy)
    assert bool(machine_checks.driver((GPU,), CUDA_13).remedy) == bool(remedy)
    assert machine_checks.driver((GPU,), None).remedy == ""


def test_code_that_the_driver_would_translate_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    newer = Nvcc(Path("nvcc"), "nvcc release 13.2, V13.2.1", Path("lib"), (75, 90))
    monkeypatch.setattr(machine_checks, "driver_cuda", lambda: (13, 0))
    assert "if a solver finds no code" in machine_checks.driver((GPU,), newer).remedy


def test_a_gpu_without_a_driver_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine_checks, "_has_nvidia_card", lambda: False)
    assert machine_checks.driver((), CUDA_13).found == "none needed"
    monkeypatch.setattr(machine_checks, "_has_nvidia_card", lambda: True)
    assert "install NVIDIA's driver" in machine_checks.driver((), CUDA_13).remedy


def test_a_terminal_that_takes_other_text_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    class Latin:
        encoding = "ISO-8859-1"

    monkeypatch.setattr("sys.stdout", Latin())
    assert "LC_ALL=C.UTF-8" in machine_checks.text_encoding().remedy


@pytest.mark.parametrize(
    ("cost", "source", "is_told"), [("900", "hpet", True), ("20", "hpet", False), ("900", "tsc", False)]
)
def test_a_slow_clock_is_told(
    cost: str, source: str, is_told: bool, system: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    system["/sys/devices/system/clocksource/clocksource0/current_clocksource"] = source
    monkeypatch.setattr(machine_checks, "_run_program", lambda: ["1", cost])
    _, clock = machine_checks.compiled_program()
    assert clock.found.startswith(f"{source}: {cost} ns") and bool(clock.remedy) == is_told


def test_a_compiler_that_builds_nothing_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse() -> list[str]:
        raise ToolchainError("'g++' cannot build a C++17 program", "install g++ 9 or newer")

    monkeypatch.setattr(machine_checks, "_run_program", refuse)
    (found,) = machine_checks.compiled_program()
    assert found.is_missing and found.remedy == "install g++ 9 or newer"


@pytest.mark.cxx
def test_flags_that_compile_nothing_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CXXFLAGS", "-no-such-flag")
    (found,) = machine_checks.compiled_program()
    assert "nothing compiles with the flags -no-such-flag" in found.found
    assert found.remedy == "mend or unset CXXFLAGS and LDFLAGS"
