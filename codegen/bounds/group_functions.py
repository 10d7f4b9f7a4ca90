# SPDX-License-Identifier: Apache-2.0
"""The small models whose values bound groups of rewards, as C++: their states and steps, and the tables."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace

from hypgen.codegen.bounds.groups import Group, Part, Relaxation, describe, runs, strides, updated
from hypgen.codegen.cpp.function_builder import Builder
from hypgen.codegen.cpp.text import code_of, value_of
from hypgen.codegen.layout.state_layout import Field
from hypgen.codegen.model.interface import ERROR, HISTORY, PLACE, REWARD, Interface, clear
from hypgen.codegen.model.model_functions import arguments
from hypgen.codegen.tree.code import Code
from hypgen.codegen.tree.expr import (
    FALSE,
    TRUE,
    Braces,
    Choice,
    Expr,
    Literal,
    Name,
    Operand,
    Prefix,
    braces,
    call,
    member,
    method,
    number,
    of,
    op,
    plus,
)
from hypgen.codegen.tree.statements import (
    Declare,
    Do,
    For,
    Function,
    Lambda,
    Return,
    assign,
    const,
    var,
    zeroed,
)
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

    def all(self) -> list[Function]:
        """Return the functions of all groups."""
        return [
            function
            for named in self.groups
            for function in (self._numbering(named), self._put(named), self._step(named))
        ]

    def upper(self) -> Function:
        """Return ``upper``: the declared bound or what the groups are worth, whichever is less."""
        builder = self.interface.given(PLACE)
        reads = [member("params", n.table)[call(n.index, "fixed", "state")] for n in self.groups]
        if self.relaxation.declared:
            builder.code.add(Return(reads[0]))
            return builder.done("float", "upper", ["// The tables hold the declared bound where it is less."])
        builder.code.add(var("float", "bound", reads[0]))
        for read in reads[1:]:
            builder.code.add(assign("bound", read, "+="))
        less_of_both(builder.code)
        return builder.done("float", "upper")

    def lower(self) -> list[Function]:
        """Return ``lower``, if it looks up what the default policy earns."""
        if self.earned is None:
            return []
        builder = self.interface.given([*PLACE, HISTORY])
        index = call(self.groups[0].index, "fixed", "state")
        builder.code.add(Return(member("params", self.earned)[index]))
        return [builder.done("float", "lower")]

    def fill(self, code: Code) -> None:
        """Append what fills the tables when params are loaded."""
        model = self.interface.model
        stops, discount = TRUE if self._may_stop() else FALSE, Literal(repr(model.discount))
        groups: list[Expr] = []
        for i, named in enumerate(self.groups):
            actions = named.group.actions
            code.add(Declare("static constexpr int", f"actions_{i}", braces("", *actions), ("",)))
            own = braces("", f"actions_{i}", len(actions))
            step = Name(named.step, ("Draws",))
            row = (named.group.states, own, named.put, named.index, self._legal(i), step, *self._table(i))
            groups.append(braces("", *row))
        kind = "const relaxation::Group<Params, Fixed, State>"
        code.add(Declare(kind, "groups", Braces("", tuple(groups), rows=True), ("",)))
        code.add(Do(call("relaxation::fill", "groups", "params", discount, stops)))
        if self.earned is None:
            return
        given = ("const Params& given", "const Fixed& fixed", "const State& state", "Draws& draws")
        default = call("default_policy", "given", "fixed", "state", braces("History"), "draws")
        code.add(const("auto", "policy", Lambda(given, (Return(default),))))
        fill = "relaxation::fill_earned<Params, Fixed, State>"
        earned = member("params", self.earned)
        code.add(Do(call(fill, of("groups")[0], "policy", "tail", earned, "params", discount)))

    def _may_stop(self) -> bool:
        """Return whether an episode may end after any step."""
        return self.interface.model.horizon is not None

    def _legal(self, number: int) -> str:
        """Return the name of the function that says which actions are legal in a group."""
        return "is_legal"

    def _table(self, number: int) -> list[Operand]:
        """Return the members of the runtime's group that say what is in its table."""
        declared = "declared_upper" if self.relaxation.declared else "nullptr"
        members: list[Operand] = [declared, member("params", self.groups[number].table)]
        rows, bits = self._rows(number), self.interface.model.reward_bits
        if rows != 1 or bits != ir.REWARD_BITS:
            members.append(rows)
        if bits != ir.REWARD_BITS:
            members.append(bits)
        return members

    def _rows(self, number: int) -> int:
        """Return the number of the table's rows."""
        return 1

    def _ends(self) -> Expr:
        """Return the condition on which a group's step ends the episode."""
        needs = self.context.needs.of(self.context.model.terminal)
        return call("is_terminal", *arguments(needs, self.context))

    # A group's states ----------------------------------------------------------------------------

    def _numbering(self, named: Named) -> Function:
        """Return the function that numbers a state of the group."""
        return self._index(named.group.parts, named.index, f"// Where a state stands in {named.table}.")

    def _index(self, parts: Sequence[Part], name: str, comment: str) -> Function:
        """Return the function that numbers the joint values of the parts."""
        builder = self.interface.given(PLACE[1:])
        builder.code.add(var("std::int32_t", "index", 0))
        for part in parts:
            type_ = part.variable.type
            if (bits := self._bits(part)) is not None:
                builder.code.add(assign("index", of("index") * (1 << bits.count) + bits.read))
                continue

            def append(read: ir.StateRead, type_: Type = type_) -> None:
                code = code_of(builder.printer.expr(read), type_)
                builder.code.add(assign("index", plus(of("index") * size_of(type_), code)))

            self._each(builder, part, append, ascending=True)
        builder.code.add(Return(of("index")))
        return builder.done("std::int32_t", name, [comment])

    def _put(self, named: Named) -> Function:
        """Return the function that makes a state of the group; all that it does not need is zero."""
        builder = self.interface.given([("std::int32_t", "index"), ("Fixed&", "fixed"), ("State&", "state")])
        clear(builder.code, "fixed", "state")
        for part in reversed(named.group.parts):
            type_ = part.variable.type
            if (bits := self._bits(part)) is not None:
                builder.code.add(Do(bits.write(of("index") % (1 << bits.count))))
                builder.code.add(assign("index", 1 << bits.count, "/="))
                continue

            def take(read: ir.StateRead, type_: Type = type_) -> None:
                owner = "fixed" if self.interface.model.variable(read.variable).fixed else "state"
                setter = self.context.names.setters[read.variable]
                value = value_of(of("index") % size_of(type_), type_)
                given = builder.printer.exprs(read.indices)
                builder.code.add(Do(method(owner, setter, *given, value)))
                builder.code.add(assign("index", size_of(type_), "/="))

            self._each(builder, part, take, ascending=False)
        return on_host(
            builder.done(
                "void", named.put, ["// The state of an entry: all that the group does not read is zero."]
            )
        )

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
        read = method("state", self.context.names.bits[name])
        setter = self.context.names.bits_setters[name]
        if not part.members:
            count = field.length * field.width
            return _Bits(count, read, lambda value: method("state", setter, value))
        if len(field.indices) > 1 or len(runs(part.members)) > 1:
            return None
        count, shift = len(part.members) * field.width, part.members[0] * field.width
        read = op(op(read, ">>", shift) if shift else read, "&", (1 << count) - 1)

        def write(value: Expr) -> Expr:
            return method("state", setter, op(value, "<<", shift) if shift else value)

        return _Bits(count, read, write)

    # A group's step ------------------------------------------------------------------------------

    def _step(self, named: Named) -> Function:
        """Return the step of the group's variables, rewards and end."""
        builder = self.interface.acting([*PLACE, ("int", "action"), ("D&", "draws"), ("State&", "next")])
        builder.code.add(assign("next", "state"))
        for update in (update for stage in self.interface.stages for update in stage):
            binder = update.element.binder
            for some in strides(updated(named.group, update)):
                with builder.guarded(update.guard), _loop(builder, binder, some):
                    builder.code.add(self.interface.update_call(builder, update))
        builder.code.add(zeroed("StepResult", "result"))
        for reward in self.context.model.rewards:
            members = [m or 0 for r, m in named.group.terms if r.name == reward.name]
            for some in strides(sorted(members)):
                with (
                    builder.guarded(self.interface.reward_guard(reward)),
                    _loop(builder, reward.binder, some),
                ):
                    self.interface.earn(builder, reward, REWARD, ERROR)
        self.interface.limit(builder, REWARD)
        builder.code.add(assign(member("result", "terminal"), self._ends()))
        builder.code.add(Return(of("result")))
        return on_host(
            builder.done("StepResult", named.step, ["// A step of the group's own variables and rewards."])
        )


