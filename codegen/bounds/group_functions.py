# SPDX-License-Identifier: Apache-2.0
"""The small models whose values bound groups of rewards, as C++: their states and steps, and the tables."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from hypgen.codegen.bounds.groups import Group, Part, Relaxation, describe, runs, strides, updated
from hypgen.codegen.cpp import template_data
from hypgen.codegen.cpp.function_builder import Builder
from hypgen.codegen.cpp.text import Code, code_of, integer, value_of
from hypgen.codegen.layout.state_layout import Field
from hypgen.codegen.model.interface import HISTORY, PLACE, Interface
from hypgen.codegen.model.model_functions import arguments
from hypgen.dsl import ir
from hypgen.dsl.types import Type, low_of, size_of


@dataclass(frozen=True)
class Named:
    """A group and the C++ names of its table and functions."""

    group: Group
    table: str
    index: str
    put: str
    step: str


class GroupFunctions:
    """Builds what bounds the groups of one model's rewards, of all agents together."""

    def __init__(self, interface: Interface, relaxation: Relaxation, fields: Sequence[Field]) -> None:
        self.interface = interface
        self.context = interface.context
        self.relaxation = relaxation
        self.fields = {field.variable: field for field in fields}
        names, unique = self.context.names, self.context.names.struct.unique
        self.groups = [
            Named(
                group,
                names.derived_table(f"group_{i}_table"),
                unique(f"index_of_group_{i}"),
                unique(f"put_group_{i}"),
                unique(f"step_group_{i}"),
            )
            for i, group in enumerate(relaxation.groups)
        ]
        self.earned = names.derived_table("earned_table") if relaxation.earned else None

    def whole(self) -> set[str]:
        """Return the arrays whose bits are read at once."""
        parts = [part for named in self.groups for part in named.group.parts]
        return {part.variable.name for part in parts if self._bits(part) is not None}

    def params(self) -> list[str]:
        """Return the tables' declarations."""
        found = [
            f"float {named.table}[{named.group.states}];  // computed: the worth of {describe(named.group)}"
            for named in self.groups
        ]
        if self.earned is not None:
            states = self.groups[0].group.states
            found.append(f"float {self.earned}[{states}];  // computed: what the default policy earns")
        return found

    def constants(self) -> list[str]:
        """Return what the runtime asks of the model's type."""
        return ["static constexpr bool kLooksUpPolicy = true;"] if self.earned is not None else []

    def all(self) -> list[template_data.Function]:
        """Return the functions of all groups."""
        return [
            function
            for named in self.groups
            for function in (self._numbering(named), self._put(named), self._step(named))
        ]

    def upper(self) -> template_data.Function:
        """Return ``upper``: the declared bound or what the groups are worth, whichever is less."""
        builder = self.interface.given(PLACE)
        reads = [f"params.{n.table}[{n.index}(fixed, state)]" for n in self.groups]
        if self.relaxation.declared:
            builder.code.add(f"return {reads[0]};")
            return builder.done("float", "upper", ["// The tables hold the declared bound where it is less."])
        builder.code.add(f"float worth = {reads[0]};")
        for read in reads[1:]:
            builder.code.add(f"worth += {read};")
        builder.code.add("const float declared = declared_upper(params, fixed, state);")
        builder.code.add("return worth < declared ? worth : declared;")
        return builder.done("float", "upper")

    def lower(self) -> list[template_data.Function]:
        """Return ``lower``, if it looks up what the default policy earns."""
        if self.earned is None:
            return []
        builder = self.interface.given([*PLACE, HISTORY])
        builder.code.add(f"return params.{self.earned}[{self.groups[0].index}(fixed, state)];")
        return [builder.done("float", "lower")]

    def fill(self, code: Code) -> None:
        """Append what fills the tables when params are loaded."""
        model = self.interface.model
        stops = "true" if self._may_stop() else "false"
        for i, named in enumerate(self.groups):
            actions = ", ".join(map(str, named.group.actions))
            code.add(f"static constexpr int actions_{i}[] = {{{actions}}};")
        with code.block("const relaxation::Group<Params, Fixed, State> groups[] ="):
            for i, named in enumerate(self.groups):
                code.add(
                    f"{{{named.group.states}, {{actions_{i}, {len(named.group.actions)}}}, {named.put}, "
                    f"{named.index}, {self._legal(i)}, {named.step}<Draws>, {self._table(i)}}},"
                )
        code.lines[-1] += ";"
        code.add(f"relaxation::fill(groups, params, {model.discount!r}, {stops});")
        if self.earned is None:
            return
        given = "const Params& given, const Fixed& fixed, const State& state, Draws& draws"
        with code.block(f"const auto policy = []({given})"):
            code.add("return default_policy(given, fixed, state, History{}, draws);")
        code.lines[-1] += ";"
        code.add(
            f"relaxation::fill_earned<Params, Fixed, State>(groups[0], policy, tail, params.{self.earned}, "
            f"params, {model.discount!r});"
        )

    def _may_stop(self) -> bool:
        """Return whether an episode may end after any step."""
        return self.interface.model.horizon is not None

    def _legal(self, number: int) -> str:
        """Return the name of the function that says which actions are legal in a group."""
        return "is_legal"

    def _table(self, number: int) -> str:
        """Return the members of the runtime's group that say what is in its table."""
        declared = "declared_upper" if self.relaxation.declared else "nullptr"
        members = [declared, f"params.{self.groups[number].table}"]
        rows, bits = self._rows(number), self.interface.model.reward_bits
        if rows != 1 or bits != ir.REWARD_BITS:
            members.append(str(rows))
        if bits != ir.REWARD_BITS:
            members.append(str(bits))
        return ", ".join(members)

    def _rows(self, number: int) -> int:
        """Return the number of the table's rows."""
        return 1

    def _ends(self) -> str:
        """Return the condition on which a group's step ends the episode."""
        needs = self.context.needs.of(self.context.model.terminal)
        return f"is_terminal({arguments(needs, self.context)})"

    # A group's states ----------------------------------------------------------------------------

    def _numbering(self, named: Named) -> template_data.Function:
        """Return the function that numbers a state of the group."""
        return self._index(
            named.group.parts, named.index, f"// States as far as {describe(named.group)} goes."
        )

    def _index(self, parts: Sequence[Part], name: str, comment: str) -> template_data.Function:
        """Return the function that numbers the joint values of the parts."""
        builder = self.interface.given(PLACE[1:])
        builder.code.add("std::int32_t index = 0;")
        for part in parts:
            type_ = part.variable.type
            if (bits := self._bits(part)) is not None:
                builder.code.add(f"index = index * {1 << bits.count} + {bits.read};")
                continue

            def append(read: ir.StateRead, type_: Type = type_) -> None:
                text = code_of(builder.printer.text(read), type_)
                builder.code.add(f"index = index * {size_of(type_)} + {text};")

            self._each(builder, part, append, ascending=True)
        builder.code.add("return index;")
        return builder.done("std::int32_t", name, [comment])

    def _put(self, named: Named) -> template_data.Function:
        """Return the function that makes a state of the group; all that it does not need is zero."""
        builder = self.interface.given([("std::int32_t", "index"), ("Fixed&", "fixed"), ("State&", "state")])
        builder.code.add("fixed = Fixed{};")
        builder.code.add("state = State{};")
        for part in reversed(named.group.parts):
            type_ = part.variable.type
            if (bits := self._bits(part)) is not None:
                builder.code.add(bits.write.format(f"index % {1 << bits.count}"))
                builder.code.add(f"index /= {1 << bits.count};")
                continue

            def take(read: ir.StateRead, type_: Type = type_) -> None:
                owner = "fixed" if self.interface.model.variable(read.variable).fixed else "state"
                setter = self.context.names.setters[read.variable]
                value = value_of(f"index % {size_of(type_)}", type_)
                given = [builder.printer.text(i) for i in read.indices]
                builder.code.add(f"{owner}.{setter}({', '.join([*given, value])});")
                builder.code.add(f"index /= {size_of(type_)};")

            self._each(builder, part, take, ascending=False)
        return on_host(builder.done("void", named.put))

    def _each(
        self, builder: Builder, part: Part, use: Callable[[ir.StateRead], None], ascending: bool
    ) -> None:
        """Append what ``use`` appends for each entry of the part, in loops where there are several."""
        indices = part.variable.indices
        binders = [ir.Binder("ijkl"[n : n + 1] or f"i{n}", t) for n, t in enumerate(indices)]
        read = ir.StateRead(
            part.variable.type, part.variable.name, tuple(ir.Local(b.type, b.name) for b in binders)
        )
        if not binders:
            use(read)
            return
        found = strides(part.members or range(size_of(indices[0])))
        for some in found if ascending else reversed(found):
            with ExitStack() as stack:
                stack.enter_context(_loop(builder, binders[0], some, ascending))
                for binder in binders[1:]:
                    some = range(size_of(binder.type))
                    stack.enter_context(_loop(builder, binder, some, ascending))
                use(read)

    def _bits(self, part: Part) -> _Bits | None:
        """Return how the part lies side by side in a word with every pattern a joint value, if it does."""
        field = self.fields.get(part.variable.name)
        if field is None or not field.indices or not field.one_word or field.width == 0:
            return None
        if size_of(field.type) != 1 << field.width or field.stride != field.width:
            return None
        name = part.variable.name
        read = f"state.{self.context.names.bits[name]}()"
        write = f"state.{self.context.names.bits_setters[name]}({{0}});"
        if not part.members:
            return _Bits(field.length * field.width, read, write)
        if len(field.indices) > 1 or len(runs(part.members)) > 1:
            return None
        count, shift = len(part.members) * field.width, part.members[0] * field.width
        read = f"{read} >> {shift}" if shift else read
        write = write.format(f"{{0}} << {shift}") if shift else write
        return _Bits(count, f"({read} & {(1 << count) - 1})", write)

    # A group's step ------------------------------------------------------------------------------

    def _step(self, named: Named) -> template_data.Function:
        """Return the step of the group's variables, rewards and end."""
        builder = self.interface.acting([*PLACE, ("int", "action"), ("D&", "draws"), ("State&", "next")])
        builder.code.add("next = state;")
        for update in (update for stage in self.interface.stages for update in stage):
            binder = update.element.binder
            for some in strides(updated(named.group, update)):
                with builder.guarded(update.guard), _loop(builder, binder, some):
                    builder.code.add(self.interface.update_call(builder, update))
        builder.code.add("StepResult result{};")
        for reward in self.context.model.rewards:
            members = [m or 0 for r, m in named.group.terms if r.name == reward.name]
            for some in strides(sorted(members)):
                with (
                    builder.guarded(self.interface.reward_guard(reward)),
                    _loop(builder, reward.binder, some),
                ):
                    self.interface.earn(builder, reward, "result.reward", "result.error")
        self.interface.limit(builder, "result.reward")
        builder.code.add(f"result.terminal = {self._ends()};")
        builder.code.add("return result;")
        return on_host(builder.done("StepResult", named.step))


@dataclass(frozen=True)
class _Bits:
    """A part that is a field of bits: how many, and how they are read and written."""

    count: int
    read: str
    write: str


@contextmanager
def _loop(builder: Builder, binder: ir.Binder | None, some: range, ascending: bool = True) -> Iterator[None]:
    """Put what is added meanwhile into a loop over some of the binder's positions, if there is a binder."""
    if binder is None:
        yield
        return
    first, last = (integer(position + low_of(binder.type)) for position in (some[0], some[-1]))
    begin, test, end, step = (first, "<=", last, "+") if ascending else (last, ">=", first, "-")
    onward = f"{step * 2}{{0}}" if some.step == 1 else f"{{0}} {step}= {some.step}"
    head = f"for (std::int32_t {{0}} = {begin}; {{0}} {test} {end}; {onward})"
    with builder.printer.loop(binder, head):
        yield
    builder.code.join()


def on_host(function: template_data.Function) -> template_data.Function:
    """Return the function without a device's version."""
    head = tuple(line.replace("HYPGEN_FN static", "static") for line in function.head)
    return template_data.Function(function.comment, head, function.body)
