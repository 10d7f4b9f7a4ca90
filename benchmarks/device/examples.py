# SPDX-License-Identifier: Apache-2.0
"""Builds the programs that ``emit.py`` wrote the code of, and runs their self-tests on this machine's GPU.

python3 examples.py FOLDER [MODEL ...] [--lanes N] [--steps T] [--sanitize [TOOL ...]]

Without ``--sanitize`` it compares as much as is asked for. With it, the same self-tests, small ones by
default, run under compute-sanitizer. Needs Python, nvcc and g++, and nothing of hypgen's own Python.
Solvers of the same code are not built again.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

TOOLS = ("memcheck", "racecheck", "initcheck", "synccheck")
SUMMARY = re.compile(r"(?:ERROR SUMMARY: (\d+) error|RACECHECK SUMMARY: (\d+) hazard)")
NOISE = 12  # lines of a report that are shown


@dataclass(frozen=True)
class Commands:
    """How each kind of unit is compiled, and programs are linked."""

    host: list[str]
    device: list[str]
    link: list[str]


def commands(folder: Path, nvcc: str, arch: str) -> Commands:
    """Return the commands; the flags are those of the emitted projects."""
    runtime = folder / "runtime"
    include = [f"-I{runtime / 'include'}", "-isystem", str(folder / "third_party")]
    flags = (runtime / "cmake" / "nvcc_flags.txt").read_text().split()
    host = ["-O3", "-march=native", *(runtime / "cmake" / "host_flags.txt").read_text().split()]
    shared = [f"-Xcompiler={flag}" for flag in host]
    library = (
        Path(subprocess.check_output(["which", nvcc], text=True).strip()).resolve().parent.parent / "lib"
    )
    return Commands(
        ["g++", "-std=c++17", *host, "-DHYPGEN_CUDA", *include],
        [nvcc, f"-arch={arch}", "-lineinfo", *flags, *shared, *include],  # lines, for the sanitizers
        [nvcc, f"-arch={arch}", "-cudart", "static", f"-L{library}", "-Xcompiler=-pthread"],
    )


def digest(folders: list[Path], asked: Commands) -> str:
    """Return a short name for the contents of some folders and how they are compiled."""
    total = hashlib.sha256(repr((asked.host, asked.device)).encode())
    for path in sorted(path for folder in folders for path in folder.rglob("*") if path.is_file()):
        total.update(path.name.encode() + b"\0" + path.read_bytes())
    return total.hexdigest()[:12]


def run(command: list[str]) -> None:
    """Run a compiler; where it fails its messages are shown, and what it was to make is missing."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        print(f"{' '.join(command)}\n{done.stdout[:2000]}", flush=True)


def build(folder: Path, names: list[str], asked: argparse.Namespace) -> dict[str, Path]:
    """Return the programs of the models that can be built; they are built unless they are there."""
    how = commands(folder, asked.nvcc, asked.arch)
    programs: Path = asked.programs
    programs.mkdir(parents=True, exist_ok=True)
    targets = {
        name: programs / f"{name}-{digest([folder / 'runtime', folder / 'models' / name], how)}"
        for name in names
    }
    missing = [name for name in names if not targets[name].is_file()]
    with tempfile.TemporaryDirectory() as place, ThreadPoolExecutor(asked.jobs) as pool:
        units: dict[Path, list[str]] = {}
        models = {name: sorted((folder / "models" / name).glob("*.c*")) for name in missing}
        sources = (folder / "runtime" / "src").rglob("*.cpp") if missing else ()
        runtime = sorted(path for path in sources if path.parent.name != "exact")
        # Those that take longest come first.
        for source in sorted([*sum(models.values(), []), *runtime], key=lambda path: path.suffix != ".cu"):
            target = Path(place) / f"{source.parent.name}.{source.name}.o"
            compiler = how.device if source.suffix == ".cu" else how.host
            units[source] = [*compiler, "-c", str(source), "-o", str(target)]
        list(pool.map(run, units.values()))
        objects = {source: command[-1] for source, command in units.items()}
        links = [
            [*how.link, *(objects[source] for source in [*models[name], *runtime]), "-o", str(targets[name])]
            for name in missing
        ]
        list(pool.map(run, links))
    return {name: target for name, target in targets.items() if target.is_file()}


def limited(command: list[str], limit: float) -> tuple[str, str]:
    """Return what a command printed, and why that is not all; nothing if it is."""
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    ) as process:
        try:
            text, _ = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)  # a sanitizer's program too
            return process.communicate()[0], f"stopped after {limit:g} s"
    return text, "" if process.returncode in (0, 1) else f"ended with {process.returncode}"


def selftest(program: Path, lanes: int, steps: int, asked: argparse.Namespace) -> list[str]:
    """Return the command of a self-test, whose size is as asked for or the one given."""
    size = ["--lanes", str(asked.lanes or lanes), "--steps", str(asked.steps or steps)]
    size += ["--warps", str(asked.warps)] if asked.warps else []
    return [str(program), "--quiet", "--json", "-", "--seed", str(asked.seed), *size]


