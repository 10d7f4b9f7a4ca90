# SPDX-License-Identifier: Apache-2.0
"""Measure simulated worlds of RockSample(7,8): docs/results/worlds.md has the table.

    python benchmarks/worlds.py [--runs 3] [--seconds 2] [--device cuda]

Each row steps worlds by actions that were drawn before: moves and checks, with equal probability. Episodes
that end are started again. Rows that need gymnasium or pomdp_py are left out without it. One thread each,
and seconds are those of the processor: other programs may share the machine. With a GPU they are those of the
clock on the wall.
"""

from __future__ import annotations

import argparse
import importlib.util
import itertools
import random
import statistics
import time
from collections.abc import Callable, Iterator

import numpy as np
from machine import ROOT, machine

import hypgen

MODEL = ROOT / "examples" / "rock_sample.pomdp"
N, K = 7, 8
SAMPLE = 4  # the only action that is not always legal
ACTIONS = [a for a in range(5 + K) if a != SAMPLE]
DRAWN = 1 << 12  # actions, which come round again
BASE = "a loop over pomdp_py's own RockSample(7,8)"

Steps = Iterator[int]  # yields how many steps it has done since the last


def vectorised(solver: hypgen.Solver, count: int, device: str) -> Steps:
    """Step a vectorised environment."""
    envs = solver.vector_env(count, device=device)
    envs.reset(seed=1)
    drawn = np.random.default_rng(1).choice(ACTIONS, (64, count))
    for actions in itertools.cycle(drawn):
        envs.step(actions)
        yield count


def arrays(solver: hypgen.Solver, count: int, device: str) -> Steps:
    """Step worlds without Gymnasium."""
    with solver.worlds(count, seed=1, device=device) as worlds:
        worlds.reset()
        drawn = np.random.default_rng(1).choice(ACTIONS, (64, count))
        for actions in itertools.cycle(drawn):
            worlds.step(np.where(worlds.terminal, worlds.NEXT_EPISODE, actions))
            yield count


def alone(solver: hypgen.Solver) -> Steps:
    """Step one environment."""
    env = solver.env()
    env.reset(seed=1)
    for action in itertools.cycle(random.Random(1).choices(ACTIONS, k=DRAWN)):
        if env.step(action)[2]:
            env.reset()
        yield 1


def interpreted() -> Steps:
    """Step the interpreter, an episode of one world at a time."""
    from hypgen.dsl.interpret.episode import Episode

    model = hypgen.load(MODEL).loaded.model
    numbers = itertools.count()
    episode = Episode(model, 1, next(numbers))
    for action in itertools.cycle(random.Random(1).choices(ACTIONS, k=DRAWN)):
        episode.step(action)
        if episode.now.terminal:
            episode = Episode(model, 1, next(numbers))
        yield 1


def of_pomdp_py() -> Steps:
    """Step the environment of pomdp_py with its own models of RockSample."""
    import pomdp_py
    from pomdp_py.problems.rocksample import rocksample_problem as rocks

    random.seed(1)
    start, places = rocks.RockSampleProblem.generate_instance(N, K)

    def is_exit(position: tuple[int, int]) -> bool:
        return position[0] == N

    transition, rewards = rocks.RSTransitionModel(N, places, is_exit), rocks.RSRewardModel(places, is_exit)
    observe = rocks.RSObservationModel(places)
    world = pomdp_py.Environment(start, transition, rewards)
    moves = [rocks.MoveNorth, rocks.MoveSouth, rocks.MoveEast, rocks.MoveWest]
    actions = [*moves, *(rocks.CheckAction(k) for k in range(K))]
    for action in itertools.cycle(random.Random(1).choices(actions, k=DRAWN)):
        world.state_transition(action, execute=True)
        world.provide_observation(observe, action)
        if world.state.terminal:
            good = tuple(rocks.RockType.random() for _ in range(K))
            world.apply_transition(rocks.State(start.position, good, False))
        yield 1


def rate(make: Callable[[], Steps], seconds: float, clock: Callable[[], float]) -> float:
    """Return the steps a second of one run, after a tenth of it that does not count."""
    steps = make()
    begin = clock()
    while clock() < begin + seconds / 10:
        next(steps)
    done, begin = 0, clock()
    while (now := clock()) < begin + seconds:
        done += next(steps)
    return done / (now - begin)


def main() -> None:
    """Measure all rows, run by run, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=2.0)
    parser.add_argument("--device", default="cpu")
    options = parser.parse_args()
    device = options.device
    solver = hypgen.load(MODEL, n=N, k=K).compile(target="cpu" if device == "cpu" else "cuda")
    clock = time.process_time if device == "cpu" else time.perf_counter
    counts = (64, 1024, 4096, 16384) if device == "cpu" else (4096, 16384, 65536, 262144)
    rows: dict[str, Callable[[], Steps]] = {}
    if importlib.util.find_spec("pomdp_py") is not None:
        rows[BASE] = of_pomdp_py
    rows["a loop over hypgen's interpreter"] = interpreted
    if importlib.util.find_spec("gymnasium") is not None:
        rows["`solver.env()`"] = lambda: alone(solver)
        for count in counts:
            rows[f"`solver.vector_env({count})`"] = lambda count=count: vectorised(solver, count, device)
    for count in counts[2:]:
        rows[f"`solver.worlds({count})`"] = lambda count=count: arrays(solver, count, device)
    found: dict[str, list[float]] = {name: [] for name in rows}
    for _ in range(options.runs):
        for name, make in rows.items():
            found[name].append(rate(make, options.seconds, clock))
    print(f"Machine: {machine()}. {options.runs} runs of {options.seconds:g} s each; median and range.\n")
    print("| what is stepped | steps/s | times pomdp_py |\n|---|---|---|")
    base = statistics.median(found[BASE]) if BASE in found else float("nan")
    for name, rates in found.items():
        median = statistics.median(rates)
        print(f"| {name} | {median:,.0f} ({min(rates):,.0f} to {max(rates):,.0f}) | {median / base:,.1f} |")


if __name__ == "__main__":
    main()
