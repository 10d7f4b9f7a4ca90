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
from hypgen.dsl.types.builtin_names import RESERVED_CALLS, RESERVED_VALUES

Global = (
    ast.Const
    | ast.Param
    | ast.TypeAlias
    | ast.EnumDecl
    | ast.RecordDecl
    | ast.Function
    | ast.Action
    | ast.Element
)
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


@dataclass
class Symbols:
    """All declared names: global ones, each element's variables and lets, and variants with their enums.

    ``policy`` has the default policy's memory and lets.
    """

    globals: dict[str, Global] = field(default_factory=dict)
    members: dict[str, dict[str, StateMember]] = field(default_factory=dict)
    variants: dict[str, list[ast.EnumDecl]] = field(default_factory=dict)
    observations: dict[str, ast.Observe] = field(default_factory=dict)
    policy: dict[str, PolicyMember] = field(default_factory=dict)

    def refuse_shadow(self, name: str, element: str | None, span: Span, *, in_policy: bool = False) -> None:
        """Raise if a local called ``name`` would hide something visible in ``element`` or the policy."""
        taken: tuple[str, Span] | None = None
        if name in self.globals:
            taken = kind_of(self.globals[name]), self.globals[name].span
        elif element is not None and name in self.members[element]:
            member = self.members[element][name]
            taken = f"{kind_of(member)} of '{element}'", member.span
        elif in_policy and name in self.policy:
            taken = f"{kind_of(self.policy[name])} of the policy", self.policy[name].span
        elif name in self.variants:
            taken = f"a variant of '{self.variants[name][0].name}'", self.variants[name][0].span
        elif name in RESERVED_VALUES:
            raise Mistake(e02_names.built_in(name, span))
        if taken is not None:
            raise Mistake(e02_names.shadows(name, taken[0], span, taken[1]))

    def is_taken(self, name: str) -> bool:
        """Return whether anything declared is called ``name``."""
        return (
            name in self.globals
            or name in self.variants
            or name in self.policy
            or any(name in members for members in self.members.values())
        )

    def suggestion(
        self, name: str, element: str | None, extra: set[str], expected: Type | None, primed: bool
    ) -> str:
        """Return a remedy for the unknown value ``name``, which stands where ``expected`` is needed."""
        known = set(self.globals) | set(self.variants) | extra | {*RESERVED_VALUES, "false", "true"}
        if element is not None:
            known |= set(self.members[element])
        owner = next((e for e, members in self.members.items() if name in members), None)
        if owner is not None:
            item, prime = self.globals[owner], "'" * primed
            if isinstance(item, ast.Element) and item.binder is not None:
                member = item.binder.name
                read = f"{owner}[{member}].{name}{prime}"
                return f"each member of {owner} has it: write {read} of a member {member}"
            return f"it belongs to an element: write {owner}.{name}{prime}"
        if close := did_you_mean(name, known):
            return close
        if isinstance(expected, Enum):
            return f"'{expected.name}' has {', '.join(v.name for v in expected.variants)}"
        return "declare it as a const, a param, a let or a variable"


def collect(file: ast.ModelFile, report: Report) -> Symbols:
    """Return the names that ``file`` declares; duplicates are reported and the first one stays."""
    symbols = Symbols()
    declarations = [item for item in file.items if isinstance(item, Global)]
    actions = [item for item in declarations if isinstance(item, ast.Action)]
    for declaration in declarations:
        if declaration not in actions[1:]:  # further actions are refused as such, not as names
            report.attempt(partial(_declare, symbols, declaration))
    for item in file.items:
        match item:
            case ast.EnumDecl(name=name) if symbols.globals.get(name) is item:
                report.attempt(partial(_declare_variants, symbols, item))
            case ast.Observe(name=name):
                report.attempt(partial(_declare_observation, symbols, item, name))
    for element in declarations:
        if isinstance(element, ast.Element) and symbols.globals.get(element.name) is element:
            for member in element.members:
                report.attempt(partial(_declare_member, symbols, element, member))
    for item in file.items:
        for part in item.members if isinstance(item, ast.Policy) else ():
            report.attempt(partial(_declare_policy_member, symbols, part))
    return symbols


def _declare(symbols: Symbols, item: Global) -> None:
    if item.name in symbols.globals:
        raise Mistake(e02_names.duplicate(item.name, item.span, symbols.globals[item.name].span))
    symbols.globals[item.name] = item
    if isinstance(item, ast.Element):
        symbols.members[item.name] = {}
    if item.name in RESERVED_VALUES or (isinstance(item, ast.Function) and item.name in RESERVED_CALLS):
        raise Mistake(e02_names.built_in(item.name, item.span))


def _declare_variants(symbols: Symbols, enum: ast.EnumDecl) -> None:
    seen: dict[str, Span] = {}
    gather([partial(_declare_variant, symbols, enum, variant, seen) for variant in enum.variants])


def _declare_variant(
    symbols: Symbols, enum: ast.EnumDecl, variant: ast.VariantDecl, seen: dict[str, Span]
) -> None:
    if variant.name in seen:
        raise Mistake(e02_names.duplicate(variant.name, variant.span, seen[variant.name]))
    if variant.name in symbols.globals:
        raise Mistake(e02_names.duplicate(variant.name, variant.span, symbols.globals[variant.name].span))
    seen[variant.name] = variant.span
    symbols.variants.setdefault(variant.name, []).append(enum)


def _declare_observation(symbols: Symbols, item: ast.Observe, name: str) -> None:
    if name in symbols.observations:
        raise Mistake(e02_names.duplicate(name, item.span, symbols.observations[name].span))
    symbols.observations[name] = item


def _declare_policy_member(symbols: Symbols, member: ast.Item) -> None:
    if not isinstance(member, PolicyMember):
        return
    first = symbols.policy.get(member.name) or symbols.observations.get(member.name)
    if first is not None:
        raise Mistake(e02_names.duplicate(member.name, member.span, first.span))
    symbols.refuse_shadow(member.name, None, member.span)
    symbols.policy[member.name] = member
    if member.name == "default":
        raise Mistake(e02_names.default_as_member(member.span))


def _declare_member(symbols: Symbols, element: ast.Element, member: ast.Item) -> None:
    if isinstance(member, ast.Observe):
        _declare_observation(symbols, member, f"{element.name}.{member.name}")
    if not isinstance(member, StateMember):
        return
    own = symbols.members[element.name]
    if member.name in own:
        raise Mistake(e02_names.duplicate(member.name, member.span, own[member.name].span))
    symbols.refuse_shadow(member.name, None, member.span)
    if element.binder is not None and element.binder.name == member.name:
        raise Mistake(e02_names.duplicate(member.name, member.span, element.binder.span))
    own[member.name] = member
