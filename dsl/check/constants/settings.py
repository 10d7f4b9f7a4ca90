# SPDX-License-Identifier: Apache-2.0
"""``discount`` and ``horizon``, and the settings that an instance or the command line gives."""

from __future__ import annotations

from hypgen.dsl import ir
from hypgen.dsl.check.constants.constant_entries import scalar
from hypgen.dsl.check.scope.scope import Program, Scope
from hypgen.dsl.check.scope.symbols import Global, kind_of
from hypgen.dsl.messages import e02_names, e08_parts
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import FLOAT, INT


def _single(kind: str, program: Program) -> ast.Setting | None:
    found = [i for i in program.file.items if isinstance(i, ast.Setting) and i.kind == kind]
    if len(found) > 1:
        raise Mistake(e02_names.duplicate(kind, found[1].span, found[0].span))
    return found[0] if found else None


def discount(program: Program) -> float:
    """Return the discount: exactly as written if it is a literal."""
    item = _single("discount", program)
    if item is None:
        raise Mistake(e08_parts.no_discount(program.file.span))
    value = _constant(item, program, "the discount").value
    if not 0 < value <= 1:
        raise Mistake(e08_parts.wrong_discount(value, item.value.span))
    if isinstance(item.value, ast.Literal):
        return float(item.value.value)
    return float(value)


def horizon(program: Program) -> int | None:
    """Return the horizon, None if there is none."""
    item = _single("horizon", program)
    if item is None:
        return None
    scope = Scope(program, evaluate=True, constant=True)
    value = int(scalar(item.value, scope, INT, "the horizon").value)
    if value < 1:
        raise Mistake(e08_parts.wrong_horizon(value, item.value.span))
    return value


def _constant(item: ast.Setting, program: Program, what: str) -> ir.Const:
    return scalar(item.value, Scope(program, evaluate=True, constant=True), FLOAT, what)


def refuse_unknown(program: Program) -> None:
    """Report settings that name neither a const nor a param."""
    known = [n for n, i in program.symbols.values.items() if isinstance(i, ast.Const | ast.Param)]
    declared: dict[str, Global] = {item.name: item for item in program.symbols.declared}
    for name, value in program.overrides.items():
        if name in known:
            continue
        if name in declared:
            item = declared[name]
            error = Mistake(e08_parts.setting_of_other(name, kind_of(item), value.span, item.span))
        else:
            error = Mistake(e08_parts.unknown_setting(name, known, value.span))
        program.report.add(error)
