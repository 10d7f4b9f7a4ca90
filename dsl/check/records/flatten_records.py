# SPDX-License-Identifier: Apache-2.0
"""Records of floats taken apart: each becomes the scalars in it, before anything is checked.

``hidden at: Vec`` becomes the variables ``at.x`` and ``at.y``; a function of such a type becomes one for each
leaf; an expression of such a type is asked for one leaf at a time. What comes after sees scalars only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

from hypgen.dsl.check.records.record_shapes import Names, Shape, Shapes
from hypgen.dsl.check.scope.draw_syntax import fields_of_record
from hypgen.dsl.messages import e02_names, e03_calls, e03_values, e07_draws
from hypgen.dsl.messages.report import Mistake, Report, gather
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.walk import map_expressions, walk
from hypgen.dsl.types.builtin_names import DRAWS

Path = tuple[str, ...]
Overrides = Mapping[str, ast.Expr]


def flatten(
    file: ast.ModelFile, overrides: Overrides, report: Report
) -> tuple[ast.ModelFile, dict[str, ast.Expr]]:
    """Return the model and the settings without records of floats; reports how they are misused."""
    shapes = Shapes(file)
    if not any(isinstance(i, ast.RecordDecl) and shapes.record(i.name) for i in file.items):
        return file, dict(overrides)
    flattener = _Flattener(shapes)
    items: list[ast.Item] = []
    for item in file.items:
        items += report.attempt(partial(flattener.item, item, Names())) or ()
    settings: dict[str, ast.Expr] = {}
    for name, value in overrides.items():
        settings |= report.attempt(partial(flattener.setting, name, value)) or {}
    return replace(file, items=tuple(items)), settings


class _Flattener:
    def __init__(self, shapes: Shapes) -> None:
        self.shapes = shapes

    # Declarations --------------------------------------------------------------------------------

    def item(self, item: ast.Item, names: Names) -> list[ast.Item]:
        """Return a declaration's leaves; itself, with its expressions rewritten, if it is no record."""
        match item:
            case ast.Element(members=members):
                inner = Names(item.name)
                own = gather([partial(self.item, m, inner) for m in members])
                return [replace(item, members=tuple(m for part in own for m in part))]
            case ast.Function():
                return self._function(item)
            case ast.Const(name=name, value=value) if shape := self.shapes.item(name):
                return [
                    replace(item, name=n, type=t, value=self.leaf(value, shape, path, names))
                    for n, t, path in self._leaves(name, item.type, shape)
                ]
            case ast.Param(name=name, default=default) if shape := self.shapes.item(name):
                return [
                    replace(
                        item,
                        name=n,
                        type=t,
                        default=None if default is None else self.leaf(default, shape, path, names),
                    )
                    for n, t, path in self._leaves(name, item.type, shape)
                ]
            case ast.Variable(name=name) if shape := self.shapes.of_type(item.type):
                return [replace(item, name=n, type=t) for n, t, _ in self._leaves(name, item.type, shape)]
            case ast.Observe(name=name, rhs=rhs) if shape := self.shapes.of_type(item.type):
                return [
                    replace(item, name=n, type=t, rhs=self._rhs(rhs, shape, path, names))
                    for n, t, path in self._leaves(name, item.type, shape)
                ]
            case ast.Init(name=name, rhs=rhs) | ast.Update(name=name, rhs=rhs) if (
                names.element is not None and (shape := self.shapes.variable(names.element, name))
            ):
                return [
                    replace(item, name=_joined(name, path), rhs=self._rhs(rhs, shape, path, names))
                    for path, _ in self.shapes.leaves(shape.record)
                ]
            case ast.Policy(members=members):
                for let in members:
                    if isinstance(let, ast.Let):
                        names = self.shapes.bound(let.name, self.shapes.of_let(let, names), names)
                own = gather([partial(self.item, m, names) for m in members])
                rhs = replace(item.rhs, expr=self.scalar(item.rhs.expr, names))
                kinds = ast.Memory | ast.Let | ast.Update
                kept = tuple(m for part in own for m in part if isinstance(m, kinds))
                return [replace(item, rhs=rhs, members=kept)]
            case ast.Let(name=name) if shape := self.shapes.of(ast.Name(item.span, name), names):
                return [
                    replace(
                        item,
                        name=_joined(name, path),
                        type=None if item.type is None else t,
                        rhs=self._rhs(item.rhs, shape, path, names),
                    )
                    for path, t in self.shapes.leaves(shape.record)
                ]
        return [map_expressions(item, lambda e: self.scalar(e, names))]

    def setting(self, name: str, value: ast.Expr) -> dict[str, ast.Expr]:
        """Return the settings of the leaves of a const or param."""
        shape = self.shapes.item(name)
        if shape is None:
            return {name: value}
        leaves = self.shapes.leaves(shape.record)
        return {_joined(name, path): self.leaf(value, shape, path, Names()) for path, _ in leaves}

    def _leaves(self, name: str, node: ast.TypeExpr, shape: Shape) -> list[tuple[str, ast.TypeExpr, Path]]:
        """Return the names, types and paths of a declaration's leaves."""
        array = self.shapes.resolved(node)
        result = []
        for path, leaf in self.shapes.leaves(shape.record):
            t = ast.TypeArray(node.span, leaf, array.indices) if isinstance(array, ast.TypeArray) else leaf
            result.append((_joined(name, path), t, path))
        return result

    def _function(self, item: ast.Function) -> list[ast.Item]:
        formals: list[ast.FieldDecl] = []
        names = Names()
        for formal in item.formals:
            shape = self.shapes.of_type(formal.type)
            self.shapes.refuse_shadow(formal.name, Names(), formal.span)
            names = self.shapes.bound(formal.name, shape, names)
            if shape is None:
                formals.append(formal)
            else:
                formals += [
                    replace(formal, name=n, type=t)
                    for n, t, _ in self._leaves(formal.name, formal.type, shape)
                ]
        result = self.shapes.of_type(item.type)
        if result is None:
            rhs = replace(item.rhs, expr=self.scalar(item.rhs.expr, names))
            return [replace(item, formals=tuple(formals), rhs=rhs)]
        return [
            replace(
                item,
                name=_joined(item.name, path),
                formals=tuple(formals),
                type=t,
                rhs=self._rhs(item.rhs, result, path, names),
            )
            for path, t in self.shapes.leaves(result.record)
        ]

    def _rhs(self, rhs: ast.Rhs, shape: Shape, path: Path, names: Names) -> ast.Rhs:
        return replace(rhs, expr=self.leaf(rhs.expr, shape, path, names))

    # Expressions ---------------------------------------------------------------------------------

    def leaf(self, e: ast.Expr, shape: Shape, path: Path, names: Names) -> ast.Expr:
        """Return the scalar at ``path`` in a record (in each entry of an array of records)."""
        if self._draws_once(e):
            raise Mistake(e07_draws.draw_for_record(shape.record.name, self._form(shape.record), e.span))
        match e:
            case ast.If(_, condition, then, otherwise):
                return replace(
                    e,
                    condition=self.scalar(condition, names),
                    then=self.leaf(then, shape, path, names),
                    otherwise=self.leaf(otherwise, shape, path, names),
                )
            case ast.Match(_, scrutinee, arms):
                inner = [replace(a, body=self.leaf(a.body, shape, path, self._arm(a, names))) for a in arms]
                return replace(e, scrutinee=self.scalar(scrutinee, names), arms=tuple(inner))
            case ast.LetIn():
                return self._let_in(e, names, lambda body, inner: self.leaf(body, shape, path, inner))
            case ast.Prime(_, operand):
                return replace(e, operand=self.leaf(operand, shape, path, names))
            case ast.Comprehension(_, binders, body) if shape.array:
                for binder in binders:
                    self.shapes.refuse_shadow(binder.name, names, binder.span)
                return replace(e, body=self.leaf(body, self._entry(body, shape), path, names))
            case ast.ArrayLiteral(_, items) if shape.array:
                entries = [self.leaf(i, self._entry(i, shape), path, names) for i in items]
                return replace(e, items=tuple(entries))
        found = self.shapes.of(e, names)
        if found is None or found.record.name != shape.record.name or found.array != shape.array:
            raise self._mismatch(e, shape, found)
        match e:
            case ast.Name(_, name):
                return replace(e, name=_joined(name, path))
            case ast.Member(_, operand, name):
                if self.shapes.element_of(operand, name) is not None:
                    return replace(e, operand=self._element(operand, names), name=_joined(name, path))
                outer = self.shapes.of(operand, names)
                assert outer is not None, "a member that is a record belongs to one"
                return self.leaf(operand, outer, (name, *path), names)
            case ast.Index(_, operand, indices):
                array = self.leaf(operand, replace(shape, array=True), path, names)
                return replace(e, operand=array, indices=tuple(self.scalar(i, names) for i in indices))
            case ast.With():
                return self._changed(e, shape, path, names)
            case ast.Call():
                return self._call(e, shape, path, names)
        raise AssertionError(e)

    def _draws_once(self, e: ast.Expr) -> bool:
        """Return whether one draw decides several fields, which are drawn apart."""
        match e:
            case ast.LetIn(draw=True):
                return True
            case ast.If(_, part) | ast.Match(_, part):
                return self._draws(part)
            case ast.Call(_, name, arguments) if self.shapes.function(name) is not None:
                return any(map(self._draws, arguments))
        return False

    def _draws(self, e: ast.Expr) -> bool:
        """Return whether anything in ``e`` is a draw."""
        for inner in walk(e):
            if isinstance(inner, ast.Expr) and _draws(inner):
                return True
            item = self.shapes.function(inner.name) if isinstance(inner, ast.Call) else None
            if item is not None and item.rhs.draw:
                return True
        return False

    def _entry(self, node: ast.Expr, shape: Shape) -> Shape:
        """Return the shape of an entry: of an array of several indexes, rows may be written one by one."""
        return (
            shape if isinstance(node, ast.Comprehension | ast.ArrayLiteral) else replace(shape, array=False)
        )

    def _call(self, e: ast.Call, shape: Shape, path: Path, names: Names) -> ast.Expr:
        """Return a leaf of the value of a constructor, a function, ``at`` or ``last``."""
        if self.shapes.function(e.name) is not None:
            return replace(e, name=_joined(e.name, path), arguments=self._arguments(e, names))
        if e.name == "last" and len(e.arguments) == 2:
            what, first = e.arguments
            return replace(e, arguments=tuple(self.leaf(part, shape, path, names) for part in (what, first)))
        if e.name == "at":
            array = self.leaf(e.arguments[0], replace(shape, array=True), path, names)
            indices = [self.scalar(i, names) for i in e.arguments[1:-1]]
            return replace(e, arguments=(array, *indices, self.leaf(e.arguments[-1], shape, path, names)))
        parts = shape.record.fields
        if len(e.arguments) != len(parts):
            form = self._form(shape.record)
            raise Mistake(e03_calls.wrong_fields(e.name, len(parts), len(e.arguments), form, e.span))
        taken = None
        for part, argument in zip(parts, e.arguments, strict=True):
            inner = self.shapes.of_type(part.type)
            here = part.name == path[0]
            # All are rewritten, so that a mistake in one is told whichever leaf is asked for.
            if inner is None:
                found = self.scalar(argument, names)
            else:
                rest = path[1:] if here else next(p for p, _ in self.shapes.leaves(inner.record))
                found = self.leaf(argument, inner, rest, names)
            taken = found if here else taken
        assert taken is not None, "a leaf's path starts with a field"
        return taken

    def _changed(self, e: ast.With, shape: Shape, path: Path, names: Names) -> ast.Expr:
        """Return a leaf of a record with changed fields: of the new value, or of the record."""
        found = None
        for field in e.fields:
            part = self.shapes.field(shape.record, field.name)
            if part is None:
                known = [f.name for f in shape.record.fields]
                raise Mistake(e02_names.unknown_field(shape.record.name, field.name, known, field.span))
            inner, here = self.shapes.of_type(part.type), field.name == path[0]
            if inner is None:
                value = self.scalar(field.value, names)
            else:
                rest = path[1:] if here else next(p for p, _ in self.shapes.leaves(inner.record))
                value = self.leaf(field.value, inner, rest, names)
            found = value if here else found
        return self.leaf(e.operand, shape, path, names) if found is None else found

    def _arguments(self, e: ast.Call, names: Names) -> tuple[ast.Expr, ...]:
        """Return a function's arguments with each record as its leaves."""
        item = self.shapes.function(e.name)
        assert item is not None
        if len(e.arguments) != len(item.formals):
            form = f"{e.name}({', '.join(f.name for f in item.formals)})"
            has = len(e.arguments)
            raise Mistake(e03_calls.wrong_arguments(e.name, len(item.formals), has, form, e.span))
        result: list[ast.Expr] = []
        for formal, argument in zip(item.formals, e.arguments, strict=True):
            shape = self.shapes.of_type(formal.type)
            if shape is None:
                result.append(self.scalar(argument, names))
            else:
                leaves = self.shapes.leaves(shape.record)
                result += [self.leaf(argument, shape, path, names) for path, _ in leaves]
        return tuple(result)

    def _let_in(self, e: ast.LetIn, names: Names, rewrite: Callable[[ast.Expr, Names], ast.Expr]) -> ast.Expr:
        """Return ``let v = e in body``, a local for each leaf where the value is a record."""
        self.shapes.refuse_shadow(e.name, names, e.span)
        shape = self.shapes.of_local(e, names)
        body = rewrite(e.body, self.shapes.bound(e.name, shape, names))
        if shape is None:
            return replace(e, value=self.scalar(e.value, names), body=body)
        for path, t in reversed(list(self.shapes.leaves(shape.record))):
            value = self.leaf(e.value, shape, path, names)
            kind = None if e.type is None else t
            body = replace(e, name=_joined(e.name, path), value=value, body=body, type=kind)
        return body

    def _arm(self, arm: ast.Arm, names: Names) -> Names:
        for pattern in arm.patterns:
            if pattern.argument is not None:
                self.shapes.refuse_shadow(pattern.argument, names, pattern.span)
                names = self.shapes.bound(pattern.argument, None, names)
        return names

    def scalar(self, e: ast.Expr, names: Names) -> ast.Expr:
        """Return an expression that is no record with every record inside it taken apart."""
        shape = self.shapes.of(e, names)
        if shape is not None:
            leaves = [".".join(path) for path, _ in self.shapes.leaves(shape.record)]
            raise Mistake(e03_values.record_for_value(_described(shape), leaves, e.span))
        match e:
            case ast.Member(_, operand, name) if self.shapes.element_of(operand, name) is not None:
                return replace(e, operand=self._element(operand, names))
            case ast.Member(_, operand, name) if (outer := self.shapes.of(operand, names)) is not None:
                part = None if outer.array else self.shapes.field(outer.record, name)
                if part is None:
                    raise self._no_field(e, outer)
                return self.leaf(operand, outer, (name,), names)
            case ast.Call(_, name) if self.shapes.function(name) is not None and self._takes_records(name):
                return replace(e, arguments=self._arguments(e, names))
            case ast.LetIn():
                return self._let_in(e, names, self.scalar)
            case ast.Quantified(binders=binders) | ast.Comprehension(binders=binders):
                for binder in binders:
                    self.shapes.refuse_shadow(binder.name, names, binder.span)
                    names = self.shapes.bound(binder.name, None, names)
            case ast.Match(_, scrutinee, arms):
                inner = [replace(a, body=self.scalar(a.body, self._arm(a, names))) for a in arms]
                return replace(e, scrutinee=self.scalar(scrutinee, names), arms=tuple(inner))
        return map_expressions(e, lambda part: self.scalar(part, names))

    def _element(self, e: ast.Expr, names: Names) -> ast.Expr:
        """Return an element or a member of it with its index rewritten; a record may have its name."""
        if not isinstance(e, ast.Index):
            return e
        return replace(e, indices=tuple(self.scalar(i, names) for i in e.indices))

    def _takes_records(self, name: str) -> bool:
        item = self.shapes.function(name)
        return item is not None and any(self.shapes.of_type(f.type) for f in item.formals)

    # Mistakes ------------------------------------------------------------------------------------

    def _form(self, record: ast.RecordDecl) -> str:
        return f"{record.name}({', '.join(f.name for f in record.fields)})"

    def _no_field(self, e: ast.Member, shape: Shape) -> Mistake:
        if shape.array:
            return Mistake(e03_calls.field_of_record_array(shape.record.name, e.name, e.span))
        known = [f.name for f in shape.record.fields]
        return Mistake(e02_names.unknown_field(shape.record.name, e.name, known, e.span))

    def _mismatch(self, e: ast.Expr, shape: Shape, found: Shape | None) -> Mistake:
        wanted = self._form(shape.record)
        literal = fields_of_record(e, shape.record.name, [f.name for f in shape.record.fields])
        if literal is not None:
            return literal
        if _draws(e):
            return Mistake(e07_draws.draw_for_record(shape.record.name, wanted, e.span))
        given = "" if found is None else _described(found)
        form = f"[i in ..: {wanted}]" if shape.array else wanted
        return Mistake(e03_values.record_needed(_described(shape), given, form, e.span))


def _described(shape: Shape) -> str:
    return f"{'an array of records' if shape.array else 'a record'} '{shape.record.name}'"


def _draws(e: ast.Expr) -> bool:
    match e:
        case ast.Call(_, name):
            return name in DRAWS
        case ast.Quantified(_, kind):
            return kind in DRAWS
    return isinstance(e, ast.TableLiteral)


def _joined(name: str, path: Path) -> str:
    return ".".join((name, *path))
