# SPDX-License-Identifier: Apache-2.0
"""Drives once and writes a recording of it, for ``hypgen view``.

python -m vehicle.picture --scene plaza --seed 3 --out drive.jsonl
hypgen view examples/vehicle/vehicle.pomdp --log drive.jsonl -o drive.html --gif drive.gif
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

import hypgen
from hypgen.api.solver import Solver
from vehicle import policies, scenes
from vehicle.bridge import Situation
from vehicle.drive import Drive
from vehicle.drives import PEOPLE
from vehicle.policies import Choice, Planned
from vehicle.world import World


class Recorder:
    """Notes each decision of a drive as a line of a recording (docs/reference/recording.md).

    What is true of an intention is the simulated person's own. The world here is not the model, so nothing
    says what a step has earned: rewards are 0.
    """

    def __init__(self, policy: Planned, solver: Solver, model: hypgen.Model, params: dict[str, Any]) -> None:
        found = solver.description
        self._bridge = policy.bridge
        variables = [field | {"visible": True} for field in found["visible"]]
        variables += [field | {"visible": False} for field in found["hidden"]]
        known = {p["name"]: p["default"][0] for p in found["params"]} | params  # all are numbers
        header = {
            "type": "recording",
            "version": 1,
            "kind": "episode",
            "file": "vehicle.pomdp",
            **{name: found[name] for name in ("model", "hash", "discount", "horizon", "actions")},
            "options": {"seed": 0, "mode": self._bridge.planner.info["mode"]},
            "params": known,
            "variables": variables,
        }
        self.lines: list[dict[str, Any]] = [header, {"type": "start", "episode": 0, "visible": {}}]
        self._state: dict[str, Any] = {}

    def watch(self, drive: Drive, situation: Situation, choice: Choice) -> None:
        """Add a decision."""
        bridge, planner = self._bridge, self._bridge.planner
        chosen = bridge.nearest(situation)
        visible = bridge.state(situation, chosen)
        visible["ped.prior"] = np.ravel(visible["ped.prior"]).tolist()  # type: ignore[call-overload]
        away = drive.tracks.at[chosen][:, None] - drive.world.crowd.at
        who = np.hypot(away[..., 0], away[..., 1]).argmin(1)
        aims, attends = drive.world.crowd.aims[who], drive.world.crowd.attends[who]
        rest = bridge.people - len(who)
        hidden = {
            "ped.intent": ["stand" if a < 0 else f"exit({a})" for a in aims] + ["stand"] * rest,
            "ped.stops": [bool(a) for a in attends] + [False] * rest,
        }
        self._state = {**visible, "car.begun": False, "car.s": 0.0, **hidden}
        names = ["stand", "straight", *(f"exit({e})" for e in range(len(bridge.intents) - 2))]
        drawn = planner.sample_belief(200)
        sampled = {
            "ped.intent": [[names[v] for v in row] for row in drawn["ped.intent"]],
            "ped.stops": drawn["ped.stops"].tolist(),
        }
        marginals = [
            {"variable": n, "values": [{"value": v, "probability": p} for v, p in values.items()]}
            for n, values in planner.belief.items()
            if isinstance(values, dict)
        ]
        try:
            tree: dict[str, Any] | None = planner.tree(depth=3, top=4)
        except hypgen.PlannerError:
            tree = None  # the comparison alone decided
        number = len(self.lines) - 2
        self.lines.append(
            {
                "type": "step",
                "episode": 0,
                "step": number,
                "action": planner.action(choice.name),
                "action_name": choice.name,
                "default_action": None,
                "reward": 0.0,
                "terminal": False,
                "seen": {},
                "state": self._state,
                "sampled": sampled,
                "particles_total": None,
                "marginals": marginals,
                "tree": tree,
                "tree_shown": 0,
                "tree_total": 0,
                "status": choice.status,
                "lower": choice.lower,
                "upper": choice.upper,
                "search_seconds": drive.log.seconds[-1],
                "update_seconds": 0.0,
            }
        )

    def write(self, path: Path) -> None:
        """Write the file."""
        steps = len(self.lines) - 2
        end = {"steps": steps, "discounted_return": 0.0, "status": "ok", "terminal": False}
        lines = [*self.lines, {"type": "episode", "episode": 0, **end, "state": self._state}]
        path.write_text("".join(json.dumps(line, separators=(",", ":")) + "\n" for line in lines))


def main() -> None:
    """Play one drive and write it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--scene", default="plaza", choices=scenes.SCENES)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--people", type=int, default=0)
    parser.add_argument("--row", default="despot", choices=policies.SOLVERS)
    parser.add_argument("--share", type=float, default=0.9, help="of the period, for a decision")
    parser.add_argument("--out", type=Path, required=True)
    args = parser.parse_args()
    model = hypgen.load(Path(__file__).with_name("vehicle.pomdp"))
    solver = model.compile(progress=print)
    scene = scenes.make(args.scene, args.seed, args.people or PEOPLE[args.scene])
    policy = policies.make(args.row, solver, scene.exits, 1 / 3, args.seed)
    assert isinstance(policy, Planned)  # all rows of SOLVERS are
    recorder = Recorder(policy, solver, model, {"first_dt": 1 / 3})
    world = World(scene, args.seed)
    Drive(world, policy, 3, budget=args.share / 3, watch=recorder.watch).play(60)
    recorder.write(args.out)
    print(world.counts)


if __name__ == "__main__":
    main()
