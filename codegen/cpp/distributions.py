# SPDX-License-Identifier: Apache-2.0
"""IR distributions as C++: a sampler that takes one word, and the density that belongs to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass

from hypgen.codegen.cpp import masses
from hypgen.codegen.cpp.expressions import ADD, TERNARY, Append, ExprPrinter
from hypgen.codegen.cpp.laws import bin_density_text, bin_text, count_text, density_text, draw_text
from hypgen.codegen.cpp.sink import Sink
from hypgen.codegen.cpp.text import code_of, integer, scalar, shifted
from hypgen.codegen.layout import nodes
from hypgen.codegen.passes.expr_shapes import needs_statements
from hypgen.dsl import ir
from hypgen.dsl.ir.draw_words import words_of
from hypgen.dsl.ir.walk import negated
from hypgen.dsl.types import Bool, Type, low_of, size_of

_DRAWN = "drawn%"  # the local that stands for what was drawn


@dataclass(frozen=True)
class Word:
    """The word of a draw as C++: ``plain`` of 32 bits, ``fine`` with the 31 bits below it; its ``place``."""

    plain: str
    fine: str
    place: str

    @staticmethod
    def of(site: str, index: str) -> Word:
        """Return the word that a site of the model draws."""
        place = f"Site::{site}, {index}"
        return Word(f"draws.word({place})", f"dist::fine(draws, {place})", place)

    def to(self, is_plain: bool) -> str:
        """Return one of both."""
        return self.plain if is_plain else self.fine

    def behind(self, words: int) -> Word:
        """Return the word that lies so many behind this one, for a draw within the draw."""
        steps = "dist::kNextDraw" if words == 1 else f"{words} * dist::kNextDraw"
        place = f"{self.place} + {steps}" if words else self.place
        return Word(f"draws.word({place})", f"dist::fine(draws, {place})", place)


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
                    printer.text(condition),
                    lambda: self.sample(then, word, sink),
                    lambda: self.sample(otherwise, word, sink),
                    sink,
                )
            case ir.LetDist(name=name, value=value, body=body):
                printer.declare(name, value, body)
                self.sample(body, word, sink)
            case ir.Bernoulli(probability=p, complement=q):
                drawn = word.to(masses.is_plain(p, q, printer.context.model))
                self.code.add(sink(f"dist::bernoulli({drawn}, {masses.text(p, q, printer)})"))
            case ir.Uniform(type=type_):
                self.code.add(sink(_value(f"dist::uniform({word.plain}, {size_of(type_)})", type_)))
            case ir.Noisy(type=type_, value=value):
                code = code_of(printer.text(value, ADD), type_)
                drawn = word.to(self._is_plain_noise(dist))
                chosen = f"dist::noisy({drawn}, {code}, {self._noise(dist)}, {size_of(type_)})"
                self.code.add(sink(_value(chosen, type_)))
            case ir.Table():
                self._sample_table(dist, word, sink)
            case ir.UniformSet():
                self._sample_set(dist, word, sink)
            case ir.UniformInt() | ir.Counted():
                self.code.add(sink(count_text(dist, word.plain, "", printer)))
            case ir.Continuous():
                self.code.add(sink(draw_text(dist, word.plain, printer)))
            case ir.Binned():
                self.code.add(sink(bin_text(dist, word.plain, printer)))
            case ir.Weighted():
                self._sample_weighted(dist, word, sink)
            case ir.Widened(dist=inner):
                self.sample(inner, word, sink)
            case ir.DrawIn(name=name, law=law, body=body):
                local = printer.scope.unique(name)
                self.code.add(f"{scalar(law.type)} {local}{{}};")
                self.sample(law, word, Sink(f"{local} = "))
                printer.bind(name, local)
                self.sample(body, word.behind(words_of(law)), sink)
            case ir.InVariant(type=enum, variant=variant, dist=inner):
                make = printer.constructor(enum, variant)
                self.sample(inner, word, Sink(f"{sink.before}{make}(", f"){sink.after}"))
            case nodes.WeightedPick(value=value):
                drawn = printer.scope.unique("word")
                self.code.add(f"const auto {drawn} = {word.plain};")
                self._at_position(_position(drawn, dist.bounds()), value, sink)
            case nodes.UniformPick(count=count, value=value):
                self._at_position(f"dist::uniform({word.plain}, {printer.text(count)})", value, sink)
            case _:
                raise TypeError(f"no sampler for {type(dist).__name__}")

    def _at_position(self, position: str, value: ir.Expr, sink: Sink) -> None:
        """Append what gives ``sink`` a pick's value."""
        local = self.printer.scope.unique("entry")
        self.code.add(f"const std::int32_t {local} = {position};")
        self.printer.bind(nodes.POSITION, local)
        self.printer.emit(value, sink)

    def _is_plain_noise(self, dist: ir.Noisy) -> bool:
        """Return whether a 32-bit word tells the value, and surely the others too."""
        if not masses.is_plain(dist.probability, dist.complement, self.printer.context.model):
            return False
        others = size_of(dist.type) - 1
        return others < 2 or masses.leaves(dist.probability) >= others * masses.PART

    def _noise(self, dist: ir.Noisy) -> str:
        if self._is_plain_noise(dist):
            return self.printer.text(dist.probability)
        return masses.mass_text(dist.probability, dist.complement, self.printer)

    def _sample_table(self, dist: ir.Table, word: Word, sink: Sink) -> None:
        printer = self.printer
        entries, last = dist.entries, dist.rest
        if last is None:
            entries, last = entries[:-1], entries[-1][0]
        if not entries:
            printer.emit(last, sink)
            return
        plain = masses.is_plain_table(dist, printer.context.model)
        shares = [printer.text(p) for _, p in entries] if plain else masses.table_texts(dist, printer)
        if len(entries) == 1 and not needs_statements(entries[0][0], last):
            first = f"dist::bernoulli({word.to(plain)}, {shares[0]})"
            texts = printer.text(entries[0][0], TERNARY + 1), printer.text(last, TERNARY + 1)
            self.code.add(sink(f"{first} ? {texts[0]} : {texts[1]}"))
            return
        drawn = printer.scope.unique("word")
        self.code.add(f"const auto {drawn} = {word.to(plain)};")
        bounds: list[str] = []
        for share in shares:
            name = printer.scope.unique("below")
            if plain:
                end = " + ".join([*bounds[-1:], f"math::threshold({share})"])
            else:
                end = f"dist::up_to({bounds[-1]}, {share})" if bounds else share
            self.code.add(f"const std::uint64_t {name} = {end};")
            bounds.append(name)
        reached = "{} < {}" if plain else "{}.below({})"
        for position, ((value, _), bound) in enumerate(zip(entries, bounds, strict=True)):
            chained = "else if" if position and not sink.returns else "if"
            with self.printer.block(f"{chained} ({reached.format(drawn, bound)})"):
                printer.emit(value, sink)
            if sink.returns:
                self.code.join()
        with ExitStack() as stack:
            if not sink.returns:
                stack.enter_context(self.printer.block("else"))
            printer.emit(last, sink)

    def _sample_set(self, dist: ir.UniformSet, word: Word, sink: Sink) -> None:
        """Count the matches, then go to the one that the word picks."""
        printer, code = self.printer, self.code
        count, left = printer.scope.unique("count"), printer.scope.unique("left")
        code.add(f"std::int32_t {count} = 0;")
        self._matches(dist, lambda: code.add(f"++{count};"))
        with printer.block(f"if ({count} == 0)"):
            self._empty(dist, lambda d: self.sample(d, word, sink), lambda: printer.emit(dist.value, sink))
        picked = printer.scope.unique("picked")
        with ExitStack() as stack:
            if not sink.returns:
                stack.enter_context(printer.block("else"))
            code.add(f"std::int32_t {left} = dist::uniform({word.plain}, {count});")
            if sink.returns and len(dist.binders) == 1:
                self._matches(dist, lambda: self._return_at(dist, left, sink))
                code.add(f"return {printer.first(ir.Binder('', dist.type))};")
                return
            code.add(f"{scalar(dist.type)} {picked}{{}};")
            self._matches(dist, lambda: self._pick_at(dist, left, picked))
            code.add(sink(picked))

    def _sample_weighted(self, dist: ir.Weighted, word: Word, sink: Sink) -> None:
        """Add up the weights, then go to the first match that the word does not pass."""
        printer, code, binder = self.printer, self.code, dist.binders[0]
        everything, picked = map(printer.scope.unique, ("all", "picked"))
        code.add(f"dist::WeightSum {everything};")
        code.add(f"{scalar(binder.type)} {picked} = {printer.first(binder)};")
        self._matches(
            dist,
            lambda: self._pick_if(f"{everything}.add({printer.text(dist.weight)})", picked, binder),
        )
        with ExitStack() as stack:
            if dist.otherwise is not None:
                with printer.block(f"if ({everything}.empty())"):
                    self.sample(dist.otherwise, word, sink)
                if not sink.returns:
                    stack.enter_context(printer.block("else"))
            drawn, walk = map(printer.scope.unique, ("word", "walk"))
            code.add(f"const auto {drawn} = {word.fine};")
            code.add(f"dist::WeightWalk {walk}({everything});")

            def search() -> None:
                condition = f"{walk}.add({printer.text(dist.weight)}) && {drawn}.below({walk}.until())"
                self._pick_if(condition, picked, binder, "break;")

            self._matches(dist, search)
            code.add(sink(picked))

    def _pick_if(self, condition: str, picked: str, binder: ir.Binder, *then: str) -> None:
        with self.printer.block(f"if ({condition})"):
            for line in (f"{picked} = {self.printer.locals[binder.name]};", *then):
                self.code.add(line)
        self.code.join()

    def _return_at(self, dist: ir.UniformSet, left: str, sink: Sink) -> None:
        with self.printer.block(f"if ({left}-- == 0)"):
            self.printer.emit(dist.value, sink)
        self.code.join()

    def _pick_at(self, dist: ir.UniformSet, left: str, picked: str) -> None:
        with self.printer.block(f"if ({left}-- == 0)"):
            self.printer.emit(dist.value, Sink(f"{picked} = "))
        self.code.join()

    def _matches(self, dist: ir.UniformSet | ir.Weighted, append: Append) -> None:
        """Loop over the matches of a set; ``append`` adds what to do at each."""
        with self.printer.loops(dist.binders):
            with ExitStack() as stack:
                if dist.condition is not None:
                    condition = self.printer.text(dist.condition)
                    stack.enter_context(self.printer.block(f"if ({condition})"))
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

    def density(self, dist: ir.Dist, value: str, sink: Sink) -> None:
        """Append statements that give ``sink`` the density (a double) of ``value``, a C++ local."""
        printer, code = self.printer, self.code
        match dist:
            case ir.Certain(value=certain):
                code.add(sink(f"{self._is(certain, value)} ? 1.0 : 0.0"))
            case ir.IfDist(condition=condition, then=then, otherwise=otherwise):
                printer.branch(
                    printer.text(condition),
                    lambda: self.density(then, value, sink),
                    lambda: self.density(otherwise, value, sink),
                    sink,
                )
            case ir.LetDist(name=name, value=local, body=body):
                printer.declare(name, local, body)
                self.density(body, value, sink)
            case ir.Bernoulli(probability=p, complement=q):
                code.add(sink(f"dist::bernoulli_density({value}, {masses.text(p, q, printer)})"))
            case ir.Uniform(type=type_):
                code.add(sink(f"1.0 / {size_of(type_)}.0"))
            case ir.Noisy(type=type_, value=center):
                same = self._is(center, value)
                code.add(sink(f"dist::noisy_density({same}, {self._noise(dist)}, {size_of(type_)})"))
            case ir.Table():
                self._table_density(dist, value, sink)
            case ir.UniformSet():
                self._set_density(dist, value, sink)
            case ir.UniformInt() | ir.Counted():
                code.add(sink(count_text(dist, value, "_density", printer)))
            case ir.Continuous():
                code.add(sink(density_text(dist, value, printer)))
            case ir.Binned():
                code.add(sink(bin_density_text(dist, value, printer)))
            case ir.Weighted():
                self._weighted_density(dist, value, sink)
            case ir.Widened(dist=inner):
                low = low_of(inner.type)
                printer.branch(
                    f"{value} < {integer(low)} || {value} > {integer(low + size_of(inner.type) - 1)}",
                    lambda: code.add(sink("0.0")),
                    lambda: self.density(inner, value, sink),
                    sink,
                )
            case ir.DrawIn():
                self._density_of_two(dist, value, sink)
            case ir.InVariant():
                self._variant_density(dist, value, sink)
            case nodes.WeightedPick(probabilities=probabilities, value=picked):
                sums = printer.scope.unique("masses")
                code.add(f"dist::Masses {sums};")
                for number, probability in enumerate(probabilities):
                    printer.bind(nodes.POSITION, str(number))
                    code.add(f"{sums}.take({printer.text(probability)}, {self._is(picked, value)});")
                printer.bind(nodes.POSITION, str(len(probabilities)))
                code.add(f"{sums}.take_rest({self._is(picked, value)});")
                code.add(sink(f"{sums}.density()"))
            case nodes.UniformPick():
                self._uniform_pick_density(dist, value, sink)
            case _:
                raise TypeError(f"no density for {type(dist).__name__}")

    def _table_density(self, dist: ir.Table, value: str, sink: Sink) -> None:
        printer, code = self.printer, self.code
        if masses.is_plain_table(dist, printer.context.model):  # the last entry's share matters to none
            shares = [printer.text(p) for _, p in dist.entries]
        else:
            shares = masses.table_texts(dist, printer)
        sums = printer.scope.unique("masses")
        code.add(f"dist::Masses {sums};")
        for (entry, _), share in zip(dist.entries, shares, strict=False):
            code.add(f"{sums}.take({share}, {self._is(entry, value)});")
        last = dist.entries[-1][0] if dist.rest is None else dist.rest
        code.add(f"{sums}.take_rest({self._is(last, value)});")
        code.add(sink(f"{sums}.density()"))

    def _density_of_two(self, dist: ir.DrawIn, value: str, sink: Sink) -> None:
        """Sum over what may be drawn first; a record of it tells what it was."""
        printer, code, total = self.printer, self.code, self.printer.scope.unique("total")
        code.add(f"double {total} = 0.0;")

        def add(first: str) -> None:
            chance = printer.scope.unique("chance")
            code.add(f"double {chance} = 0.0;")
            self.density(dist.law, first, Sink(f"{chance} = "))
            printer.bind(dist.name, first)  # only the body knows it: draws in the law may have the name
            with printer.block(f"if ({chance} > 0.0)"):
                self.density(dist.body, value, Sink(f"{total} += {chance} * (", ");"))
            code.join()

        read = _told_by_record(dist)
        if read is None:
            with printer.loops((ir.Binder(dist.name, dist.law.type),)):
                add(printer.locals[dist.name])
        else:
            printer.bind(_DRAWN, value)
            text, local = printer.text(read), printer.scope.unique(dist.name)
            code.add(f"const {scalar(read.type)} {local} = {text};")
            add(local)
        code.add(sink(total))

    def _variant_density(self, dist: ir.InVariant, value: str, sink: Sink) -> None:
        printer, inner = self.printer, dist.dist
        printer.bind(_DRAWN, value)
        whole = ir.Local(dist.type, _DRAWN)

        def of_argument() -> None:
            argument = printer.scope.unique("argument")
            if not isinstance(inner, ir.Uniform):  # its density is that of any value
                read = printer.text(dist.argument_of(whole))
                self.code.add(f"const {scalar(inner.type)} {argument} = {read};")
            self.density(inner, argument, sink)

        printer.branch(
            printer.text(dist.is_made(whole)), of_argument, lambda: self.code.add(sink("0.0")), sink
        )

    def _set_density(self, dist: ir.UniformSet, value: str, sink: Sink) -> None:
        printer, code = self.printer, self.code
        count, equal = printer.scope.unique("count"), printer.scope.unique("equal")
        code.add(f"std::int32_t {count} = 0;")
        code.add(f"std::int32_t {equal} = 0;")

        def tally() -> None:
            code.add(f"++{count};")
            with printer.block(f"if ({self._is(dist.value, value)})"):
                code.add(f"++{equal};")
            code.join()

        self._matches(dist, tally)
        with printer.block(f"if ({count} == 0)"):
            self._empty(
                dist,
                lambda d: self.density(d, value, sink),
                lambda: code.add(sink(f"{self._is(dist.value, value)} ? 1.0 : 0.0")),
            )
        with ExitStack() as stack:
            if not sink.returns:
                stack.enter_context(printer.block("else"))
            code.add(sink(f"static_cast<double>({equal}) / static_cast<double>({count})"))

    def _weighted_density(self, dist: ir.Weighted, value: str, sink: Sink) -> None:
        printer, code, binder = self.printer, self.code, dist.binders[0]
        everything, likeliest, walk, found = map(printer.scope.unique, ("all", "likeliest", "walk", "found"))
        code.add(f"dist::WeightSum {everything};")
        code.add(f"{scalar(binder.type)} {likeliest} = {printer.first(binder)};")
        self._matches(
            dist,
            lambda: self._pick_if(f"{everything}.add({printer.text(dist.weight)})", likeliest, binder),
        )
        with printer.block(f"if ({everything}.empty())"):
            if dist.otherwise is not None:
                self.density(dist.otherwise, value, sink)
            else:
                code.add(sink(f"{value} == {printer.first(binder)} ? 1.0 : 0.0"))
        with ExitStack() as stack:
            if not sink.returns:
                stack.enter_context(printer.block("else"))
            code.add(f"dist::WeightWalk {walk}({everything});")
            code.add(f"std::uint64_t {found} = 0;")

            def search() -> None:
                is_value = f"{value} == {printer.locals[binder.name]}"
                with printer.block(f"if ({walk}.add({printer.text(dist.weight)}) && {is_value})"):
                    code.add(f"{found} = {walk}.until() - {walk}.before();")
                code.join()

            self._matches(dist, search)
            rest = f"{value} == {likeliest} ? dist::kWhole - {walk}.until() : 0"
            code.add(sink(f"dist::share_of({found} + ({rest}))"))

    def _uniform_pick_density(self, dist: nodes.UniformPick, value: str, sink: Sink) -> None:
        printer, code = self.printer, self.code
        count, equal = printer.scope.unique("count"), printer.scope.unique("equal")
        code.add(f"const std::int32_t {count} = {printer.text(dist.count)};")
        code.add(f"std::int32_t {equal} = 0;")
        entry = printer.bind(nodes.POSITION, printer.scope.unique("entry"))
        with printer.block(f"for (std::int32_t {entry} = 0; {entry} < {count}; ++{entry})"):
            code.add(f"{equal} += {self._is(dist.value, value)} ? 1 : 0;")
        code.join()
        code.add(sink(f"static_cast<double>({equal}) / static_cast<double>({count})"))

    def _is(self, expr: ir.Expr, value: str) -> str:
        text = self.printer.text(expr, ADD)
        return f"{value} == ({text})" if text.startswith("!") else f"{value} == {text}"


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


def _value(code: str, type_: Type) -> str:
    return f"{code} != 0" if isinstance(type_, Bool) else shifted(code, low_of(type_))


def _position(word: str, bounds: Sequence[int]) -> str:
    """Return how many of the bounds a word has reached; none reaches 2^32."""
    reached = [f"dist::reached({word}, 0x{b:08X}u)" for b in bounds if b < nodes.WORDS]
    return " + ".join(reached) or "0"
