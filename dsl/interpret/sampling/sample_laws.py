# SPDX-License-Identifier: Apache-2.0
"""Repeating visited steps many times: samplers against densities, and returns against the upper bound."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.values import Array, Frame, State, combinations
from hypgen.dsl.interpret.floats.philox import PhiloxDraws, Stream, derive
from hypgen.dsl.interpret.interpreter import Interpreter
from hypgen.dsl.interpret.sampling.findings import Moment, Place
from hypgen.dsl.interpret.sampling.sample_model import CONFIRMING, PLAYING, WEIGHING, Progress, Visit, Walk
from hypgen.dsl.interpret.value_text import value_text
from hypgen.dsl.messages import c_sampling
from hypgen.dsl.types import Float

_FALSE_ALARM = 1e-6  # of a whole run on a correct model
_STEPS, _REPEATS, _ENTRIES = 16, 2000, 16
_BINS, _LEAST_EXPECTED = 32, 25.0
_PARTS = 16  # of what a continuous law draws
_FLOATS = 64  # so many in an interval at least, else its width is not that of the law

_STATES, _FIRST_ACTIONS, _EPISODES, _CONFIRMING = 16, 3, 128, 4096
_SIGMAS = 6.0
_FIRST_LOOK, _SECOND_LOOK = 5, 6  # streams of random words
_NEGLIGIBLE, _LONGEST = 1e-3, 300

T = TypeVar("T")
_Part = ir.Observation | ir.Assign


class _Repeated(Interpreter):
    """Lanes that repeat what some visits began, ``repeats`` lanes a visit."""

    def __init__(self, model: ir.Model, visits: Sequence[Visit], repeats: int) -> None:
        super().__init__(model, lanes=len(visits) * repeats)
        self.visits = visits
        self.repeats = repeats
        self.state = self.spread([v.state for v in visits])
        self.history = self.spread([v.history for v in visits])
        self.action = np.repeat([v.action for v in visits], repeats)

    def spread(self, values: Sequence[State]) -> State:
        """Return the lanes' arrays of one value a visit."""
        return {
            name: np.repeat(np.stack([v[name] for v in values]), self.repeats, axis=0) for name in values[0]
        }

    def frame(self, draws: PhiloxDraws) -> Frame:
        """Return the frame in which the steps' observations are evaluated."""
        after = self.spread([v.after for v in self.visits if v.after is not None])
        return self._frame(self.state, after=after, action=self.action, draws=draws)

    def draw(self, part: _Part, number: int, frame: Frame) -> Array:
        """Return each lane's draw of an entry of an observation or update."""
        with np.errstate(all="ignore"):
            word = frame.word(part.site.id, number)
            return np.broadcast_to(self._evaluator.sample(part.dist, frame, word), (self.lanes,))

    def density(self, part: _Part, frame: Frame, value: Array) -> Array:
        """Return each lane's density of a value."""
        with np.errstate(all="ignore"):
            return np.broadcast_to(self._evaluator.density(part.dist, frame, value), (self.lanes,))


# Samplers against densities ----------------------------------------------------------------------


def check_densities(walk: Walk, progress: Progress) -> None:
    """Draw what the agent sees many times in some visited steps, and test it against its density.

    A chi-square test for each step and entry, of a continuous law over intervals, its level such that all
    together cry wolf less than once in a million runs. A rejection must repeat with other draws, which makes
    up for the approximate tails.
    """
    visits = _spaced([v for v in walk.visits if v.after is not None], _STEPS)
    parts = list(_weighted(walk.model))
    if not visits or not parts:
        return
    run = _Repeated(walk.model, visits, _REPEATS)
    level = _FALSE_ALARM / (len(visits) * sum(len(entries) for _, entries in parts))
    for n, (part, entries) in enumerate(parts):
        for number, values in entries:
            if walk.is_over(WEIGHING):
                walk.cut.append(f"samplers of {n} of {len(parts)} parts were compared with densities")
                return
            _check_law(walk, run, part, number, values, level)
        progress("comparing samplers with densities", n + 1, len(parts))


def _weighted(model: ir.Model) -> Iterator[tuple[_Part, list[tuple[int, dict[str, Array]]]]]:
    """Yield what has a density that the filter uses, with some of its entries."""
    variables = {f.name: model.variable(f.name) for f in model.key if not f.observed}
    weighed = (u for u in model.updates if u.variable in variables and not variables[u.variable].copied)
    parts: list[_Part] = [*model.observations, *weighed, *model.first_seen]
    for part in parts:
        if not isinstance(part.dist, ir.Certain):
            chosen = itertools.islice(combinations(part.binders), _ENTRIES)
            yield part, [(number, values) for number, _, values in chosen]


