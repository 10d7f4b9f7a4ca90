# SPDX-License-Identifier: Apache-2.0
"""What a robot that has a compiled library alone imports."""

import subprocess
import sys

import hypgen.api


def test_a_library_plans_without_the_compiler() -> None:
    program = """
import sys
sys.modules |= {name: None for name in ("lark", "jinja2", "rich", "click")}
from hypgen.api import Planner, PlannerError, Solver, Worlds
"""
    subprocess.run([sys.executable, "-c", program], check=True)


def test_every_name_is_there() -> None:
    assert all(getattr(hypgen.api, name).__name__ == name for name in hypgen.api.__all__)
