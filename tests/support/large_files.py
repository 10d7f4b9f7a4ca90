# SPDX-License-Identifier: Apache-2.0
"""Writes large model files in other formats, for tests and for measurements of `hypgen import`.

python3 tests/support/large_files.py rock-sample SIZE ROCKS > FILE.pomdpx
python3 tests/support/large_files.py dense STATES ACTIONS OBSERVATIONS > FILE.POMDP

`rock-sample` is RockSample(SIZE, ROCKS) in POMDPX, with a variable for the robot and one for each rock.
What is seen and what is earned are one table each, over the action, the robot and all rocks.
`dense` is random, in Cassandra's format, with every probability above 0.
"""

from __future__ import annotations

import argparse
import random
from collections.abc import Iterator

MOVES = {"amn": (0, 1), "ame": (1, 0), "ams": (0, -1), "amw": (-1, 0)}
HALF_EFFICIENCY = 20.0  # the distance at which a sensor's efficiency is a half


def rock_sample(size: int, rocks: int) -> Iterator[str]:
    """Yield the lines of RockSample(size, rocks); the robot's last value is the end."""
    cells = [(x, y) for y in range(size) for x in range(size)]
    places = random.Random(size * 1000 + rocks).sample(cells, rocks)
    end = f"s{len(cells)}"
    name = {cell: f"s{n}" for n, cell in enumerate(cells)}
    actions = [*MOVES, "as", *(f"ac{n}" for n in range(rocks))]
    yield '<?xml version="1.0" encoding="ISO-8859-1"?>'
    yield f'<pomdpx version="1.0" id="RockSample_{size}_{rocks}">'
    yield "<Discount>0.95</Discount>\n<Variable>"
    yield '<StateVar vnamePrev="robot_0" vnameCurr="robot_1" fullyObs="true">'
    yield f"<NumValues>{len(cells) + 1}</NumValues></StateVar>"
    for n in range(rocks):
        yield f'<StateVar vnamePrev="rock{n}_0" vnameCurr="rock{n}_1">'
        yield "<ValueEnum>good bad</ValueEnum></StateVar>"
    yield '<ObsVar vname="obs_sensor"><ValueEnum>ogood obad</ValueEnum></ObsVar>'
    yield f'<ActionVar vname="action"><ValueEnum>{" ".join(actions)}</ValueEnum></ActionVar>'
    yield '<RewardVar vname="reward"/>\n</Variable>\n<InitialStateBelief>'
    start = f"s{(size // 2) * size}"
    yield from _table(
        "robot_0", "null", [("-", " ".join(str(int(f"s{n}" == start)) for n in range(len(cells) + 1)))]
    )
    for n in range(rocks):
        yield from _table(f"rock{n}_0", "null", [("-", "uniform")])
    yield "</InitialStateBelief>\n<StateTransitionFunction>"
    moves = [("* - -", "identity")]
    for action, (dx, dy) in MOVES.items():
        for x, y in cells:
            to = (
                end
                if x + dx == size
                else name[(x + dx, min(max(y + dy, 0), size - 1))]
                if x + dx >= 0
                else name[(x, y)]
            )
            if to != name[(x, y)]:
                moves += [
                    (f"{action} {name[(x, y)]} {name[(x, y)]}", "0.0"),
                    (f"{action} {name[(x, y)]} {to}", "1.0"),
                ]
    yield from _table("robot_1", "action robot_0", moves)
    for n, place in enumerate(places):
        entries = [("* * - -", "identity"), (f"as {name[place]} good -", "0.0 1.0")]
        yield from _table(f"rock{n}_1", f"action robot_0 rock{n}_0", entries)
    yield "</StateTransitionFunction>\n<ObsFunction>"
    anything = " *" * rocks
    seen = [(f"* *{anything} -", "1.0 0.0")]
    for n, (px, py) in enumerate(places):
        for x, y in cells:
            right = 0.5 + 0.5 * 2 ** (-(((px - x) ** 2 + (py - y) ** 2) ** 0.5) / HALF_EFFICIENCY)
            for value, words in (("good", (right, 1 - right)), ("bad", (1 - right, right))):
                row = f"ac{n} {name[(x, y)]}{_only(n, value, rocks)} -"
                seen.append((row, f"{words[0]:.6f} {words[1]:.6f}"))
    yield from _table("obs_sensor", "action robot_1 " + " ".join(f"rock{n}_1" for n in range(rocks)), seen)
    yield "</ObsFunction>\n<RewardFunction>"
    gains = [(f"* *{anything}", "0"), (f"as *{anything}", "-100"), (f"as {end}{anything}", "0")]
    gains += [(f"amw {name[cell]}{anything}", "-100") for cell in cells if cell[0] == 0]
    gains += [(f"amn {name[cell]}{anything}", "-100") for cell in cells if cell[1] == size - 1]
    gains += [(f"ams {name[cell]}{anything}", "-100") for cell in cells if cell[1] == 0]
    gains += [(f"ame {name[cell]}{anything}", "10") for cell in cells if cell[0] == size - 1]
    for n, place in enumerate(places):
        gains += [
            (f"as {name[place]}{_only(n, value, rocks)}", gain)
            for value, gain in (("good", "10"), ("bad", "-10"))
        ]
    parents = "action robot_0 " + " ".join(f"rock{n}_0" for n in range(rocks))
    yield from _table("reward", parents, gains, "Func", "ValueTable")
    yield "</RewardFunction>\n</pomdpx>"


def _only(rock: int, value: str, rocks: int) -> str:
    return "".join(f" {value if n == rock else '*'}" for n in range(rocks))


def _table(
    variable: str,
    parents: str,
    entries: list[tuple[str, str]],
    tag: str = "CondProb",
    numbers: str = "ProbTable",
) -> Iterator[str]:
    yield f'<{tag}><Var>{variable}</Var><Parent>{parents}</Parent><Parameter type="TBL">'
    for instance, values in entries:
        yield f"<Entry><Instance>{instance}</Instance><{numbers}>{values}</{numbers}></Entry>"
    yield f"</Parameter></{tag}>"


def dense(states: int, actions: int, observations: int) -> Iterator[str]:
    """Yield the lines of a random model whose probabilities are all above 0."""
    draws = random.Random(states * actions * observations)
    yield "discount: 0.95\nvalues: reward"
    yield f"states: {states}\nactions: {actions}\nobservations: {observations}"
    for table, size in (("T", states), ("O", observations)):
        for action in range(actions):
            yield f"{table}: {action}"
            for _ in range(states):
                weights = [draws.random() ** 4 + 1e-3 for _ in range(size)]
                total = sum(weights)
                yield " ".join(f"{w / total:.7f}" for w in weights)
    for action in range(actions):
        for state in range(states):
            yield f"R: {action} : {state} : * : * {draws.uniform(-10, 10):.3f}"


def main() -> None:
    """Print the file that is asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("kind", choices=("rock-sample", "dense"))
    parser.add_argument("sizes", type=int, nargs="+")
    asked = parser.parse_args()
    for line in (rock_sample if asked.kind == "rock-sample" else dense)(*asked.sizes):
        print(line)


if __name__ == "__main__":
    main()
