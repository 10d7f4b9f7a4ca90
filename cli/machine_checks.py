# SPDX-License-Identifier: Apache-2.0
"""What ``hypgen doctor`` looks at besides tools: does a compiler work, is there a clock, room and memory?"""

from __future__ import annotations

import locale
import os
import re
import resource
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from hypgen.runtime.builder.commands import require_compiler
from hypgen.runtime.builder.cuda_tools import Gpu, Nvcc, driver_cuda
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.preflight import free_megabytes, require_writable, temporary_folder
from hypgen.runtime.builder.process_group import ProcessGroup
from hypgen.runtime.builder.tools import find_compiler, numbers, run

MEMORY_NEEDED = 2048  # MB: a search takes 1024, a compiler most of the rest
SLOW_CLOCK = 200.0  # nanoseconds for a look at it; a search looks every few microseconds
COARSE_CLOCK = 1000.0
NVIDIA = "0x10de"

# Starts a thread, and prints the clock's resolution and what a look at it costs, in nanoseconds. The best of
# many rounds counts, as other programs interrupt some.
PROGRAM = """\
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>
#include <variant>
int main() {
  using Clock = std::chrono::steady_clock;
  using Nanoseconds = std::chrono::duration<double, std::nano>;
  constexpr int kRounds = 100, kLooks = 1000;
  std::variant<int, double> resolution = 1e18;
  double cost = 1e18;
  std::thread([&] {
    for (int round = 0; round < kRounds; ++round) {
      const Clock::time_point start = Clock::now();
      Clock::time_point before = start;
      for (int look = 0; look < kLooks; ++look) {
        const Clock::time_point now = Clock::now();
        const double passed = Nanoseconds(now - before).count();
        if (passed > 0.0) resolution = std::min(std::get<double>(resolution), passed);
        before = now;
      }
      cost = std::min(cost, Nanoseconds(before - start).count() / kLooks);
    }
  }).join();
  std::printf("%.0f %.0f", std::get<double>(resolution), cost);
}
"""


@dataclass(frozen=True)
class Finding:
    """A line about the machine; ``remedy`` is empty where nothing is to be done."""

    name: str
    found: str
    remedy: str = ""
    is_missing: bool = False  # models cannot be compiled before that is mended


def findings() -> Iterator[Finding]:
    """Yield what is found, in the order in which it is shown."""
    yield from compiled_program()
    yield cores()
    yield memory()
    yield temporary()
    yield text_encoding()


def compiled_program() -> Iterator[Finding]:
    """Compile and start a program with a thread, and look at the clock by it."""
    start = time.monotonic()
    try:
        words = _run_program()
    except ToolchainError as error:
        yield Finding("test program", f"MISSING: {error.message}", error.remedy, is_missing=True)
        return
    except OSError as error:  # told by the line about temporary files
        yield Finding("test program", f"not tried: {error.strerror or error}")
        return
    yield Finding(
        "test program", f"compiled as C++17 with threads and run ({time.monotonic() - start:.1f} s)"
    )
    resolution, cost = (float(word) for word in words)
    source = _read("/sys/devices/system/clocksource/clocksource0/current_clocksource") or "unknown"
    remedy = ""
    if (cost > SLOW_CLOCK or resolution > COARSE_CLOCK) and source != "tsc":
        remedy = f"plans end late by the clock '{source}': start Linux with clocksource=tsc if that can be"
    yield Finding(
        "clock", f"{source}: {cost:.0f} ns for a look, differences from {resolution:.0f} ns", remedy
    )


def _run_program() -> list[str]:
    compiler = find_compiler().path
    with tempfile.TemporaryDirectory() as folder:
        source, program = Path(folder) / "probe.cpp", Path(folder) / "probe"
        source.write_text(PROGRAM, encoding="utf-8")
        with ProcessGroup() as group:
            require_compiler(group, compiler, source, program)
        words = (run([str(program)]) or "").split()
    if len(words) != 2:
        raise ToolchainError(
            "what the compiler builds does not start",
            "let TMPDIR name a folder on a file system that is not mounted with `noexec`",
        )
    return words


def cores() -> Finding:
    """Return how many cores this process may use, and how they change their frequency."""
    usable = sorted(os.sched_getaffinity(0))
    found = f"{len(usable)} of {os.cpu_count()} usable"
    share = core_limit()
    remedies = []
    if share is not None and share < len(usable):
        found += f", the container has the time of {share:g}"
        whole = max(1, int(share))
        remedies.append(
            f"more threads than the container has cores are stopped in mid-plan: use --threads {whole}"
        )
    folder = "/sys/devices/system/cpu/cpu{}/cpufreq/scaling_governor"
    governors = sorted({g for core in usable if (g := _read(folder.format(core)))})
    found += f", governor {', '.join(governors) or 'unknown'}"
    if "powersave" in governors or "conservative" in governors:
        remedies.append(
            "cores that save power plan less: `sudo cpupower frequency-set -g performance` where power allows"
        )
    return Finding("cores", found, "; ".join(remedies))


