# SPDX-License-Identifier: Apache-2.0
"""IR distributions as C++: a sampler that takes one word, and the density that belongs to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack

from hypgen.codegen.cpp import laws, masses
from hypgen.codegen.cpp.expressions import Append, ExprPrinter
from hypgen.codegen.cpp.sink import Sink, into
from hypgen.codegen.cpp.text import code_of, scalar, value_of
from hypgen.codegen.cpp.word import Word
from hypgen.codegen.layout import nodes
from hypgen.codegen.passes.expr_shapes import needs_statements
from hypgen.codegen.tree.expr import (
    Choice,
    Expr,
    Literal,
    Operand,
    Postfix,
    call,
    cast,
    method,
    number,
    of,
    op,
)
from hypgen.codegen.tree.statements import (
    BREAK,
    Declare,
    Do,
    Return,
    Statement,
    assign,
    const,
    for_below,
    increment,
    var,
    when,
    zeroed,
)
from hypgen.dsl import ir
from hypgen.dsl.ir.draw_words import words_of
from hypgen.dsl.ir.walk import negated
from hypgen.dsl.types import low_of, size_of

_DRAWN = "drawn%"  # the local that stands for what was drawn
_ONE, _ZERO = Literal("1.0"), Literal("0.0")


class DistPrinter:
    """Prints samplers and densities through the printer of the function that they stand in."""

    def __init__(self, printer: ExprPrinter) -> None:
        self.printer = printer
        self.code = printer.code

    # Sampling ------------------------------------------------------------------------------------

    def sample(self, dist: ir.Dist, word: Word, sink: Sink) -> None:
        """Append statements that give ``sink`` the value drawn with ``word``."""
        printer = self.printer
        match dist:
            case ir.Certain(value=value):
                printer.emit(value, sink)
            case ir.IfDist(then=ir.Certain(value=value), otherwise=ir.Certain(value=other)) if sink.keeps(
                value
            ) and sink.keeps(other):
                return
            case ir.IfDist(
                condition=condition, then=ir.Certain(value=value) as kept, otherwise=otherwise
            ) if sink.keeps(value):
                changes = ir.IfDist(dist.type, negated(condition), otherwise, kept)
                self.sample(changes, word, sink)
            case ir.IfDist(condition=condition, then=then, otherwise=otherwise):
                printer.branch(
                    printer.expr(condition),
                    lambda: self.sample(then, word, sink),
                    lambda: self.sample(otherwise, word, sink),
                    sink,
                )
            case ir.LetDist(name=name, value=value, body=body):
                printer.declare(name, value, body)
                self.sample(body, word, sink)
            case ir.Bernoulli(probability=p, complement=q):
                drawn = word.to(masses.is_plain(p, q, printer.context.model))
                self.code.add(sink(call("dist::bernoulli", drawn, masses.argument(p, q, printer))))
            case ir.Uniform(type=type_):
                self.code.add(sink(value_of(call("dist::uniform", word.plain, size_of(type_)), type_)))
            case ir.Noisy(type=type_, value=value):
                code = code_of(printer.expr(value), type_)
                drawn = word.to(self._is_plain_noise(dist))
                chosen = call("dist::noisy", drawn, code, self._noise(dist), size_of(type_))
                self.code.add(sink(value_of(chosen, type_)))
            case ir.Table():
                self._sample_table(dist, word, sink)
            case ir.UniformSet():
                self._sample_set(dist, word, sink)
            case ir.UniformInt() | ir.Counted():
                self.code.add(sink(laws.count(dist, word.plain, "", printer)))
            case ir.Continuous():
                self.code.add(sink(laws.draw(dist, word.plain, printer)))
            case ir.Binned():
                self.code.add(sink(laws.bin_drawn(dist, word.plain, printer)))
            case ir.Weighted():
                self._sample_weighted(dist, word, sink)
            case ir.Widened(dist=inner):
                self.sample(inner, word, sink)
            case ir.DrawIn(name=name, law=law, body=body):
                local = printer.scope.unique(name)
                self.code.add(zeroed(scalar(law.type), local))
                self.sample(law, word, into(local))
                printer.bind(name, local)
                self.sample(body, word.behind(words_of(law)), sink)
            case ir.InVariant(type=enum, variant=variant, dist=inner):
                make = printer.constructor(enum, variant)
                self.sample(inner, word, sink.through(lambda argument: call(make, argument)))
            case nodes.WeightedPick(value=value):
                drawn_name = printer.scope.unique("word")
                self.code.add(const("auto", drawn_name, word.plain))
                self._at_position(_position(drawn_name, dist.bounds()), value, sink)
            case nodes.UniformPick(count=count, value=value):
                self._at_position(call("dist::uniform", word.plain, printer.expr(count)), value, sink)
            case _:
                raise TypeError(f"no sampler for {type(dist).__name__}")

    def _at_position(self, position: Expr, value: ir.Expr, sink: Sink) -> None:
        """Append what gives ``sink`` a pick's value."""
        local = self.printer.scope.unique("entry")
        self.code.add(const("std::int32_t", local, position))
        self.printer.bind(nodes.POSITION, local)
        self.printer.emit(value, sink)

    def _is_plain_noise(self, dist: ir.Noisy) -> bool:
        """Return whether a 32-bit word tells the value, and surely the others too."""
        if not masses.is_plain(dist.probability, dist.complement, self.printer.context.model):
            return False
        others = size_of(dist.type) - 1
        return others < 2 or masses.leaves(dist.probability) >= others * masses.PART

    def _noise(self, dist: ir.Noisy) -> Expr:
        if self._is_plain_noise(dist):
            return self.printer.expr(dist.probability)
        return masses.mass(dist.probability, dist.complement, self.printer)

    def _sample_table(self, dist: ir.Table, word: Word, sink: Sink) -> None:
        printer = self.printer
        entries, last = dist.entries, dist.rest
        if last is None:
            entries, last = entries[:-1], entries[-1][0]
        if not entries:
            printer.emit(last, sink)
            return
        plain = masses.is_plain_table(dist, printer.context.model)
        shares = printer.exprs([p for _, p in entries]) if plain else masses.of_table(dist, printer)
        if len(entries) == 1 and not needs_statements(entries[0][0], last):
            first = call("dist::bernoulli", word.to(plain), shares[0])
            self.code.add(sink(Choice(first, printer.expr(entries[0][0]), printer.expr(last))))
            return
        drawn = printer.scope.unique("word")
        self.code.add(const("auto", drawn, word.to(plain)))
        bounds: list[str] = []
        for share in shares:
            name = printer.scope.unique("below")
            end = call("math::threshold", share) if plain else share
            if bounds:
                end = of(bounds[-1]) + end if plain else call("dist::up_to", bounds[-1], end)
            self.code.add(const("std::uint64_t", name, end))
            bounds.append(name)
        for position, ((value, _), bound) in enumerate(zip(entries, bounds, strict=True)):
            reached = op(drawn, "<", bound) if plain else method(drawn, "below", bound)
            with printer.when(reached, chained=bool(position) and not sink.returns):
                printer.emit(value, sink)
            if sink.returns:
                self.code.join()
        with ExitStack() as stack:
            self._or_else(stack, sink)
            printer.emit(last, sink)

    def _or_else(self, stack: ExitStack, sink: Sink) -> None:
        """Put what is added until ``stack`` closes behind the ``if`` before it, or into its ``else``."""
        if not sink.returns:
            stack.enter_context(self.printer.otherwise())

    def _sample_set(self, dist: ir.UniformSet, word: Word, sink: Sink) -> None:
        """Count the matches, then go to the one that the word picks."""
        printer, code = self.printer, self.code
        count, left = printer.scope.unique("count"), printer.scope.unique("left")
        code.add(var("std::int32_t", count, 0))
        self._matches(dist, lambda: code.add(increment(count)))
        with printer.when(op(count, "==", 0)):
            self._empty(dist, lambda d: self.sample(d, word, sink), lambda: printer.emit(dist.value, sink))
        picked = printer.scope.unique("picked")
        with ExitStack() as stack:
            self._or_else(stack, sink)
            code.add(var("std::int32_t", left, call("dist::uniform", word.plain, count)))
            if sink.returns and len(dist.binders) == 1:
                self._matches(dist, lambda: self._at_last(left, lambda: printer.emit(dist.value, sink)))
                code.add(Return(printer.first(ir.Binder("", dist.type))))
                return
            code.add(zeroed(scalar(dist.type), picked))
            self._matches(dist, lambda: self._at_last(left, lambda: printer.emit(dist.value, into(picked))))
            code.add(sink(of(picked)))

    def _sample_weighted(self, dist: ir.Weighted, word: Word, sink: Sink) -> None:
        """Add up the weights, then go to the first match that the word does not pass."""
        printer, code, binder = self.printer, self.code, dist.binders[0]
        everything, picked = map(printer.scope.unique, ("all", "picked"))
        code.add(Declare("dist::WeightSum", everything))
        code.add(var(scalar(binder.type), picked, printer.first(binder)))
        self._matches(
            dist,
            lambda: self._pick_if(method(everything, "add", printer.expr(dist.weight)), picked, binder),
        )
        with ExitStack() as stack:
            if dist.otherwise is not None:
                with printer.when(method(everything, "empty")):
                    self.sample(dist.otherwise, word, sink)
                self._or_else(stack, sink)
            drawn, walk = map(printer.scope.unique, ("word", "walk"))
            code.add(const("auto", drawn, word.fine))
            code.add(Declare("dist::WeightWalk", walk, arguments=(of(everything),)))

            def search() -> None:
                added = method(walk, "add", printer.expr(dist.weight))
                reached = op(added, "&&", method(drawn, "below", method(walk, "until")))
                self._pick_if(reached, picked, binder, BREAK)

            self._matches(dist, search)
            code.add(sink(of(picked)))

    def _pick_if(self, condition: Expr, picked: str, binder: ir.Binder, *then: Statement) -> None:
        self.code.add(when(condition, assign(picked, self.printer.locals[binder.name]), *then))

    def _at_last(self, left: str, append: Append) -> None:
        """Append what ``append`` does where none is ``left`` before the match."""
        with self.printer.when(op(Postfix(of(left), "--"), "==", 0)):
            append()
        self.code.join()

    def _matches(self, dist: ir.UniformSet | ir.Weighted, append: Append) -> None:
        """Loop over the matches of a set; ``append`` adds what to do at each."""
        with self.printer.loops(dist.binders):
            with ExitStack() as stack:
                if dist.condition is not None:
                    stack.enter_context(self.printer.when(self.printer.expr(dist.condition)))
                append()
            self.code.join()

    def _empty(self, dist: ir.UniformSet, otherwise: Callable[[ir.Dist], None], first: Append) -> None:
        """Append what a set without a match gives."""
        if dist.otherwise is not None:
            otherwise(dist.otherwise)
            return
        for binder in dist.binders:
            self.printer.bind(binder.name, self.printer.first(binder))
        first()

    # Densities -----------------------------------------------------------------------------------

    def density(self, dist: ir.Dist, value: Operand, sink: Sink) -> None:
        """Append statements that give ``sink`` the density (a double) of ``value``, a C++ local."""
        printer, code = self.printer, self.code
        match dist:
            case ir.Certain(value=certain):
                code.add(sink(Choice(self._is(certain, value), _ONE, _ZERO)))
            case ir.IfDist(condition=condition, then=then, otherwise=otherwise):
                printer.branch(
                    printer.expr(condition),
                    lambda: self.density(then, value, sink),
                    lambda: self.density(otherwise, value, sink),
                    sink,
                )
            case ir.LetDist(name=name, value=local, body=body):
                printer.declare(name, local, body)
                self.density(body, value, sink)
            case ir.Bernoulli(probability=p, complement=q):
                code.add(sink(call("dist::bernoulli_density", value, masses.argument(p, q, printer))))
            case ir.Uniform(type=type_):
                code.add(sink(_ONE / Literal(f"{size_of(type_)}.0")))
            case ir.Noisy(type=type_, value=center):
                same = self._is(center, value)
                code.add(sink(call("dist::noisy_density", same, self._noise(dist), size_of(type_))))
            case ir.Table():
                self._table_density(dist, value, sink)
            case ir.UniformSet():
                self._set_density(dist, value, sink)
            case ir.UniformInt() | ir.Counted():
                code.add(sink(laws.count(dist, value, "_density", printer)))
            case ir.Continuous():
                code.add(sink(laws.density(dist, value, printer)))
            case ir.Binned():
                code.add(sink(laws.bin_density(dist, value, printer)))
            case ir.Weighted():
                self._weighted_density(dist, value, sink)
            case ir.Widened(dist=inner):
                low = low_of(inner.type)
                outside = op(op(value, "<", low), "||", op(value, ">", low + size_of(inner.type) - 1))
                printer.branch(
                    outside, lambda: code.add(sink(_ZERO)), lambda: self.density(inner, value, sink), sink
                )
            case ir.DrawIn():
                self._density_of_two(dist, value, sink)
            case ir.InVariant():
                self._variant_density(dist, value, sink)
            case nodes.WeightedPick(probabilities=probabilities, value=picked):
                sums = printer.scope.unique("masses")
                code.add(Declare("dist::Masses", sums))
                for place, probability in enumerate(probabilities):
                    printer.bind(nodes.POSITION, number(place))
                    code.add(Do(method(sums, "take", printer.expr(probability), self._is(picked, value))))
                printer.bind(nodes.POSITION, number(len(probabilities)))
                code.add(Do(method(sums, "take_rest", self._is(picked, value))))
                code.add(sink(method(sums, "density")))
            case nodes.UniformPick():
                self._uniform_pick_density(dist, value, sink)
            case _:
                raise TypeError(f"no density for {type(dist).__name__}")

    def _table_density(self, dist: ir.Table, value: Operand, sink: Sink) -> None:
        printer, code = self.printer, self.code
        if masses.is_plain_table(dist, printer.context.model):  # the last entry's share matters to none
            shares = printer.exprs([p for _, p in dist.entries])
        else:
            shares = masses.of_table(dist, printer)
        sums = printer.scope.unique("masses")
        code.add(Declare("dist::Masses", sums))
        for (entry, _), share in zip(dist.entries, shares, strict=False):
            code.add(Do(method(sums, "take", share, self._is(entry, value))))
        last = dist.entries[-1][0] if dist.rest is None else dist.rest
        code.add(Do(method(sums, "take_rest", self._is(last, value))))
        code.add(sink(method(sums, "density")))

    def _density_of_two(self, dist: ir.DrawIn, value: Operand, sink: Sink) -> None:
        """Sum over what may be drawn first; a record of it tells what it was."""
        printer, code, total = self.printer, self.code, self.printer.scope.unique("total")
        code.add(var("double", total, _ZERO))

        def add(first: Operand) -> None:
            chance = printer.scope.unique("chance")
            code.add(var("double", chance, _ZERO))
            self.density(dist.law, first, into(chance))
            printer.bind(dist.name, first)  # only the body knows it: draws in the law may have the name
            with printer.when(op(chance, ">", _ZERO)):
                self.density(dist.body, value, into(total, "+=").through(lambda d: of(chance) * d))
            code.join()

        read = _told_by_record(dist)
        if read is None:
            with printer.loops((ir.Binder(dist.name, dist.law.type),)):
                add(printer.locals[dist.name])
        else:
            printer.bind(_DRAWN, value)
            told, local = printer.expr(read), printer.scope.unique(dist.name)
            code.add(const(scalar(read.type), local, told))
            add(local)
        code.add(sink(of(total)))

    def _variant_density(self, dist: ir.InVariant, value: Operand, sink: Sink) -> None:
        printer, inner = self.printer, dist.dist
        printer.bind(_DRAWN, value)
        whole = ir.Local(dist.type, _DRAWN)

        def of_argument() -> None:
            argument = printer.scope.unique("argument")
            if not isinstance(inner, ir.Uniform):  # its density is that of any value
                read = printer.expr(dist.argument_of(whole))
                self.code.add(const(scalar(inner.type), argument, read))
            self.density(inner, argument, sink)

        made = printer.expr(dist.is_made(whole))
        printer.branch(made, of_argument, lambda: self.code.add(sink(_ZERO)), sink)

    def _set_density(self, dist: ir.UniformSet, value: Operand, sink: Sink) -> None:
        printer, code = self.printer, self.code
        count, equal = printer.scope.unique("count"), printer.scope.unique("equal")
        code.add(var("std::int32_t", count, 0))
        code.add(var("std::int32_t", equal, 0))

        def tally() -> None:
            code.add(increment(count))
            code.add(when(self._is(dist.value, value), increment(equal)))

        self._matches(dist, tally)
        with printer.when(op(count, "==", 0)):
            self._empty(
                dist,
                lambda d: self.density(d, value, sink),
                lambda: code.add(sink(Choice(self._is(dist.value, value), _ONE, _ZERO))),
            )
        with ExitStack() as stack:
            self._or_else(stack, sink)
            code.add(sink(_ratio(equal, count)))

    def _weighted_density(self, dist: ir.Weighted, value: Operand, sink: Sink) -> None:
        printer, code, binder = self.printer, self.code, dist.binders[0]
        everything, likeliest, walk, found = map(printer.scope.unique, ("all", "likeliest", "walk", "found"))
        code.add(Declare("dist::WeightSum", everything))
        code.add(var(scalar(binder.type), likeliest, printer.first(binder)))
        self._matches(
            dist,
            lambda: self._pick_if(method(everything, "add", printer.expr(dist.weight)), likeliest, binder),
        )
        with printer.when(method(everything, "empty")):
            if dist.otherwise is not None:
                self.density(dist.otherwise, value, sink)
            else:
                code.add(sink(Choice(op(value, "==", printer.first(binder)), _ONE, _ZERO)))
        with ExitStack() as stack:
            self._or_else(stack, sink)
            code.add(Declare("dist::WeightWalk", walk, arguments=(of(everything),)))
            code.add(var("std::uint64_t", found, 0))
            until = method(walk, "until")

            def search() -> None:
                is_value = op(value, "==", printer.locals[binder.name])
                reached = op(method(walk, "add", printer.expr(dist.weight)), "&&", is_value)
                code.add(when(reached, assign(found, until - method(walk, "before"))))

            self._matches(dist, search)
            rest = Choice(op(value, "==", likeliest), Literal("dist::kWhole") - until, number(0))
            code.add(sink(call("dist::share_of", of(found) + rest)))

    def _uniform_pick_density(self, dist: nodes.UniformPick, value: Operand, sink: Sink) -> None:
        printer, code = self.printer, self.code
        count, equal = printer.scope.unique("count"), printer.scope.unique("equal")
        code.add(const("std::int32_t", count, printer.expr(dist.count)))
        code.add(var("std::int32_t", equal, 0))
        entry = printer.scope.unique("entry")
        printer.bind(nodes.POSITION, entry)
        with printer.block(for_below(entry, count)):
            is_value = self._is(dist.value, value)
            code.add(assign(equal, Choice(is_value, number(1), number(0)), "+="))
        code.join()
        code.add(sink(_ratio(equal, count)))

    def _is(self, expr: ir.Expr, value: Operand) -> Expr:
        return op(value, "==", self.printer.expr(expr))


def _told_by_record(dist: ir.DrawIn) -> ir.Expr | None:
    """Return the field of a record drawn, ``_DRAWN``, that is what was drawn first; None if none is."""
    body = dist.body
    while isinstance(body, ir.DrawIn | ir.LetDist) and body.name != dist.name:
        body = body.body
    if not isinstance(body, ir.Certain) or not isinstance(body.value, ir.MakeRecord):
        return None
    record = body.value.record
    for (name, type_), value in zip(record.fields, body.value.values, strict=True):
        if isinstance(value, ir.Local) and value.name == dist.name and type_ == dist.law.type:
            return ir.FieldRead(type_, record, name, ir.Local(record, _DRAWN))
    return None


def _ratio(part: str, whole: str) -> Expr:
    return cast("double", part) / cast("double", whole)


def _position(word: str, bounds: Sequence[int]) -> Expr:
    """Return how many of the bounds a word has reached; none reaches 2^32."""
    result: Expr | None = None
    for bound in bounds:
        if bound < nodes.WORDS:
            reached = call("dist::reached", word, Literal(f"0x{bound:08X}u"))
            result = reached if result is None else result + reached
    return number(0) if result is None else result
