# SPDX-License-Identifier: Apache-2.0
"""Warnings of doubtful text: names that nothing uses, ``==`` on floats, sensors that hide no noise.

Names are judged by the text as it was written; a library's are not, for others may use them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.check.scope.scope import Program
from hypgen.dsl.check.scope.symbols import kind_of
from hypgen.dsl.ir import masses, operators
from hypgen.dsl.ir.reads import reached
from hypgen.dsl.ir.undefined import never_finite, partly_never_finite
from hypgen.dsl.messages import e03_types, w_warnings
from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.walk import walk

_JUDGED = ast.Const | ast.Param | ast.TypeAlias | ast.EnumDecl | ast.RecordDecl | ast.Function
_LEAST = Fraction(1, 10**16)  # below, masses are off by more than one part in a thousand
_Name = tuple[str | None, str]


def warnings(file: ast.ModelFile, model: ir.Model, program: Program) -> list[Diagnostic]:
    """Return the warnings for a model without mistakes, by position; ``file`` is as the author wrote it."""
    found = [*_unused(file), *_float_equalities(program), *_reversible(model), *_idle(model)]
    found += [*_behind(model), *_endless(model), *_rounded(file)]
    if not model.rewards:
        start = file.span
        head = replace(start, end_line=start.line, end_column=start.column + len(f"model {file.name}"))
        found.append(w_warnings.nothing_to_earn(head))
    return sorted(dict.fromkeys(found), key=lambda d: (d.span is not None and d.span, d.code))


# Unused names ------------------------------------------------------------------------------------


def _unused(file: ast.ModelFile) -> Iterator[Diagnostic]:
    members: dict[str, set[str]] = {}
    owners: dict[str, list[str]] = {}
    for item in file.items:
        if isinstance(item, ast.Element):
            own = {m.name for m in item.members if isinstance(m, ast.Variable | ast.Let)}
            members.setdefault(item.name, set()).update(own)
        if isinstance(item, ast.EnumDecl):
            for variant in item.variants:
                owners.setdefault(variant.name, []).append(item.name)
    used: set[_Name] = set()
    for item in file.items:
        if isinstance(item, ast.Element):
            if item.binder is not None:
                used.update(_mentions(item.binder, None, members, owners))
            for member in item.members:
                own_name = (item.name, getattr(member, "name", ""))
                by_value = isinstance(member, ast.Init | ast.Update | ast.Let)
                found = set(_mentions(member, item.name, members, owners))
                used |= found - {own_name} if by_value else found
        elif isinstance(item, ast.Policy):
            used |= set(_mentions(item.rhs, None, members, owners))
            for part in item.members:
                used |= set(_mentions(part, None, members, owners)) - {(None, part.name)}
        else:
            used |= set(_mentions(item, None, members, owners)) - {(None, getattr(item, "name", ""))}
    for item in file.items:
        if item.span.file != file.span.file:
            continue
        if isinstance(item, _JUDGED) and (None, item.name) not in used:
            yield _never_used(item.name, item, item.span)
        if isinstance(item, ast.Policy):
            for part in item.members:
                if not isinstance(part, ast.Update) and (None, part.name) not in used:
                    yield _never_used(part.name, part, part.span)
        if isinstance(item, ast.Element):
            for member in item.members:
                if not isinstance(member, ast.Variable | ast.Let) or getattr(member, "visible", False):
                    continue
                if (item.name, member.name) not in used:
                    yield _never_used(f"{item.name}.{member.name}", member, member.span)


def _never_used(name: str, item: ast.Item, span: Span) -> Diagnostic:
    is_value = isinstance(item, ast.Param | ast.Variable | ast.Let | ast.Memory)
    return w_warnings.never_used(name, kind_of(item), is_value, span)


def _mentions(
    node: ast.Node, element: str | None, members: Mapping[str, set[str]], owners: Mapping[str, list[str]]
) -> Iterator[_Name]:
    """Yield the names that ``node`` mentions, each with its element if it has one."""
    for part in walk(node):
        match part:
            case ast.Name(_, name) | ast.Call(_, name) | ast.TypeName(_, name):
                yield None, name
                yield from ((None, enum) for enum in owners.get(name, ()))
                if element is not None and name in members[element]:
                    yield element, name
            case ast.Pattern(_, str() as name):
                yield from ((None, enum) for enum in owners.get(name, ()))
            case ast.Member(_, ast.Name(_, owner) | ast.Index(_, ast.Name(_, owner)), name):
                yield owner, name


# Probabilities -----------------------------------------------------------------------------------


def _rounded(file: ast.ModelFile) -> Iterator[Diagnostic]:
    """Yield the probabilities that float32 takes for 1 before a draw counts them, and the least ones."""
    for item in file.items:
        kept = isinstance(item, ast.Const) and isinstance(item.type, ast.TypeName)  # a number: exact in draws
        if isinstance(item, ast.Const | ast.Param | ast.Function) and not kept:
            drawn = isinstance(item, ast.Function) and item.rhs.draw
            if not drawn and any(isinstance(t, ast.TypeName) and t.name == "prob" for t in walk(item.type)):
                yield from _near_one(item)
        for part in walk(item):
            if isinstance(part, ast.TableLiteral):
                yield from _tiny([weight for _, weight in part.entries])
            elif isinstance(part, ast.Call) and part.name in ("bernoulli", "noisy"):
                yield from _tiny(part.arguments[-1:])


def _near_one(item: ast.Node) -> Iterator[Diagnostic]:
    for part in walk(item):
        exact = part.exact if isinstance(part, ast.Literal) else None
        if exact is not None and exact < 1 and operators.real(float(exact)).value == 1:
            yield w_warnings.rounded_probability(_decimal(exact), "1", part.span)


def _tiny(weights: Iterable[ast.Node]) -> Iterator[Diagnostic]:
    for part in weights:
        if isinstance(part, ast.Literal) and part.exact is not None and 0 < part.exact < _LEAST:
            nearest = masses.of_constant(operators.real(float(part.exact), exact=part.exact)) / masses.WHOLE
            yield w_warnings.rounded_probability(_decimal(part.exact), f"{nearest:.3g}", part.span)


def _decimal(number: Fraction) -> str:
    """Return a number's decimals."""
    digits = Decimal(number.numerator) / Decimal(number.denominator)
    return f"{digits:.28g}" if number > Fraction(1, 2) else f"{digits:.6g}"


