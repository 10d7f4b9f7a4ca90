# SPDX-License-Identifier: Apache-2.0
"""The descriptor: what the solver tells people about a model, and what a parameter file may set."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import reduce

from hypgen.codegen.cpp import template_data
from hypgen.codegen.cpp.body_printer import Context
from hypgen.codegen.cpp.function_builder import laid_out
from hypgen.codegen.cpp.key_codes import KeyLayout
from hypgen.codegen.cpp.text import from_int32, value_of
from hypgen.codegen.layout.naming import Scope
from hypgen.codegen.model.c_header import CHeader
from hypgen.codegen.model.value_fields import hidden_fields, number, places, seen_fields, visible_fields
from hypgen.codegen.tree.code import Code
from hypgen.codegen.tree.expr import (
    FALSE,
    TRUE,
    Choice,
    Expr,
    Literal,
    Operand,
    braces,
    call,
    following,
    member,
    method,
    of,
    op,
)
from hypgen.codegen.tree.lines import statements
from hypgen.codegen.tree.statements import (
    Declare,
    Do,
    Function,
    Return,
    Statement,
    assign,
    const,
    for_below,
    var,
    when,
)
from hypgen.dsl import ir
from hypgen.dsl.ir.rounding import Rounding
from hypgen.dsl.ir.undefined import may_be_undefined
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import (
    Bool,
    Enum,
    Float,
    Int,
    Record,
    Type,
    flat_indices,
    length_of,
    low_of,
    size_of,
)

# Variable names are for people who read traces; nobody reads more of them than this.
_NAMES = "std::vector<std::string>"
_PARAMS = member("model", "params")
_MAX_VARIABLE_NAMES = 4096


def main_view(context: Context, project: template_data.Project) -> template_data.Main:
    """Return the view of ``library.cpp``."""
    return _Descriptor(context).view(project, exact=False)


def library_view(context: Context, project: template_data.Project) -> template_data.Library:
    """Return what solvers and libraries say of all values that their callers give and get."""
    model, names = context.model, _Descriptor(context).name_functions
    header = CHeader(model, project.stem)
    return template_data.Library(
        tuple(visible_fields(model, names)),
        tuple(seen_fields(model, names)),
        tuple(hidden_fields(model, names)),
        header.enumerators(),
        header.functions(),
    )


def exact_view(
    context: Context, project: template_data.Project, rounded: tuple[Rounding, Rounding]
) -> template_data.Main:
    """Return the view of ``exact.cpp``, which names the values of states too.

    ``rounded`` tells how far the model is from its text, with the params of the text and with any.
    """
    ends = ((repr(n) if math.isfinite(n) else "HUGE_VAL" for n in one) for one in rounded)
    texts = tuple(f"{{{', '.join(one)}}}" for one in ends)
    return replace(_Descriptor(context).view(project, exact=True), rounding=texts)


def doubtful_terms(model: ir.Model, file: str) -> Iterator[str]:
    """Yield the bounds and rewards that may be no number, each with its place in a file."""
    functions = {f.name: f for f in model.functions}
    terms: list[tuple[str, ir.Expr | None, Span | None]] = [
        (f"bound {name}", getattr(model, name), model.spans.get(name)) for name in ("upper", "lower", "tail")
    ]
    terms += [(f"reward '{r.name}'", r.value, r.span) for r in model.rewards]
    for name, value, span in terms:
        if value is not None and span is not None and may_be_undefined((value,), functions):
            yield f"{name} ({file}:{span.line})"


def _string(text: str) -> str:
    return json.dumps(text)


class _Descriptor:
    def __init__(self, context: Context) -> None:
        self.context = context
        self.model = context.model
        scope = Scope(
            {"std", "hypgen", "descriptor", "main", "Model", "names", "action_names", "observation_name"}
            | {"value_names", "exact", "model", "first_observation_name", "hidden_value_name"}
        )
        coded: list[Enum | Record] = [*self.model.enums, *self.model.records]
        self.name_functions = {t.name: scope.unique(f"name_of_{t.name}") for t in coded}

    def view(self, project: template_data.Project, exact: bool) -> template_data.Main:
        """Return the view."""
        shown: list[Type] = [self.model.action.type, *(k.type for k in self.model.key)]
        shown += [p.type for p in self.model.params]
        shown += [v.type for v in self.model.variables]
        functions = [self._type_name(t) for t in self._named_types(shown)]
        functions += [self._action_names(), self._observation_name()]
        functions += [self._first_observation_name()] if self.model.first_seen else []
        functions += [self._value_names()] if exact else []
        functions += [self._hidden_value_name()] if not exact and self._has_hidden_names() else []
        return template_data.Main(
            project.banner,
            f"{project.stem}.hpp",
            self.context.names.model,
            tuple(functions),
            self._settings(project, exact),
        )

    def _named_types(self, shown: Iterable[Type]) -> list[Enum | Record]:
        """Return the enums and records that naming values of some types takes, contained ones first."""
        found: dict[str, Enum | Record] = {}

        def visit(type_: Type) -> None:
            if isinstance(type_, Enum):
                for v in type_.variants:
                    if v.argument is not None:
                        visit(v.argument)
                found[type_.name] = type_
            elif isinstance(type_, Record):
                for _, inner in type_.fields:
                    visit(inner)
                found[type_.name] = type_

        for type_ in shown:
            visit(type_)
        return list(found.values())

    def _name(self, type_: Type, value: Operand) -> Expr:
        """Return C++ for a value's name."""
        if isinstance(type_, Bool):
            return call("std::string", Choice(of(value), _quoted("true"), _quoted("false")))
        if isinstance(type_, Enum | Record):
            return call(self.name_functions[type_.name], value)
        return call("std::to_string", value)

    def _type_name(self, type_: Enum | Record) -> template_data.Function:
        code, names = Code(), self.context.names
        cpp, members = f"Model::{names.types[type_.name]}", names.members[type_.name]
        if isinstance(type_, Record):
            text: Expr = _quoted(type_.name + "(")
            for n, (field, inner) in enumerate(type_.fields):
                text = text + _quoted(", ") if n else text
                text = text + self._name(inner, call(f"{cpp}::{members[field]}", "value"))
            code.add(Return(text + _quoted(")")))
        else:
            for variant in type_.variants:
                if variant.argument is None:
                    constant = Literal(f"{cpp}::{members[variant.name]}")
                    code.add(when(op("value", "==", constant), Return(_quoted(variant.name))))
                    continue
                taken = call(f"{cpp}::{members[f'of {variant.name}']}", "value")
                argument = self._name(variant.argument, taken)
                test = call(f"{cpp}::{members[f'is {variant.name}']}", "value")
                name = _quoted(variant.name + "(") + argument + _quoted(")")
                code.add(when(test, Return(name), short=False))
            code.add(Return(_quoted("?")))
        name_function = self.name_functions[type_.name]
        return _function("std::string", name_function, [("std::int32_t", "value")], code)

    def _action_names(self) -> template_data.Function:
        code, action = Code(), self.model.action
        code.add(Declare(_NAMES, "names"))
        with code.block(for_below("action", Literal("Model::kActionCount"), "int")):
            if action.indices:
                code.add(var("int", "rest", "action"))
                code.add(Declare("std::string", "components"))
                with code.block(for_below("i", length_of(action.indices), "int")):
                    value = value_of(of("rest") % size_of(action.type), action.type)
                    name = self._name(action.type, value)
                    code.add(assign("components", name + _comma(0) + of("components")))
                    code.add(assign("rest", size_of(action.type), "/="))
                code.add(_push(_quoted("(") + of("components") + _quoted(")")))
            else:
                code.add(_push(self._name(action.type, value_of("action", action.type))))
        code.add(Return(of("names")))
        return _function(_NAMES, "action_names", [], code)

    def _observation_name(self) -> template_data.Function:
        code, scope = Code(), Scope({"key", "rest", "value"})
        layout = KeyLayout(self.model.key)
        if layout.fields:
            reader = Declare("hypgen::KeyReader", "rest", arguments=(of("key"),))
            code.add(reader if layout.wide else var("Model::Key", "rest", of("key")[0]))
        texts: dict[str, str] = {}
        for field in layout.reading():
            texts[field.name] = text = scope.unique(field.name)
            code.add(Declare("std::string", text))
            with code.block(layout.entries(field)):
                code.add(const("std::int32_t", "value", layout.take(field)))
                layout.go_on(code, field)
                value = self._name(field.type, from_int32("value", field.type, "hypgen::"))
                if layout.wide:
                    code.add(assign(text, _comma(0) + value, "+="))
                else:
                    code.add(assign(text, value + _comma(field.length - 1) + of(text)))
        parts: list[tuple[str, str, str]] = []
        for field in layout.fields:
            label = f"{field.name}=" if len(layout.fields) > 1 else ""
            before, after = (f"{label}(", ")") if field.indices else (label, "")
            parts.append((before, texts[field.name], after))
        code.add(Return(_joined(parts) if parts else _quoted("none")))
        return _function("std::string", "observation_name", [("hypgen::KeyWords", "key")], code)

    def _first_observation_name(self) -> template_data.Function:
        """Return C++ for what is visible at the start and tells of hidden variables."""
        code, scope = Code(), Scope({"visible", "i"})
        parts: list[tuple[str, str, str]] = []
        for variable in (v for v in self.model.variables if v.visible):
            length = length_of(variable.indices)
            if not variable.informative:
                code.add(assign("visible", length, "+="))
                continue
            text = scope.unique(variable.name.replace(".", "_"))
            value = self._name(variable.type, from_int32(following("visible"), variable.type, "hypgen::"))
            if variable.indices:
                code.add(Declare("std::string", text))
                with code.block(for_below("i", length, "int")):
                    code.add(assign(text, _comma(0) + value, "+="))
            else:
                code.add(const("std::string", text, value))
            label = f"{variable.name}=" if len(self.model.first_seen) > 1 else ""
            before, after = (f"{label}(", ")") if variable.indices else (label, "")
            parts.append((before, text, after))
        code.add(Return(_joined(parts)))
        given = [("const std::int32_t*", "visible")]
        return _function("std::string", "first_observation_name", given, code)

    def _value_names(self) -> template_data.Function:
        """Return C++ for the names of all values of a state, in the order of ``export_state``."""
        code = Code()
        code.add(Declare(_NAMES, "names"))
        for variable in self.model.variables:
            with code.block(for_below("i", length_of(variable.indices), "int")):
                code.add(_push(self._name(variable.type, following("values"))))
        code.add(Return(of("names")))
        return _function(_NAMES, "value_names", [("const std::int32_t*", "values")], code)

    def _hidden(self) -> list[ir.Variable]:
        return [v for v in self.model.variables if not v.visible]

    def _has_hidden_names(self) -> bool:
        """Return whether a hidden variable's values have names that are not numbers."""
        return any(isinstance(v.type, Bool | Enum | Record) for v in self._hidden())

    def _hidden_value_name(self) -> template_data.Function:
        """Return C++ for the name of one value of a hidden variable, which is given by its number."""
        code = Code()
        for place, variable in enumerate(self._hidden()):
            if isinstance(variable.type, Bool | Enum | Record):
                code.add(when(op("variable", "==", place), Return(self._name(variable.type, "value"))))
        code.add(Return(call("std::to_string", "value")))
        given = [("int", "variable"), ("std::int32_t", "value")]
        return _function("std::string", "hidden_value_name", given, code)

    def _settings(self, project: template_data.Project, exact: bool) -> tuple[str, ...]:
        model, lines = self.model, []
        lines.append(f"model.name = {_string(model.name)};")
        lines.append(f"model.file = {_string(project.file)};")
        lines.append(f"model.hash = {_string(model.source_hash)};")
        lines.append(f"model.discount = {model.discount!r};")
        if model.horizon is not None:
            lines.append(f"model.horizon = {model.horizon};")
        lines.append(f"model.has_success = {'false' if model.success is None else 'true'};")
        lines.append("model.action_names = action_names();")
        lines.append("model.observation_name = observation_name;")
        if model.first_seen:
            lines.append("model.first_observation_name = first_observation_name;")
        if hidden := [*self._hidden_variables()]:
            lines += _setting("hidden_variables", hidden)
        if not exact and (visible := [*self._visible_variables()]):
            lines += _setting("visible_variables", visible)
        if not exact and self._has_hidden_names():
            lines.append("model.hidden_value_name = hidden_value_name;")
        names = list(itertools.islice(self._variable_names(), _MAX_VARIABLE_NAMES + 1))
        if len(names) <= _MAX_VARIABLE_NAMES:
            lines += _setting("variable_names", [*map(_quoted, names)])
        if project.doubtful:
            lines += _setting("doubtful", [*map(_quoted, project.doubtful)])
        for param in model.params:
            lines += statements([Do(_PARAMS.call("push_back", self._param(param)))])
            if isinstance(param.type, Enum | Record):
                names_of = member(_PARAMS.call("back"), "value_names")
                loop = for_below("code", size_of(param.type))
                loop.body.append(Do(names_of.call("push_back", self._name(param.type, "code"))))
                loop.short = True
                lines += statements([loop])
            if isinstance(param.type, Enum) and param.type.glyphs:
                lines += statements([assign(member(_PARAMS.call("back"), "glyphs"), _glyphs(param.type))])
        return tuple(lines)

    def _hidden_variables(self) -> Iterator[Expr]:
        """Yield C++ for the name, place and kind of each hidden variable."""
        firsts = places(self.model)
        for variable in (v for v in self.model.variables if not v.visible):
            count = length_of(variable.indices)
            is_float = TRUE if isinstance(variable.type, Float) else FALSE
            yield braces("", _quoted(variable.name), firsts[variable.name], count, is_float)

    def _visible_variables(self) -> Iterator[Expr]:
        """Yield C++ for the name, length and kind of each visible variable."""
        for variable in (v for v in self.model.variables if v.visible):
            kinds = (TRUE if x else FALSE for x in (bool(variable.indices), isinstance(variable.type, Float)))
            yield braces("", _quoted(variable.name), length_of(variable.indices), *kinds)

    def _variable_names(self) -> itertools.chain[str]:
        def entries(variable: ir.Variable) -> list[str]:
            ranges = [range(low_of(t), low_of(t) + size_of(t)) for t in variable.indices]
            found = itertools.product(*ranges)
            return [f"{variable.name}[{', '.join(map(str, i))}]" if i else variable.name for i in found]

        return itertools.chain.from_iterable(entries(v) for v in self.model.variables)

    @staticmethod
    def _param(param: ir.Param) -> Expr:
        type_ = param.type
        low, high = "0", "1"
        match type_:
            case Bool():
                kind = "kBool"
            case Float(prob=True):
                kind = "kProb"
            case Float(low=least, high=most):
                kind, low, high = "kFloat", number(least), number(most)
            case Int(low=least, high=most):
                kind, low, high = "kInt", number(least), number(most)
            case _:
                kind, high = "kEnum", str(size_of(type_) - 1)
        dims = braces("", *(size_of(i) for i in flat_indices(param.indices)))
        defaults = braces("", *(Literal(number(v)) for v in param.default or ()))
        kinds = (Literal(f"hypgen::ParamKind::{kind}"), Literal(low), Literal(high))
        return braces("", _quoted(param.name), *kinds, dims, defaults, braces(""))


