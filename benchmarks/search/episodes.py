# SPDX-License-Identifier: Apache-2.0
"""Plays the episodes of many settings in pieces: several processes at a time, each on cores of its own.

A piece is some episodes of one setting, played by one process. Finished pieces are kept in a folder and not
played again, so a study can be interrupted and goes on where it was. Episode i of a seed has the same start
and the same world in every setting. Needs Python, taskset and solvers that ``hypgen compile`` made.
"""

from __future__ import annotations

import argparse
import functools
import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

PIECE = 5  # episodes: what an interruption may lose of a setting
PATIENCE = 10.0  # seconds that a solver has to end its step once it is asked to stop


@dataclass(frozen=True)
class Setting:
    """A solver with options whose episodes are compared with others'."""

    name: str
    solver: Path
    options: tuple[str, ...]
    cores: int = 1
    wants_gpu: bool = False

    def __str__(self) -> str:
        return f"{self.solver.name}, {self.name}"


@dataclass(frozen=True)
class Piece:
    """Episodes ``first`` to ``first + runs - 1`` of a setting."""

    setting: Setting
    wave: int
    first: int
    runs: int

    def options(self) -> list[str]:
        """Return all that the solver is told but where its lines go."""
        return [*self.setting.options, "--first-run", str(self.first), "--runs", str(self.runs), "--quiet"]

    def lines(self, keep: Path) -> Path:
        """Return the file of a finished piece's lines; its name changes with the solver and its options."""
        total = hashlib.sha256(" ".join(self.options()).encode() + program_digest(self.setting.solver))
        return keep / f"{self.setting.solver.name}-{total.hexdigest()[:16]}.jsonl"


@dataclass
class Running:
    """A process that plays a piece, and what it holds."""

    piece: Piece
    process: subprocess.Popen[str]
    cores: list[int]
    gpu: str | None
    partial: Path


