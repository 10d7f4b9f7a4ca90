# SPDX-License-Identifier: Apache-2.0
"""Syntax tree to typed expressions: names, types, ranges, units, and who may read what.

Takes the syntax tree of a whole file. Gives checked declarations on demand (``program``).
"""
