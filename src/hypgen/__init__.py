# SPDX-License-Identifier: Apache-2.0
"""hypgen compiles declarative POMDP models into native online planners."""

__version__ = "0.2.0"
