# SPDX-License-Identifier: Apache-2.0
"""An evaluation that watches itself: what goes wrong in which lanes, and where in the model.

Types exclude integers out of range and indexes out of bounds. What is left to find is in floats
(probabilities, weights, NaN) and in sets that turn out to be empty.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from hypgen.dsl import ir
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Array, Frame, Word, combinations
from hypgen.dsl.interpret.sampling.findings import Findings, Moment, Place
from hypgen.dsl.ir import operators
from hypgen.dsl.messages import c_sampling, w_warnings
from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span

_DIVISIONS = {"floordiv": "//", "mod": "%"}
_ROUNDING = 1e-6  # by which a probability computed in float32 may miss 0 or 1


class Watch(Evaluator):
    """Evaluates, and adds to ``findings`` what goes wrong where it matters.

    ``active`` are the lanes that count; ``place`` is the declaration that is evaluated.
    """

    def __init__(self, model: ir.Model, params: Mapping[str, Sequence[Any]], findings: Findings) -> None:
        super().__init__(model, params)
        self.active: Array = np.asarray(np.True_)
        self.place = Place(None)
        self._findings = findings
        self._conditions: list[Array] = []

    @contextmanager
    def at(self, place: Place) -> Iterator[None]:
        """Say where in the model what is evaluated meanwhile stands."""
        outer, self.place = self.place, place
        try:
            yield
        finally:
            self.place = outer

    @contextmanager
    def only(self, active: Array) -> Iterator[None]:
        """Let only these lanes count meanwhile."""
        outer, self.active = self.active, active
        try:
            yield
        finally:
            self.active = outer

    def note(
        self,
        finding: Callable[[int, Span | None], Diagnostic],
        bad: npt.NDArray[np.bool_] | np.bool_,
        frame: Frame,
        part: ir.Expr | ir.Dist | None = None,
    ) -> None:
        """Add a finding if any lane that counts is bad; ``finding`` takes the first such lane, and the place.

        That is the place of ``part``, as far as that says where it stands, or else of the declaration.
        """
        if not np.any(bad):
            return
        lanes = len(frame.lanes)
        wrong = bad & np.broadcast_to(self.active, lanes)
        for condition in self._conditions:
            wrong = wrong & condition
        # Where legality is asked for, actions are a further axis before the lanes.
        wrong = wrong.reshape(-1, lanes).any(axis=0)
        if not wrong.any():
            return
        lane = int(np.argmax(wrong))
        own, declared = None if part is None else part.span, self.place.span
        outside = own is not None and declared is not None and not declared.contains(own)
        notes = ((declared, "it is drawn from here"),) if outside and declared is not None else ()
        diagnostic = replace(finding(lane, own or declared), notes=notes)
        self._findings.add(diagnostic, int(wrong.sum()), lambda: moment_of(frame, lane), self.place)

    def where(self, condition: Array, evaluate: Callable[[], Array]) -> Array:
        """Return what ``evaluate`` gives, watching the lanes in which the condition holds."""
        self._conditions.append(condition)
        try:
            return evaluate()
        finally:
            self._conditions.pop()

    # Places ----------------------------------------------------------------------------------

    def _call(self, e: ir.Call, frame: Frame) -> Array:
        function = self._functions[e.function]
        with self.at(Place(function.span, (function.body,), function.formals)):
            return super()._call(e, frame)

    def _let_read(self, e: ir.LetRead, frame: Frame) -> Array:
        let = self._lets[e.let]
        with self.at(Place(let.span, (let.dist,), () if let.binder is None else (let.binder,))):
            return super()._let_read(e, frame)

    # What can go wrong -----------------------------------------------------------------------

    def _clamp(self, e: ir.Clamp, frame: Frame) -> Array:
        result = super()._clamp(e, frame)
        if isinstance(e, ir.Checked):
            operand = self.value(e.operand, frame)
            self.note(
                lambda lane, span: c_sampling.outside_checked(_at(operand, lane), e.low, e.high, span),
                result != operand,
                frame,
                e,
            )
        return result

    def _binary(self, e: ir.Binary, frame: Frame) -> Array:
        if e.op in _DIVISIONS and operators.ends(e.right.type)[0] <= 0 <= operators.ends(e.right.type)[1]:
            self.note(
                lambda _, span: w_warnings.zero_divisor(_DIVISIONS[e.op], span),
                self.value(e.right, frame) == 0,
                frame,
                e,
            )
        return super()._binary(e, frame)

    def _extremum(self, e: ir.Quantified, frame: Frame) -> Array:
        if e.otherwise is None and e.condition is not None:
            holds = [self.holds(e.condition, frame.bind(values)) for _, _, values in combinations(e.binders)]
            empty = ~np.logical_or.reduce(np.broadcast_arrays(*holds))
            self.note(
                lambda _, span: c_sampling.extreme_of_nothing(e.kind, span),
                empty,
                frame,
                e,
            )
        return super()._extremum(e, frame)

    def sample(self, dist: ir.Dist, frame: Frame, word: Word) -> Array:
        """Return a draw from the distribution in each lane, having checked its parameters."""
        match dist:
            case ir.Bernoulli():
                self._check_probability(dist.probability, frame)
            case ir.Noisy():
                self._check_probability(dist.probability, frame)
            case ir.Table():
                self._check_table(dist, frame)
            case ir.UniformSet(otherwise=None):
                self._check_set(dist, frame)
            case ir.Binomial():
                self._check_probability(dist.probability, frame)
            case ir.Weighted():
                self._check_weights(dist, frame)
            case ir.UniformInt() | ir.Poisson() | ir.Continuous() | ir.Binned():
                self._check_law(dist, frame)
        return super().sample(dist, frame, word)

    def _check_probability(self, e: ir.Expr, frame: Frame) -> None:
        value = self.value(e, frame).astype(np.float64)
        self.note(
            lambda lane, span: c_sampling.wrong_probability(_at(value, lane), span),
            ~((value >= -_ROUNDING) & (value <= 1 + _ROUNDING)),
            frame,
            e,
        )

    def _check_table(self, dist: ir.Table, frame: Frame) -> None:
        total: Array = np.zeros(())
        possible: Array = np.ones((), dtype=np.bool_)
        for _, weight in dist.entries:
            self._check_probability(weight, frame)
            value = self.value(weight, frame).astype(np.float64)
            total, possible = total + value, possible & (value >= -_ROUNDING) & (value <= 1 + _ROUNDING)
        slack = _ROUNDING * len(dist.entries)
        too_much = possible & (total > 1 + slack)  # what is no probability has been told already
        self.note(
            lambda lane, span: c_sampling.wrong_sum(_at(total, lane), span),
            too_much if dist.rest is not None else too_much | possible & (total < 1 - slack),
            frame,
            dist,
        )

    def _check_set(self, dist: ir.UniformSet, frame: Frame) -> None:
        if dist.condition is None:
            return
        holds = [
            self.holds(dist.condition, frame.bind(values)) for _, _, values in combinations(dist.binders)
        ]
        self.note(
            lambda _, span: c_sampling.draw_from_nothing(span),
            ~np.logical_or.reduce(np.broadcast_arrays(*holds)),
            frame,
            dist,
        )

    def _check_weights(self, dist: ir.Weighted, frame: Frame) -> None:
        some: Array = np.zeros((), dtype=np.bool_)
        for _, _, values in combinations(dist.binders):
            inner = frame.bind(values)
            holds, weight = self.holds(dist.condition, inner), self.value(dist.weight, inner)
            negative = holds & ~(weight >= 0.0)
            self._check_parameter("a weight", weight, negative, "give weights from 0 up", inner, dist.weight)
            some = some | (holds & (weight > 0.0))
        if dist.otherwise is None:
            self.note(
                lambda _, span: c_sampling.only_zero_weights(span),
                ~some,
                frame,
                dist,
            )

    def _check_law(self, dist: ir.Dist, frame: Frame) -> None:
        match dist:
            case ir.Poisson(mean=mean):
                value = self.value(mean, frame)
                wrong = ~((value >= 0.0) & (value <= 690.0))
                what, remedy = "the mean of a poisson draw", "keep it in 0..690"
                self._check_parameter(what, value, wrong, remedy, frame, mean)
            case ir.Normal(deviation=scale) | ir.Exponential(mean=scale):
                value = self.value(scale, frame)
                what = (
                    "a standard deviation"
                    if isinstance(dist, ir.Normal)
                    else "the mean of an exponential draw"
                )
                self._check_parameter(what, value, ~(value > 0.0), "keep it above 0", frame, scale)
            case ir.UniformInt() | ir.UniformFloat() | ir.Truncated() | ir.Binned():
                low, high = self.value(dist.low, frame), self.value(dist.high, frame)
                wrong = ~(low <= high) if isinstance(dist, ir.UniformInt | ir.UniformFloat) else ~(low < high)
                remedy = "keep it above the lower end"
                self._check_parameter("the upper end of a draw", high, wrong, remedy, frame, dist)
        if isinstance(dist, ir.Truncated | ir.Clamped | ir.Binned):
            self._check_law(dist.law, frame)

    def _check_parameter(
        self, what: str, value: Array, wrong: Array, remedy: str, frame: Frame, part: ir.Expr | ir.Dist
    ) -> None:
        self.note(
            lambda lane, span: c_sampling.wrong_parameter(what, _at(value, lane), remedy, span),
            wrong,
            frame,
            part,
        )

    # Branches of distributions ---------------------------------------------------------------

    def _choose(self, dist: ir.IfDist, frame: Frame, evaluate: Callable[[ir.Dist], Array]) -> Array:
        condition = self.value(dist.condition, frame)
        if condition.ndim == 0:
            return evaluate(dist.then if condition else dist.otherwise)
        then = self.where(condition, lambda: evaluate(dist.then))
        otherwise = self.where(~condition, lambda: evaluate(dist.otherwise))
        return np.where(condition, then, otherwise)


def _at(value: Array, lane: int) -> float:
    flat = np.asarray(value)
    return float(flat if flat.ndim == 0 else flat[..., lane].flat[0])


def moment_of(frame: Frame, lane: int) -> Moment:
    """Return one lane of what is evaluated."""

    def pick(value: Array) -> Any:
        return (value if np.ndim(value) == 0 else value[..., lane].flat[0]).item()

    after = None if frame.after is None else {n: v[lane].tolist() for n, v in frame.after.items()}
    action = None if frame.action is None else pick(frame.action)
    values = {name: pick(value) for name, value in frame.locals.items()}
    return Moment({n: v[lane].tolist() for n, v in frame.state.items()}, after, action, values)
