# SPDX-License-Identifier: Apache-2.0
"""The names that a model declares, found before anything is checked."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

from hypgen.dsl.messages import e02_names
from hypgen.dsl.messages.diagnostic import did_you_mean
from hypgen.dsl.messages.report import Mistake, Report, gather
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast
from hypgen.dsl.types import Enum, Type
from hypgen.dsl.types.builtin_names import FOREIGN_VALUES, RESERVED_CALLS, RESERVED_VALUES

TypeItem = ast.TypeAlias | ast.EnumDecl | ast.RecordDecl
Value = ast.Const | ast.Param | ast.Action
Global = TypeItem | Value | ast.Function | ast.Element
StateMember = ast.Variable | ast.Let
PolicyMember = ast.Memory | ast.Let

_KINDS: dict[type[ast.Item], str] = {
    ast.Const: "a const",
    ast.Param: "a param",
    ast.TypeAlias: "a type",
    ast.EnumDecl: "an enum",
    ast.RecordDecl: "a record",
    ast.Function: "a function",
    ast.Action: "the action",
    ast.Element: "an element",
    ast.Variable: "a variable",
    ast.Let: "a let",
    ast.Memory: "memory",
}


def kind_of(item: ast.Item) -> str:
    """Return what ``item`` is, in words."""
    return _KINDS.get(type(item), "a declaration")


_CLOCKS = ("t", "time", "step", "now")  # what authors call the number of steps so far


@dataclass
class Symbols:
    """All declared names, in spaces that the grammar tells apart, so that one name may stand in several.

    A type stands behind ``:`` or ``in``, a function before ``(``, an element before ``.name``, a value alone.
    A record and a variant with an argument are called too; a variant without one stands alone. ``members``
    are each element's variables and lets, ``policy`` the default policy's memory and lets. ``declared`` has
    all but these in the order of the text. ``clashing`` are names that were taken, as they are written and,
    of members, with their element: what uses them says nothing more.
    """

    types: dict[str, TypeItem] = field(default_factory=dict)
    functions: dict[str, ast.Function] = field(default_factory=dict)
    elements: dict[str, ast.Element] = field(default_factory=dict)
    values: dict[str, Value] = field(default_factory=dict)
    members: dict[str, dict[str, StateMember]] = field(default_factory=dict)
    variants: dict[str, list[ast.EnumDecl]] = field(default_factory=dict)
    observations: dict[str, ast.Observe] = field(default_factory=dict)
    policy: dict[str, PolicyMember] = field(default_factory=dict)
    declared: list[Global] = field(default_factory=list)
    clashing: set[str] = field(default_factory=set)

    @property
    def actions(self) -> list[str]:
        """Return the action's name, if there is one."""
        return [name for name, item in self.values.items() if isinstance(item, ast.Action)]

    def record(self, name: str) -> ast.RecordDecl | None:
        """Return the record that a call of ``name`` makes."""
        item = self.types.get(name)
        return item if isinstance(item, ast.RecordDecl) else None

    def has_member(self, element: str, name: str) -> bool:
        """Return whether an element has a variable, a let or an observation of that name."""
        return name in self.members.get(element, {}) or f"{element}.{name}" in self.observations

    def plain_variant(self, name: str) -> ast.VariantDecl | None:
        """Return a variant of that name without an argument, which stands alone as a value does."""
        found = (v for enum in self.variants.get(name, []) for v in enum.variants if v.name == name)
        return next((v for v in found if v.argument is None), None)

    def other_kind(self, name: str) -> str | None:
        """Return what ``name`` is where it is no value, in words: ``a function``."""
        for space in (self.functions, self.elements, self.types):
            if name in space:
                return kind_of(space[name])
        return None

    def refuse_shadow(self, name: str, element: str | None, span: Span, *, in_policy: bool = False) -> None:
        """Raise if a local called ``name`` would hide a value visible in ``element`` or the policy."""
        taken: tuple[str, Span] | None = None
        if name in self.values:
            taken = kind_of(self.values[name]), self.values[name].span
        elif element is not None and name in self.members[element]:
            member = self.members[element][name]
            taken = f"{kind_of(member)} of '{element}'", member.span
        elif in_policy and name in self.policy:
            taken = f"{kind_of(self.policy[name])} of the policy", self.policy[name].span
        elif (variant := self.plain_variant(name)) is not None:
            taken = f"a variant of '{self.variants[name][0].name}'", variant.span
        elif name in RESERVED_VALUES:
            raise Mistake(e02_names.built_in(name, span))
        if taken is not None:
            raise Mistake(e02_names.shadows(name, taken[0], span, taken[1]))

    def is_taken(self, name: str) -> bool:
        """Return whether anything declared is called ``name``."""
        spaces = (self.types, self.functions, self.elements, self.values, self.variants, self.policy)
        is_member = any(name in own for own in self.members.values())
        return is_member or any(name in space for space in spaces)

    def suggestion(
        self, name: str, element: str | None, extra: set[str], expected: Type | None, primed: bool
    ) -> str:
        """Return a remedy for the unknown value ``name``, which stands where ``expected`` is needed."""
        known = (
            set(self.values)
            | set(self.elements)
            | set(self.variants)
            | extra
            | {*RESERVED_VALUES, "false", "true"}
        )
        if element is not None:
            known |= set(self.members[element])
        if name in FOREIGN_VALUES:
            return f"write {FOREIGN_VALUES[name]}"
        owner = next((e for e, members in self.members.items() if name in members), None)
        if owner is not None:
            item, prime = self.elements[owner], "'" * primed
            if item.binder is not None:
                member = item.binder.name
                read = f"{owner}[{member}].{name}{prime}"
                return f"each member of {owner} has it: write {read} of a member {member}"
            return f"it belongs to an element: write {owner}.{name}{prime}"
        if close := did_you_mean(name, known):
            return close
        if isinstance(expected, Enum):
            return f"'{expected.name}' has {', '.join(v.name for v in expected.variants)}"
        if name in _CLOCKS:
            count = f"visible {name}: 0 .. 99  init {name} = 0  {name}' = clamp({name} + 1)"
            return f"count steps in an element: {count}"
        return "declare it as a const, a param, a let or a variable"


def collect(file: ast.ModelFile, report: Report) -> Symbols:
    """Return the names that ``file`` declares; names that are taken are reported and the first one stays."""
    symbols = Symbols()
    declarations = [item for item in file.items if isinstance(item, Global)]
    actions = [item for item in declarations if isinstance(item, ast.Action)]
    for declaration in declarations:
        if declaration not in actions[1:]:  # further actions are refused as such, not as names
            report.attempt(partial(_declare, symbols, declaration))
    for item in file.items:
        match item:
            case ast.EnumDecl(name=name) if symbols.types.get(name) is item:
                report.attempt(partial(_declare_variants, symbols, item))
            case ast.Observe(name=name):
                report.attempt(partial(_declare_observation, symbols, item, name))
    for element in symbols.elements.values():
        for member in element.members:
            report.attempt(partial(_declare_member, symbols, element, member))
    for item in file.items:
        for part in item.members if isinstance(item, ast.Policy) else ():
            report.attempt(partial(_declare_policy_member, symbols, part))
    return symbols


def _clash(symbols: Symbols, name: str, span: Span, first: Span) -> Mistake:
    symbols.clashing.add(name)
    return Mistake(e02_names.duplicate(name, span, first))


def _declare(symbols: Symbols, item: Global) -> None:
    name = item.name
    others: list[Global | None]
    match item:
        case ast.Function():
            others = [symbols.functions.get(name), symbols.record(name)]
        case ast.Element():
            others = [symbols.elements.get(name), _enum(symbols, name)]
        case ast.RecordDecl():
            others = [symbols.types.get(name), symbols.functions.get(name)]
        case ast.EnumDecl():
            others = [symbols.types.get(name), symbols.elements.get(name), symbols.values.get(name)]
        case ast.TypeAlias():
            others = [symbols.types.get(name)]
        case _:
            others = [symbols.values.get(name), _enum(symbols, name)]
    first = next((other for other in others if other is not None), None)
    if first is not None:
        raise _clash(symbols, name, item.span, first.span)
    symbols.declared.append(item)
    match item:
        case ast.Function():
            symbols.functions[name] = item
        case ast.Element():
            symbols.elements[name] = item
            symbols.members[name] = {}
        case ast.TypeAlias() | ast.EnumDecl() | ast.RecordDecl():
            symbols.types[name] = item
        case _:
            symbols.values[name] = item
    is_built_in = name in (RESERVED_CALLS if isinstance(item, ast.Function) else RESERVED_VALUES)
    if is_built_in and not isinstance(item, ast.Element | TypeItem):
        symbols.clashing.add(name)
        raise Mistake(e02_names.built_in(name, item.span))


def _enum(symbols: Symbols, name: str) -> ast.EnumDecl | None:
    """Return the enum of that name: ``Enum.variant`` looks as a read of an element or a field does."""
    item = symbols.types.get(name)
    return item if isinstance(item, ast.EnumDecl) else None


def _declare_variants(symbols: Symbols, enum: ast.EnumDecl) -> None:
    seen: dict[str, Span] = {}
    gather([partial(_declare_variant, symbols, enum, variant, seen) for variant in enum.variants])


def _declare_variant(
    symbols: Symbols, enum: ast.EnumDecl, variant: ast.VariantDecl, seen: dict[str, Span]
) -> None:
    name = variant.name
    if name in seen:
        raise _clash(symbols, name, variant.span, seen[name])
    seen[name] = variant.span
    symbols.variants.setdefault(name, []).append(enum)
    other: ast.Item | None = symbols.values.get(name)
    if variant.argument is not None:
        if name in RESERVED_CALLS - {"at"}:  # which takes three arguments or more, and a variant one
            symbols.clashing.add(name)
            raise Mistake(e02_names.built_in(name, variant.span))
        other = symbols.functions.get(name) or symbols.record(name)
    if other is not None:
        raise _clash(symbols, name, variant.span, other.span)


def _declare_observation(symbols: Symbols, item: ast.Observe, name: str) -> None:
    if name in symbols.observations:
        raise _clash(symbols, name, item.span, symbols.observations[name].span)
    symbols.observations[name] = item


def _declare_policy_member(symbols: Symbols, member: ast.Item) -> None:
    if not isinstance(member, PolicyMember):
        return
    name = member.name
    first = symbols.policy.get(name) or symbols.observations.get(name)
    if first is not None:
        raise _clash(symbols, name, member.span, first.span)
    symbols.policy[name] = member
    _refuse_shadow(symbols, name, member.span)
    if name == "default":
        raise Mistake(e02_names.default_as_member(member.span))


def _declare_member(symbols: Symbols, element: ast.Element, member: ast.Item) -> None:
    if isinstance(member, ast.Observe):
        _declare_observation(symbols, member, f"{element.name}.{member.name}")
    if not isinstance(member, StateMember):
        return
    own, name = symbols.members[element.name], member.name
    if name in own:
        symbols.clashing.add(f"{element.name}.{name}")
        raise _clash(symbols, name, member.span, own[name].span)
    own[name] = member
    _refuse_shadow(symbols, name, member.span)
    if element.binder is not None and element.binder.name == name:
        raise _clash(symbols, name, member.span, element.binder.span)


def _refuse_shadow(symbols: Symbols, name: str, span: Span) -> None:
    """Raise if a member would hide a value; it stays declared, so that nothing more is said of it."""
    try:
        symbols.refuse_shadow(name, None, span)
    except Mistake:
        symbols.clashing.add(name)
        raise
