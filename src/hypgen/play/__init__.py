# SPDX-License-Identifier: Apache-2.0
"""Episodes of compiled solvers: played, read as JSON lines, and compared in the same worlds.

Takes programs that play. Gives returns by episode, with intervals of paired differences.
"""