def _check_law(
    walk: Walk, run: _Repeated, part: _Part, number: int, values: dict[str, Array], level: float
) -> None:
    key = derive(walk.seed, Stream.TEST, 4)
    lanes = np.arange(run.lanes)

    def frame_of(step: int) -> Frame:
        return run.frame(PhiloxDraws(key, lanes, step)).bind(values)

    pilot = run.draw(part, number, frame_of(0))
    cells = _Cells.of(pilot, isinstance(part.dist.type, Float), len(run.visits))
    suspects = _rejected(run, part, number, frame_of(1), cells, level)
    if not suspects:
        return
    again = _rejected(run, part, number, frame_of(2), cells, level)
    for visit in sorted(suspects.keys() & again.keys()):
        span, name = part.span, part.name if isinstance(part, ir.Observation) else part.variable
        diagnostic = c_sampling.wrong_density(name, again[visit], span)
        place = Place(span, (part.dist,), part.binders)
        walk.collected.add(diagnostic, 1, partial(_moment, run.visits[visit]), place)


@dataclass(frozen=True)
class _Cells:
    """What draws are counted in: values, and of floats intervals, a row of ends for each visit.

    ``held`` tells the visits in which a value has a probability: elsewhere the law may be continuous.
    """

    values: Array
    held: Array
    ends: Array

    @staticmethod
    def of(pilot: Array, floats: bool, visits: int) -> _Cells:
        """Return the cells for draws like these: of floats, values that repeat and parts of equal counts."""
        found, counts = np.unique(pilot, return_counts=True)
        values = found[np.argsort(-counts, kind="stable")][:_BINS]
        if not floats:
            return _Cells(values, np.ones((visits, len(values)), np.bool_), np.zeros((visits, 0)))
        rows = pilot.reshape(visits, -1)
        values, held = _points(rows, found[counts > _LEAST_EXPECTED])
        cells = _Cells(values, held, np.zeros((visits, _PARTS + 1)))
        for ends, row, own in zip(cells.ends, rows.astype(np.float64), cells._spread(rows), strict=True):
            spread = row[own & np.isfinite(row)]
            if len(spread) > _PARTS * _LEAST_EXPECTED:
                ends[:] = np.quantile(spread, np.linspace(0, 1, _PARTS + 1))
        return cells

    def _spread(self, drawn: Array) -> Array:
        """Return which draws of each visit are at no value that has a probability there."""
        own = np.ones(drawn.shape, np.bool_)
        for v, held in zip(self.values, self.held.T, strict=True):
            own &= (drawn != v) | ~held[:, None]
        return own

    def counted(self, drawn: Array) -> Array:
        """Return how many of each visit's draws are in each cell."""
        inside = [(drawn == v).sum(axis=1) * held for v, held in zip(self.values, self.held.T, strict=True)]
        own = self._spread(drawn)
        for low, high in itertools.pairwise(self.ends.T):
            inside.append((own & (drawn > low[:, None]) & (drawn < high[:, None])).sum(axis=1))
        return np.stack(inside, axis=1)

    def expected(self, density: Callable[[Array], Array], lanes: int) -> tuple[Array, Array]:
        """Return how many each cell should have by the density of each lane, and the variance of that.

        An interval is evaluated at one place for each lane of a visit, evenly spaced: lanes may differ in
        what other draws made of their law. Intervals of few floats are left out.
        """
        counts = [
            density(np.broadcast_to(v, 1)).sum(axis=1) * held
            for v, held in zip(self.values, self.held.T, strict=True)
        ]
        variances = [np.zeros(len(c)) for c in counts]
        for low, high in itertools.pairwise(self.ends.T):
            width = np.where(
                high - low > _FLOATS * np.spacing(np.abs(high).astype(np.float32)), high - low, 0.0
            )
            places = low[:, None] + width[:, None] * ((np.arange(lanes) + 0.5) / lanes)
            found = density(places.astype(np.float32).reshape(-1))
            counts.append(width * found.sum(axis=1))
            variances.append(width**2 * found.var(axis=1) * lanes)
        return np.stack(counts, axis=1), np.stack(variances, axis=1)

    def name(self, visit: int, cell: int, text: Callable[[bool | int | float], str]) -> str:
        """Return a cell in words."""
        if cell < len(self.values):
            return text(self.values[cell].item())
        low, high = self.ends[visit, cell - len(self.values) :][:2]
        return f"a value from {low:.6g} to {high:.6g}"


