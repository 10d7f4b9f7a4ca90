# SPDX-License-Identifier: Apache-2.0
"""Draws what sharing a step among warps gains: docs/results/data/gpu_warps.csv becomes gpu_warps.svg.

python benchmarks/device/plot_warps.py        # needs matplotlib
"""

from __future__ import annotations

import csv
from pathlib import Path

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams["svg.hashsalt"] = "hypgen"  # the same file from run to run
import matplotlib.pyplot as plt  # noqa: E402

DATA = Path(__file__).resolve().parent.parent.parent / "docs" / "results" / "data"


def main() -> None:
    """Draw a panel for each kind of batch, a line for each number of pedestrians."""
    with (DATA / "gpu_warps.csv").open() as file:
        rows = list(csv.DictReader(file))
    batches = list(dict.fromkeys((row["scenarios"], row["batch"]) for row in rows))
    figure, panels = plt.subplots(1, len(batches), figsize=(3.6 * len(batches), 3.2), sharey=True)
    for panel, (scenarios, batch) in zip(panels, batches, strict=True):
        for pedestrians in dict.fromkeys(row["pedestrians"] for row in rows):
            points = {
                int(row["warps"]): float(row["leaves_a_second"])
                for row in rows
                if (row["scenarios"], row["batch"], row["pedestrians"]) == (scenarios, batch, pedestrians)
            }
            if 1 in points:
                gains = [points[warps] / points[1] for warps in sorted(points)]
                panel.plot(sorted(points), gains, marker="o", label=pedestrians)
        panel.set_xscale("log", base=2)
        panel.set_xticks([1, 2, 4, 8, 16], ["1", "2", "4", "8", "16"])
        panel.axhline(1.0, color="grey", linewidth=0.8)
        panel.set_title(f"leaves of {scenarios}, {batch} a batch", fontsize=10)
        panel.set_xlabel("warps that share a step")
    panels[0].set_ylabel("leaves a second, against 1 warp")
    panels[-1].legend(title="pedestrians", fontsize=8)
    figure.tight_layout()
    figure.savefig(DATA / "gpu_warps.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
