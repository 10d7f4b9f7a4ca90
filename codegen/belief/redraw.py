# SPDX-License-Identifier: Apache-2.0
"""Initial values that particles may draw anew as long as nothing has read them (``redraw.hpp``).

Few values of which all hidden state consists are moved one by one instead (``value_moves.py``).
"""

from __future__ import annotations

import math
from collections import Counter

from hypgen.codegen.layout.naming import Names
from hypgen.codegen.layout.state_layout import WORD, Block, Field
from hypgen.codegen.tree.expr import TRUE, Expr, Literal, call, cast, member, number, of, op, shifted
from hypgen.codegen.tree.statements import Function, Return, Statement, when
from hypgen.dsl import ir
from hypgen.dsl.ir.draw_words import words_of
from hypgen.dsl.types import Float, length_of, size_of

MOST = 4_096  # words that a particle keeps: 16 kB, and thousands of particles have them
MOST_MOVED = 64  # values: of more, moves one by one change too few
MOST_BITS = 512.0  # of these values together, so that their joint probability is a double


def redrawn(model: ir.Model) -> tuple[ir.Assign, ...]:
    """Return the inits of hidden fixed variables that draw: those of single values first.

    None without a variable that has entries: what is a single value is soon read. None either where the
    belief is a product of posteriors, where the words would take too much memory, or where values move.
    """
    return () if moves_values(model) else _drawn(model)


def moves_values(model: ir.Model) -> bool:
    """Return whether particles move their hidden values one by one.

    So where all of these are drawn at the start and never change: then what was seen weighs them alone.
    """
    hidden = [v for v in model.variables if not v.visible]
    if not hidden or {a.variable for a in _drawn(model)} != {v.name for v in hidden}:
        return False
    if any(isinstance(v.type, Float) for v in hidden) or any(words_of(e.dist) for e in model.all_lets):
        return False
    bits = sum(length_of(v.indices) * math.log2(size_of(v.type)) for v in hidden)
    return bits <= MOST_BITS and sum(length_of(v.indices) for v in hidden) <= MOST_MOVED


def _drawn(model: ir.Model) -> tuple[ir.Assign, ...]:
    """Return the inits of hidden fixed variables that draw, one word for each value."""
    if model.factored:
        return ()
    variables = {v.name: v for v in model.variables}
    times = Counter(a.site.path for a in model.inits)
    found = [
        a
        for a in model.inits
        if variables[a.variable].fixed
        and not variables[a.variable].visible
        and words_of(a.dist) == 1
        and times[a.site.path] == 1
    ]
    if not any(a.binders for a in found) or sum(_words(a) for a in found) > MOST:
        return ()
    return tuple(sorted(found, key=lambda a: bool(a.binders)))


def _words(init: ir.Assign) -> int:
    return length_of(tuple(b.type for b in init.binders))


def constants(model: ir.Model) -> tuple[str, ...]:
    """Return how many random words those inits take, and how many of them are single values'."""
    counts = [_words(a) for a in redrawn(model)]
    singles = sum(not a.binders for a in redrawn(model))
    if not counts:
        return ()
    return (
        f"static constexpr int kRedrawnWords = {sum(counts)};",
        f"static constexpr int kRedrawnSingles = {singles};",
    )


def functions(model: ir.Model, names: Names, fixed: Block) -> tuple[Function, ...]:
    """Return the number of a site's word among them, and whether the value of a word was read."""
    fields = {field.variable: field for field in fixed.fields}
    sites: list[Statement] = []
    reads, first = [], 0
    for init in redrawn(model):
        site = Literal(f"Site::{names.sites[init.site.path]}")
        index = cast("int", "index")
        sites.append(when(op("site", "==", site), Return(of(first) + index if first else index)))
        field = fields[init.variable]
        reads.append((first, field))
        first += field.length
    if not sites:
        return ()
    return (
        Function(
            "int",
            "redrawn_word",
            [("std::uint32_t", "site"), ("std::uint32_t", "index")],
            [*sites, Return(number(-1))],
            ("// Which of the words that particles may draw anew is drawn there; -1 if none is.",),
        ),
        Function(
            "bool",
            "is_word_read",
            [("const Fixed&", "fixed"), ("int", "word")],
            [
                *(
                    when(op("word", ">=", start), Return(_is_read(field, start)))
                    for start, field in reversed(reads[1:])
                ),
                Return(_is_read(reads[0][1], 0)),
            ],
            ("// Whether the value that was drawn with that word has been read.",),
        ),
    )


def _is_read(field: Field, start: int) -> Expr:
    if not field.width:
        return TRUE  # a single possible value has no bits
    word, shift = place_of(field, shifted("word", -start))
    return call("bits::was_read", word, shift, field.width)


def place_of(field: Field, entry: Expr) -> tuple[Expr, Expr]:
    """Return the word of the fixed state that an entry of a field lies in, and its first bit there."""
    words = member("fixed", "words")
    if field.length == 1:
        return words[field.word], number(field.shift)
    place = entry if field.stride == 1 else entry * field.stride
    if field.shift:
        place = of(field.shift) + place
    word = place / WORD
    return words[of(field.word) + word if field.word else word], place % WORD
