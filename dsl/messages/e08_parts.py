# SPDX-License-Identifier: Apache-2.0
"""Texts of E08xx: parts of a model that are missing, too many or not constant, and settings of them."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.dsl.messages.diagnostic import Diagnostic, did_you_mean
from hypgen.dsl.messages.source import Span

NOT_CONSTANT = "E0810"


def no_action(span: Span) -> Diagnostic:
    """A model without an action."""
    return Diagnostic("E0801", "the model has no action", span, "add a line: action act: Act")


def second_action(span: Span, first: Span) -> Diagnostic:
    """A model with two actions."""
    return Diagnostic(
        "E0802",
        "the model has a second action",
        span,
        "there is one: join the two in a record, or in an array if they are alike",
        ((first, "the first action is here"),),
    )


def no_discount(span: Span) -> Diagnostic:
    """A model without a discount."""
    return Diagnostic("E0803", "the model has no discount", span, "add a line: discount 0.95")


def wrong_discount(discount: float, span: Span) -> Diagnostic:
    """A discount outside 0 < discount <= 1."""
    message = f"the discount is {discount:g}"
    return Diagnostic("E0804", message, span, "it lies in 0 < discount <= 1")


def wrong_horizon(horizon: int, span: Span) -> Diagnostic:
    """A horizon below 1."""
    return Diagnostic("E0804", f"the horizon is {horizon}", span, "it is a number of steps, 1 or more")


def infinite_return(discount: Span) -> Diagnostic:
    """A model whose return no reward limits: ``discount`` is the place of a discount of 1."""
    return Diagnostic(
        "E0804",
        "with a discount of 1 and no horizon a return may be infinite, so that no bound can be derived",
        discount,
        "add a line: horizon 100, or a discount less than 1, or declare both bound upper and bound tail",
    )


def unknown_bound(name: str, known: Sequence[str], span: Span) -> Diagnostic:
    """A bound with another name than those that there are."""
    remedy = did_you_mean(name, known) or "bounds are upper, lower and tail"
    return Diagnostic("E0805", f"there is no bound '{name}'", span, remedy)


def unknown_policy(name: str, span: Span) -> Diagnostic:
    """A policy that is not called ``default``."""
    remedy = did_you_mean(name, ["default"]) or "the one policy is called default"
    return Diagnostic("E0805", f"there is no policy '{name}'", span, remedy)


def large_observation(most_bits: int, largest: str, span: Span) -> Diagnostic:
    """Observations of more bits than are kept for a step; ``largest`` is the one with the most."""
    return Diagnostic(
        "E0806",
        f"what the agent sees in a step takes more than {most_bits} bits",
        span,
        f"make observations smaller, '{largest}' first: coarser types, or fewer of them",
    )


def same_draw_id(name: str, other: str, span: Span) -> Diagnostic:
    """Two draws whose names hash to one id, so that they would share their random numbers."""
    message = f"the draws '{other}' and '{name}' happen to have the same id"
    return Diagnostic("E0807", message, span, "rename one of the two")


def unknown_setting(name: str, known: Sequence[str], span: Span) -> Diagnostic:
    """A setting of a name that the model does not declare; ``known`` are its consts and params."""
    listed = f"it has {', '.join(known)}" if known else "remove this setting"
    message = f"the model has no const or param '{name}'"
    return Diagnostic("E0808", message, span, did_you_mean(name, known) or listed)


def setting_of_other(name: str, kind: str, span: Span, declared: Span) -> Diagnostic:
    """A setting of another ``kind`` of declaration (``a type``)."""
    return Diagnostic(
        "E0809",
        f"'{name}' is {kind}, which cannot be set",
        span,
        "settings are for consts and params",
        ((declared, f"'{name}' is declared here"),),
    )


def not_constant(what: str, span: Span) -> Diagnostic:
    """A value that must be known when the model is compiled, and is not."""
    message = f"{what} is not known when the model is compiled"
    return Diagnostic(NOT_CONSTANT, message, span, "use literals, consts and functions of them only")


def end_of_draw_not_constant(span: Span) -> Diagnostic:
    """An end of ``truncated`` or ``clamp`` of a draw that is not constant."""
    return Diagnostic(NOT_CONSTANT, "this end must be a constant", span, "use literals and consts")


def end_of_range_not_constant(span: Span) -> Diagnostic:
    """An end of a range type that is no constant int."""
    message = "the end of a range must be a constant int"
    return Diagnostic(NOT_CONSTANT, message, span, "use literals and consts of type int only")


def ends_not_constant(function: str, span: Span) -> Diagnostic:
    """``wrap`` or ``checked`` with ends that are not constant."""
    remedy = "use literals and consts; clamp takes ends that vary"
    return Diagnostic(NOT_CONSTANT, f"the ends of {function} must be constants", span, remedy)


def false_invariant(span: Span) -> Diagnostic:
    """An invariant that no state fulfils."""
    remedy = "state what is true of every state, such as total == n"
    return Diagnostic("E0811", "this invariant never holds", span, remedy)


def not_enumerable(name: str, span: Span) -> Diagnostic:
    """A continuous draw in a model whose outcomes are to be tried one by one."""
    return Diagnostic(
        "E0812",
        f"'{name}' is drawn from a continuous law: it has too many values to try them all",
        span,
        "an exact solution needs draws of finitely many values, such as `binned(D, low, high)`; "
        "`hypgen run` plans with any",
    )
