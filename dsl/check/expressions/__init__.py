# SPDX-License-Identifier: Apache-2.0
"""All expressions: one function for each kind of syntax node.

Takes a syntax node, a scope and an expected type. Gives a typed expression of ``ir``.
"""
