# SPDX-License-Identifier: Apache-2.0
"""A vehicle among people: a simulator, a path planner, and a generated solver for the speed."""
