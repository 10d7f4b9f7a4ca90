# SPDX-License-Identifier: Apache-2.0
"""A model's functions in lanes: many scenarios at a time on a CPU."""

from __future__ import annotations
