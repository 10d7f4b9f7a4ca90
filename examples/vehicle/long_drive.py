# SPDX-License-Identifier: Apache-2.0
"""Drives round the plaza for a long time with one planner; writes a JSON line a minute, of time and memory.

python -m vehicle.long_drive --minutes 30 --out long.jsonl
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path

from hypgen.api.solver import Solver
from vehicle import hybrid_a_star, policies, scenes
from vehicle.bridge import Situation
from vehicle.drive import Drive
from vehicle.drives import PEOPLE, compiled
from vehicle.policies import Choice, Policy
from vehicle.world import World

GOALS = ((31.0, 28.0), (14.0, 32.0), (7.0, 14.0), (27.0, 9.0))  # round the fountain


class LongDrive(Drive):
    """A drive with another goal after each, which notes each minute."""

    def __init__(self, world: World, policy: Policy, hertz: float, budget: float, out: Path) -> None:
        super().__init__(world, policy, hertz, budget, self._note)
        self._out, self._minutes, self.turns = out, 0, 0
        self.lines: list[dict[str, float]] = []

    def arrive(self) -> bool:
        """Take the next goal; a drive ends by its time alone."""
        self.turns += 1
        pose = self.world.car.pose
        self.world.scene = replace(self.world.scene, goal=GOALS[self.turns % len(GOALS)])
        path = hybrid_a_star.plan(self.world.scene, (pose.x, pose.y, pose.heading), free=2.5)
        if path is None:
            raise RuntimeError(f"no path from {pose}")
        self.path, self.s = path, 0.0
        return False

    def _note(self, drive: Drive, situation: Situation, choice: Choice) -> None:
        counts = self.world.counts
        if counts.seconds < 60 * (self._minutes + 1):
            return
        self._minutes += 1
        status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
        seconds = self.log.seconds
        line = {
            "minute": self._minutes,
            "metres": counts.metres,
            "front_hits": counts.front_hits,
            "hits": counts.hits,
            "turns": self.turns,
            "late": sum(s > self.period for s in seconds),
            "latest_ms": 1000 * (max(seconds) - self.period),
            "mib": int(status["VmRSS"].split()[0]) / 1024,
            "tracks": len(self.tracks.at),
        }
        self.lines.append(line)
        with self._out.open("a") as out:
            print(json.dumps(line), file=out)


def main() -> None:
    """Drive round the fountain."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--row", default="despot", choices=policies.SOLVERS)
    parser.add_argument("--hertz", type=float, default=3.0)
    parser.add_argument("--share", type=float, default=0.9, help="of the period, for a decision")
    parser.add_argument("--library", help="that of vehicle.pomdp; compiled if left out")
    parser.add_argument("--out", type=Path, required=True)
    args = parser.parse_args()
    scene = replace(scenes.make("plaza", 1, PEOPLE["plaza"]), goal=GOALS[0])
    solver = Solver(Path(args.library or compiled()))
    policy = policies.make(args.row, solver, scene.exits, 1 / args.hertz, 1)
    LongDrive(World(scene, 1), policy, args.hertz, args.share / args.hertz, args.out).play(
        60 * args.minutes + 1
    )


if __name__ == "__main__":
    main()
