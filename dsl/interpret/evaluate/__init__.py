# SPDX-License-Identifier: Apache-2.0
"""Expressions and distributions of ``ir``, evaluated over all lanes at once.

Takes an expression and the values that it reads. Gives an array with one entry a lane.
"""
