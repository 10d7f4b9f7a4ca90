# SPDX-License-Identifier: Apache-2.0
"""Settings that suit a model: candidates play the same episodes, and the best is tested in others."""

from hypgen.tuning.running import tune

__all__ = ["tune"]