def _joined(parts: Sequence[tuple[str, str, str]]) -> Expr:
    """Return C++ for a list of texts, each with what stands before and after it."""
    terms, pending = list[Expr](), ""
    for n, (before, text, after) in enumerate(parts):
        before = f"{pending}{', ' if n else ''}{before}"
        terms += [_quoted(before), of(text)] if before else [of(text)]
        pending = after
    return reduce(lambda a, b: a + b, [*terms, _quoted(pending)] if pending else terms)


def _glyphs(enum: Enum) -> Expr:
    """Return C++ for the glyph and the code of each variant that has one."""
    glyphs = ((json.dumps(glyph, ensure_ascii=False), code) for glyph, code in enum.glyphs.items())
    return braces("", *(braces("", Literal(glyph), code) for glyph, code in glyphs))


def _function(result: str, name: str, arguments: list[tuple[str, str]], code: Code) -> template_data.Function:
    return laid_out(Function(result, name, arguments, code.body, mark=""))


def _quoted(text: str) -> Expr:
    return Literal(_string(text))


def _comma(first: int) -> Expr:
    """Return what stands between entries, where ``i`` is ``first`` at the first one."""
    return Choice(op("i", "==", first), _quoted(""), _quoted(", "))


def _push(name: Expr) -> Statement:
    return Do(method("names", "push_back", name))


def _setting(name: str, values: Sequence[Expr]) -> list[str]:
    return [*statements([assign(member("model", name), braces("", *values))])]
