# SPDX-License-Identifier: Apache-2.0
"""A solver's process: plays a cell on cores, and with a GPU, of its own."""

from __future__ import annotations

import functools
import os
import platform
import signal
import subprocess
import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from hypgen import __version__
from hypgen.experiments.cells import Cell
from hypgen.experiments.store import Failure, Store
from hypgen.runtime.builder.compile_flags import host_flags
from hypgen.runtime.builder.solver import runtime_id
from hypgen.runtime.builder.tools import user_flags

PATIENCE = 10.0  # seconds that a solver has to end its step once it is asked to stop
POLL = 0.02  # seconds between two looks at processes


@dataclass(frozen=True)
class Played:
    """What became of a cell: what the solver wrote, or the problem. ``about`` says where and with what."""

    about: dict[str, Any]
    lines: str
    problem: str = ""

    def keep(self, cell: Cell, store: Store) -> Cell | Failure:
        """Put it into a store, and return it as what an executor yields."""
        if not self.problem:
            store.put(cell, self.about, self.lines)
            return cell
        failure = Failure(cell, self.problem)
        store.fail(failure)
        return failure


class SolverProcess:
    """A solver that plays now. The system kills it where the thread that started it ends.

    ``command`` is the solver and its arguments, ``lines`` the file that it writes its JSON lines to, and
    ``param`` the text of its file of params. ``about`` says how it was compiled. It is killed after
    ``seconds``.
    """

    def __init__(
        self,
        command: Sequence[str],
        lines: Path,
        cores: Sequence[int],
        gpu: str | None,
        about: dict[str, Any],
        seconds: float,
        param: str | None,
    ) -> None:
        self._lines, self._seconds, self._began = lines, seconds, time.monotonic()
        self._param = lines.with_suffix(".param")
        given = [] if param is None else [f"--param={self._param}"]
        if param is not None:
            self._param.write_text(param, encoding="utf-8")
        self._about = about | {
            "machine": machine(),
            "cores": len(cores),
            "began": datetime.now(UTC).isoformat(timespec="seconds"),
            "load_average": os.getloadavg(),
        }
        bound = ["setpriv", "--pdeathsig", "KILL", "taskset", "-c", ",".join(map(str, cores))]
        self._process = subprocess.Popen(
            [*bound, *command, *given, "--quiet", f"--json={lines}"],
            env=os.environ | ({} if gpu is None else {"CUDA_VISIBLE_DEVICES": gpu}),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
        )

    def has_ended(self) -> bool:
        """Return whether it has ended; kill it where its time is up."""
        if self._process.poll() is None and time.monotonic() - self._began > self._seconds:
            self._process.kill()
            self._process.wait()
        return self._process.poll() is not None

    def played(self) -> Played:
        """Return what it has played, once it has ended, and remove its file."""
        assert self._process.stderr is not None
        said, code = self._process.stderr.read().strip()[-500:], self._process.returncode
        self._process.stderr.close()
        seconds = time.monotonic() - self._began
        try:
            if code == 0:
                about = {**self._about, "seconds": round(seconds, 3)}
                return Played(about, self._lines.read_text(encoding="utf-8"))
        finally:
            self._remove_files()
        reason = (
            f"the solver ended with code {code}" if code > 0 else f"the solver was ended by signal {-code}"
        )
        if code == -signal.SIGKILL:
            reason = f"the solver was killed after {seconds:.0f} s: out of memory, or hung"
        return Played(self._about, "", f"{reason}{': ' if said else ''}{said}")

    def ask_to_end(self) -> None:
        """Let it end after its step."""
        self._process.send_signal(signal.SIGTERM)

    def stop(self) -> None:
        """End it; what it has played is dropped."""
        self.ask_to_end()
        try:
            self._process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.communicate()
        self._remove_files()

    def _remove_files(self) -> None:
        for path in (self._lines, self._param):
            path.unlink(missing_ok=True)


@functools.cache
def machine() -> dict[str, Any]:
    """Return what tells results of this machine, and of this hypgen, from those of others."""
    found = {
        "hypgen": __version__,
        "commit": _commit(),
        "runtime": runtime_id(),
        "flags": [*host_flags(), *user_flags("CXXFLAGS"), *user_flags("LDFLAGS")],
        "system": f"{platform.system()} {platform.release()}",
        "cores": os.cpu_count(),
    }
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        found["processor"] = next(
            line.split(":")[1].strip() for line in lines if line.startswith("model name")
        )
    except (OSError, StopIteration):
        found["processor"] = platform.machine()
    return found


def _commit() -> str:
    """Return the commit of the clone that this is, with a mark if files have changed; empty elsewhere."""
    clone = Path(__file__).resolve().parents[3]
    if not (clone / ".git").exists():
        return ""
    command = ["git", "-C", str(clone), "describe", "--always", "--dirty", "--exclude=*"]
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=10.0).stdout.strip()
    except (OSError, subprocess.TimeoutExpired):
        return ""
