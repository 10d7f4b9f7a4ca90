# SPDX-License-Identifier: Apache-2.0
"""The functions that keep the history: what the default policy knows of the past."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.codegen.belief.belief_functions import BeliefFunctions
from hypgen.codegen.cpp.function_builder import Builder, origin
from hypgen.codegen.layout import history_layout
from hypgen.codegen.model.interface import PLACE, Interface
from hypgen.codegen.model.model_functions import arguments
from hypgen.codegen.tree.expr import TRUE, Expr, braces, call, method
from hypgen.codegen.tree.statements import Comment, Do, Function, assign, const
from hypgen.dsl import ir

_STEP = [*PLACE, ("int", "action")]
_CHANGE = [("const History&", "history"), ("History&", "after")]
_NEXT = ("const State&", "next")


class HistoryFunctions:
    """Builds ``init_history``, ``advance_history`` and ``roll_history`` of a model that keeps something."""

    def __init__(self, interface: Interface, beliefs: BeliefFunctions | None) -> None:
        self.interface = interface
        self.beliefs = beliefs
        self.context = interface.context
        self.model = interface.model
        self.kept = [o for o in self.model.observations if o.name in self.model.history.observations]
        self.fields = history_layout.fields(self.model)

    def all(self) -> list[Function]:
        """Return the functions in the order in which they call each other."""
        return [self.init(), self.remember(), self.advance(), self.roll()]

    def init(self) -> Function:
        """Return ``init_history``: the registers' first values."""
        builder = self.interface.given([*PLACE, ("History&", "history")])
        builder.code.add(assign("history", braces("History")))
        for register in self.model.history.registers:
            builder.code.add(Comment(f"{origin(register.span)}: {register.name}"))
            self._fill(builder, "history", register, register.first)
        if self.beliefs is not None:
            self.beliefs.start(builder)
        return builder.done("void", "init_history")

    def remember(self) -> Function:
        """Return ``remember``: all that is kept but what was seen."""
        builder = self.interface.acting([*_STEP, *_CHANGE])
        builder.code.add(assign("after", braces("History")))
        for register in self.model.history.registers:
            builder.code.add(Comment(f"{origin(register.span)}: {register.name}'"))
            self._fill(builder, "after", register, register.update)
        if self.model.history.action:
            action = self.model.action
            binders = [ir.Binder(f"i{n}", t) for n, t in enumerate(action.indices)]
            with builder.printer.loops(binders):
                done = ir.ActionRead(action.type, _locals(binders))
                self._set(builder, "after", history_layout.ACTION, binders, builder.printer.expr(done))
        if any(f.key == history_layout.STARTED for f in self.fields):
            self._set(builder, "after", history_layout.STARTED, [], TRUE)
        return builder.done("void", "remember", ["// What is kept besides what was seen."])

    def advance(self) -> Function:
        """Return ``advance_history``: what was seen comes from the key."""
        key = (self.interface.key.argument, "key")
        builder = self.interface.given([*_STEP, key, _NEXT, *_CHANGE])
        given = ("params", "fixed", "state", "action", "history", "after")
        builder.code.add(Do(call("remember", *given)))
        if self.kept:
            digits = self.interface.digits(builder, {o.name for o in self.kept})
            for observation in self.kept:
                with builder.printer.loops(observation.binders):
                    value = digits[observation.name](observation.binders)
                    self._keep(builder, observation, value)
        if self.beliefs is not None:
            self.beliefs.advance(builder, "action")
        return builder.done("void", "advance_history")

    def roll(self) -> Function:
        """Return ``roll_history``: what was seen is drawn, and only what is kept."""
        builder = self.interface.acting([*_STEP, ("D&", "draws"), _NEXT, *_CHANGE])
        given = ("params", "fixed", "state", self.interface.code, "history", "after")
        builder.code.add(Do(call("remember", *given)))
        for observation in self.kept:
            with builder.printer.loops(observation.binders):
                needs = self.context.needs.of(observation.dist)
                more = builder.printer.exprs(_locals(observation.binders))
                name = self.interface.parts.observations[observation.name]
                self._keep(builder, observation, call(name, *arguments(needs, self.context, *more)))
        if self.beliefs is not None and self.beliefs.kept:
            given = ("params", "fixed", "state", self.interface.code, "draws", "next")
            builder.code.add(const("Key", "key", call("observe", *given)))
            self.beliefs.advance(builder, self.interface.code)
        return builder.done("void", "roll_history")

    def _fill(self, builder: Builder, owner: str, register: ir.Register, entries: ir.Entries) -> None:
        with builder.printer.loops(entries.binders):
            value = builder.printer.expr(entries.value)
            self._set(builder, owner, history_layout.memory_key(register.name), entries.binders, value)

    def _keep(self, builder: Builder, observation: ir.Observation, value: Expr) -> None:
        key = history_layout.observation_key(observation.name)
        self._set(builder, "after", key, observation.binders, value)

    def _set(self, builder: Builder, owner: str, key: str, binders: Sequence[ir.Binder], value: Expr) -> None:
        indices = builder.printer.exprs(_locals(binders))
        setter = self.context.names.history_setters[key]
        builder.code.add(Do(method(owner, setter, *indices, value)))


def _locals(binders: Sequence[ir.Binder]) -> tuple[ir.Local, ...]:
    return tuple(ir.Local(b.type, b.name) for b in binders)
