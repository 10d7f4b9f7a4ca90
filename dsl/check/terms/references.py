# SPDX-License-Identifier: Apache-2.0
"""Names, members and indexes: what an expression reads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from hypgen.dsl import ir
from hypgen.dsl.analysis.uses import ReadKind, Use
from hypgen.dsl.check.scope.fit_type import check_as
from hypgen.dsl.check.scope.scope import Scope
from hypgen.dsl.check.scope.symbols import StateMember, kind_of
from hypgen.dsl.ir import operators
from hypgen.dsl.ir.operators import to_index
from hypgen.dsl.messages import e02_names, e03_calls, e04_variables, e05_reads, e08_parts
from hypgen.dsl.messages.report import Mistake, gather
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.walk import walk
from hypgen.dsl.types import PROB, Enum, Float, Record, Type, size_of
from hypgen.dsl.types.palette import COLOUR
from hypgen.dsl.types.units import PLAIN

Entry = Callable[[tuple[ir.Expr, ...]], ir.Expr]

_PI = 3.14159265358979323846


@dataclass(frozen=True)
class Reference:
    """Something readable under a name: with ``indices`` of these types, ``entry`` gives the read."""

    label: str
    indices: tuple[Type, ...]
    entry: Entry


def check(node: ast.Name | ast.Member | ast.Index, scope: Scope, expected: Type | None) -> ir.Expr:
    """Return the read, variant or field that ``node`` means."""
    reference = find(node.operand if isinstance(node, ast.Index) else node, scope)
    if isinstance(node, ast.Index):
        if reference is None:
            raise _not_indexable(node, scope)
        return entry(reference, node.indices, node.span, scope)
    if reference is not None:
        return entry(reference, (), node.span, scope)
    if isinstance(node, ast.Name):
        return _plain_name(node, scope, expected)
    return _member(node, scope)


def _other_indexes(reference: Reference, nodes: tuple[ast.Expr, ...], scope: Scope) -> str:
    """Return what to write where the number of indexes is wrong: a record or its fields may be meant."""
    types = reference.indices
    if not types:
        return _alone(reference.label, scope)
    if len(types) == 1 and isinstance(types[0], Record) and len(types[0].fields) == len(nodes):
        fields = ", ".join(name for name, _ in types[0].fields)
        return f"write {reference.label}[{types[0]}({fields})]"
    remedy = f"it is indexed by [{', '.join(map(str, types))}]"
    if not nodes:
        return f"{remedy}: say which entry, {reference.label}[..]" + "'" * scope.primed
    given = scope.check(nodes[0]).type if len(nodes) == 1 else None
    if isinstance(given, Record) and len(given.fields) == len(types):
        fields = ", ".join(f"p.{name}" for name, _ in given.fields)
        remedy += f": write {reference.label}[{fields}] of a {given} p, or declare it over [{given}]"
    return remedy


def entry(reference: Reference, nodes: tuple[ast.Expr, ...], span: Span, scope: Scope) -> ir.Expr:
    """Return the read of ``reference`` at the indexes that ``nodes`` write."""
    if len(nodes) != len(reference.indices):
        remedy = _other_indexes(reference, nodes, scope)
        raise Mistake(
            e03_calls.wrong_indexes(reference.label, len(reference.indices), len(nodes), remedy, span)
        )
    indices = [
        partial(check_as, n, scope, t, f"the index of '{reference.label}'", is_index=True)
        for n, t in zip(nodes, reference.indices, strict=True)
    ]
    return scope.narrow(reference.entry(tuple(gather(indices))))


def _alone(label: str, scope: Scope) -> str:
    """Return how a scalar is written here, of this member of a family and of others."""
    element, _, name = label.partition(".")  # a record's field has another dot, a param's no element
    is_element = name and element in scope.program.symbols.elements
    if not is_element or scope.program.element(element).binder is None:
        return f"write {name if is_element and element == scope.element else label} alone"
    other = f"{element}[..].{name}"
    return (
        f"write {name} for this member, {other} for another" if element == scope.element else f"write {other}"
    )


def find(node: ast.Expr, scope: Scope) -> Reference | None:
    """Return what ``node`` refers to, or None if it names no data (a variant, a field, an expression)."""
    match node:
        case ast.Name(span, name):
            return _named(name, span, scope)
        case ast.Member(span, operand, name):
            owner = element_of(operand, name, scope)
            return None if owner is None else _element_member(*owner, name, span, scope)
    return None


def _named(name: str, span: Span, scope: Scope) -> Reference | None:
    if name in scope.locals:
        local = scope.locals[name]
        return Reference(name, (), lambda _: local)
    program = scope.program
    if name in program.symbols.clashing:
        raise Mistake  # that the name was taken has been reported
    if scope.history and name in program.symbols.policy:
        return _policy_member(name, span, scope)
    if scope.element is not None and name in program.symbols.members[scope.element]:
        binder = program.element(scope.element).binder
        own = () if binder is None else (scope.locals.get(binder.name, ir.Local(binder.type, binder.name)),)
        return _state(scope.element, name, own, span, scope)
    match program.symbols.values.get(name):
        case ast.Const() as item:
            value = program.const(item)
            if isinstance(value, ir.ConstantArray):
                return Reference(name, value.indices, partial(_table_entry, value))
            return Reference(name, (), lambda _: value)
        case ast.Param() as item:
            _refuse_constant(f"the param '{name}'", span, scope)
            param = program.param(item)
            return Reference(name, param.indices, lambda i: ir.ParamRead(param.type, name, i))
        case ast.Action() as item:
            _refuse_constant("the action", span, scope)
            action = program.action(item)
            return Reference(name, action.indices, partial(_action_entry, action, span, scope))
    return None


def _policy_member(name: str, span: Span, scope: Scope) -> Reference:
    """Return a register or let of the policy."""
    if scope.primed:
        raise Mistake(e04_variables.next_of_policy(name, span))
    program = scope.program
    item = program.symbols.policy[name]
    if isinstance(item, ast.Memory):
        t, indices = program.memory(item)
        return Reference(
            name,
            indices,
            lambda i: record(ir.MemoryRead(t, name, i), Use("memory", name, False, span), scope),
        )
    let = program.policy_let(item)
    use = Use("policy draw" if let.draws else "policy let", let.name, False, span)
    return Reference(name, (), lambda _: record(ir.LetRead(let.dist.type, let.name), use, scope))


def _table_entry(table: ir.ConstantArray, indices: tuple[ir.Expr, ...]) -> ir.Expr:
    position = 0
    for index, t in zip(indices, table.indices, strict=True):
        if not isinstance(index, ir.Const):
            return ir.TableRead(_reached(table), table.name, indices)
        position = position * size_of(t) + to_index(t, index.value)
    value = table.values[position]
    if isinstance(table.type, Float):
        return operators.real(value, table.type.unit)
    return operators.literal(value) if operators.is_numeric(table.type) else ir.Const(table.type, value)


def _reached(table: ir.ConstantArray) -> Type:
    """Return the type of a table's entries, as narrow as they are."""
    if not operators.is_numeric(table.type) or table.type == PROB:
        return table.type
    return operators.numeric(table.type, (min(table.values), max(table.values)))


