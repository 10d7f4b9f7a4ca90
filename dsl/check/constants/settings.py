"""``discount`` and ``horizon``, and the settings that an instance or the command line gives."""

from __future__ import annotations

from hypgen.dsl import ir
from hypgen.dsl.check.constants.constant_entries import scalar
from hypgen.dsl.check.scope.scope import Program, Scope
from hypgen.dsl.check.scope.symbols import duplicate, kind_of
from hypgen.dsl.messages.diagnostic import did_you_mean
from hypgen.dsl.messages.report import mistake
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import FLOAT, INT


def _single(kind: str, program: Program) -> ast.Setting | None:
    found = [i for i in program.file.items if isinstance(i, ast.Setting) and i.kind == kind]
    if len(found) > 1:
        raise duplicate(kind, found[1].span, found[0].span)
    return found[0] if found else None


def discount(program: Program) -> float:
    """Return the discount: exactly as written if it is a literal."""
    item = _single("discount", program)
    if item is None:
        raise mistake("E0803", "the model has no discount", program.file.span, "add a line: discount 0.95")
    value = _constant(item, program, "the discount").value
    if not 0 < value <= 1:
        raise mistake("E0804", f"the discount is {value:g}", item.value.span, "it lies in 0 < discount <= 1")
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
        raise mistake(
            "E0804", f"the horizon is {value}", item.value.span, "it is a number of steps, 1 or more"
        )
    return value


def _constant(item: ast.Setting, program: Program, what: str) -> ir.Const:
    return scalar(item.value, Scope(program, evaluate=True, constant=True), FLOAT, what)


def refuse_unknown(program: Program) -> None:
    """Report settings that name neither a const nor a param."""
    declared = program.symbols.globals
    known = [n for n, i in declared.items() if isinstance(i, ast.Const | ast.Param)]
    for name, value in program.overrides.items():
        if name in known:
            continue
        if name in declared:
            error = mistake(
                "E0809",
                f"'{name}' is {kind_of(declared[name])}, which cannot be set",
                value.span,
                "settings are for consts and params",
                [(declared[name].span, f"'{name}' is declared here")],
            )
        else:
            error = mistake(
                "E0808",
                f"the model has no const or param '{name}'",
                value.span,
                did_you_mean(name, known)
                or (f"it has {', '.join(known)}" if known else "remove this setting"),
            )
        program.report.add(error)