def tally(text: str) -> tuple[Counter[str], list[str]]:
    """Return what a self-test compared, by kind of check, and what is to be said of it."""
    counts: Counter[str] = Counter()
    remarks = []
    for line in text.splitlines():
        if not line.startswith('{"type":"check"'):
            continue
        check = json.loads(line)
        counts[check["check"].split()[0]] += check["steps"]
        counts["differing"] += check["differing"]
        if check["remark"]:
            remarks.append(f"  {check['check']}, {check['variant']}: {check['remark']}")
    return counts, remarks


def compare(programs: dict[str, Path], asked: argparse.Namespace) -> bool:
    """Run each model's self-test, which uses all cores; print a line for each."""
    kinds = ("schedule", "device", "leaves", "differing")
    print(f"{'model':<26}{'host steps':>16}{'device steps':>16}{'rows':>16}{'differing':>16}", flush=True)
    totals: Counter[str] = Counter()
    good = True
    for name, program in programs.items():
        text, trouble = limited(selftest(program, 20_000, 90, asked), asked.limit)
        counts, remarks = tally(text)
        print(f"{name:<26}" + "".join(f"{counts[kind]:>16,}" for kind in kinds), *remarks, sep="\n")
        if trouble:
            print(f"  {trouble}\n{text[-1000:]}")
        sys.stdout.flush()
        totals += counts
        good = good and not trouble and counts["differing"] == 0 and counts["device"] > 0
    print(f"{f'{len(programs)} models':<26}" + "".join(f"{totals[kind]:>16,}" for kind in kinds))
    return good


def findings(command: list[str], limit: float) -> tuple[str, str]:
    """Return how many findings a sanitizer's run has, or why that is not known, and what to show of them."""
    text, trouble = limited(command, limit)
    counts, remarks = tally(text)
    match = SUMMARY.search(text)
    if trouble or not match:
        count = trouble or "no summary"
    elif counts["device"] == 0 or counts["differing"] > 0:
        count = "differs" if counts["device"] else "nothing on a GPU"
    else:
        count = match[1] or match[2]
    report = [line for line in text.splitlines() if not line.startswith("{")][:NOISE]
    return count, "" if count == "0" else "\n".join([*remarks, *(f"    {line}" for line in report)])


def sanitize(programs: dict[str, Path], asked: argparse.Namespace) -> bool:
    """Run each self-test under each tool, several at a time; print a line for each model."""
    tools = asked.sanitize or TOOLS
    print(f"{'model':<26}" + "".join(f"{tool:>20}" for tool in tools), flush=True)
    clean = True
    with ThreadPoolExecutor(asked.at_once) as pool:
        jobs = {}
        for name, program in programs.items():
            small = selftest(program, 64, 6, asked)
            commands = [[asked.sanitizer, "--tool", tool, *small, "--threads", "1"] for tool in tools]
            jobs[name] = [pool.submit(findings, command, asked.limit) for command in commands]
        for name, results in jobs.items():
            found = [job.result() for job in results]
            print(f"{name:<26}" + "".join(f"{count:>20}" for count, _ in found))
            for tool, (count, text) in zip(tools, found, strict=True):
                clean = clean and count == "0"
                if text:
                    print(f"  {tool}:\n{text}")
            sys.stdout.flush()
    return clean


def arguments() -> argparse.Namespace:
    """Return the command line's."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path, help="what emit.py wrote")
    parser.add_argument("models", nargs="*", help="all if none is named")
    parser.add_argument("--lanes", type=int, help="walks of a self-test (20000; with --sanitize 64)")
    parser.add_argument("--steps", type=int, help="steps of a walk (90; with --sanitize 6)")
    parser.add_argument("--warps", type=int, help="that share a step (all numbers that make sense)")
    parser.add_argument("--seed", type=int, default=0, help="of the walks (0)")
    parser.add_argument("--limit", type=float, default=60, help="seconds for each run (60)")
    parser.add_argument("--sanitize", nargs="*", choices=TOOLS, help="run compute-sanitizer's tools (all)")
    parser.add_argument("--at-once", type=int, default=8, help="runs of the sanitizer at a time (8)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="compilers at a time (all cores)")
    parser.add_argument("--arch", default="native", help="of the GPU, as nvcc's -arch (native)")
    parser.add_argument("--nvcc", default="nvcc", help="the CUDA compiler (nvcc)")
    parser.add_argument("--sanitizer", default="compute-sanitizer", help="NVIDIA's (compute-sanitizer)")
    parser.add_argument("--programs", type=Path, help="where programs are kept (beside FOLDER)")
    return parser.parse_intermixed_args()


def main() -> None:
    """Build, then compare or sanitize."""
    asked = arguments()
    folder = asked.folder.resolve()
    asked.programs = (asked.programs or folder.with_name(folder.name + "_programs")).resolve()
    names = asked.models or sorted(path.name for path in (folder / "models").iterdir())
    programs = build(folder, names, asked)
    good = compare(programs, asked) if asked.sanitize is None else sanitize(programs, asked)
    sys.exit(0 if good and len(programs) == len(names) else 1)


if __name__ == "__main__":
    main()
