# SPDX-License-Identifier: Apache-2.0
"""How many random words a draw takes: a draw within a draw has words of its own."""

from __future__ import annotations

from hypgen.dsl import ir

MOST_WORDS = 64  # of one draw; their number is in the index of a word, above 2^24 members


def words_of(dist: ir.Dist) -> int:
    """Return how many words sampling ``dist`` may take; 0 for what draws nothing."""
    match dist:
        case ir.Certain():
            return 0
        case ir.IfDist(then=then, otherwise=otherwise):
            return max(words_of(then), words_of(otherwise))
        case ir.LetDist(body=inner) | ir.Widened(dist=inner) | ir.InVariant(dist=inner):
            return words_of(inner)
        case ir.DrawIn(law=law, body=body):
            return words_of(law) + words_of(body)
        case ir.UniformSet(otherwise=ir.Dist() as rest) | ir.Weighted(otherwise=ir.Dist() as rest):
            return max(1, words_of(rest))
    return 1
