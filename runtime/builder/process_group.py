# SPDX-License-Identifier: Apache-2.0
"""Commands that end with hypgen, however it ends."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
from types import TracebackType

# The shell's input is a pipe from hypgen, which the system closes when hypgen dies, even by SIGKILL.
# Ninja gives each compiler a group of its own, and passes SIGTERM on to it.
WATCH = 'trap "" TERM; read -r line && exit; kill -s TERM 0; sleep 1; kill -s KILL 0'


class ProcessGroup:
    """A group of processes, led by a shell that ends the whole group when hypgen is gone.

    A signal to the process that started a compiler does not reach the parts that the compiler has started.
    A group is reached as a whole. An exception that leaves the ``with`` statement ends the group too.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._is_stopped = False
        null = subprocess.DEVNULL
        self._watcher = subprocess.Popen(
            ["/bin/sh", "-c", WATCH], stdin=subprocess.PIPE, stdout=null, stderr=null, process_group=0
        )

    def __enter__(self) -> ProcessGroup:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None:
            self.stop()
        assert self._watcher.stdin is not None
        with contextlib.suppress(OSError):
            self._watcher.stdin.write(b"end\n")
            self._watcher.stdin.flush()
        self._watcher.wait()
        with contextlib.suppress(OSError):
            self._watcher.stdin.close()

    def run(self, command: list[str]) -> subprocess.CompletedProcess[str]:
        """Run a command, and return its status and all that it prints."""
        with self._lock:
            if self._is_stopped:
                return subprocess.CompletedProcess(command, -signal.SIGTERM, "")
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors="replace",
                process_group=self._watcher.pid,
            )
        with process:
            try:
                output, _ = process.communicate()
            except BaseException:
                self.stop()
                raise
        return subprocess.CompletedProcess(command, process.returncode, output)

    def stop(self) -> None:
        """End what runs, and start nothing more."""
        with self._lock:
            self._is_stopped = True
            with contextlib.suppress(OSError):
                os.killpg(self._watcher.pid, signal.SIGTERM)
