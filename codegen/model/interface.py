# SPDX-License-Identifier: Apache-2.0
"""The functions that the runtime calls: the Model concept."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from contextlib import nullcontext

from hypgen.codegen.cpp.body_printer import Context
from hypgen.codegen.cpp.function_builder import Builder, origin
from hypgen.codegen.cpp.key_codes import KeyLayout
from hypgen.codegen.cpp.text import from_int32, scalar, value_of
from hypgen.codegen.model.model_functions import (
    PartNames,
    arguments,
    density_needs,
    first_assigned,
    key_of,
    position,
    update_needs,
)
from hypgen.codegen.model.value_fields import places
from hypgen.codegen.passes.guards import Guards
from hypgen.codegen.passes.partition import ElementUpdate
from hypgen.codegen.tree.code import Code
from hypgen.codegen.tree.expr import (
    Expr,
    Literal,
    Operand,
    braces,
    call,
    cast,
    following,
    member,
    method,
    of,
    op,
    shifted,
)
from hypgen.codegen.tree.statements import (
    Comment,
    Declare,
    Do,
    Function,
    Return,
    assign,
    const,
    for_down,
    var,
    when,
    zeroed,
)
from hypgen.dsl import ir
from hypgen.dsl.types import Bool, Float, Type, length_of, low_of, size_of

HISTORY = ("const History&", "history")
WEIGHT, NOTHING = var("double", "weight", Literal("1.0")), Return(Literal("0.0"))
REWARD, ERROR = member("result", "reward"), member("result", "error")
PLACE = [("const Params&", "params"), ("const Fixed&", "fixed"), ("const State&", "state")]
Digit = Callable[[Sequence[ir.Binder]], Expr]
Stages = Sequence[Sequence[ElementUpdate]]


class Interface:
    """Builds the Model concept's functions of one model."""

    def __init__(self, context: Context, parts: PartNames, stages: Stages) -> None:
        self.context = context
        self.model = context.model
        self.parts = parts
        self.stages = stages
        self.action = context.names.action
        self.key = KeyLayout(self.model.key)
        bits = self.model.reward_bits
        self.to_fixed = "math::to_fixed" if bits == ir.REWARD_BITS else f"math::to_fixed<{bits}>"
        # What functions that act call the action's code: as the model calls the action where the two are one.
        type_, joint = self.model.action.type, bool(self.model.action.indices)
        self.code = "action" if joint or isinstance(type_, Bool) or low_of(type_) else self.action

    def given(self, arguments: Sequence[tuple[str, str]]) -> Builder:
        """Return a builder with these arguments, of the C++ types that stand before them."""
        builder = Builder(self.context)
        for kind, name in arguments:
            builder.take(kind, name)
        return builder

    def acting(self, arguments: Sequence[tuple[str, str]]) -> Builder:
        """Return a builder that is given the action's code and reads it as the model does."""
        action = self.model.action
        if action.indices:
            line = const("Joint", self.action, call("joint", "action"))
            return self.given(arguments).prelude(self.action, line)
        if isinstance(action.type, Bool) or low_of(action.type):
            line = const(scalar(action.type), self.action, value_of("action", action.type))
            return self.given(arguments).prelude(self.action, line)
        return self.given([(kind, self.code if name == "action" else name) for kind, name in arguments])

    # The start -----------------------------------------------------------------------------------

    def init(self, visible: bool) -> Function:
        """Return ``init_visible``, which starts from zeroes, or ``init_hidden``."""
        builder = self.given(
            [("const Params&", "params"), ("D&", "draws"), ("Fixed&", "fixed"), ("State&", "state")]
        )
        if visible:
            clear(builder.code, "fixed", "state")
        firsts = places(self.model)
        for group in self.model.init_groups(visible):
            members = group[0].binders[:1] if len(group) > 1 else ()
            with builder.printer.loops(members):
                for init in group:
                    builder.code.add(Comment(f"{origin(init.span)}: {init.variable}"))
                    with builder.printer.loops(init.binders[len(members) :]):
                        first_assigned(init, firsts[init.variable], builder)
        return builder.done("void", "init_visible" if visible else "init_hidden")

    def init_likelihood(self) -> list[Function]:
        """Return ``init_likelihood``, if what is seen at the start tells of hidden variables."""
        if not self.model.first_seen:
            return []
        builder = self.given(PLACE)
        builder.code.add(WEIGHT)
        for init in self.model.first_seen:
            with builder.printer.loops(init.binders):
                name = self.parts.init_densities[init.variable]
                self._weigh(builder, name, init, self.first_value(builder, init.variable, init.binders))
        builder.code.add(Return(of("weight")))
        return [builder.done("double", "init_likelihood")]

    def first_value(self, builder: Builder, variable: str, binders: Sequence[ir.Binder]) -> Expr:
        """Return what is seen of a visible variable at the start."""
        type_ = self.model.variable(variable).type
        return builder.printer.expr(ir.StateRead(type_, variable, _locals(binders)))

    def export(self, visible_only: bool) -> Function:
        """Return ``export_visible`` or ``export_state``."""
        builder = self.given([*PLACE[1:], ("std::int32_t*", "out")])
        for variable, binders in self._flattened(visible_only):
            with builder.printer.loops(binders):
                read = ir.StateRead(variable.type, variable.name, _locals(binders))
                value = builder.printer.expr(read)
                if isinstance(variable.type, Float):
                    value = cast("std::int32_t", call("math::canonical_bits", value))
                builder.code.add(assign(following("out"), value))
        return builder.done("void", "export_visible" if visible_only else "export_state")

    def import_visible(self) -> Function:
        """Return ``import_visible``."""
        builder = self.given([("const std::int32_t*", "in"), ("Fixed&", "fixed"), ("State&", "state")])
        clear(builder.code, "fixed", "state")
        for variable, binders in self._flattened(True):
            with builder.printer.loops(binders):
                value = from_int32(following("in"), variable.type)
                owner = "fixed" if variable.fixed else "state"
                indices = builder.printer.exprs(_locals(binders))
                setter = self.context.names.setters[variable.name]
                builder.code.add(Do(method(owner, setter, *indices, value)))
        return builder.done("void", "import_visible")

    def _flattened(self, visible_only: bool) -> list[tuple[ir.Variable, list[ir.Binder]]]:
        """Return the variables with binders over their entries."""
        return [
            (v, [ir.Binder("ijkl"[n : n + 1] or f"i{n}", t) for n, t in enumerate(v.indices)])
            for v in self.model.variables
            if v.visible or not visible_only
        ]

    # A step --------------------------------------------------------------------------------------

    def update_call(self, builder: Builder, update: ElementUpdate) -> Do:
        """Return the call of an element update, for the member that its binder stands for."""
        own = [builder.printer.locals[b.name] for b in _binders(update.element.binder)]
        given = arguments(update_needs(update, self.context), self.context, *own)
        return Do(call(self.parts.updates[key_of(update)], *given))

    def _update(self, builder: Builder, update: ElementUpdate) -> None:
        with (
            builder.guarded(update.guard),
            builder.printer.loops(_binders(update.element.binder)),
        ):
            builder.code.add(self.update_call(builder, update))

    def reward_guard(self, term: ir.Reward) -> ir.Expr | None:
        """Return the condition without which a reward term is zero for every member, if there is one."""
        return Guards(self.model, self.context.needs).reward(term)

    def earn(self, builder: Builder, term: ir.Reward, total: Operand, error: Operand) -> None:
        """Append what adds a reward term to ``total``, for the member that its binder stands for."""
        own = [builder.printer.locals[b.name] for b in _binders(term.binder)]
        given = arguments(self.context.needs.of(term.value), self.context, *own)
        value = call(self.parts.rewards[term.name], *given)
        if isinstance(term.value.type, Float):
            earned = builder.printer.scope.unique("earned")
            builder.code.add(const("float", earned, value))
            builder.code.add(assign(error, call("math::is_nan", earned), "|="))
            value = of(earned)
        builder.code.add(assign(total, call(self.to_fixed, value), "+="))

    def limit(self, builder: Builder, total: Expr) -> None:
        """Append what takes the sum of rewards for the step's reward."""
        if not self.model.rewards_fit:
            builder.code.add(assign(REWARD, call("math::saturate_fixed", total)))
        elif total != REWARD:
            builder.code.add(assign(REWARD, total))

    def conclude(self, builder: Builder, total: Expr) -> None:
        """Append what ends a step: its reward, and whether the episode has ended and how."""
        self.limit(builder, total)
        ends = self._test("is_terminal", self.model.terminal)
        builder.code.add(assign(member("result", "terminal"), ends))
        if self.model.success is not None:
            succeeds = self._test("is_success", self.model.success)
            builder.code.add(assign(member("result", "success"), succeeds))
        builder.code.add(Return(of("result")))

    def step(self) -> Function:
        """Return ``step``: the stages, then rewards, then whether the episode has ended."""
        builder = self.acting([*PLACE, ("int", "action"), ("D&", "draws"), ("State&", "next")])
        builder.code.add(assign("next", "state"))
        for stage in self.stages:
            for update in stage:
                self._update(builder, update)
        builder.code.add(zeroed("StepResult", "result"))
        for term in self.model.rewards:
            with (
                builder.guarded(self.reward_guard(term)),
                builder.printer.loops(_binders(term.binder)),
            ):
                self.earn(builder, term, REWARD, ERROR)
        self.conclude(builder, REWARD)
        return builder.done("StepResult", "step")

    def _test(self, name: str, expr: ir.Expr) -> Expr:
        return call(name, *arguments(self.context.needs.of(expr), self.context))

    def tests(self) -> list[Function]:
        """Return ``is_terminal`` and, if the model says what success is, ``is_success``."""
        found = []
        tests = (("terminal", self.model.terminal), ("success", self.model.success))
        for name, expr in tests:
            if expr is not None:
                builder = Builder(self.context).given(self.context.needs.of(expr))
                found.append(builder.value(expr).done("bool", f"is_{name}", self._origin(name)))
        return found

    def _origin(self, declaration: str) -> list[str]:
        span = self.model.spans.get(declaration)
        return [] if span is None else [f"// {origin(span)}"]

    # What the agent sees -------------------------------------------------------------------------

    def observe(self) -> Function:
        """Return ``observe``: the digits of the key, in order."""
        builder = self.acting([*PLACE, ("int", "action"), ("D&", "draws"), ("const State&", "next")])
        code = builder.code
        self.key.begin(code)
        for field in self.model.key:
            binders = self._key_binders(field)
            with builder.printer.loops(binders):
                self.key.put(code, field, self._digit(field, binders, builder))
        self.key.end(code)
        return builder.done("Key", "observe")

    def _key_binders(self, field: ir.KeyField) -> list[ir.Binder]:
        if field.observed:
            return list(self._observation(field.name).binders)
        return [ir.Binder(f"i{n}", t) for n, t in enumerate(field.indices)]

    def _observation(self, name: str) -> ir.Observation:
        return next(o for o in self.model.observations if o.name == name)

    def _digit(self, field: ir.KeyField, binders: list[ir.Binder], builder: Builder) -> Expr:
        if field.observed:
            needs = self.context.needs.of(self._observation(field.name).dist)
            more = builder.printer.exprs(_locals(binders))
            value = call(self.parts.observations[field.name], *arguments(needs, self.context, *more))
        else:
            value = builder.printer.expr(ir.StateRead(field.type, field.name, _locals(binders), True))
        if isinstance(field.type, Float):
            return call("math::canonical_bits", value)
        return shifted(value, -low_of(field.type))

    def filter(self) -> Function:
        """Return ``filter``: ``step`` with what the key tells instead of draws, and how likely that was."""
        builder = self.acting(
            [*PLACE, ("int", "action"), (self.key.argument, "key"), ("D&", "draws"), ("State&", "next")]
        )
        code = builder.code
        digits = self.digits(builder)
        code.add(assign("next", "state"))
        code.add(WEIGHT)
        for stage, assigns in zip(self.stages, self.model.stages(), strict=True):
            for element in stage:
                if not element.observed:
                    self._update(builder, element)
            seen = {a.variable for u in stage if u.observed for a in u.assigns}
            for update in assigns:
                if update.variable in seen:
                    self._condition(builder, update, digits[update.variable])
        code.add(when(self._test("is_terminal", self.model.terminal), NOTHING))
        self._weigh_observations(builder, digits)
        code.add(Return(of("weight")))
        return builder.done(
            "double", "filter", ["// A step given what was seen of it, and how likely that was."]
        )

    def observation_density(self) -> Function:
        """Return ``observation_density``: how likely a key is, given the state after the step."""
        builder = self.acting(
            [
                *PLACE,
                ("int", "action"),
                (self.key.argument, "key"),
                ("D&", "draws"),
                ("const State&", "next"),
            ]
        )
        code, digits = builder.code, self.digits(builder)
        for field in self.model.key:
            if field.observed:
                continue
            binders = self._key_binders(field)
            with builder.printer.loops(binders):
                seen = digits[field.name](binders)
                own = builder.printer.expr(ir.StateRead(field.type, field.name, _locals(binders), True))
                code.add(when(op(own, "!=", seen), NOTHING))
        code.add(WEIGHT)
        self._weigh_observations(builder, digits)
        code.add(Return(of("weight")))
        return builder.done(
            "double", "observation_density", ["// How likely a key is after a step to `next`."]
        )

    def weigh_hidden(self) -> Function:
        """Return ``weigh_hidden``: what ``filter`` returns, where the state after the step is known."""
        builder = self.acting(
            [*PLACE, ("int", "action"), (self.key.argument, "key"), ("const State&", "next")]
        )
        code = builder.code
        weighed = [a for stage in self.stages for u in stage if u.observed for a in u.assigns]
        weighed = [a for a in weighed if not self.model.variable(a.variable).copied]
        code.add(when(self._test("is_terminal", self.model.terminal), NOTHING))
        seen = {o.name for o in self.model.observations}
        digits = self.digits(builder, seen) if seen else {}
        code.add(WEIGHT)
        for update in weighed:
            with builder.printer.loops(update.binders):
                type_ = self.model.variable(update.variable).type
                value = ir.StateRead(type_, update.variable, _locals(update.binders), True)
                name = self.parts.densities[update.variable]
                self._weigh(builder, name, update, builder.printer.expr(value))
        self._weigh_observations(builder, digits)
        code.add(Return(of("weight")))
        return builder.done("double", "weigh_hidden")

    def _weigh_observations(self, builder: Builder, digits: Mapping[str, Digit]) -> None:
        for observation in self.model.observations:
            with builder.printer.loops(observation.binders):
                self._weigh(
                    builder,
                    self.parts.observation_densities[observation.name],
                    observation,
                    digits[observation.name](observation.binders),
                )

    def _condition(self, builder: Builder, update: ir.Assign, digit: Digit) -> None:
        """Append what takes a visible variable from the key."""
        with builder.printer.loops(update.binders):
            value = digit(update.binders)
            if not self.model.variable(update.variable).copied:
                self._weigh(builder, self.parts.densities[update.variable], update, value)
            indices = builder.printer.exprs(_locals(update.binders))
            setter = self.context.names.setters[update.variable]
            builder.code.add(Do(method("next", setter, *indices, value)))

    def _weigh(self, builder: Builder, name: str, part: ir.Assign | ir.Observation, value: Expr) -> None:
        more = builder.printer.exprs(_locals(part.binders))
        given = arguments(density_needs(part.dist, self.context), self.context, *more, value)
        builder.code.add(assign("weight", call(name, *given), "*="))

    def digits(self, builder: Builder, used: Set[str] | None = None) -> dict[str, Digit]:
        """Append the key's digits as locals; return a field's entry, given its binders.

        ``used`` are the fields that will be read, if not all are.
        """
        result: dict[str, Digit] = {}
        self.key.begin_reading(builder.code)
        for field in self.key.reading_of(used):
            if used is not None and field.name not in used:
                self._skip(builder, field)
                continue
            name = builder.printer.scope.unique(f"observed_{field.name}")
            if field.indices:
                length = length_of(field.indices)
                builder.code.add(Declare("std::int32_t", name, dimensions=(length,)))
                with builder.code.block(self.key.entries(field)):
                    builder.code.add(assign(of(name)["i"], self.key.take(field)))
                    self.key.go_on(builder.code, field)
            else:
                builder.code.add(Declare("const std::int32_t", name, self.key.take(field)))
                self.key.go_on(builder.code, field)
            result[field.name] = digit(builder, name, field.type)
        return result

    def keep_digits(self, builder: Builder, kept: Mapping[str, Expr]) -> None:
        """Append what stores digits of the key: ``kept`` has where, by the name of their field."""
        self.key.begin_reading(builder.code)
        for field in self.key.reading_of(kept.keys()):
            target = kept.get(field.name)
            if target is None:
                self._skip(builder, field)
                continue
            with builder.code.block(self.key.entries(field)) if field.indices else nullcontext():
                entry = target["i"] if field.indices else target
                builder.code.add(assign(entry, self.key.take(field)))
                self.key.go_on(builder.code, field)

    def _skip(self, builder: Builder, field: ir.KeyField) -> None:
        """Append what passes over the values of a field."""
        with builder.code.block(self.key.entries(field)) if field.indices else nullcontext():
            self.key.skip(builder.code, field)

    # What the agent does -------------------------------------------------------------------------

    def is_legal(self) -> Function:
        """Return ``is_legal``."""
        builder = self.acting([*PLACE, ("int", "action")])
        return builder.value(self.model.legal).done("bool", "is_legal", self._origin("legal"))

    def bounds(self, derived: bool = False, looks_up: bool = False) -> list[Function]:
        """Return ``upper``, ``tail`` and ``lower``; the first is ``declared_upper`` where more is derived.

        ``looks_up``: without ``lower``, as what the default policy earns is looked up.
        """
        result = []
        for name in ("upper", "tail") if looks_up else ("upper", "tail", "lower"):
            builder = self.given([*PLACE, HISTORY] if name == "lower" else PLACE)
            value = getattr(self.model, name)
            if value is None:
                builder.code.add(Return(Literal("0.0f")))
            else:
                builder.value(value if isinstance(value.type, Float) else ir.ToFloat(Float(), value))
            function = "declared_upper" if derived and name == "upper" else name
            comment = self._origin(name)
            if name == "lower" and value is None:
                comment = ["// There is none: kHasLower is false."]
            if name == "upper" and not comment:
                comment = ["// None is declared: the most that all steps together can earn."]
            result.append(builder.done("float", function, comment))
        return result

    def joint(self) -> Function:
        """Return ``joint``, which takes a product action's code apart."""
        builder = self.given([("int", "action")])
        action, code = self.model.action, builder.code
        code.add(zeroed("Joint", "result"))
        with builder.printer.block(for_down("i", length_of(action.indices))):
            size = size_of(action.type)
            component = member("result", "components")["i"]
            code.add(assign(component, value_of(of("action") % size, action.type)))
            code.add(assign("action", size, "/="))
        code.add(Return(of("result")))
        return builder.done("Joint", "joint")


def digit(builder: Builder, name: Operand, type_: Type) -> Digit:
    """Return a digit's entry that ``name`` holds, given its binders."""

    def entry(binders: Sequence[ir.Binder]) -> Expr:
        code = of(name)[position(binders, builder.printer)] if binders else of(name)
        return from_int32(code, type_)

    return entry


def clear(code: Code, *owners: str) -> None:
    """Append what makes the parts of a state zero."""
    for owner in owners:
        code.add(assign(owner, braces(owner.capitalize())))


def _locals(binders: Sequence[ir.Binder]) -> tuple[ir.Local, ...]:
    return tuple(ir.Local(b.type, b.name) for b in binders)


def _binders(binder: ir.Binder | None) -> list[ir.Binder]:
    return [] if binder is None else [binder]
