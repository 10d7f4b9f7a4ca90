# SPDX-License-Identifier: Apache-2.0
"""Small models as the exact solver enumerates them, written for other solvers.

Takes the exact solver's dump. Gives Cassandra's format and split states.
"""
