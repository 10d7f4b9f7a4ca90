# SPDX-License-Identifier: Apache-2.0
"""Makes tables of the lines of drives.

python -m vehicle.report drives.jsonl
"""

from __future__ import annotations

import json
import math
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

Line = dict[str, object]
HEAD = (
    "| policy | drives | arrived | front collisions a drive | a km | at over 0.5 m/s | flank contacts "
    "| near misses | time to goal, s | speed, m/s | hard brakings | deadlines kept | latest, ms | NIS |"
)


def interval(values: np.ndarray) -> str:
    """Return mean and 95 % interval of a mean."""
    half = 1.96 * values.std(ddof=1) / math.sqrt(len(values)) if len(values) > 1 else math.nan
    return f"{values.mean():.2f} ± {half:.2f}"


def row(name: str, lines: list[Line]) -> str:
    """Return a row of the table."""

    def column(key: str) -> np.ndarray:
        return np.array([float(str(line[key])) for line in lines])

    arrived = np.array([bool(line["arrived"]) for line in lines])
    front, metres, seconds = column("front_hits"), column("metres"), column("seconds")
    kept = 1 - column("late").sum() / column("decisions").sum()
    rate = 1000 * front.sum() / max(metres.sum(), 1.0)
    spread = 1000 * 1.96 * np.sqrt(((front - rate / 1000 * metres) ** 2).sum()) / max(metres.sum(), 1.0)
    late = 1000 * max(0.0, column("latest").max())
    cells = [
        *(name, str(len(lines)), f"{100 * arrived.mean():.0f} %", interval(front)),
        f"{rate:.1f} ± {spread:.1f}",
        interval(column("fast_hits")),
        interval(column("hits") - front),
        interval(column("near")),
        interval(seconds[arrived]) if arrived.any() else "",
        f"{metres.sum() / seconds.sum():.2f}",
        interval(column("hard_brakings")),
        f"{100 * kept:.2f} %",
        f"{late:.0f}",
        f"{column('surprise').mean():.2f}",
    ]
    return f"| {' | '.join(cells)} |"


def tables(lines: list[Line]) -> str:
    """Return a table for each rate and each thing that is wrong, a row for each policy."""
    groups: dict[tuple[object, object], dict[str, list[Line]]] = defaultdict(lambda: defaultdict(list))
    for line in lines:
        groups[(line["hertz"], line["wrong"])][str(line["row"])].append(line)
    found = []
    for (hertz, wrong), rows in sorted(groups.items(), key=str):
        found += [f"{hertz:g} Hz, wrong: {wrong}", "", HEAD, "|---" * (HEAD.count("|") - 1) + "|"]
        found += [row(name, rows[name]) for name in rows] + [""]
    return "\n".join(found)


if __name__ == "__main__":
    texts = [text for name in sys.argv[1:] for text in Path(name).read_text().splitlines()]
    print(tables([json.loads(text) for text in texts]))
