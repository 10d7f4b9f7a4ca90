# SPDX-License-Identifier: Apache-2.0
"""Finds compilers and builds solvers: the runtime once, then each model; results are cached.

Takes the files of a generated project. Gives an executable, or a folder that builds without hypgen.
"""