def _points(rows: Array, repeated: Array) -> tuple[Array, Array]:
    """Return which of the values that ``repeated`` lists have a probability in some visit, and in which.

    Far from 0 few floats lie where a law draws, so that draws of a continuum repeat as well. A value has a
    probability where it is far more frequent than the floats around it.
    """
    finite = np.where(np.isfinite(rows), rows, 0)
    width = finite.max(axis=1) - finite.min(axis=1)
    # A visit with one value shows no scale: its law may be narrower than the floats are apart.
    coarse = width < _FLOATS * _PARTS * np.spacing(np.abs(finite).max(axis=1))
    columns = []
    for v in repeated:
        count = (rows == v).sum(axis=1)
        near = (np.abs(finite - v) <= _FLOATS / 2 * np.spacing(np.abs(v))).sum(axis=1) - count
        columns.append((count > 1) & (count > 4 + 4 * near / _FLOATS) & ~coarse)
    held = np.stack(columns, axis=1) if columns else np.zeros((len(rows), 0), np.bool_)
    some = held.any(axis=0)
    return repeated[some], held[:, some]


def _rejected(
    run: _Repeated, part: _Part, number: int, frame: Frame, cells: _Cells, level: float
) -> dict[int, str]:
    """Return the visits whose draws do not follow their density, and how."""
    shape = (len(run.visits), run.repeats)
    drawn = run.draw(part, number, frame)
    impossible = (run.density(part, frame, drawn) <= 0).reshape(shape)
    observed = cells.counted(drawn.reshape(shape))
    expected, variance = cells.expected(lambda v: run.density(part, frame, v).reshape(shape), run.repeats)
    text = partial(_value, part, run)
    result: dict[int, str] = {}
    for visit in range(shape[0]):
        if impossible[visit].any():
            value = drawn.reshape(shape)[visit][np.argmax(impossible[visit])].item()
            result[visit] = f"{text(value)} was drawn, and its density is 0"
            continue
        statistic, freedom, worst = _chi_square(
            observed[visit], expected[visit], variance[visit], run.repeats
        )
        if freedom and _tail(statistic, freedom) < level:
            result[visit] = (
                f"{cells.name(visit, worst, text)} came {observed[visit][worst]} times in {run.repeats}, "
                f"{expected[visit][worst]:.1f} expected (chi-square {statistic:.0f}, {freedom} degrees of "
                "freedom)"
            )
    return result


def _value(part: _Part, run: _Repeated, value: bool | int | float) -> str:
    if isinstance(part, ir.Observation):
        return value_text(value, part.type)
    return value_text(value, run.model.variable(part.variable).type)


def _chi_square(observed: Array, expected: Array, variance: Array, total: int) -> tuple[float, int, int]:
    """Return the statistic, its degrees of freedom, and the cell that adds most to it.

    What is expected may be an estimate, whose ``variance`` then adds to that of a count.
    """
    large = expected >= _LEAST_EXPECTED
    if not large.any():
        return 0.0, 0, 0
    counts = np.append(observed[large], total - observed[large].sum()).astype(np.float64)
    wanted = np.append(expected[large], max(total - expected[large].sum(), 0.0))
    doubt = np.append(variance[large], variance[large].sum())
    if wanted[-1] < _LEAST_EXPECTED:  # too few for a cell of their own
        most = int(np.argmax(wanted))
        for cells in (counts, wanted, doubt):
            cells[most] += cells[-1]
        counts, wanted, doubt = counts[:-1], wanted[:-1], doubt[:-1]
    terms = (counts - wanted) ** 2 / (wanted + doubt)
    worst = int(np.argmax(terms[: int(large.sum())]))
    return float(terms.sum()), len(terms) - 1, int(np.flatnonzero(large)[worst])


def _tail(statistic: float, freedom: int) -> float:
    """Return the probability that chi-square is larger, by the cube root's normal approximation.

    Wilson and Hilferty, "The distribution of chi-square" (PNAS 1931).
    """
    variance = 2 / (9 * freedom)
    z = ((statistic / freedom) ** (1 / 3) - (1 - variance)) / math.sqrt(variance)
    return math.erfc(z / math.sqrt(2)) / 2


# Returns against the upper bound -----------------------------------------------------------------


