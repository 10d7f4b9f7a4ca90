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
