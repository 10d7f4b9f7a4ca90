# SPDX-License-Identifier: Apache-2.0
"""Texts of C....: what sampling finds in a run of the model.

C01xx are about values, C02xx about bounds, C03xx about states, C04xx about laws and C05xx about beliefs.
A finding tells what is wrong in one sampled moment; its numbers are those of that moment.
"""

from __future__ import annotations

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span

INFINITE_REWARD = "C0104"


def wrong_probability(value: float, span: Span | None) -> Diagnostic:
    """A probability outside 0 .. 1."""
    message = f"a probability of {value:.6g}, outside 0..1"
    return Diagnostic("C0101", message, span, "change the formula, or limit it with clamp(.., 0, 1)")


def wrong_sum(total: float, span: Span | None) -> Diagnostic:
    """A table whose probabilities do not sum to 1."""
    message = f"the probabilities of a table sum to {total:.6g}"
    return Diagnostic("C0102", message, span, "make them sum to 1; `else value` takes what is left")


def extreme_of_nothing(quantifier: str, span: Span | None) -> Diagnostic:
    """``min``, ``argmax`` and the like of nothing."""
    message = f"nothing fulfils the condition of this '{quantifier}'"
    return Diagnostic(
        "C0103", message, span, "say what it is then: add `else value`, or change the condition"
    )


def draw_from_nothing(span: Span | None) -> Diagnostic:
    """``uniform`` over a set without members."""
    message = "nothing fulfils the condition of this 'uniform': there is no value to draw"
    remedy = "say what to draw then: add `else draw`, or change the condition"
    return Diagnostic("C0103", message, span, remedy)


def only_zero_weights(span: Span | None) -> Diagnostic:
    """``weighted`` whose weights are all 0."""
    message = "no weight of this 'weighted' is above 0: there is no value to draw"
    remedy = "say what to draw then: add `else draw`, or change the weights"
    return Diagnostic("C0103", message, span, remedy)


def infinite_reward(name: str, value: float, span: Span | None) -> Diagnostic:
    """A reward that is no number, or too large to be summed exactly enough."""
    return Diagnostic(
        INFINITE_REWARD,
        f"the reward '{name}' is {value:.6g}, not a number up to 16,777,216",
        span,
        "look for a division by 0 or a logarithm in it, or limit it with clamp(.., low, high)",
    )


def infinite_variable(name: str, value: str, span: Span | None) -> Diagnostic:
    """A float variable that becomes infinite or no number."""
    remedy = "keep what it is computed from in range: a divisor from 0, a root or logarithm above 0"
    return Diagnostic("C0105", f"'{name}' becomes {value}", span, remedy)


def wrong_parameter(what: str, value: float, remedy: str, span: Span | None) -> Diagnostic:
    """A parameter of a draw that its law does not allow."""
    return Diagnostic("C0106", f"{what} is {value:.6g}", span, remedy)


def outside_checked(value: float, low: float, high: float, span: Span | None) -> Diagnostic:
    """``checked`` of a value outside its ends."""
    message = f"a 'checked' value is {value:.6g}, outside {low} .. {high}"
    remedy = "correct what it is computed from; solvers go on with the nearest end"
    return Diagnostic("C0107", message, span, remedy)


def infinite_bound(name: str, value: float, span: Span | None) -> Diagnostic:
    """A bound that is infinite or no number."""
    remedy = "a bound is a finite number: look for a division by 0 or a logarithm in it"
    return Diagnostic("C0201", f"bound {name} is {value:.6g}", span, remedy)


def crossed_bounds(lower: float, upper: float, span: Span | None) -> Diagnostic:
    """A lower bound above the upper one."""
    message = f"bound lower is {lower:.6g}, above bound upper, {upper:.6g}"
    return Diagnostic("C0202", message, span, "correct one of the two: no value lies between them")


_ENDLESS = "; or end the episode where nothing more is earned or lost: terminal when .."


def low_upper_bound(upper: float, policy: str, mean: float, endless: bool, span: Span | None) -> Diagnostic:
    """An upper bound below what a policy, in words, earns in the mean; ``endless``: nothing ends episodes."""
    message = f"bound upper is {upper:.6g}, and {policy} earns {mean:.6g} from here in the mean"
    remedy = f"raise the bound: it must hold in each state for whatever the agent does{_ENDLESS * endless}"
    return Diagnostic("C0203", message, span, remedy)


def violated_bound(name: str, violations: int, beliefs: int, endless: bool, span: Span | None) -> Diagnostic:
    """A bound on the wrong side of what is earned; without a span it is one that hypgen derives.

    ``endless``: nothing ends episodes.
    """
    side = "below" if name == "upper" else "above"
    message = (
        f"bound {name} is {side} what the default policy earns, at {violations:,} of {beliefs:,} beliefs"
    )
    if span is None:
        remedy = "hypgen derives this bound, so this is a bug of hypgen: please report it with the model"
    else:
        remedy = f"{'raise' if name == 'upper' else 'lower'} the bound: it must hold in each state"
        remedy += _ENDLESS * endless
    return Diagnostic("C0204", message, span, remedy)


def no_legal_action(span: Span | None) -> Diagnostic:
    """A state in which no action is legal."""
    message = "no action is legal in a state that can be reached"
    remedy = "let some action be legal in every state, or end the episode there (`terminal when`)"
    return Diagnostic("C0301", message, span, remedy)


def broken_invariant(span: Span | None) -> Diagnostic:
    """A state in which an invariant does not hold."""
    message = "an invariant does not hold in a state that can be reached"
    remedy = "correct the updates or inits that lead there, or the invariant"
    return Diagnostic("C0303", message, span, remedy)


def wrong_density(name: str, how: str, span: Span | None) -> Diagnostic:
    """A sampler whose draws do not have the density that filters use: a mistake of hypgen's own."""
    message = f"'{name}' is not drawn as its density says: {how}"
    return Diagnostic("C0401", message, span, "this is a bug of hypgen: please report it with the model")


def wrong_belief(name: str, shape: str, p: float, remedy: str, span: Span | None) -> Diagnostic:
    """A belief in which the ranks of the true value are not uniform; ``shape`` as of ``Ranks``."""
    how = {
        "sure": "is too sure: the true value lies at its ends too often",
        "wide": "is too wide: the true value lies in its middle too often",
        "low": "is too low: the true value lies in its upper half too often",
        "high": "is too high: the true value lies in its lower half too often",
        "uneven": "is wrong: the true value has some ranks in it too often",
    }
    message = f"the belief of '{name}' {how[shape]} (p {'< 1e-15' if p < 1e-15 else f'= {p:.1g}'})"
    return Diagnostic("C0501", message, span, remedy)