@dataclass(frozen=True)
class _Bits:
    """A part that is a field of bits: how many, and how they are read and written."""

    count: int
    read: Expr
    write: Callable[[Expr], Expr]


@contextmanager
def _loop(builder: Builder, binder: ir.Binder | None, some: range, ascending: bool = True) -> Iterator[None]:
    """Put what is added meanwhile into a loop over some of the binder's positions, if there is a binder."""
    if binder is None:
        yield
        return
    first, last = (position + low_of(binder.type) for position in (some[0], some[-1]))
    begin, test, end, sign = (first, "<=", last, "+") if ascending else (last, ">=", first, "-")

    def head(variable: str) -> For:
        step = assign(variable, some.step, f"{sign}=")
        onward = Do(Prefix(sign * 2, of(variable))) if some.step == 1 else step
        return For("std::int32_t", variable, number(begin), op(variable, test, end), onward)

    with builder.printer.loop(binder, head):
        yield
    builder.code.join()


def less_of_both(code: Code) -> None:
    """Append the return of ``bound`` or of the declared bound, whichever is less."""
    code.add(const("float", "declared", call("declared_upper", "params", "fixed", "state")))
    code.add(Return(Choice(op("bound", "<", "declared"), of("bound"), of("declared"))))


def on_host(function: Function) -> Function:
    """Return the function without a device's version."""
    return replace(function, mark="static")
