# SPDX-License-Identifier: Apache-2.0
"""The descriptor: what the solver tells people about a model, and what a parameter file may set."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from hypgen.codegen.cpp import template_data
from hypgen.codegen.cpp.expressions import Context
from hypgen.codegen.cpp.key_codes import KeyLayout
from hypgen.codegen.cpp.text import Code, from_int32, value_of, wrapped
from hypgen.codegen.layout.naming import Scope
from hypgen.codegen.model.c_header import CHeader
from hypgen.codegen.model.value_fields import hidden_fields, number, places, seen_fields, visible_fields
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

    def _name(self, type_: Type, value: str) -> str:
        """Return C++ for a value's name."""
        if isinstance(type_, Bool):
            return f'std::string({value} ? "true" : "false")'
        if isinstance(type_, Enum | Record):
            return f"{self.name_functions[type_.name]}({value})"
        return f"std::to_string({value})"

    def _type_name(self, type_: Enum | Record) -> template_data.Function:
        code, names = Code(), self.context.names
        cpp, members = f"Model::{names.types[type_.name]}", names.members[type_.name]
        if isinstance(type_, Record):
            parts = [self._name(t, f"{cpp}::{members[f]}(value)") for f, t in type_.fields]
            fields = ' + ", " + '.join(parts)
            code.add(f'return {_string(type_.name + "(")} + {fields} + ")";')
        else:
            for variant in type_.variants:
                if variant.argument is None:
                    code.add(f"if (value == {cpp}::{members[variant.name]}) return {_string(variant.name)};")
                    continue
                argument = self._name(variant.argument, f"{cpp}::{members[f'of {variant.name}']}(value)")
                with code.block(f"if ({cpp}::{members[f'is {variant.name}']}(value))"):
                    code.add(f'return {_string(variant.name + "(")} + {argument} + ")";')
            code.add('return "?";')
        head = f"std::string {self.name_functions[type_.name]}(std::int32_t value) {{"
        return template_data.Function((), (head,), tuple(code.lines))

    def _action_names(self) -> template_data.Function:
        code, action = Code(), self.model.action
        code.add("std::vector<std::string> names;")
        with code.block("for (int action = 0; action < Model::kActionCount; ++action)"):
            if action.indices:
                code.add("int rest = action;")
                code.add("std::string components;")
                with code.block(f"for (int i = 0; i < {length_of(action.indices)}; ++i)"):
                    value = self._name(action.type, value_of(f"rest % {size_of(action.type)}", action.type))
                    code.add(f'components = {value} + (i == 0 ? "" : ", ") + components;')
                    code.add(f"rest /= {size_of(action.type)};")
                code.add('names.push_back("(" + components + ")");')
            else:
                code.add(f"names.push_back({self._name(action.type, value_of('action', action.type))});")
        code.add("return names;")
        return template_data.Function((), ("std::vector<std::string> action_names() {",), tuple(code.lines))

    def _observation_name(self) -> template_data.Function:
        code, scope = Code(), Scope({"key", "rest", "value"})
        layout = KeyLayout(self.model.key)
        if layout.fields:
            code.add(f"{'hypgen::KeyReader rest(key)' if layout.wide else 'Model::Key rest = key[0]'};")
        texts: dict[str, str] = {}
        for field in layout.reading():
            texts[field.name] = text = scope.unique(field.name)
            code.add(f"std::string {text};")
            with layout.entries(code, field):
                layout.take(code, field, "const std::int32_t value")
                value = from_int32("value", field.type)
                if isinstance(field.type, Float):
                    value = f"hypgen::{value}"
                value = self._name(field.type, value)
                if layout.wide:
                    code.add(f'{text} += (i == 0 ? "" : ", ") + {value};')
                else:
                    code.add(f'{text} = {value} + (i == {field.length - 1} ? "" : ", ") + {text};')
        parts: list[tuple[str, str, str]] = []
        for field in layout.fields:
            label = f"{field.name}=" if len(layout.fields) > 1 else ""
            before, after = (f"{label}(", ")") if field.indices else (label, "")
            parts.append((before, texts[field.name], after))
        code.add(f"return {_joined(parts)};" if parts else 'return "none";')
        head = f"std::string observation_name(hypgen::KeyWords{' key' if parts else ''}) {{"
        return template_data.Function((), (head,), tuple(code.lines))

    def _first_observation_name(self) -> template_data.Function:
        """Return C++ for what is visible at the start and tells of hidden variables."""
        code, scope = Code(), Scope({"visible", "i"})
        parts: list[tuple[str, str, str]] = []
        for variable in (v for v in self.model.variables if v.visible):
            length = length_of(variable.indices)
            if not variable.informative:
                code.add(f"visible += {length};")
                continue
            text = scope.unique(variable.name.replace(".", "_"))
            value = from_int32("*visible++", variable.type)
            if isinstance(variable.type, Float):
                value = f"hypgen::{value}"
            value = self._name(variable.type, value)
            if variable.indices:
                code.add(f"std::string {text};")
                with code.block(f"for (int i = 0; i < {length}; ++i)"):
                    code.add(f'{text} += (i == 0 ? "" : ", ") + {value};')
            else:
                code.add(f"const std::string {text} = {value};")
            label = f"{variable.name}=" if len(self.model.first_seen) > 1 else ""
            before, after = (f"{label}(", ")") if variable.indices else (label, "")
            parts.append((before, text, after))
        code.add(f"return {_joined(parts)};")
        head = "std::string first_observation_name(const std::int32_t* visible) {"
        return template_data.Function((), (head,), tuple(code.lines))

    def _value_names(self) -> template_data.Function:
        """Return C++ for the names of all values of a state, in the order of ``export_state``."""
        code = Code()
        code.add("std::vector<std::string> names;")
        for variable in self.model.variables:
            with code.block(f"for (int i = 0; i < {length_of(variable.indices)}; ++i, ++values)"):
                code.add(f"names.push_back({self._name(variable.type, '*values')});")
        code.add("return names;")
        head = "std::vector<std::string> value_names(const std::int32_t* values) {"
        return template_data.Function((), (head,), tuple(code.lines))

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
                code.add(f"if (variable == {place}) return {self._name(variable.type, 'value')};")
        code.add("return std::to_string(value);")
        head = "std::string hidden_value_name(int variable, std::int32_t value) {"
        return template_data.Function((), (head,), tuple(code.lines))

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
        if hidden := ", ".join(self._hidden_variables()):
            lines += wrapped(f"model.hidden_variables = {{{hidden}}};")
        if not exact and (visible := ", ".join(self._visible_variables())):
            lines += wrapped(f"model.visible_variables = {{{visible}}};")
        if not exact and self._has_hidden_names():
            lines.append("model.hidden_value_name = hidden_value_name;")
        names = list(itertools.islice(self._variable_names(), _MAX_VARIABLE_NAMES + 1))
        if len(names) <= _MAX_VARIABLE_NAMES:
            lines += wrapped(f"model.variable_names = {{{', '.join(map(_string, names))}}};")
        if doubtful := ", ".join(map(_string, project.doubtful)):
            lines += wrapped(f"model.doubtful = {{{doubtful}}};")
        for param in model.params:
            lines += wrapped(f"model.params.push_back({self._param(param)});")
            if isinstance(param.type, Enum | Record):
                call = self._name(param.type, "code")
                lines.append(
                    f"for (std::int32_t code = 0; code < {size_of(param.type)}; ++code) "
                    f"model.params.back().value_names.push_back({call});"
                )
            if isinstance(param.type, Enum) and param.type.glyphs:
                lines += wrapped(f"model.params.back().glyphs = {{{_glyphs(param.type)}}};")
        return tuple(lines)

    def _hidden_variables(self) -> Iterator[str]:
        """Yield C++ for the name, place and kind of each hidden variable."""
        firsts = places(self.model)
        for variable in (v for v in self.model.variables if not v.visible):
            count = length_of(variable.indices)
            is_float = "true" if isinstance(variable.type, Float) else "false"
            yield f"{{{_string(variable.name)}, {firsts[variable.name]}, {count}, {is_float}}}"

    def _visible_variables(self) -> Iterator[str]:
        """Yield C++ for the name, length and kind of each visible variable."""
        for variable in (v for v in self.model.variables if v.visible):
            is_array, is_float = (
                str(x).lower() for x in (bool(variable.indices), isinstance(variable.type, Float))
            )
            yield f"{{{_string(variable.name)}, {length_of(variable.indices)}, {is_array}, {is_float}}}"

    def _variable_names(self) -> itertools.chain[str]:
        def entries(variable: ir.Variable) -> list[str]:
            ranges = [range(low_of(t), low_of(t) + size_of(t)) for t in variable.indices]
            found = itertools.product(*ranges)
            return [f"{variable.name}[{', '.join(map(str, i))}]" if i else variable.name for i in found]

        return itertools.chain.from_iterable(entries(v) for v in self.model.variables)

    @staticmethod
    def _param(param: ir.Param) -> str:
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
        dims = ", ".join(str(size_of(i)) for i in flat_indices(param.indices))
        defaults = ", ".join(number(v) for v in param.default or ())
        return (
            f"{{{_string(param.name)}, hypgen::ParamKind::{kind}, {low}, {high}, "
            f"{{{dims}}}, {{{defaults}}}, {{}}}}"
        )


def _joined(parts: Sequence[tuple[str, str, str]]) -> str:
    """Return C++ for a list of texts, each with what stands before and after it."""
    joined, pending = "", ""
    for n, (before, text, after) in enumerate(parts):
        before = f"{pending}{', ' if n else ''}{before}"
        joined += (f"{_string(before)} + " if before else "") + f"{text} + "
        pending = after
    return joined + _string(pending) if pending else joined.removesuffix(" + ")


def _glyphs(enum: Enum) -> str:
    """Return C++ for the glyph and the code of each variant that has one."""
    return ", ".join(f"{{{json.dumps(g, ensure_ascii=False)}, {code}}}" for g, code in enum.glyphs.items())
