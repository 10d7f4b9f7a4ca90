# SPDX-License-Identifier: Apache-2.0
"""People as a robot knows them: tracks that are born, coast, are found again, and die.

Each track has a Kalman filter of constant velocity and what is believed of its intention. A track that is not
detected coasts and keeps both; a detection that fits it later finds it again with all it had.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vehicle.scenes import Floats
from vehicle.sensor import Scan

PUSH = 1.0  # m/s^2: how people change their velocity
SENSES = 0.08  # m: the noise that the sensor is taken to have
GATE = 3.0  # standard deviations
FAR = 1.5  # m: no detection is a track's that is further away
HITS = 3  # detections until somebody is believed to be there
COASTS, KEPT = 0.6, 3.0  # s without a detection: how long a track counts as seen, and how long it is kept
SLOW = 0.3  # m/s: who stands
USUAL = 1.2  # m/s: what people walk at, until one was seen to walk


class Tracks:
    """All tracks, in arrays by track."""

    def __init__(self, prior: Floats) -> None:
        self.prior = prior  # (intents,): what is believed of the intention of who was never seen
        self.id = np.zeros(0, np.int64)
        self.label = np.zeros(0, np.int64)  # that of the last detection
        self.at = np.zeros((0, 2))  # m
        self.velocity = np.zeros((0, 2))  # m/s
        self.variance = np.zeros((0, 3))  # of place, of both, of velocity, on each axis
        self.hits = np.zeros(0, np.int64)
        self.missed = np.zeros(0)  # s since the last detection
        self.stood = np.zeros(0)  # s
        self.pace = np.zeros(0)  # m/s, of who walks
        self.intent = np.zeros((0, len(prior)))
        self.before = np.zeros((0, 4))  # place and velocity at the decision before; NaN where there was none
        self.found_again = 0
        self.surprise = (
            2.0  # the mean normalised innovation squared of late; 2 if the filters' noises are right
        )
        self._born = 0

    def seen(self) -> npt.NDArray[np.bool_]:
        """Return which tracks are people who are there now."""
        found: npt.NDArray[np.bool_] = (self.hits >= HITS) & (self.missed <= COASTS)
        return found

    def step(self, scan: Scan, seconds: float) -> None:
        """Move all tracks on, give each its detection, and let tracks be born and die."""
        self._predict(seconds)
        track, detection = self._pairs(scan)
        self._correct(track, scan.at[detection])
        self.label[track] = scan.labels[detection]
        self.found_again += int((self.missed[track] > COASTS).sum())
        self.missed += seconds
        self.missed[track] = 0.0
        self.hits[track] += 1
        speed = np.hypot(*self.velocity.T)
        self.stood = np.where(speed < SLOW, self.stood + seconds, 0.0)
        walks = (speed > 0.5) & (self.missed == 0) & (self.hits > 5)
        self.pace += np.where(walks, seconds * (np.clip(speed, 0.5, 2.0) - self.pace), 0.0)
        kept = (self.missed <= KEPT) & ((self.hits >= HITS) | (self.missed <= 0.25))
        self._keep(kept)
        self._bear(scan, np.setdiff1d(np.arange(len(scan.at)), detection))

    def remember(self) -> None:
        """Keep where everybody is, for the next decision's update of the belief."""
        self.before = np.concatenate([self.at, self.velocity], 1)

    def _predict(self, seconds: float) -> None:
        coasting = np.where(self.missed > COASTS, 0.5 ** (seconds / 0.5), 1.0)  # who is lost slows down
        self.velocity *= coasting[:, None]
        self.at = self.at + self.velocity * seconds
        p, c, v = self.variance.T
        t, q = seconds, PUSH**2
        self.variance = np.stack(
            [p + 2 * t * c + t * t * v + q * t**4 / 4, c + t * v + q * t**3 / 2, v + q * t * t], -1
        )

    def _pairs(self, scan: Scan) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
        """Return tracks and their detections, the best pairs first; an equal label makes a pair better."""
        away = np.hypot(self.at[:, None, 0] - scan.at[None, :, 0], self.at[:, None, 1] - scan.at[None, :, 1])
        deviation = np.sqrt(self.variance[:, :1] + SENSES**2)
        first, second = np.nonzero(away < np.minimum(GATE * deviation + 0.1, FAR))
        same = self.label[first] == scan.labels[second]
        new = self.hits[first] < HITS
        order = np.argsort(away[first, second] / deviation[first, 0] - 1.0 * same + 1.0 * new)
        tracks, detections = set(), set()
        found = []
        for k in order:
            i, j = int(first[k]), int(second[k])
            if i not in tracks and j not in detections:
                tracks.add(i)
                detections.add(j)
                found.append((i, j))
        both = np.array(found, np.int64).reshape(-1, 2)
        return both[:, 0], both[:, 1]

    def _correct(self, track: npt.NDArray[np.int64], at: Floats) -> None:
        p, c, v = self.variance[track].T
        total = p + SENSES**2
        off = at - self.at[track]
        self.at[track] += (p / total)[:, None] * off
        self.velocity[track] += (c / total)[:, None] * off
        self.variance[track] = np.stack([p - p * p / total, c - p * c / total, v - c * c / total], -1)
        old = self.hits[track] > 10
        for value in ((off**2).sum(1) / total)[old]:
            self.surprise += 0.002 * (value - self.surprise)

    def _keep(self, kept: npt.NDArray[np.bool_]) -> None:
        for name in (
            *("id", "label", "at", "velocity", "variance", "hits", "missed", "stood", "pace"),
            *("intent", "before"),
        ):
            setattr(self, name, getattr(self, name)[kept])

    def _bear(self, scan: Scan, new: npt.NDArray[np.int64]) -> None:
        count = len(new)
        first = {
            "id": np.arange(self._born, self._born + count),
            "label": scan.labels[new],
            "at": scan.at[new],
            "velocity": np.zeros((count, 2)),
            "variance": np.tile([SENSES**2, 0.0, 1.0], (count, 1)),
            "hits": np.ones(count, np.int64),
            "missed": np.zeros(count),
            "stood": np.zeros(count),
            "pace": np.full(count, USUAL),
            "intent": np.tile(self.prior, (count, 1)),
            "before": np.full((count, 4), np.nan),
        }
        for name, value in first.items():
            setattr(self, name, np.concatenate([getattr(self, name), value]))
        self._born += count