def _action_entry(action: ir.Action, span: Span, scope: Scope, indices: tuple[ir.Expr, ...]) -> ir.Expr:
    if scope.action is not None:
        return scope.action
    if scope.owner is not None:
        scope.program.uses.add(scope.owner, Use("action", action.name, False, span))
    return ir.ActionRead(action.type, indices)


def _refuse_constant(what: str, span: Span, scope: Scope) -> None:
    if scope.constant:
        raise Mistake(e08_parts.not_constant(what, span))


def element_of(node: ast.Expr, member: str, scope: Scope) -> tuple[str, tuple[ir.Expr, ...]] | None:
    """Return the element that ``node`` names before ``.member``, with the index of one of a family.

    A value of that name is meant where the element has no such member.
    """
    name = node.operand if isinstance(node, ast.Index) else node
    if not isinstance(name, ast.Name) or name.name not in scope.program.symbols.elements:
        return None
    if not scope.program.symbols.has_member(name.name, member) and _is_value(name.name, scope):
        return None
    binder = scope.program.element(name.name).binder
    given = node.indices if isinstance(node, ast.Index) else ()
    if len(given) != (0 if binder is None else 1):
        if binder is None:
            raise Mistake(e03_calls.element_with_index(name.name, node.span))
        read = member + "'" * scope.primed
        raise Mistake(
            e03_calls.family_without_index(name.name, binder.name, read, binder.type, len(given), node.span)
        )
    if binder is None:
        return name.name, ()
    try:
        index = check_as(given[0], scope, binder.type, f"the index of '{name.name}'", is_index=True)
    except Mistake as error:
        told = partial(
            e02_names.unknown_member_index, family=name.name, index=binder.type, span=given[0].span
        )
        raise Mistake(*map(told, error.diagnostics)) from None
    return name.name, (index,)


