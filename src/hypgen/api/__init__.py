# SPDX-License-Identifier: Apache-2.0
"""Models, solvers and planners for programs in Python; the package ``hypgen`` offers these names itself."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hypgen.api.c_interface import PlannerError
    from hypgen.api.comparing import compare
    from hypgen.api.model import Model, load
    from hypgen.api.planner import Decision, Moments, Planner
    from hypgen.api.simulation import EpisodeRecord, Observation, StepRecord
    from hypgen.api.solver import Solver
    from hypgen.api.solving import Solution, solve
    from hypgen.api.worlds import Worlds
    from hypgen.dsl.messages.diagnostic import ModelError
    from hypgen.play.played_programs import Comparison

# Where each name is. It is imported when it is used: a robot that has a compiled library alone plans by it
# without the compiler's own dependencies.
_MODULES = {
    "Comparison": "hypgen.play.played_programs",
    "ModelError": "hypgen.dsl.messages.diagnostic",
    "PlannerError": "hypgen.api.c_interface",
    "compare": "hypgen.api.comparing",
    "Model": "hypgen.api.model",
    "load": "hypgen.api.model",
    "Decision": "hypgen.api.planner",
    "Moments": "hypgen.api.planner",
    "Planner": "hypgen.api.planner",
    "EpisodeRecord": "hypgen.api.simulation",
    "Observation": "hypgen.api.simulation",
    "StepRecord": "hypgen.api.simulation",
    "Solver": "hypgen.api.solver",
    "Solution": "hypgen.api.solving",
    "solve": "hypgen.api.solving",
    "Worlds": "hypgen.api.worlds",
}

__all__ = [
    "Comparison",
    "Decision",
    "EpisodeRecord",
    "Model",
    "ModelError",
    "Moments",
    "Observation",
    "Planner",
    "PlannerError",
    "Solution",
    "Solver",
    "StepRecord",
    "Worlds",
    "compare",
    "load",
    "solve",
]


def __getattr__(name: str) -> Any:
    """Return a name of one of the modules."""
    if name in _MODULES:
        return getattr(import_module(_MODULES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
