# SPDX-License-Identifier: Apache-2.0
"""Texts of W..: what is allowed and yet doubtful."""

from __future__ import annotations

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span


def never_used(name: str, kind: str, is_value: bool, span: Span) -> Diagnostic:
    """A declaration that nothing needs: a value that is never read, or a type or function never used."""
    message = f"'{name}' is {kind} that nothing {'reads' if is_value else 'uses'}"
    return Diagnostic("W01", message, span, "remove it, or use it where it was meant to matter")


def float_equality(span: Span) -> Diagnostic:
    """A comparison of two floats for equality."""
    message = "floats are tested for equality, which rounding decides"
    return Diagnostic("W02", message, span, "compare with a tolerance, abs(a - b) < 0.001")


def shown_draw(observation: str, draw: str, span: Span, drawn: Span) -> Diagnostic:
    """An observation that tells exactly what was drawn."""
    return Diagnostic(
        "W03",
        f"'{observation}' shows the draw '{draw}' as it is, so that the particle "
        "filter must drop all that drew something else",
        span,
        "draw in the observation itself, or observe the draw with noisy(.., p)",
        ((drawn, f"'{draw}' is drawn here"),),
    )


def illegal_choice(action: str, span: Span | None) -> Diagnostic:
    """A default policy that chooses an action that is not legal; sampling finds it."""
    message = f"the default policy chooses an illegal action, {action}"
    remedy = "choose a legal one; the solver takes the first legal action instead"
    return Diagnostic("W04", message, span, remedy)


def idle_reward(reward: str, span: Span) -> Diagnostic:
    """A reward that every policy earns alike."""
    return Diagnostic(
        "W05",
        f"'{reward}' is the same whatever is done, and nothing ends an episode early",
        span,
        "let it depend on the state or the action, or end episodes with `terminal when`",
    )


def nothing_to_earn(span: Span) -> Diagnostic:
    """A model without any reward."""
    message = "the model has no reward, so that all policies are worth the same"
    return Diagnostic("W11", message, span, "add what is to be reached or avoided: reward name = ..")


def rounded_probability(number: str, nearest: str, span: Span) -> Diagnostic:
    """A probability of which rounding loses what it says of a rare outcome."""
    return Diagnostic(
        "W06",
        f"{number} is kept as {nearest}, so that what is rare here never comes or always",
        span,
        "keep the probability p of the rare outcome, and write 1 - p; or write the number in the draw itself"
        if nearest == "1"
        else "probabilities are kept from 1e-16 up",
    )


def state_before(observation: str, variable: str, span: Span) -> Diagnostic:
    """An observation of the state that the step has left."""
    return Diagnostic(
        "W07",
        f"'{observation}' shows the state before the step: it reads '{variable}', which the step changes",
        span,
        f"an observation comes after the step: write {variable}' for the value that the step gives",
    )


def endless_bound(bound: str, why: str, span: Span) -> Diagnostic:
    """A bound that is infinite or no number."""
    return Diagnostic("W08", f"bound {bound} is no finite number: {why}", span, "give a finite number")


def reward_without_value(reward: str, why: str, span: Span) -> Diagnostic:
    """A reward with a part that is infinite or no number, as params are."""
    message = f"reward '{reward}' is no finite number with the defaults of params: {why}"
    return Diagnostic("W08", message, span, "give the param another default, or guard what it is in")


def never_paid(reward: str, steps: int, span: Span) -> Diagnostic:
    """A reward that sampling never saw paid."""
    return Diagnostic(
        "W09",
        f"reward '{reward}' was 0 in every one of {steps:,} sampled steps",
        span,
        "does it read x, before the step, where x' is meant? If it is only rare, take more samples",
    )


def zero_divisor(operator: str, span: Span | None) -> Diagnostic:
    """A division of ints by 0, which sampling finds."""
    message = f"the divisor of '{operator}' is 0, and so the result is 0"
    return Diagnostic("W10", message, span, "guard it: if d == 0 then .. else .., or divide by max(d, 1)")
