# SPDX-License-Identifier: Apache-2.0
"""What stands in lanes for the types and functions that generated code uses."""

from __future__ import annotations

from hypgen.codegen.tree.expr import Call, Expr, Literal, Operand, of

MASK = "Mask"

# Types of one name in both texts.
STRUCTS = ("Params", "Fixed", "State", "History", "Joint")

_SCALARS = ("std::int32_t", "int", "bool", "float", "double", "Key", "Real", "std::uint32_t", "std::uint64_t")

# Classes of the runtime with a form in lanes.
CLASSES = {
    "dist::Masses": "dist::MassesLanes",
    "dist::Normal": "dist::NormalLanes",
    "dist::RecurringNormal": "dist::NormalLanes",
    "dist::Uniform": "dist::UniformLanes",
    "dist::Exponential": "dist::ExponentialLanes",
    "dist::Bins": "dist::BinsLanes",
}

# Functions of the runtime with a form in lanes, and whether they change anything.
RUNTIME = {
    **dict.fromkeys(
        (
            *("math::min", "math::max", "math::clamp", "math::sign", "math::abs", "math::is_nan"),
            *("math::from_zero", "math::floordiv", "math::mod"),
            *("math::floor_to_int", "math::ceil_to_int", "math::round_to_int", "math::to_fixed"),
            "math::saturate_fixed",
            *("math::sqrt", "math::log", "math::log2", "math::exp", "math::exp2", "math::hypot"),
            *("math::sin", "math::cos", "math::tan", "math::asin", "math::acos", "math::atan2"),
            *("math::pow", "math::normal_cdf"),
            *("dist::bernoulli", "dist::uniform", "dist::uniform_int", "dist::reached", "dist::fine"),
            *("dist::poisson", "dist::binomial", "dist::noisy", "dist::mass", "dist::up_to"),
            *("math::threshold", "math::mass"),
            "posteriors::probability",
        ),
        False,
    ),
    "posteriors::normalise": True,
}


class NoLanes(Exception):
    """A model has no lanes; the text says why."""


def lane_type(kind: str) -> str | None:
    """Return the type of values of all lanes; None for what is no number."""
    plain = kind.removeprefix("const ")
    if plain not in _SCALARS:
        return None
    return f"lanes::Lanes<{'std::int32_t' if plain == 'int' else plain}>"


def lanes_of(result: str) -> str:
    """Return the type of a function's result in lanes."""
    if result == "StepResult":
        return "lanes::StepLanes"
    found = lane_type(result)
    if found is None:
        raise NoLanes(f"a function returns a {result}")
    return found


def on_lanes(function: str, *arguments: Operand) -> Expr:
    """Return the call of a function for lanes."""
    return Call(Literal(f"lanes::{function}"), tuple(map(of, arguments)))