def check_returns(walk: Walk, progress: Progress) -> None:
    """Play on from some visited states and test that no policy's mean return is above ``bound upper``.

    The policies: the default one, and others that begin with another legal action.
    """
    wrong_rewards = any(f.diagnostic.code == c_sampling.INFINITE_REWARD for f in walk.findings)
    if "upper" not in walk.model.spans or wrong_rewards:
        return
    visits = [v._replace(action=a) for v in _spaced(walk.visits, _STATES) for a in _first_actions(walk, v)]
    suspects = _above(walk, visits, _EPISODES, 3.0, _FIRST_LOOK, progress)
    worst = sorted(suspects, key=lambda s: s[1] - s[2], reverse=True)[:4]
    if not worst:
        return
    worst_visits = [visit for visit, _, _ in worst]
    for visit, mean, upper in _above(walk, worst_visits, _CONFIRMING, _SIGMAS, _SECOND_LOOK, progress):
        how = "the default policy" if visit.action < 0 else "one action and then the default policy"
        place = Place(walk.model.spans["upper"], (walk.model.upper,))
        diagnostic = c_sampling.low_upper_bound(upper, how, mean, walk.model.endless, place.span)
        walk.collected.add(diagnostic, 1, partial(_moment, visit), place)


def _first_actions(walk: Walk, visit: Visit) -> list[int]:
    """Return the codes of actions to begin with; -1 leaves the choice to the default policy."""
    one = _Repeated(walk.model, [visit], 1)
    legal = np.flatnonzero(one.legal_actions(one.state)[:, 0])
    return [-1, *(int(a) for a in _spaced(list(legal), _FIRST_ACTIONS))] if len(legal) else []


def _above(
    walk: Walk, visits: Sequence[Visit], episodes: int, sigmas: float, stream: int, progress: Progress
) -> list[tuple[Visit, float, float]]:
    """Return the visits whose mean return is above the bound by so many standard errors, and both."""
    if not visits:
        return []
    run = _Repeated(walk.model, visits, episodes)
    with np.errstate(all="ignore"):
        share = PLAYING if stream == _FIRST_LOOK else CONFIRMING
        returns, finished = _play(walk, run, derive(walk.seed, Stream.TEST, stream), share, progress)
    upper = run.upper(run.state).reshape(len(visits), episodes)[:, 0].astype(np.float64)
    result = []
    for visit, earned, bound, complete in zip(
        visits, returns.reshape(-1, episodes), upper, finished.reshape(-1, episodes), strict=True
    ):
        # One episode more, in which the worst that was ever seen happens: a rare loss may have been missed.
        sample = np.append(earned, earned.min() + walk.least_reward)
        error = sample.std() / math.sqrt(len(sample))
        slack = 1e-4 * (1 + abs(bound))
        if complete.all() and math.isfinite(bound) and sample.mean() - sigmas * error > bound + slack:
            result.append((visit, float(sample.mean()), float(bound)))
    return result


def _play(
    walk: Walk, run: _Repeated, key: tuple[int, int], share: float, progress: Progress
) -> tuple[Array, Array]:
    """Return each lane's discounted return, never too high, and whether nothing of it is missing.

    ``share`` of the walk's time has passed when it ends at the latest.
    """
    model, lanes = run.model, np.arange(run.lanes)
    state, history = run.state, run.history
    time = np.repeat([v.time for v in run.visits], run.repeats)
    returns = np.zeros(run.lanes)
    alive = np.ones(run.lanes, dtype=np.bool_)
    weight, t = 1.0, 0
    while alive.any() and weight > _NEGLIGIBLE and t < _LONGEST:
        if walk.is_over(share):
            walk.cut.append(f"returns were played for {t} steps")
            break
        draws = PhiloxDraws(key, lanes, t)
        action = run.default_policy(state, draws, history)
        if t == 0:
            action = np.where(run.action >= 0, run.action, action)
        alive &= action >= 0
        taken = np.maximum(action, 0)
        step = run.step(state, taken, draws)
        returns += np.where(alive, weight * step.reward.astype(np.float64) * 2.0**-model.reward_bits, 0.0)
        seen = run.observe(state, taken, draws, step.after)
        history = run.advance_history(state, taken, seen, step.after, history)
        state = step.after
        alive &= ~step.terminal
        t, weight = t + 1, weight * model.discount
        if model.horizon is not None:
            alive &= time + t < model.horizon
        progress("playing on from visited states", t, _LONGEST)
    if model.discount < 1:
        returns[alive] += weight * walk.least_reward / (1 - model.discount)
        alive[:] = False
    return returns, ~alive


def _spaced(items: Sequence[T], count: int) -> list[T]:
    """Return up to ``count`` of the items, evenly spaced."""
    if len(items) <= count:
        return list(items)
    return [items[i * len(items) // count] for i in range(count)]


def _moment(visit: Visit) -> Moment:
    def lists(values: State) -> dict[str, object]:
        return {name: value.tolist() for name, value in values.items()}

    after = None if visit.after is None else lists(visit.after)
    return Moment(lists(visit.state), after, visit.action if visit.action >= 0 else None)