def _is_value(name: str, scope: Scope) -> bool:
    """Return whether a value is called ``name`` here."""
    symbols = scope.program.symbols
    own = {} if scope.element is None else symbols.members[scope.element]
    return name in scope.locals or name in symbols.values or name in own


def _element_member(
    element: str, indices: tuple[ir.Expr, ...], name: str, span: Span, scope: Scope
) -> Reference:
    members = scope.program.symbols.members[element]
    if name in members:
        return _state(element, name, indices, span, scope)
    if f"{element}.{name}" in scope.program.symbols.observations:
        raise observation_read(f"{element}.{name}", span, scope)
    if element in scope.program.symbols.clashing:
        raise Mistake  # it may be a member of the other element of that name
    own = next(iter(scope.program.symbols.members.get(name, ())), None)
    other = None if own is None else f"{name}.{own}"
    raise Mistake(e02_names.unknown_member(element, name, members, other, span))


def observation_read(path: str, span: Span, scope: Scope) -> Mistake:
    """Return the mistake of reading an observation."""
    name = path.rpartition(".")[2]
    if scope.history:
        return Mistake(e02_names.observation_in_policy(name, span))
    return Mistake(e02_names.observation_in_model(name, span))


def _state(element: str, name: str, member: tuple[ir.Expr, ...], span: Span, scope: Scope) -> Reference:
    """Return a variable or let of an element; ``member`` is the family member's index."""
    program = scope.program
    _refuse_constant(f"'{name}' of element '{element}'", span, scope)
    item: StateMember = program.symbols.members[element][name]
    path = f"{element}.{name}"
    if isinstance(item, ast.Variable):
        variable = program.variable(element, item)
        primed = scope.primed and not variable.fixed
        own = variable.indices[len(member) :]
        return Reference(
            path,
            own,
            lambda i: record(
                ir.StateRead(variable.type, path, (*member, *i), primed, span=span),
                Use("variable", path, primed, span),
                scope,
            ),
        )
    let = program.let(element, item)
    draws, primed = item.rhs.draw and let.draws, scope.primed
    kind: ReadKind = "draw" if draws else "let"
    if scope.evaluate and not draws:
        return Reference(path, (), lambda _: program.follow_let(element, item, member, scope))
    return Reference(
        path,
        (),
        lambda _: record(
            ir.LetRead(let.dist.type, path, member, primed), Use(kind, path, primed, span), scope
        ),
    )


def record(read: ir.Expr, use: Use, scope: Scope) -> ir.Expr:
    """Return ``read`` and note that the declaration in work makes ``use`` of what it names."""
    if scope.owner is not None:
        scope.program.uses.add(scope.owner, use)
    return read


def _plain_name(node: ast.Name, scope: Scope, expected: Type | None) -> ir.Expr:
    name, program = node.name, scope.program
    if name in program.symbols.clashing:
        raise Mistake  # that the name was taken has been reported
    if expected == COLOUR and name in COLOUR.offsets:
        return ir.Const(COLOUR, COLOUR.offsets[name])
    if name in program.symbols.variants:
        enum = owner_of(name, node.span, scope, expected)
        variant = enum.variant(name)
        assert variant is not None
        if variant.argument is not None:
            raise Mistake(e03_calls.variant_takes_argument(name, variant.argument, node.span))
        return ir.Const(enum, enum.offsets[name])
    if name == "gamma":
        return operators.real(program.discount(node.span), PLAIN)
    if name == "pi":
        return operators.real(_PI, PLAIN)
    if name in program.symbols.elements:
        is_family = program.element(name).binder is not None
        raise Mistake(e02_names.element_as_value(name, is_family, scope.primed, node.span))
    if name in program.symbols.functions:
        raise Mistake(e02_names.function_as_value(name, node.span))
    if name in program.symbols.types:
        raise Mistake(e02_names.not_a_value(name, kind_of(program.symbols.types[name]), node.span))
    own = f"{scope.element}.{name}"
    if name in program.symbols.observations or own in program.symbols.observations:
        raise observation_read(name, node.span, scope)
    if name in program.symbols.policy:
        kind = kind_of(program.symbols.policy[name])
        raise Mistake(e05_reads.policy_outside_policy(name, kind, node.span))
    if not program.symbols.actions:
        raise Mistake  # that the model has no action is reported: this may be its name
    if name == "_":
        raise Mistake(e02_names.wildcard(node.span))
    remedy = program.symbols.suggestion(name, scope.element, _local_names(scope), expected, scope.primed)
    raise Mistake(e02_names.unknown_name(name, remedy, node.span))


