# SPDX-License-Identifier: Apache-2.0
"""Solves model files of other people and compares the intervals with certified ones.

python3 benchmarks/exact/corpus.py FOLDER [--time 20] [--gap 0.001] [--all] [NAME ...]

FOLDER has models in Cassandra's format or POMDPX in its subfolders, and a README.md with a table of lines
"| name[, name ..] | lower | upper |". Names choose files; without any, all that are in the table are solved,
with --all all that are in the subfolders. Prints a table in Markdown, where `import` is the whole command's
time; the exit code is 1 if an interval does not overlap the certified one.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time as clock
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any

HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]
SUFFIXES = (".pomdp", ".POMDP", ".pomdpx")


def certified(page: str) -> dict[str, tuple[float, float]]:
    """Return the interval of each name in the page's table, with what its digits leave open."""
    found = {}
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        try:
            lower, upper = (Decimal(cell) for cell in cells[1:3])
        except (ValueError, InvalidOperation):
            continue
        ends = float(lower) - half_digit(lower), float(upper) + half_digit(upper)
        found.update({name.strip(): ends for name in cells[0].split(",")})
    return found


def half_digit(number: Decimal) -> float:
    """Return half a unit of a number's last digit."""
    return 0.5 * 10.0 ** int(number.as_tuple().exponent)


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


def import_seconds(file: Path) -> float:
    """Return what `hypgen import` takes."""
    start = clock.monotonic()
    subprocess.run([*HYPGEN, "import", str(file)], capture_output=True, check=True)
    return clock.monotonic() - start


def main() -> int:
    """Solve the models and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--time", type=float, default=20.0, help="seconds for each model (20)")
    parser.add_argument("--gap", type=float, default=1e-3, help="where to stop (0.001)")
    parser.add_argument("--all", action="store_true", help="files without a certified interval, too")
    asked = parser.parse_args()
    known = certified((asked.folder / "README.md").read_text(encoding="utf-8"))
    print("| model | states | import | lower | upper | seconds | certified | overlap |")
    print("|---|---|---|---|---|---|---|---|")
    apart = 0
    names = asked.names or list(known)
    if asked.all:
        files = [p for p in sorted(asked.folder.glob("*/*")) if p.suffix in SUFFIXES]
        names = [p.name if p.name in known else p.stem for p in files]
    for name in names:
        file = file_of(asked.folder, name)
        seconds = import_seconds(file)
        found = solve(file, asked.time, asked.gap)
        sure, overlap = "-", "-"
        if name in known:
            low, high = known[name]
            sure = f"{low:.6g} .. {high:.6g}"
            overlap = "yes" if found["lower"] <= high and low <= found["upper"] else "NO"
        apart += overlap == "NO"
        print(
            f"| {name} | {found['states']} | {seconds:.1f} | {found['lower']:.6g} | {found['upper']:.6g} "
            f"| {found['seconds']:.2f} | {sure} | {overlap} |",
            flush=True,
        )
    return 1 if apart else 0


if __name__ == "__main__":
    sys.exit(main())
