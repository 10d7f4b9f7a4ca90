# SPDX-License-Identifier: Apache-2.0
"""``default_policy``: what the agent does without a search."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from hypgen.codegen.cpp.body_printer import Context
from hypgen.codegen.cpp.function_builder import Builder, origin
from hypgen.codegen.cpp.text import code_of, scalar
from hypgen.codegen.cpp.word import Word
from hypgen.codegen.model.interface import HISTORY, PLACE, Interface
from hypgen.codegen.model.model_functions import arguments, position
from hypgen.codegen.tree.expr import Choice, Expr, Literal, Operand, Postfix, call, number, of, op, plus
from hypgen.codegen.tree.statements import For, Function, Return, assign, const, for_below, var, when
from hypgen.dsl import ir
from hypgen.dsl.ir.reads import reached
from hypgen.dsl.ir.walk import Node, free_locals, map_children
from hypgen.dsl.types import size_of

_NONE = Return(number(-1))


def _every_action() -> For:
    return for_below("action", Literal("kActionCount"), "int")


def _legal(action: Operand) -> Expr:
    return call("is_legal", "params", "fixed", "state", action)


class PolicyFunctions:
    """Builds ``default_policy`` and what it takes.

    The policy's lets that draw nothing become locals of ``default_policy``, computed once for all parts of
    the action; ``choose`` is given those that it reads.
    """

    def __init__(self, interface: Interface) -> None:
        self.interface = interface
        self.context = interface.context
        self.model = interface.model
        self.type = self.model.action.type
        self.always_legal = isinstance(self.model.legal, ir.Const) and self.model.legal.value is True

    def all(self) -> list[Function]:
        """Return the functions in the order in which they call each other."""
        policy = self.model.policy
        if policy is None:
            return [self._uniform()]
        dist = _with_locals(policy.dist, policy.lets)
        shared = _read(dist, policy.lets)
        taken = [let for let in shared if _name(let.name) in free_locals(dist)]
        needs = self.context.needs.of(dist)
        builder = self.interface.given([*PLACE, HISTORY, ("D&", "draws")])
        for let in shared:
            assert isinstance(let.dist, ir.Certain)
            value = _with_locals(let.dist.value, policy.lets)
            builder.printer.declare(_name(let.name), value, ir.Local(let.dist.type, _name(let.name)))
        values = [builder.printer.locals[_name(let.name)] for let in taken]
        self._choose(builder, policy, arguments(needs, self.context, *values))
        found = [self._chooser(policy, dist, taken)]
        if not self.always_legal:
            found.append(self._first_legal())
        return [*found, builder.done("int", "default_policy")]

    def _chooser(self, policy: ir.Policy, dist: ir.Dist, taken: Sequence[ir.Let]) -> Function:
        chosen = Builder(self.context).given(self.context.needs.of(dist))
        for let in taken:
            chosen.local(_name(let.name), let.dist.type)
        for binder in policy.binders:
            chosen.local(binder.name, binder.type)
        site = self.context.names.sites.get(policy.site.path, "")
        chosen.sampled(dist, site, position(policy.binders, chosen.printer))
        return chosen.done(scalar(self.type), "choose", [f"// {origin(policy.span)}: policy default"])

    def _choose(self, builder: Builder, policy: ir.Policy, given: list[Operand]) -> None:
        """Append what puts the action together and makes it legal."""
        code = builder.code
        if policy.binders:
            code.add(var("int", "chosen", 0))
            with builder.printer.loops(policy.binders):
                members = [builder.printer.locals[b.name] for b in policy.binders]
                choice = code_of(call("choose", *given, *members), self.type)
                code.add(assign("chosen", plus(of("chosen") * size_of(self.type), choice)))
        elif self.always_legal:
            code.add(Return(code_of(call("choose", *given), self.type)))
            return
        else:
            code.add(const("int", "chosen", code_of(call("choose", *given), self.type)))
        if self.always_legal:
            code.add(Return(of("chosen")))
        else:
            code.add(when(_legal("chosen"), Return(of("chosen"))))
            code.add(Return(call("first_legal", "params", "fixed", "state")))

    def _first_legal(self) -> Function:
        builder = self.interface.given(PLACE)
        with builder.printer.block(_every_action()):
            builder.code.add(when(_legal("action"), Return(of("action"))))
        builder.code.add(_NONE)
        return builder.done("int", "first_legal")

    def _uniform(self) -> Function:
        builder = self.interface.given([*PLACE, HISTORY, ("D&", "draws")])
        code = builder.code
        code.add(var("std::int32_t", "count", 0))
        with builder.printer.block(_every_action()):
            code.add(assign("count", Choice(_legal("action"), number(1), number(0)), "+="))
        code.join()
        code.add(when(op("count", "==", 0), _NONE))
        word = Word.of("policy_default", number(0)).plain
        code.add(var("std::int32_t", "left", call("dist::uniform", word, "count")))
        with builder.printer.block(_every_action()):
            last = op(Postfix(of("left"), "--"), "==", 0)
            code.add(when(op(_legal("action"), "&&", last), Return(of("action"))))
        code.add(_NONE)
        comment = ["// No `policy default` in the model: any legal action."]
        return builder.done("int", "default_policy", comment)


def uncalled_lets(context: Context) -> set[str]:
    """Return the policy's lets that nothing calls, since ``default_policy`` holds them in locals."""
    model, policy = context.model, context.model.policy
    if policy is None:
        return set()
    lets = {let.name: let for let in policy.lets}
    nodes: list[Node] = [let.dist for let in policy.lets if let.draws]
    nodes += [node for r in model.history.registers for node in (r.first.value, r.update.value)]
    nodes += [] if model.lower is None else [model.lower]
    for read in context.beliefs.values():  # functions of their own
        nodes += [read.operand] if read.index is None else [read.operand, read.index]
    called = {let.name for let in policy.lets if let.draws}
    called |= {node.let for node, _ in reached(nodes, {}, lets) if isinstance(node, ir.LetRead)}
    return lets.keys() - called


def _name(let: str) -> str:
    """Return the name of the local that holds a let, which shadows no other local."""
    return let.rpartition(".")[2]


def _with_locals(node: Any, lets: Iterable[ir.Let]) -> Any:
    """Return ``node`` with reads of lets that draw nothing as reads of locals of their names."""
    certain = {let.name for let in lets if not let.draws}

    def change(inner: Any) -> Any:
        if isinstance(inner, ir.LetRead) and inner.let in certain:
            return ir.Local(inner.type, _name(inner.let))
        return map_children(inner, change)

    return change(node)


def _read(dist: ir.Dist, lets: Sequence[ir.Let]) -> list[ir.Let]:
    """Return the lets whose locals ``dist`` comes to read, each after those that it reads."""
    named = {_name(let.name): let for let in lets}
    found: dict[str, ir.Let] = {}

    def visit(node: Node) -> None:
        for name in sorted(free_locals(node) & named.keys()):
            if name not in found:
                visit(_with_locals(named[name].dist, lets))
                found[name] = named[name]

    visit(dist)
    return list(found.values())