def memory() -> Finding:
    """Return how much memory there is, and what limits it for this process."""
    facts = dict(re.findall(r"^(\w+):\s+(\d+) kB", _read("/proc/meminfo"), re.MULTILINE))
    total, free = (int(facts.get(name, 0)) // 1000 for name in ("MemTotal", "MemAvailable"))
    limits = {"the container's limit": memory_limit(), "`ulimit -v`": _address_limit()}
    found = f"{free} of {total} MB available"
    remedy = ""
    if free < MEMORY_NEEDED:
        remedy = "close other programs, or give solvers less by --memory"
    for name, limit in limits.items():
        if limit is not None and limit < total:
            found += f", {name} is {limit} MB"
            if limit < MEMORY_NEEDED:
                remedy = f"raise {name}, or give solvers less by --memory"
    return Finding("memory", found, remedy)


def temporary() -> Finding:
    """Return where temporary files go, and how much room they have."""
    name = "temporary"
    try:
        folder = temporary_folder()
        require_writable(folder, "TMPDIR")
    except ToolchainError as error:
        return Finding(name, f"MISSING: {error.message}", error.remedy, is_missing=True)
    found = f"{folder}, {free_megabytes(folder)} MB free"
    wanted = os.environ.get("TMPDIR")
    if wanted and Path(wanted) != folder:
        return Finding(
            name, found, f"TMPDIR names '{wanted}', which cannot be written: make it, or unset TMPDIR"
        )
    return Finding(name, found)


def text_encoding() -> Finding:
    """Return how text is written to the terminal."""
    encodings = {(sys.stdout.encoding or "none").lower(), sys.getfilesystemencoding().lower()}
    name = locale.setlocale(locale.LC_CTYPE)
    found = f"{name}, {', '.join(sorted(encodings))}"
    if encodings <= {"utf-8"}:
        return Finding("locale", found)
    return Finding("locale", found, "models are UTF-8: set a locale such as LC_ALL=C.UTF-8")


def driver(gpus: tuple[Gpu, ...], nvcc: Nvcc | None) -> Finding:
    """Return whether the GPU's driver takes what nvcc makes."""
    if not gpus:
        if not _has_nvidia_card():
            return Finding("driver", "none needed")
        text = "a GPU of NVIDIA is there, and nvidia-smi does not list it"
        return Finding("driver", text, "install NVIDIA's driver, or give the container the GPU")
    newest = driver_cuda()
    if newest is None:
        return Finding("driver", gpus[0].driver)
    found = f"{gpus[0].driver}, runs CUDA up to {newest[0]}.{newest[1]}"
    made = numbers(nvcc.version)[:2] if nvcc is not None else ()
    if nvcc is None or made <= newest:
        return Finding("driver", found)
    if made[:1] == newest[:1]:  # code runs within a major version; what a driver has to translate does not
        remedy = (
            f"if a solver finds no code for the GPU, install a driver for CUDA {made[0]}.{made[1]} or newer"
        )
    else:
        remedy = (
            f"the driver is too old for {nvcc.version}: install one for CUDA {made[0]}.{made[1]} or newer, "
            f"or an nvcc of CUDA {newest[0]}.{newest[1]}"
        )
    return Finding("driver", found, remedy)


def core_limit() -> float | None:
    """Return how many cores' time the container has; None without a limit."""
    found = []
    for folder in _control_groups("cpu"):
        quota, _, period = _read(folder / "cpu.max").partition(" ")
        quota = quota or _read(folder / "cpu.cfs_quota_us")
        period = period or _read(folder / "cpu.cfs_period_us")
        if quota.isdigit() and period.isdigit():
            found.append(int(quota) / int(period))
    return min(found, default=None)


def memory_limit() -> int | None:
    """Return the container's memory in MB; None without a limit."""
    names = ("memory.max", "memory.limit_in_bytes")
    texts = (_read(folder / name) for folder in _control_groups("memory") for name in names)
    return min((int(text) // 10**6 for text in texts if text.isdigit()), default=None)


def _control_groups(kind: str) -> Iterator[Path]:
    """Yield the folders of this process's control groups of a kind, of both versions, and of those above."""
    for line in _read("/proc/self/cgroup").splitlines():
        _, kinds, path = line.split(":", 2)
        if kinds and kind not in kinds.split(","):
            continue
        root = Path("/sys/fs/cgroup") / (kinds and kind)
        folder = root / path.lstrip("/")
        yield from (f for f in (folder, *folder.parents) if f.is_relative_to(root))


def _address_limit() -> int | None:
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    return None if limit == resource.RLIM_INFINITY else limit // 10**6


def _has_nvidia_card() -> bool:
    devices = Path("/sys/bus/pci/devices")
    cards = (d for d in devices.glob("*") if _read(d / "vendor") == NVIDIA)
    return any(_read(card / "class").startswith("0x03") for card in cards)


def _read(path: str | Path) -> str:
    """Return what a file of the system says, nothing where there is none."""
    try:
        return Path(path).read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return ""
