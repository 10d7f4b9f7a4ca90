# SPDX-License-Identifier: Apache-2.0
"""Plays drives and writes a JSON line for each; what a file has already is not played again.

python -m vehicle.drives --out drives.jsonl --rows reactive,ttc,default,despot --drives 100
"""

from __future__ import annotations

import argparse
import importlib.util
import itertools
import json
import os
import resource
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from pathlib import Path

from hypgen.api.solver import Solver
from vehicle import drive, policies, scenes
from vehicle.world import World

PEOPLE = {"plaza": 80, "crossing": 30, "corridor": 20, "group": 60}  # of each scene, unless told otherwise
MOST_SECONDS = 120.0
# What is wrong on purpose: how many times faster people are, and how many times noisier the sensor is.
WRONG = {"none": (1.0, 1.0), "fast": (2.0, 1.0), "noisy": (1.0, 2.0)}
Drive = Future[dict[str, object]]
KEY = ("row", "hertz", "wrong", "scene", "seed")


def cells(args: argparse.Namespace) -> Iterator[dict[str, object]]:
    """Yield what is to be played: all rows of a scene and seed beside each other."""
    names = args.scenes.split(",")
    axes = (range(args.first, args.first + args.drives), args.hertz.split(","), args.wrong.split(","))
    for number, hertz, wrong in itertools.product(*axes):
        for row in args.rows.split(","):
            yield {
                "row": row,
                "hertz": float(hertz),
                "wrong": wrong,
                "scene": names[number % len(names)],
                "seed": number // len(names),
            }


def play(cell: dict[str, object], library: str | None, people: int, share: float) -> dict[str, object]:
    """Play one drive; return its line."""
    scene_name, seed, hertz = str(cell["scene"]), int(str(cell["seed"])), float(str(cell["hertz"]))
    pace, noise = WRONG[str(cell["wrong"])]
    scene = scenes.make(scene_name, seed, people or PEOPLE[scene_name])
    solver = Solver(Path(library)) if library else None
    policy = policies.make(str(cell["row"]), solver, scene.exits, 1 / hertz, seed)
    world = World(scene, seed, pace=pace, noise=noise)
    found = drive.Drive(world, policy, hertz, budget=share / hertz)
    found.play(MOST_SECONDS)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {**cell, "people": len(scene.people), "share": share, "mib": memory, **drive.summary(found)}


def main() -> None:
    """Play what the file does not have."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, required=True, help="JSON lines, which are added to")
    parser.add_argument("--library", help="that of vehicle.pomdp; compiled if left out")
    parser.add_argument("--rows", default="reactive,ttc,default,despot", help="policies")
    parser.add_argument("--hertz", default="3", help="decisions a second: 3, 10 or both")
    parser.add_argument("--wrong", default="none", help=f"what is wrong: {', '.join(WRONG)}")
    parser.add_argument("--scenes", default=",".join(scenes.SCENES))
    parser.add_argument("--drives", type=int, default=100, help="of each row, spread over the scenes")
    parser.add_argument("--first", type=int, default=0, help="number of the first drive")
    parser.add_argument("--people", type=int, default=0, help="in place of those of each scene")
    parser.add_argument("--share", type=float, default=0.9, help="of the period, for a decision")
    parser.add_argument("--jobs", type=int, default=1, help="drives at a time, a process each")
    args = parser.parse_args()
    known = set()
    if args.out.exists():
        lines = (json.loads(line) for line in args.out.read_text().splitlines() if line.endswith("}"))
        known = {tuple(line[name] for name in KEY) for line in lines}
    missing = [cell for cell in cells(args) if tuple(cell[name] for name in KEY) not in known]
    needs = set(args.rows.split(",")) - set(policies.RULES)
    library = args.library or (compiled() if needs else None)
    os.environ["OMP_NUM_THREADS"] = "1"  # NumPy's threads would take the planner's cores
    count = len(missing)
    with args.out.open("a") as out, ProcessPoolExecutor(args.jobs) as pool:
        playing = [pool.submit(play, cell, library, args.people, args.share) for cell in missing]
        for played in _watched(as_completed(playing), count):
            print(json.dumps(played.result(), default=float), file=out, flush=True)


def _watched(drives: Iterable[Drive], count: int) -> Iterable[Drive]:
    """Show progress where there is Rich; a robot's machine may not have it."""
    if importlib.util.find_spec("rich") is None:
        return drives
    from rich.progress import track

    return track(drives, "drives", count)


def compiled() -> str:
    """Return the path of the model's library; only this needs the compiler."""
    import hypgen

    model = hypgen.load(Path(__file__).with_name("vehicle.pomdp"))
    return str(model.compile(progress=print).path)


if __name__ == "__main__":
    main()
