# SPDX-License-Identifier: Apache-2.0
"""Distributions after ``~``, over the type that their place asks for.

Takes a syntax node, a scope and a target type. Gives a distribution of ``ir``.
"""
