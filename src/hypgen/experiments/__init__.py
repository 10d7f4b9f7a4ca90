# SPDX-License-Identifier: Apache-2.0
"""Suites of experiments: what is played, where it is kept, and what it says."""

from hypgen.experiments.reports import report
from hypgen.experiments.running import bench

__all__ = ["bench", "report"]
