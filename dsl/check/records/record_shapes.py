# SPDX-License-Identifier: Apache-2.0
"""Names and expressions of a file that stand for records of floats, told from the syntax alone.

A record with a float among its fields is not finite: it is no binder, index or action.
``leaves`` takes everything of such a type apart; what it must know for that stands here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from hypgen.dsl.messages import e02_names
from hypgen.dsl.messages.report import Mistake
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax import ast

_FLOATS = ("float", "prob")


@dataclass(frozen=True)
class Shape:
    """A record of floats, or an array of them."""

    record: ast.RecordDecl
    array: bool = False


@dataclass(frozen=True)
class Names:
    """What names mean inside a declaration: the element's members and the locals that are records."""

    element: str | None = None
    locals: Mapping[str, Shape | None] = field(default_factory=dict)


class Shapes:
    """The records of floats that ``file`` declares, and what has their types."""

    def __init__(self, file: ast.ModelFile) -> None:
        self._types: dict[str, ast.RecordDecl | ast.TypeAlias] = {}
        self._values: dict[str, ast.Const | ast.Param | ast.Observe] = {}
        self._functions: dict[str, ast.Function] = {}
        self._members: dict[str, dict[str, ast.Variable | ast.Let | ast.Observe]] = {}
        self._active: set[str] = set()
        self._lets: dict[tuple[str, str], Shape | None] = {}
        for item in file.items:
            if isinstance(item, ast.RecordDecl | ast.TypeAlias):
                self._types.setdefault(item.name, item)
            elif isinstance(item, ast.Const | ast.Param | ast.Observe):
                self._values.setdefault(item.name, item)
            elif isinstance(item, ast.Function):
                self._functions.setdefault(item.name, item)
            elif isinstance(item, ast.Element):
                own = [m for m in item.members if isinstance(m, ast.Variable | ast.Let | ast.Observe)]
                self._members.setdefault(item.name, {m.name: m for m in reversed(own)})

    # Types ---------------------------------------------------------------------------------------

    def record(self, name: str) -> ast.RecordDecl | None:
        """Return the record of floats that is called ``name``."""
        item = self._types.get(name)
        return item if isinstance(item, ast.RecordDecl) and self._has_float(item) else None

    def _has_float(self, record: ast.RecordDecl) -> bool:
        seen = {record.name}
        waiting = [f.type for f in record.fields]
        while waiting:
            node = waiting.pop()
            if not isinstance(node, ast.TypeName) or node.name in seen:
                continue
            seen.add(node.name)
            item = self._types.get(node.name)
            if isinstance(item, ast.TypeAlias):
                waiting.append(item.type)
            elif isinstance(item, ast.RecordDecl):
                waiting += [f.type for f in item.fields]
            elif node.name in _FLOATS:
                return True
        return False

    def resolved(self, node: ast.TypeExpr) -> ast.TypeExpr:
        """Return what a type is called at the end of its aliases."""
        seen: set[str] = set()
        while isinstance(node, ast.TypeName) and node.name not in seen:
            item = self._types.get(node.name)
            if not isinstance(item, ast.TypeAlias):
                break
            seen.add(node.name)
            node = item.type
        return node

    def of_type(self, node: ast.TypeExpr) -> Shape | None:
        """Return the shape of values of a type, None if they are no records of floats."""
        node = self.resolved(node)
        if isinstance(node, ast.TypeArray):
            inner = self.of_type(node.element)
            return None if inner is None else replace(inner, array=True)
        found = self.record(node.name) if isinstance(node, ast.TypeName) else None
        return None if found is None else Shape(found)

    def field(self, record: ast.RecordDecl, name: str) -> ast.FieldDecl | None:
        """Return a record's field."""
        return next((f for f in record.fields if f.name == name), None)

    def leaves(self, record: ast.RecordDecl) -> Iterator[tuple[tuple[str, ...], ast.TypeExpr]]:
        """Yield the path and the type of each scalar in a record of floats, in order."""
        for part in record.fields:
            inner = self.of_type(part.type)
            if inner is None:
                yield (part.name,), part.type
            elif inner.record.name not in self._active:
                self._active.add(inner.record.name)
                for path, t in self.leaves(inner.record):
                    yield (part.name, *path), t
                self._active.discard(inner.record.name)

    # Expressions ---------------------------------------------------------------------------------

    def of(self, e: ast.Expr, names: Names) -> Shape | None:
        """Return the shape of an expression, None if it is no record of floats."""
        match e:
            case ast.Name(_, name):
                return self._of_name(name, names)
            case ast.Member(_, operand, name):
                return self._of_member(operand, name, names)
            case ast.Index(_, operand, _):
                inner = self.of(operand, names)
                return None if inner is None or not inner.array else replace(inner, array=False)
            case ast.Call(_, name, arguments):
                item = self._functions.get(name)
                if item is not None:
                    return self.of_type(item.type)
                if name in ("at", "last") and arguments:
                    return self.of(arguments[-1], names)
                found = self.record(name)
                return None if found is None else Shape(found)
            case ast.Prime(_, operand) | ast.With(_, operand):
                return self.of(operand, names)
            case ast.If(_, _, then, otherwise):
                return self.of(then, names) or self.of(otherwise, names)
            case ast.LetIn(_, name, _, body):
                return self.of(body, self.bound(name, self.of_local(e, names), names))
            case ast.Match(_, _, arms):
                return next(filter(None, (self.of(a.body, names) for a in arms)), None)
        return None

    def bound(self, name: str, shape: Shape | None, names: Names) -> Names:
        """Return ``names`` with a local more."""
        return replace(names, locals={**names.locals, name: shape})

    def refuse_shadow(self, name: str, names: Names, span: Span) -> None:
        """Raise if a local called ``name`` would hide a record."""
        if self._of_name(name, names) is not None:
            raise Mistake(e02_names.shadows_record(name, span))

    def function(self, name: str) -> ast.Function | None:
        """Return the function called ``name``."""
        return self._functions.get(name)

    def of_local(self, e: ast.LetIn, names: Names) -> Shape | None:
        """Return the shape of what ``let .. in`` names."""
        return self.of(e.value, names) if e.type is None else self.of_type(e.type)

    def of_let(self, item: ast.Let, names: Names) -> Shape | None:
        """Return the shape of a let that is declared where ``names`` hold."""
        return self.of(item.rhs.expr, names) if item.type is None else self.of_type(item.type)

    def variable(self, element: str, name: str) -> Shape | None:
        """Return the shape of an element's variable or observation."""
        item = self._members.get(element, {}).get(name)
        return self.of_type(item.type) if isinstance(item, ast.Variable | ast.Observe) else None

    def item(self, name: str) -> Shape | None:
        """Return the shape of a const, a param or an observation."""
        item = self._values.get(name)
        return None if item is None else self.of_type(item.type)

    def element_of(self, e: ast.Expr, member: str) -> str | None:
        """Return the element with such a member that ``e`` names, with or without an index."""
        operand = e.operand if isinstance(e, ast.Index) else e
        if not isinstance(operand, ast.Name) or member not in self._members.get(operand.name, {}):
            return None
        return operand.name

    def _of_name(self, name: str, names: Names) -> Shape | None:
        if name in names.locals:
            return names.locals[name]
        if names.element is not None and name in self._members.get(names.element, {}):
            return self._of_own(names.element, name)
        return self.item(name)

    def _of_member(self, operand: ast.Expr, name: str, names: Names) -> Shape | None:
        element = self.element_of(operand, name)
        if element is not None:
            return self._of_own(element, name)
        outer = self.of(operand, names)
        part = None if outer is None or outer.array else self.field(outer.record, name)
        return None if part is None else self.of_type(part.type)

    def _of_own(self, element: str, name: str) -> Shape | None:
        """Return the shape of an element's variable or let."""
        item = self._members[element].get(name)
        if not isinstance(item, ast.Let):
            return self.variable(element, name)
        key = (element, name)
        if key not in self._lets:
            self._lets[key] = None  # what a let that reads itself has; that is reported elsewhere
            self._lets[key] = self.of_let(item, Names(element))
        return self._lets[key]
