# SPDX-License-Identifier: Apache-2.0
"""Probabilities as masses: whole numbers of 2^-63.

A draw compares 63 random bits with masses, so that an outcome of probability 1e-15 is drawn as often as it
says. A probability that float32 holds well has the mass of its float32. What float32 would lose is taken from
what the text says (``Const.exact``), or from what the probability lacks to 1 (``complement``).
"""

from __future__ import annotations

from fractions import Fraction

from hypgen.dsl import ir
from hypgen.dsl.ir import operators
from hypgen.dsl.types import Float

WHOLE = 1 << 63
RARE = 1 << 54  # from this mass on, 2^-9, the mass of a float32 is a whole number of words
WORD = 1 << 31  # the mass of one 32-bit word
_HELD = 1 << 14  # a mass is held well if it is off by less than one part in so many


def rounded(p: float) -> int:
    """Return M(p) of a float32: p * 2^63 without its fraction, within 0 .. 2^63."""
    return 0 if not p > 0 else min(int(Fraction(min(p, 1.0)) * WHOLE), WHOLE)


def number(e: ir.Const) -> Fraction:
    """Return the number that the text says, within 0 .. 1."""
    exact = Fraction(e.value) if e.exact is None else e.exact
    return min(max(exact, Fraction(0)), Fraction(1))


def of_constant(e: ir.Const) -> int:
    """Return the mass of a constant probability: its float32's if that tells it and its complement well.

    A precise constant has that of its text.
    """
    p, mass = number(e), rounded(float(e.value))
    if e.precise:
        return round(p * WHOLE)
    if e.exact is None or (mass >= RARE and _near(mass, p) and _near(WHOLE - mass, 1 - p)):
        return mass
    return round(p * WHOLE)


def of_table(dist: ir.Table) -> tuple[int, ...] | None:
    """Return the masses of a table of constants, ``rest`` last; None where a probability is not constant.

    In order, the last takes what the others leave. If that is not what the text says of it, all masses are
    the text's, and the likeliest entry, the first of them, takes what the others leave.
    """
    constants = [p for _, p in dist.entries if isinstance(p, ir.Const)]
    if len(constants) < len(dist.entries):
        return None
    numbers = [number(p) for p in constants]
    if dist.rest is not None:
        numbers.append(max(1 - sum(numbers, Fraction(0)), Fraction(0)))
    masses: list[int] = []
    for constant in constants[: len(numbers) - 1]:
        masses.append(min(of_constant(constant), WHOLE - sum(masses)))
    last = WHOLE - sum(masses)
    if not any(p.precise for p in constants) and _near(last, numbers[-1]):
        return (*masses, last)
    masses = [round(p * WHOLE) for p in numbers]
    likeliest = masses.index(max(masses))
    masses[likeliest] = max(masses[likeliest] + WHOLE - sum(masses), 0)
    return tuple(masses)


def in_words(dist: ir.Table) -> bool:
    """Return whether the masses of a table of constants are those of its float32s, in whole words."""
    found = of_table(dist)
    if found is None:
        return False
    own = [rounded(float(p.value)) for _, p in dist.entries if isinstance(p, ir.Const)]
    return list(found[:-1]) == own[: len(found) - 1] and not any(mass % WORD for mass in found)


def _near(mass: int, p: Fraction) -> bool:
    return abs(mass - p * WHOLE) * _HELD <= p * WHOLE


def complement(e: ir.Expr) -> ir.Expr | None:
    """Return what ``e`` lacks to 1, as precise as float32 is near 0; None where no form of ``e`` tells it.

    None too for a constant, which has its exact number, and for what does not come near 1.
    """
    near_one = isinstance(e.type, Float) and e.type.high * WHOLE > WHOLE - RARE
    return _lacking(e) if near_one and not isinstance(e, ir.Const) else None


def _lacking(e: ir.Expr) -> ir.Expr | None:
    match e:
        case ir.Const(value=value):
            exact = 1 - (Fraction(value) if e.exact is None else e.exact)
            return operators.real(float(exact), exact=exact)
        case ir.Clamp(operand=operand):
            return _lacking(operand)
        case ir.Binary(op="sub", left=left, right=right):
            return _sum(_lacking(left), right)
        case ir.Binary(op="mul", left=left, right=right):
            a, b = _lacking(left), _lacking(right)
            return None if a is None or b is None else _sum(a, operators.arithmetic("mul", left, b))
        case ir.If(condition=condition, then=then, otherwise=otherwise):
            a, b = _lacking(then), _lacking(otherwise)
            return None if a is None or b is None else operators.choose(condition, a, b)
    return None


def _sum(a: ir.Expr | None, b: ir.Expr) -> ir.Expr | None:
    if a is None or (isinstance(a, ir.Const) and a.value == 0):
        return None if a is None else b
    return operators.arithmetic("add", a, b)


def is_plain(e: ir.Expr, low: float) -> bool:
    """Return whether the mass of a probability from ``low`` up is surely a whole number of words.

    It is then what the float32 alone tells, and one 32-bit word is enough to compare with.
    """
    if isinstance(e, ir.Const):
        mass = of_constant(e)
        return mass % WORD == 0 and mass == rounded(float(e.value))
    return low * WHOLE >= RARE
