# SPDX-License-Identifier: Apache-2.0
"""Recursive functions: a copy for each value of the ints that are constant in a call, until they have fallen.

``power(x, 3)`` becomes a call of ``power_n3(x)``, whose body calls ``power_n2(x)``, and so on: the IR has no
recursion. Each call must give a lower constant than the call that it stands in, so that there is an end.
"""

from __future__ import annotations

from dataclasses import replace

from hypgen.dsl import ir
from hypgen.dsl.analysis.uses import Use
from hypgen.dsl.check.scope.scope import Falling, Program, Scope
from hypgen.dsl.messages import e02_names
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.walk import walk
from hypgen.dsl.types import INT, Int

_MAX_DEPTH = 100
_MAX_COPIES = 1 << 12


def recursive_functions(program: Program) -> frozenset[str]:
    """Return the functions that come to call themselves."""
    functions = program.symbols.functions
    calls = {
        name: [p.name for p in walk(item.rhs) if isinstance(p, ast.Call) and p.name in functions]
        for name, item in functions.items()
    }
    found = set()
    for name in functions:
        reached: set[str] = set()
        pending = list(calls[name])
        while pending:
            other = pending.pop()
            if other not in reached:
                reached.add(other)
                pending += calls[other]
        if name in reached:
            found.add(name)
    return frozenset(found)


def call(item: ast.Function, arguments: list[ir.Expr], node: ast.Call, scope: Scope) -> ir.Expr:
    """Return a call of a recursive function, as a call of the copy for its constant ints."""
    program = scope.program
    given = dict(zip([f.name for f in item.formals], arguments, strict=True))
    constants = {
        n: int(e.value) for n, e in given.items() if isinstance(e, ir.Const) and isinstance(e.type, Int)
    }
    _require_fall(item, constants, node.span, scope)
    frames = (*scope.unrolling, Falling(item.name, constants))
    if scope.evaluate:
        return program.follow_call(item, arguments, replace(scope, unrolling=frames))
    name = copy_name(item, constants, program)
    copy = program.copy(name, item, frames)
    if scope.owner is not None:
        program.uses.add(scope.owner, Use("function", name, scope.primed, node.span))
    result = copy.type
    if not scope.unrolling and any(f.type == INT for f in copy.formals):  # whose ranges each call proves
        proving = replace(scope, owner=None, evaluate=True, unrolling=frames)
        result = program.follow_call(item, arguments, proving).type
    rest = tuple(e for n, e in given.items() if n not in constants)
    return ir.Call(result, name, rest, scope.primed)


def copy_name(item: ast.Function, constants: dict[str, int], program: Program) -> str:
    """Return the name of the copy of a function for these constants."""
    name = item.name + "".join(f"_{n}{v}".replace("-", "m") for n, v in constants.items())
    while program.symbols.is_taken(name):
        name += "_"
    return name


def _require_fall(item: ast.Function, constants: dict[str, int], span: Span, scope: Scope) -> None:
    outer = next((f.constants for f in reversed(scope.unrolling) if f.function == item.name), None)
    if not constants:
        raise Mistake(e02_names.endless_recursion(item.name, "gives it no constant int", span, item.span))
    if outer is not None and not any(n in outer and v < outer[n] for n, v in constants.items()):
        kept = [f"'{n}' is {v} after {outer[n]}" for n, v in constants.items() if n in outer]
        why = f"does not lower it: {', '.join(kept)}" if kept else "gives it another int"
        raise Mistake(e02_names.endless_recursion(item.name, why, span, item.span))
    if len(scope.unrolling) >= _MAX_DEPTH or len(scope.program.unrolled) >= _MAX_COPIES:
        raise Mistake(e02_names.deep_recursion(item.name, _MAX_DEPTH, _MAX_COPIES, span))
