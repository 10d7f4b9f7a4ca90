# SPDX-License-Identifier: Apache-2.0
"""Prints how exact the float functions are: ``docs/results/float_functions.md`` has the table.

PYTHONPATH=tests python benchmarks/float_functions.py [SAMPLES]
"""

from __future__ import annotations

import sys

from support.float_reference import FUNCTIONS, mistaken, samples


def main() -> None:
    """Print a row for each function."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 2_000_000
    print("| function | inputs | not correctly rounded | worst error (ulp) |")
    print("|---|--:|--:|--:|")
    for name in FUNCTIONS:
        columns = samples(name, count, seed=11)
        errors = mistaken(name, columns)
        print(
            f"| `{name}` | {len(columns[0]):,} | {len(errors)} | {max(errors, default=0.5):.6f} |", flush=True
        )


if __name__ == "__main__":
    main()