# Rewards -----------------------------------------------------------------------------------------


def _idle(model: ir.Model) -> Iterator[Diagnostic]:
    """Yield the rewards that every policy earns alike: the same in each step of episodes that do not end."""
    if model.terminal != operators.FALSE:
        return
    functions = {f.name: f for f in model.functions}
    for reward in model.rewards:
        parts = reached((reward.value,), functions, {})
        if not any(isinstance(part, ir.StateRead | ir.LetRead | ir.ActionRead) for part, _ in parts):
            yield w_warnings.idle_reward(reward.name, reward.span)


# Bounds -----------------------------------------------------------------------------------------


def _endless(model: ir.Model) -> Iterator[Diagnostic]:
    """Yield what is infinite, or no number, at the defaults of params: declared bounds, parts of rewards."""
    params = {p.name: p for p in model.params}
    for name in ("upper", "lower", "tail"):
        bound: ir.Expr | None = getattr(model, name)
        if bound is not None and name in model.spans and (why := never_finite(bound, params)):
            yield w_warnings.endless_bound(name, why, model.spans[name])
    for reward in model.rewards:
        if why := partly_never_finite(reward.value, params):
            yield w_warnings.reward_without_value(reward.name, why, reward.span)


# Floats ------------------------------------------------------------------------------------------


def check_float_equalities(program: Program) -> None:
    """Report observations that compare floats for equality: sampler and density would disagree."""
    for owner in program.float_equalities:
        for start in program.uses.owners():
            if start.kind == "observe" and owner in program.uses.nodes(start):
                for span in program.float_equalities[owner]:
                    program.report.attempt(partial(_refuse_equality, start.name, span))


def _refuse_equality(observation: str, span: Span) -> None:
    raise Mistake(e03_types.observation_compares_floats(observation, span))


def _float_equalities(program: Program) -> Iterator[Diagnostic]:
    for spans in program.float_equalities.values():
        for span in spans:
            yield w_warnings.float_equality(span)


# Observations ------------------------------------------------------------------------------------


def _reversible(model: ir.Model) -> Iterator[Diagnostic]:
    """Yield the observations that show a draw as it is."""
    lets = {x.name: x for x in model.lets}
    functions = {f.name: f for f in model.functions}
    for observation in model.observations:
        for value in _certain(observation.dist):
            read = [x.let for x, _ in reached((value,), functions, lets) if isinstance(x, ir.LetRead)]
            draw = next((lets[name] for name in read if name in lets and lets[name].draws), None)
            if draw is not None:
                yield w_warnings.shown_draw(observation.name, draw.name, observation.span, draw.span)
                break


def _behind(model: ir.Model) -> Iterator[Diagnostic]:
    """Yield the observations that read of hidden variables only what they were before the step.

    One whose variables some steps leave alone may mean that, as when a sample spoils the rock that is
    seen. So may one that reads a let, which is drawn before the step.
    """
    variables = {v.name: v for v in model.variables}
    moving = {a.variable for a in model.updates if not _may_keep(a.dist, a.variable)}
    functions = {f.name: f for f in model.functions}
    for observation in model.observations:
        nodes = list(reached((observation.dist,), functions, {}))
        reads = [(x.variable, x.primed or primed) for x, primed in nodes if isinstance(x, ir.StateRead)]
        hidden = [(name, primed) for name, primed in reads if not variables[name].visible]
        if not hidden or any(isinstance(node, ir.LetRead) for node, _ in nodes):
            continue
        if all(name in moving and not primed for name, primed in hidden):
            yield w_warnings.state_before(observation.name, hidden[0][0], observation.span)


def _may_keep(node: ir.Dist | ir.Expr, variable: str) -> bool:
    """Return whether an update leaves its variable as it is in some case."""
    match node:
        case ir.Certain(_, value):
            return _may_keep(value, variable)
        case ir.IfDist(_, _, a, b) | ir.If(_, _, a, b) | ir.Binary(_, "and" | "or" | "min" | "max", a, b):
            return _may_keep(a, variable) or _may_keep(b, variable)
        case ir.LetDist(_, _, _, body) | ir.LetIn(_, _, _, body) | ir.DrawIn(_, _, _, body):
            return _may_keep(body, variable)
        case ir.StateRead(variable=name, primed=primed):
            return name == variable and not primed
    return False


def _certain(dist: ir.Dist) -> Iterator[ir.Expr]:
    """Yield the values that ``dist`` gives with certainty, in some case."""
    match dist:
        case ir.Certain(_, value):
            yield value
        case ir.IfDist(_, _, then, otherwise):
            yield from _certain(then)
            yield from _certain(otherwise)
        case ir.LetDist(_, _, _, body):
            yield from _certain(body)
