# SPDX-License-Identifier: Apache-2.0
"""Models, solvers and planners for programs in Python; the package ``hypgen`` offers these names itself."""

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
