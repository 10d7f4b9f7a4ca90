# SPDX-License-Identifier: Apache-2.0
"""Solves model files of other people and compares the intervals with certified ones.

python3 benchmarks/exact/corpus.py FOLDER [--time 20] [--gap 0.001] [NAME ...]

FOLDER has models in Cassandra's format or POMDPX in its subfolders, and a README.md with a table of lines
"| name[, name ..] | lower | upper |". Names choose files; without any, all that are in the table are solved.
Prints a table in Markdown; the exit code is 1 if an interval does not overlap the certified one.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]
SUFFIXES = (".pomdp", ".POMDP", ".pomdpx")


def certified(page: str) -> dict[str, tuple[float, float]]:
    """Return the interval of each name in the page's table."""
    found = {}
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        try:
            lower, upper = float(cells[1]), float(cells[2])
        except (IndexError, ValueError):
            continue
        found.update({name.strip(): (lower, upper) for name in cells[0].split(",")})
    return found


def file_of(folder: Path, name: str) -> Path:
    """Return the model file that the table calls ``name``."""
    return next(
        path
        for path in sorted(folder.glob("*/*"))
        if path.name == name or (path.stem == name and path.suffix in SUFFIXES)
    )


def solve(file: Path, time: float, gap: float) -> dict[str, Any]:
    """Return what ``hypgen solve`` proves of a file's model."""
    options = ["solve", str(file), "--json", f"--time={time}", f"--gap={gap}"]
    done = subprocess.run([*HYPGEN, *options], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{file.name}: {done.stderr}")
    result: dict[str, Any] = json.loads(done.stdout)
    return result


def main() -> int:
    """Solve the models and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--time", type=float, default=20.0, help="seconds for each model (20)")
    parser.add_argument("--gap", type=float, default=1e-3, help="where to stop (0.001)")
    asked = parser.parse_args()
    known = certified((asked.folder / "README.md").read_text(encoding="utf-8"))
    print("| model | states | lower | upper | seconds | certified | overlap |\n|---|---|---|---|---|---|---|")
    apart = 0
    for name in asked.names or known:
        found = solve(file_of(asked.folder, name), asked.time, asked.gap)
        low, high = known[name]
        overlap = found["lower"] <= high and low <= found["upper"]
        apart += not overlap
        print(
            f"| {name} | {found['states']} | {found['lower']:.6g} | {found['upper']:.6g} "
            f"| {found['seconds']:.2f} | {low:.6g} .. {high:.6g} | {'yes' if overlap else 'NO'} |",
            flush=True,
        )
    return 1 if apart else 0


if __name__ == "__main__":
    sys.exit(main())