@dataclass
class Machine:
    """The cores and GPUs that are free, and how many processes may run at a time."""

    jobs: int
    gpus: list[str]
    cores: list[int] = field(default_factory=lambda: sorted(os.sched_getaffinity(0)))

    def __post_init__(self) -> None:
        self.size = len(self.cores)

    def has_room(self, setting: Setting) -> bool:
        """Return whether the setting's process could start now; more threads than cores share them all."""
        has_cores = len(self.cores) >= min(setting.cores, self.size)
        return self.jobs > 0 and has_cores and (bool(self.gpus) or not setting.wants_gpu)

    def start(self, piece: Piece, keep: Path) -> Running:
        """Start a process on cores, and on a GPU if it wants one, that nobody else has."""
        count = min(piece.setting.cores, self.size)
        cores, self.cores = self.cores[:count], self.cores[count:]
        gpu = self.gpus.pop(0) if piece.setting.wants_gpu else None
        self.jobs -= 1
        partial = piece.lines(keep).with_suffix(".partial")
        command = ["taskset", "-c", ",".join(map(str, cores)), str(piece.setting.solver), *piece.options()]
        process = subprocess.Popen(
            [*command, "--json", str(partial)],
            env=os.environ | ({} if gpu is None else {"CUDA_VISIBLE_DEVICES": gpu}),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        return Running(piece, process, cores, gpu, partial)

    def take_back(self, ended: Running) -> None:
        """Free what a process held."""
        self.cores = sorted(self.cores + ended.cores)
        self.gpus += [] if ended.gpu is None else [ended.gpu]
        self.jobs += 1


def pieces_of(settings: Iterable[Setting], runs: int, a_wave: int = 1) -> list[Piece]:
    """Return all pieces in the order to play them: in waves, each of ``a_wave`` pieces of every setting.

    So whenever time is up all settings have played about the same episodes. Within a wave those with many
    cores come first, as the others fit beside and behind them.
    """
    pieces = [
        Piece(setting, first // (PIECE * a_wave), first, min(PIECE, runs - first))
        for setting in settings
        for first in range(0, runs, PIECE)
    ]
    return sorted(pieces, key=lambda piece: (piece.wave, -piece.setting.cores))


def play(pieces: list[Piece], machine: Machine, keep: Path, limit: float) -> list[str]:
    """Play the pieces that are not kept, for at most ``limit`` seconds; return what went wrong."""
    keep.mkdir(parents=True, exist_ok=True)
    waiting = [piece for piece in pieces if not piece.lines(keep).exists()]
    running: list[Running] = []
    problems = {
        piece.setting: "no GPU may be used"
        for piece in waiting
        if piece.setting.wants_gpu and not machine.gpus
    }
    waiting = [piece for piece in waiting if piece.setting not in problems]
    began = time.monotonic()
    try:
        while (waiting or running) and time.monotonic() - began < limit:
            while (piece := _next(waiting, machine)) is not None:
                waiting.remove(piece)
                running.append(machine.start(piece, keep))
            time.sleep(0.01)
            for ended in [one for one in running if one.process.poll() is not None]:
                running.remove(ended)
                machine.take_back(ended)
                _finish(ended, keep, problems)
                waiting = [piece for piece in waiting if piece.setting not in problems]
                done = len(pieces) - len(waiting) - len(running)
                say(f"{done}/{len(pieces)} pieces, {time.monotonic() - began:.0f} s: {ended.piece.setting}")
    except KeyboardInterrupt:
        say("interrupted")
    _stop(running)
    return [f"{setting}: {problem}" for setting, problem in problems.items()]


def _next(waiting: list[Piece], machine: Machine) -> Piece | None:
    """Return the first piece of the present wave that there is room for, if any."""
    this_wave = (piece for piece in waiting if piece.wave == waiting[0].wave)
    return next((piece for piece in this_wave if machine.has_room(piece.setting)), None)


def _finish(ended: Running, keep: Path, problems: dict[Setting, str]) -> None:
    """Keep a piece's lines, or note why there are none: its setting is not tried again."""
    _, errors = ended.process.communicate()
    if ended.process.returncode == 0:
        ended.partial.rename(ended.piece.lines(keep))
    else:
        problems[ended.piece.setting] = errors.strip()[-300:] or f"exit code {ended.process.returncode}"


def _stop(running: list[Running]) -> None:
    """Ask solvers to end; the episodes that they have completed stay in their partial files."""
    for one in running:
        one.process.send_signal(signal.SIGTERM)
    for one in running:
        try:
            one.process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            one.process.kill()
            one.process.communicate()


@dataclass
class Played:
    """What a setting's episodes came to."""

    run: dict[str, Any] = field(default_factory=dict)
    returns: dict[int, float] = field(default_factory=dict)
    lengths: list[int] = field(default_factory=list)
    endings: Counter[str] = field(default_factory=Counter)
    steps: list[dict[str, Any]] = field(default_factory=list)

    def add(self, lines: Iterable[dict[str, Any]]) -> None:
        """Add a process's lines; steps of an episode that it did not complete are left out."""
        steps: list[dict[str, Any]] = []
        for line in lines:
            if line["type"] == "run":
                self.run = line
            elif line["type"] == "step":
                steps.append(line)
            elif line["type"] == "episode" and line["status"] != "interrupted":
                self.returns[line["episode"]] = line["discounted_return"]
                self.lengths.append(line["steps"])
                self.endings[line["status"]] += 1
                self.steps += (step for step in steps if step["episode"] == line["episode"])
                steps = []

    def sizes(self) -> str:
        """Return what a page says of the searches' sizes."""
        names = {"K": "scenarios", "depth": "depth", "lambda": "pruning", "seed": "seed"}
        return ", ".join(f"{name} {self.run[field]}" for name, field in names.items() if field in self.run)

    def mean(self, name: str) -> float:
        """Return the mean of a field over all steps."""
        return self.total(name) / max(1, len(self.steps))

    def rate(self, name: str) -> float:
        """Return a field's sum over all steps for each second of search."""
        return self.total(name) / max(1e-9, self.total("search_seconds"))

    def total(self, name: str) -> float:
        """Return the sum of a field over all steps."""
        return float(sum(step[name] for step in self.steps))

    def searches(self) -> str:
        """Return how often searches ended how."""
        return counts(Counter(step["status"] for step in self.steps))


def counts(of: Counter[str]) -> str:
    """Return counts for a cell of a table."""
    return ", ".join(f"{name} {number}" for name, number in sorted(of.items()))


def read(pieces: Iterable[Piece], keep: Path) -> dict[Setting, Played]:
    """Return what each setting has played so far, unfinished pieces included."""
    played: dict[Setting, Played] = {}
    for piece in pieces:
        file = piece.lines(keep)
        file = file if file.exists() else file.with_suffix(".partial")
        texts = file.read_text(encoding="utf-8").split("\n")[:-1] if file.exists() else []  # the last is cut
        played.setdefault(piece.setting, Played()).add(json.loads(text) for text in texts)
    return played


@functools.cache
def program_digest(solver: Path) -> bytes:
    """Return a digest of a solver's program."""
    return hashlib.sha256(solver.read_bytes()).digest()


def knows(solver: Path, option: str) -> bool:
    """Return whether a solver has an option."""
    done = subprocess.run([str(solver), "--help"], capture_output=True, text=True, check=True)
    return any(line.split()[:1] == [option] for line in done.stdout.splitlines())


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that all scripts of this kind share."""
    parser.add_argument("--steps", type=int, default=90, help="most steps of an episode (90)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--options", default="", help='more options of the solver: --options="--depth 50"')
    parser.add_argument(
        "--keep", type=Path, required=True, help="folder of the solvers' lines and the tables"
    )
    parser.add_argument("--jobs", type=int, default=1, help="processes at a time, if there are cores (1)")
    parser.add_argument("--gpus", type=int, default=1, help="GPUs for modes gpu and hyp (1)")
    parser.add_argument("--limit", type=float, default=float("inf"), help="seconds, in all")


def machine_for(asked: argparse.Namespace) -> Machine:
    """Return the machine as the options let it be used."""
    visible = os.environ.get("CUDA_VISIBLE_DEVICES", ",".join(map(str, range(asked.gpus))))
    return Machine(asked.jobs, [gpu for gpu in visible.split(",") if gpu][: asked.gpus])


def table(header: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table in Markdown."""
    columns = tuple(header)
    cells = (columns, ("---",) * len(columns), *rows)
    return "\n".join("| " + " | ".join(row) + " |" for row in cells)


def publish(keep: Path, name: str, page: str, data: object) -> None:
    """Print a page, and write it and its numbers to the folder."""
    print(page, flush=True)
    (keep / f"{name}.md").write_text(page + "\n", encoding="utf-8")
    valid = json.loads(json.dumps(data), parse_constant=lambda nan: None)  # intervals of too few episodes
    (keep / f"{name}.json").write_text(json.dumps(valid, indent=1) + "\n", encoding="utf-8")


def say(text: str) -> None:
    """Print progress, apart from the tables."""
    print(text, file=sys.stderr, flush=True)
