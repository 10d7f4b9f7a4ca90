# SPDX-License-Identifier: Apache-2.0
"""Fuzz for long.

PYTHONPATH=tests python tests/fuzz/long_run.py --cases 1000000 [--short] [--seed 0] [--keep FOLDER]

The release's targets are 1,000,000 whole files and 10,000,000 files of less than 200 bytes (``--short``).
Prints what came how often, the slowest case and the peak of memory, and writes each failing file to the
folder. Several processes share the work by different seeds. With ``--atheris`` the same check runs under
atheris (``pip install atheris``), which follows the coverage of hypgen's Python and ends at a failure.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

from support.fuzz_cases import case, check, corpus, small_case


def main() -> int:
    """Run the cases; return 1 if one failed."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0, help="of the first case; the next ones follow")
    parser.add_argument("--short", action="store_true", help="files of less than 200 bytes")
    parser.add_argument("--keep", type=Path, default=Path("fuzz-failures"), help="where failing files go")
    parser.add_argument("--atheris", action="store_true", help="let atheris make the files")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if options.atheris:
            return _run_atheris(Path(folder))
        return _run(options, Path(folder))


def _run(options: argparse.Namespace, folder: Path) -> int:
    make = small_case if options.short else case
    codes: Counter[str] = Counter()
    failures: Counter[str] = Counter()
    slowest, start = (0.0, 0), time.monotonic()
    for seed in range(options.seed, options.seed + options.cases):
        content, began = make(seed), time.process_time()
        try:
            codes[check(content, folder)] += 1
        except Exception as error:
            place = traceback.extract_tb(error.__traceback__)[-1]
            failures[f"{type(error).__name__} at {Path(place.filename).name}:{place.lineno}: {error}"] += 1
            options.keep.mkdir(parents=True, exist_ok=True)
            (options.keep / f"{'short-' * options.short}{seed}.pomdp").write_bytes(content)
        slowest = max(slowest, (time.process_time() - began, seed))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{options.cases} cases from seed {options.seed} in {time.monotonic() - start:.0f} s")
    print(f"slowest: {slowest[0]:.2f} s of CPU (seed {slowest[1]}); peak {peak:.0f} MB")
    print(", ".join(f"{code} {count}" for code, count in codes.most_common()))
    for what, count in failures.most_common():
        print(f"FAILED {count} times: {what}")
    return 1 if failures else 0


def _run_atheris(folder: Path) -> int:
    try:
        import atheris
    except ModuleNotFoundError:
        print("atheris is not installed: pip install atheris", file=sys.stderr)
        return 2
    seeds = folder / "corpus"
    seeds.mkdir()
    for number, text in enumerate(corpus()):
        (seeds / f"{number}.pomdp").write_text(text)
    atheris.instrument_all()
    atheris.Setup([sys.argv[0], str(seeds)], lambda content: check(content, folder))
    atheris.Fuzz()
    return 0


if __name__ == "__main__":
    sys.exit(main())
