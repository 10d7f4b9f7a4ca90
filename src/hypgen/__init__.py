# SPDX-License-Identifier: Apache-2.0
"""hypgen compiles declarative POMDP models into native online planners."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hypgen.api import (
        Comparison,
        Decision,
        EpisodeRecord,
        Model,
        ModelError,
        Moments,
        Observation,
        Planner,
        PlannerError,
        Solution,
        Solver,
        StepRecord,
        Worlds,
        compare,
        load,
        solve,
    )
    from hypgen.experiments import bench, report
    from hypgen.tuning import tune

__version__ = "0.2.0"
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
    "bench",
    "compare",
    "load",
    "report",
    "solve",
    "tune",
]


def __getattr__(name: str) -> Any:
    """Return a name of another package, imported where it is used: the command line starts sooner."""
    if name in ("bench", "report"):
        from hypgen import experiments

        return getattr(experiments, name)
    if name == "tune":
        from hypgen import tuning

        return tuning.tune
    if name in __all__:
        from hypgen import api

        return getattr(api, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
