# SPDX-License-Identifier: Apache-2.0
"""Text to syntax tree.

Takes a ``Source``. Gives the nodes of ``ast``, or diagnostics in the author's words (``errors``).
"""
