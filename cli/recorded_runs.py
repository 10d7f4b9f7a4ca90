# SPDX-License-Identifier: Apache-2.0
"""Runs of a solver whose recording hypgen takes line by line: for a page that follows it, and for MCAP."""

from __future__ import annotations

import contextlib
import os
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import IO, TYPE_CHECKING

import click

from hypgen.cli.exit_codes import Exit, code_of_program
from hypgen.cli.interrupts import interrupt_code
from hypgen.cli.output import say

if TYPE_CHECKING:
    from hypgen.dsl import ir

Take = Callable[[bytes], None]


def without_record(options: Sequence[str]) -> tuple[list[str], Path | None]:
    """Return a solver's options without ``--record``, and the file that it names."""
    kept: list[str] = []
    file = None
    waiting = iter(options)
    for option in waiting:
        if option == "--record":
            file = next(waiting, "")
        elif option.startswith("--record="):
            file = option.partition("=")[2]
        else:
            kept.append(option)
    return kept, None if file is None else Path(file)


def play_live(solver: Path, options: Sequence[str], log: Path | None, model: ir.Model, file: str) -> int:
    """Run a solver while a page on this machine shows it. Gives its exit code.

    ``log`` keeps the recording, as MCAP if it is called so; ``file`` is the name of the model's file.
    """
    from hypgen.views.live import LiveEpisodes
    from hypgen.views.live_server import serve_live

    episodes = LiveEpisodes(model, file)
    with serve_live(episodes) as address:
        say(f"live: {address}")
        code = play_recorded(solver, options, log, episodes.take)
        if code == 0:  # an interrupt waits for nobody
            episodes.end()
    return code


def play_recorded(
    solver: Path, options: Sequence[str], log: Path | None, take: Take = lambda line: None
) -> int:
    """Run a solver, hand each line of its recording to ``take``, and keep it. Gives the exit code."""
    from hypgen.recordings import RecordingError, open_recording

    if str(log) == "-":
        raise click.ClickException("--record: expected a file; standard output is for --json -")
    try:
        if log is None or log.suffix != ".mcap":
            return _play(solver, options, log, take)
        from hypgen.recordings.mcap_file import write_mcap

        with tempfile.TemporaryDirectory(prefix=".hypgen-", dir=log.parent) as folder:
            lines = Path(folder) / "recording.jsonl"
            code = _play(solver, options, lines, take)
            if lines.exists():
                write_mcap(open_recording(lines), log)
            return code
    except RecordingError as error:
        raise click.ClickException(str(error)) from None
    except OSError as error:  # as the solver ends that cannot write its recording
        say(f"error: {log} cannot be written: {error.strerror}")
        return Exit.DIFFERENT


def _play(solver: Path, options: Sequence[str], log: Path | None, take: Take) -> int:
    read, write = os.pipe()
    process: subprocess.Popen[bytes] | None = None
    reading: Future[None] | None = None

    def hand_on() -> None:
        with open(read, "rb") as lines:
            try:
                with _opened(log) as keep:
                    for line in lines:
                        keep(line)
                        take(line)
            except Exception:
                if process is not None:
                    process.terminate()
                for _ in lines:  # until the solver has ended: it need not say that nobody reads
                    pass
                raise

    with ThreadPoolExecutor(1) as pool, open(write, "wb") as end:
        try:
            # Reading comes first: a solver that was told to end may have to write before it does.
            reading = pool.submit(hand_on)
            told = [str(solver), *options, f"--record=/dev/fd/{write}"]
            process = subprocess.Popen(told, pass_fds=[write])
            end.close()  # the solver has the only one: lines end with it
            code = code_of_program(process.wait())
        except KeyboardInterrupt as error:  # a signal that this process got may be for it alone
            code = interrupt_code(error)
            end.close()
            if process is not None:
                process.send_signal(code - 128)
                process.wait()
    if reading is not None:
        reading.result()
    return code


@contextlib.contextmanager
def _opened(log: Path | None) -> Iterator[Take]:
    """Yield what writes lines to a file, which is made with the first one: refused options leave none."""
    file: IO[bytes] | None = None

    def keep(line: bytes) -> None:
        nonlocal file
        if log is None:
            return
        if file is None:
            file = log.open("wb")
        file.write(line)
        file.flush()

    try:
        yield keep
        if file is not None:
            os.fsync(file.fileno())
    finally:
        if file is not None:
            file.close()