def _local_names(scope: Scope) -> set[str]:
    return set(scope.locals) | (set(scope.program.symbols.policy) if scope.history else set())


def owner_of(name: str, span: Span, scope: Scope, expected: Type | None) -> Enum:
    """Return the enum that the variant ``name`` belongs to: the expected one, or its only owner."""
    owners = scope.program.symbols.variants[name]
    item = next((o for o in owners if isinstance(expected, Enum) and o.name == expected.name), None)
    if item is None and len(owners) > 1:
        raise Mistake(e02_names.ambiguous_variant(name, [o.name for o in owners], span))
    found = scope.program.named_type(item or owners[0])
    assert isinstance(found, Enum)
    return found


def _member(node: ast.Member, scope: Scope) -> ir.Expr:
    """Return ``Enum.variant`` or a record's field."""
    if isinstance(node.operand, ast.Name) and node.operand.name not in scope.locals:
        item = scope.program.symbols.types.get(node.operand.name)
        if isinstance(item, ast.EnumDecl):
            enum = scope.program.named_type(item)
            assert isinstance(enum, Enum)
            if node.operand.name in scope.program.symbols.clashing:
                raise Mistake  # that the name was taken has been reported
            if enum.variant(node.name) is None:
                raise Mistake(e02_names.unknown_variant(enum, node.name, node.span))
            return _plain_name(ast.Name(node.span, node.name), scope, enum)
    operand = scope.check(node.operand)
    if not isinstance(operand.type, Record):
        left = node.operand.name if isinstance(node.operand, ast.Name) else ".."
        raise Mistake(e02_names.no_members(node.name, operand.type, left, node.span))
    if operand.type.field_type(node.name) is None:
        names = [n for n, _ in operand.type.fields]
        raise Mistake(e02_names.unknown_field(operand.type, node.name, names, node.span))
    return scope.narrow(operators.field(operand.type, node.name, operand))


def _not_indexable(node: ast.Index, scope: Scope) -> Mistake:
    if isinstance(node.operand, ast.Name):
        if node.operand.name in scope.program.symbols.elements:
            if scope.program.element(node.operand.name).binder is None:
                return Mistake(e03_calls.element_with_index(node.operand.name, node.span))
            return Mistake(e02_names.member_as_value(node.operand.name, scope.primed, node.span))
        if node.operand.name in scope.program.symbols.functions:
            return Mistake(e02_names.function_as_array(node.operand.name, node.span))
    match node.operand:
        case ast.Index(_, ast.Name(_, name)) if name in scope.program.symbols.elements:
            if (binder := scope.program.element(name).binder) is not None:
                return Mistake(e03_calls.twice_indexed(name, binder.type, node.span))
    operand = scope.check(node.operand)
    return Mistake(e03_calls.not_indexable(operand.type, node.span))


def is_bare_variant(node: ast.Expr, scope: Scope) -> bool:
    """Return whether ``node`` is a variant written without its enum."""
    symbols = scope.program.symbols
    if isinstance(node, ast.Name):
        return symbols.plain_variant(node.name) is not None
    return isinstance(node, ast.Call) and node.name in symbols.variants


def is_atomic(e: ir.Expr) -> bool:
    """Return whether evaluating ``e`` twice is as good as naming it."""
    match e:
        case ir.Const() | ir.Local():
            return True
        case ir.StateRead() | ir.ParamRead() | ir.TableRead() | ir.ActionRead() | ir.MemoryRead():
            return all(map(is_atomic, e.indices))
    return False


def mentions_state(node: ast.Expr, scope: Scope) -> bool:
    """Return whether ``node`` reads a variable or let, or calls a function, which may."""
    symbols = scope.program.symbols
    own = symbols.members[scope.element] if scope.element is not None else {}
    for part in walk(node):
        match part:
            case ast.Name(_, name) if name not in scope.locals and name in own:
                return True
            case ast.Member(_, ast.Name(_, name) | ast.Index(_, ast.Name(_, name)), member) if (
                symbols.has_member(name, member)
            ):
                return True
            case ast.Call(_, name) if name in symbols.functions:
                return True
    return False
