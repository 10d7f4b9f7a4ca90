# SPDX-License-Identifier: Apache-2.0
"""Models, solvers and planners for programs in Python; the package ``hypgen`` offers these names itself."""

from hypgen.api.c_interface import PlannerError
from hypgen.api.model import Model, load
from hypgen.api.planner import Decision, Moments, Planner
from hypgen.api.solver import Solver
from hypgen.dsl.messages.diagnostic import ModelError

__all__ = ["Decision", "Model", "ModelError", "Moments", "Planner", "PlannerError", "Solver", "load"]
