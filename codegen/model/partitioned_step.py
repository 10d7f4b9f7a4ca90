# SPDX-License-Identifier: Apache-2.0
"""``step`` in pieces that the warps of a block share: the same element updates, dealt by runs of members."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from hypgen.codegen.cpp.function_builder import Builder
from hypgen.codegen.layout.state_layout import Block
from hypgen.codegen.model.interface import ERROR, PLACE, Interface
from hypgen.codegen.passes.partition import Share, most_warps, shares
from hypgen.codegen.tree.expr import call, member, method, of, op, shifted
from hypgen.codegen.tree.statements import For, Function, assign, const, for_range, zeroed
from hypgen.dsl import ir
from hypgen.dsl.types import low_of, size_of

_COUNT = member("part", "count")
ACTING = [*PLACE, ("int", "action"), ("D&", "draws")]


class PartitionedStep:
    """Builds the functions that do parts of one model's step."""

    def __init__(self, interface: Interface, state: Block) -> None:
        self.interface = interface
        self.stages = [shares(stage, state) for stage in interface.stages if stage]

    def constants(self) -> tuple[str, ...]:
        """Return how many stages there are, and how many warps find something to do."""
        return (
            f"static constexpr int kStages = {len(self.stages)};",
            f"static constexpr int kMaxWarps = {most_warps(self.stages)};",
        )

    def all(self) -> list[Function]:
        """Return the functions in the order in which a block calls them."""
        return [self.stage(), self.rewards(), self.end()]

    def stage(self) -> Function:
        """Return ``step_stage``: what a warp does of a stage's updates."""
        builder = self.interface.acting([("int", "stage"), *ACTING, ("State&", "next"), ("Part", "part")])
        for number, stage in enumerate(self.stages):
            if len(self.stages) == 1:
                self._updates(builder, stage)
            else:
                with builder.printer.when(op("stage", "==", number)):
                    self._updates(builder, stage)
        return builder.done("void", "step_stage", ["// The part of a stage's updates that one warp does."])

    def _updates(self, builder: Builder, stage: Sequence[Share]) -> None:
        for share in stage:
            update = share.update
            with _dealt(builder, share.first, share.grain, update.element.binder, update.guard):
                builder.code.add(self.interface.update_call(builder, update))

    def rewards(self) -> Function:
        """Return ``step_rewards``: a warp's share of the reward terms, each member's a run of its own."""
        builder = self.interface.acting(
            [
                *ACTING,
                ("const State&", "next"),
                ("Part", "part"),
                ("std::int64_t&", "sum"),
                ("bool&", "error"),
            ]
        )
        first = 0
        for term in self.interface.model.rewards:
            with _dealt(builder, first, 1, term.binder, self.interface.reward_guard(term)):
                self.interface.earn(builder, term, "sum", "error")
            first += 1 if term.binder is None else size_of(term.binder.type)
        comment = ["// Adds the part of the reward terms that one warp computes; the sum is not saturated."]
        return builder.done("void", "step_rewards", comment)

    def end(self) -> Function:
        """Return ``step_end``: what the whole sum of rewards and the next state come to."""
        builder = self.interface.acting(
            [*ACTING, ("const State&", "next"), ("std::int64_t", "sum"), ("bool", "error")]
        )
        builder.code.add(zeroed("StepResult", "result"))
        builder.code.add(assign(ERROR, "error"))
        self.interface.conclude(builder, of("sum"))
        return builder.done("StepResult", "step_end")


@contextmanager
def _dealt(
    builder: Builder, first: int, grain: int, binder: ir.Binder | None, guard: ir.Expr | None
) -> Iterator[None]:
    """Put what is added meanwhile where only the warp that takes it gets to; runs count from ``first``."""
    printer = builder.printer
    if binder is None or grain >= size_of(binder.type):
        with (
            printer.when(method("part", "takes", first)),
            builder.guarded(guard),
            printer.loops([binder] if binder else []),
        ):
            yield
        printer.code.join()
        return
    low, high = low_of(binder.type), low_of(binder.type) + size_of(binder.type) - 1
    with builder.guarded(guard):
        if grain == 1:
            start = shifted(method("part", "first", first), low)

            def mine(variable: str) -> For:
                test, step = op(variable, "<=", high), assign(variable, _COUNT, "+=")
                return For("std::int32_t", variable, start, test, step)

            with printer.loop(binder, mine):
                yield
            printer.code.join()
            return
        runs = -(-size_of(binder.type) // grain)
        begin, step = method("part", "first", first), assign("run", _COUNT, "+=")
        with printer.block(For("int", "run", begin, op("run", "<", runs), step)):
            start, last = (shifted(of("run") * grain, offset) for offset in (low, low + grain - 1))
            if size_of(binder.type) % grain:
                last = call("math::min", last, high)
            builder.code.add(const("std::int32_t", "last", last))
            with printer.loop(binder, lambda variable: for_range(variable, start, "last")):
                yield
            printer.code.join()
