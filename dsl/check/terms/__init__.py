# SPDX-License-Identifier: Apache-2.0
"""Single forms of expressions: references, quantifiers, ``match``, ranges, recursion.

Takes one syntax node and its scope. Gives a typed expression.
"""
