# SPDX-License-Identifier: Apache-2.0
"""Parameters of the node: the model's params, and the settings of its planner."""

from __future__ import annotations

import json
from collections.abc import Iterator

from hypgen.codegen.cpp.text import float32
from hypgen.codegen.ros2.messages import described
from hypgen.codegen.ros2.package_data import Parameter
from hypgen.codegen.tree.expr import Expr, Literal, braces, call, of
from hypgen.codegen.tree.lines import statements
from hypgen.codegen.tree.statements import Do
from hypgen.dsl import ir
from hypgen.dsl.types import Bool, Enum, Float, Int, Record, Type, low_of, size_of

# Names of settings, and what each is. A library of a model refuses all others.
SETTINGS = {
    "mode": "how to plan: despot, parallel, gpu, hyp, pomcp, rollout, default",
    "time": "seconds to plan; no limit if trials is given without it",
    "period": "seconds of an update and the plan after it, in place of time",
    "trials": "most trials of a plan",
    "threads": "threads of the modes parallel, hyp and pomcp",
    "in-flight": "trials at a time",
    "observation-loss": "how far trials in flight keep apart",
    "exploration": "how far trials prefer actions that few trials took",
    "device": "where leaves are expanded: auto, cpu, cuda, cuda:N",
    "require-gpu": "true: no planner without a GPU",
    "scenarios": "most scenarios of a search",
    "rollouts": "actions of a leaf that are rolled out",
    "depth": "depth of the tree and the rollouts",
    "xi": "gap that a trial aims at, relative to the root's",
    "pruning": "what a node of the tree must be worth: a number, or auto",
    "belief": "how the belief is kept: auto, factored, particle",
    "particles": "particles of the belief",
    "memory": "MiB of a search",
    "device-memory": "MiB on the GPU",
    "seed": "of everything random",
    "settings": "a file of settings, as hypgen tune writes it",
}


def settings() -> Iterator[Parameter]:
    """Yield the planner's settings."""
    for name, text in SETTINGS.items():
        yield Parameter(f"planner.{name.replace('-', '_')}", name, text)


def params(model: ir.Model) -> Iterator[Parameter]:
    """Yield the model's params."""
    for param in model.params:
        text = described(param.name, param.type, param.indices)
        yield Parameter(f"model.{param.name}", param.name, text)


def declarations(model: ir.Model) -> Iterator[str]:
    """Yield lines of C++ that declare the params with the model's own values, or as not set."""
    for number, param in enumerate(model.params):
        yield from statements([Do(call("declare", "node", of("kParams")[number], _value(param)))])


def _value(param: ir.Param) -> Expr:
    if param.default is None:
        return braces("rclcpp::ParameterValue")
    cpp, entries = _entries(param)
    literals = [*map(Literal, entries)]
    values = braces(f"std::vector<{cpp}>", *literals) if param.indices else call(cpp, literals[0])
    return call("rclcpp::ParameterValue", values)


def _entries(param: ir.Param) -> tuple[str, list[str]]:
    """Return the type of a param's entries in C++, and C++ of each."""
    values = param.default or ()
    match param.type:
        case Bool():
            return "bool", ["true" if v else "false" for v in values]
        case Int():
            return "std::int64_t", [str(int(v)) for v in values]
        case Float():
            return "double", [float32(v).removesuffix("f") for v in values]
    return "std::string", [json.dumps(value_name(param.type, int(v))) for v in values]


def value_name(type_: Type, value: int) -> str:
    """Return the name of a finite value, as the library reads it."""
    match type_:
        case Bool():
            return "true" if value else "false"
        case Enum():
            variant = [v for v in type_.variants if type_.offsets[v.name] <= value][-1]
            if variant.argument is None:
                return variant.name
            argument = value - type_.offsets[variant.name] + low_of(variant.argument)
            return f"{variant.name}({value_name(variant.argument, argument)})"
        case Record():
            parts = [
                value_name(t, value // type_.stride(f) % size_of(t) + low_of(t)) for f, t in type_.fields
            ]
            return f"{type_.name}({', '.join(parts)})"
    return str(value)
