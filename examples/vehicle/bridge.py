# SPDX-License-Identifier: Apache-2.0
"""Between tracks and a generated planner: the file to copy for a robot of your own.

The planner has places for a few people, and a robot sees many who come and go. So the belief is kept by
track, and nothing in the planner outlives a decision:

- `reset` carries in what is known: the car, the path, where people are, and what is believed of each.
- `update` takes in where they are a period later, by the exact posterior that the compiler has derived.
- `belief` carries out the new belief, which stays with the track.

Birth, death, and finding again are the tracks' matter: a track that takes or leaves a place takes its belief
along.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hypgen.api.planner import Decision, Planner
from vehicle.hybrid_a_star import Path
from vehicle.scenes import Floats
from vehicle.tracks import Tracks

FORGETS = 0.05  # per second: how often people change their minds
NOBODY = 1000.0  # m: where an empty place stands
LEAST = 1e-3  # of a belief in an exit that the scene has
LOOKS = 14.0  # m of the path along which the nearest people are looked for


@dataclass(frozen=True)
class Situation:
    """What a decision is made for, as it will be when its action begins."""

    path: Path
    s: float  # m along the path
    speed: float  # m/s
    tracks: Tracks
    later: float  # s until the action begins


def first_belief(exits: int, places: int) -> Floats:
    """Return what is believed of who was never seen: stands, walks straight on, walks to one of the exits."""
    to_exits = np.where(np.arange(places) < exits, 0.5 / exits, 0.0)
    return np.concatenate([[0.15, 0.35], to_exits])


class Bridge:
    """A planner of vehicle.pomdp that is asked for one decision after the other."""

    def __init__(self, planner: Planner, exits: Floats, *, period: float) -> None:
        sizes = {f.name: f.dims for f in planner.visible_fields}
        self.planner, self.period = planner, period
        self.people: int = sizes["ped.x"][0]
        self._points: int = sizes["car.px"][0]
        places: int = sizes["car.exit_x"][0]
        self._exits = np.zeros((places, 2))
        self._exits[: len(exits)] = exits
        self.intents = ("stand", "straight", *(f"exit({e})" for e in range(places)))
        self._prior = first_belief(len(exits), places)
        self._decisions = 0
        self.odd_updates = 0  # updates that the model did not explain

    def tracks(self) -> Tracks:
        """Return a new set of tracks with the first belief of this planner."""
        return Tracks(self._prior)

    def decide(self, situation: Situation, deadline: float) -> Decision:
        """Update the beliefs of all who are seen, then plan until a time of ``time.monotonic``."""
        self.believe(situation.tracks)
        chosen = self.nearest(situation)
        self._decisions += 1
        self.planner.reset(self.state(situation, chosen), episode=self._decisions)
        return self.planner.plan(deadline=max(deadline, time.monotonic()))

    def believe(self, tracks: Tracks) -> None:
        """Move on the belief of each track that was there at the decision before, some at a time."""
        tracks.intent += FORGETS * self.period * (self._prior - tracks.intent)
        known = np.flatnonzero(tracks.seen() & (tracks.missed == 0) & ~np.isnan(tracks.before[:, 0]))
        for first in range(0, len(known), self.people):
            self._believe(tracks, known[first : first + self.people])
        tracks.remember()

    def _believe(self, tracks: Tracks, some: npt.NDArray[np.int64]) -> None:
        before = tracks.before[some]
        self._decisions += 1
        visible = self._ped(before[:, :2], before[:, 2:], tracks.pace[some], tracks.intent[some])
        self.planner.reset(visible | self._places() | {"car.y": -NOBODY}, episode=self._decisions)
        seen = {"ped.x": self._filled(tracks.at[some, 0]), "ped.y": self._filled(tracks.at[some, 1])}
        self.odd_updates += self.planner.update("maintain", seen) != "ok"
        belief = self.planner.belief
        for place, row in enumerate(some):
            values = belief[f"ped.intent[{place}]"]
            assert isinstance(values, dict)  # an enum has probabilities
            found = np.maximum([values.get(name, 0.0) for name in self.intents], LEAST * (self._prior > 0))
            tracks.intent[row] = found / found.sum()

    def nearest(self, situation: Situation) -> npt.NDArray[np.int64]:
        """Return the tracks to plan for: those nearest to the path ahead, who are close to the car first."""
        tracks = situation.tracks
        seen = np.flatnonzero(tracks.seen())
        at = tracks.at[seen] + tracks.velocity[seen] * situation.later
        ahead = np.arange(0.0, LOOKS, 1.0)
        way = situation.path.at(situation.s + ahead)
        away = np.hypot(at[:, None, 0] - way[None, :, 0], at[:, None, 1] - way[None, :, 1]) + 0.3 * ahead
        return seen[np.argsort(away.min(1))[: self.people]]

    def state(self, situation: Situation, chosen: npt.NDArray[np.int64]) -> dict[str, object]:
        """Return the values of the planner's visible variables."""
        tracks, path = situation.tracks, situation.path
        way = situation.s + np.arange(self._points, dtype=float)
        points = path.at(way)
        ahead = points[1] - points[0]
        ahead /= np.hypot(*ahead)
        spacing = np.arange(len(path.points)) * path.length / (len(path.points) - 1)
        at = tracks.at[chosen] + tracks.velocity[chosen] * situation.later
        return {
            "car.px": points[:, 0].tolist(),
            "car.py": points[:, 1].tolist(),
            "car.limit": np.interp(way, spacing, path.limit).tolist(),
            "car.reach": float(np.clip(path.length - situation.s, 0.5, self._points - 1)),
            "car.v": float(situation.speed),
            "car.x": float(points[0, 0]),
            "car.y": float(points[0, 1]),
            "car.ux": float(ahead[0]),
            "car.uy": float(ahead[1]),
            **self._places(),
            **self._ped(at, tracks.velocity[chosen], tracks.pace[chosen], tracks.intent[chosen]),
        }

    def _places(self) -> dict[str, object]:
        return {"car.exit_x": self._exits[:, 0].tolist(), "car.exit_y": self._exits[:, 1].tolist()}

    def _filled(self, values: Floats, empty: float = NOBODY) -> list[float]:
        return [*values.tolist(), *[empty] * (self.people - len(values))]

    def _ped(self, at: Floats, velocity: Floats, pace: Floats, intent: Floats) -> dict[str, object]:
        prior = [*intent.tolist(), *[self._prior.tolist()] * (self.people - len(at))]
        return {
            "ped.x": self._filled(at[:, 0]),
            "ped.y": self._filled(at[:, 1]),
            "ped.going_x": self._filled(velocity[:, 0], 0.0),
            "ped.going_y": self._filled(velocity[:, 1], 0.0),
            "ped.pace": self._filled(pace, 0.0),
            "ped.prior": prior,
        }
