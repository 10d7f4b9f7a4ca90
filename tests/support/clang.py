# SPDX-License-Identifier: Apache-2.0
"""clang++ on this machine, and the options with which it has nothing to say of hypgen's C++."""

from __future__ import annotations

import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from hypgen.runtime.builder.compile_flags import host_flags
from hypgen.runtime.builder.tools import find_eigen, find_json, numbers, run

from .paths import ROOT

OLDEST = 14
NEWEST = 30  # no further name is looked for
WARNINGS = [
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wno-sign-conversion",
    "-Wno-deprecated-declarations",
    "-Werror",
]


def find_clangs() -> list[str]:
    """Return the programs of each version that is new enough, the oldest first."""
    found = {}
    for name in ("clang++", *(f"clang++-{version}" for version in range(OLDEST, NEWEST))):
        path = shutil.which(name)
        version = numbers(run([path, "--version"]) or "") if path else ()
        if path and version >= (OLDEST,):
            found.setdefault(version, path)
    return [path for _, path in sorted(found.items())]


def takes(clang: str, option: str) -> bool:
    """Return whether a program of the standard library compiles and links with an option."""
    probe = [clang, option, "-std=c++17", "-x", "c++", "-", "-o", "/dev/null"]
    text = "#include <string>\nint main() { return std::string{}.size() == 1; }\n"
    return subprocess.run(probe, input=text, capture_output=True, text=True).returncode == 0


@dataclass(frozen=True)
class Checker:
    """Lets one clang read files, without compiling them; ``options``: such as ``-stdlib=libc++``."""

    clang: str
    options: tuple[str, ...] = ()

    def problems(self, sources: list[Path], include: tuple[Path, ...] = ()) -> str:
        """Return what clang has to say of ``sources``, whose own headers are in ``include``."""
        command = [*self._command(), *(f"-I{path}" for path in include), "-fsyntax-only"]

        def check(source: Path) -> str:
            done = subprocess.run([*command, str(source)], capture_output=True, text=True)
            return done.stderr or ("" if done.returncode == 0 else f"{source}: no message")

        with ThreadPoolExecutor(2) as pool:
            return "".join(pool.map(check, sources))

    def _command(self) -> list[str]:
        """Return the command without files. Headers of others are a system's: they may have warnings."""
        system = [word for path in (find_json(), find_eigen()) for word in ("-isystem", str(path))]
        ours = f"-I{ROOT / 'runtime' / 'include'}"
        return [self.clang, "-std=c++17", *host_flags(), *WARNINGS, *self.options, ours, *system]
