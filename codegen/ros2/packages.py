# SPDX-License-Identifier: Apache-2.0
"""IR -> what the templates of both packages lay out."""

from __future__ import annotations

from hypgen.codegen.layout.naming import file_stem
from hypgen.codegen.model.value_fields import drawn_at_start
from hypgen.codegen.ros2.messages import Messages
from hypgen.codegen.ros2.package_data import Packages
from hypgen.codegen.ros2.parameters import declarations, params, settings
from hypgen.codegen.ros2.ros_names import package_stem
from hypgen.dsl import ir

# The statuses of hypgen.h.
STATUSES = {
    "OK": 0,
    "CONVERGED": 1,
    "TRIAL_LIMIT": 2,
    "DEADLINE": 3,
    "DEADLINE_DEFAULT": 4,
    "MEMORY_FULL": 5,
    "GPU_LOST": 6,
    "MODEL_NAN": 7,
    "BOUNDS_CROSSED": 8,
    "EVALUATOR_FAILED": 9,
    "BELIEF_DEPLETED": 20,
    "IMPOSSIBLE_OBSERVATION": 21,
    "ALL_PARTICLES_TERMINAL": 22,
    "FAILED": 100,
    "WRONG_ARGUMENT": 100,
    "NO_LEGAL_ACTION": 101,
    "NO_GPU": 102,
    "NO_MEMORY": 103,
    "BUSY": 104,
    "INTERNAL_ERROR": 105,
}


def packages(model: ir.Model) -> Packages:
    """Return the message package and the planner's package of a model."""
    messages = Messages(model)
    visible = {v.name for v in model.variables if v.visible}
    return Packages(
        stem=package_stem(file_stem(model)),
        enums=tuple(messages.enums),
        records=tuple(messages.records),
        seen=messages.seen,
        visible=messages.visible,
        statuses=tuple(f"int32 {name}={code}" for name, code in STATUSES.items()),
        action=messages.action,
        start_is_drawn=bool(visible & drawn_at_start(model)),
        params=tuple(params(model)),
        declarations=tuple(declarations(model)),
        settings=tuple(settings()),
    )
