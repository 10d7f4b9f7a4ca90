# SPDX-License-Identifier: Apache-2.0
"""Reads Cassandra's format (pomdp.org): the declarations, the start, and what the tables come to."""

from __future__ import annotations

import re
from collections.abc import Callable

from hypgen.dsl.foreign.cassandra.rewards import Rewards
from hypgen.dsl.foreign.cassandra.tables import Probabilities
from hypgen.dsl.foreign.cassandra.tokens import HEADINGS, Tokens, Word
from hypgen.dsl.foreign.tables.foreign_model import ForeignModel, Law, Read, Row, Variable
from hypgen.dsl.foreign.tables.rows import row_of
from hypgen.dsl.foreign.tables.sums import Sums
from hypgen.dsl.foreign.tables.table import Table
from hypgen.dsl.foreign.tables.trouble import Trouble
from hypgen.dsl.messages import e09_cassandra
from hypgen.dsl.messages.source import Source, Span

MAX_STATES = 100_000
MAX_ROWS = 500_000
_INTEGER = re.compile(r"\d{1,9}")
_ACTION, _STATE, _NEXT = Read("action"), Read("state"), Read("next")


def read(source: Source, tolerance: float) -> ForeignModel:
    """Return the model of a file in Cassandra's format, rows off by ``tolerance`` scaled to 1.

    Raises ``ModelError``.
    """
    return _Reader(source, tolerance).run()


class _Reader:
    def __init__(self, source: Source, tolerance: float) -> None:
        self.trouble = Trouble(source)
        self.sums = Sums(self.trouble, tolerance)
        self.tokens = Tokens(self.trouble)
        self.discount: float | None = None
        self.discount_place: Span | None = None
        self.is_cost = False
        self.declared: dict[str, Variable] = {}
        self.start: Row | None = None
        self.pending_start: tuple[str, list[Word]] | None = None
        self.tables: tuple[Probabilities, Probabilities | None, Rewards] | None = None

    def run(self) -> ForeignModel:
        headings: dict[str, Callable[[Word], None]] = {
            "discount": self._discount,
            "values": self._values,
            "states": self._names,
            "actions": self._names,
            "observations": self._names,
            "start": self._start,
        }
        while self.tokens.peek().text:
            word = self.tokens.next()
            if word.text.lower() in headings or word.text.upper() in ("T", "O", "R"):
                self.tokens.taken = ""
            known = headings.get(word.text.lower())
            if known is not None:
                known(word)
            elif word.text.upper() in ("T", "O", "R"):
                self._entry(word)
            else:
                self._unknown(word)
        if self.tables is None:
            self._begin_tables(Word("", len(self.tokens.text.rstrip())))
        return self._model()

    def _unknown(self, word: Word) -> None:
        span = self.tokens.span(word)
        if self.tokens.taken and _INTEGER.match(word.text.lstrip("+-.")):
            self.trouble.add(e09_cassandra.number_too_many(self.tokens.taken, span))
        else:
            self.trouble.add(e09_cassandra.unknown_specification(word.text, HEADINGS, span))
        self.tokens.skip_to_heading()

    def _colon(self, after: Word) -> bool:
        if self.tokens.skip_colon():
            return True
        self.tokens.unexpected(self.tokens.peek(), f"':' after '{after.text}'")
        self.tokens.skip_to_heading()
        return False

    # Declarations --------------------------------------------------------------------------------

    def _discount(self, heading: Word) -> None:
        if not self._colon(heading):
            return
        place = self.tokens.peek()
        self.discount = self.tokens.number("the discount", "write a number from 0 to 1, such as 0.95")
        if self.discount is None:
            self.tokens.skip_to_heading()
        elif not 0 <= self.discount <= 1:
            self.trouble.add(e09_cassandra.wrong_discount(self.discount, self.tokens.span(place)))
        self.discount_place = self.tokens.span(place)

    def _values(self, heading: Word) -> None:
        if not self._colon(heading):
            return
        word = self.tokens.next()
        kind = word.text.lower().rstrip("s")
        if kind not in ("reward", "cost"):
            self.tokens.unexpected(word, "'reward' or 'cost'", "write `values: reward` or `values: cost`")
            self.tokens.skip_to_heading()
        self.is_cost = kind == "cost"

    def _names(self, heading: Word) -> None:
        if not self._colon(heading):
            return
        kind, words = heading.text.lower(), self.tokens.words()
        if kind in self.declared:
            self.trouble.add(e09_cassandra.declared_twice(kind, self.tokens.span(heading)))
            return
        if self.tables is not None:
            self.trouble.add(e09_cassandra.declared_late(kind, self.tokens.span(heading)))
            return
        if not words:
            self.tokens.unexpected(self.tokens.peek(), f"the number or the names of the {kind}")
            return
        singular = kind[:-1]
        if len(words) == 1 and _INTEGER.fullmatch(words[0].text):
            size = int(words[0].text)
            if not 0 < size <= MAX_STATES:
                span = self.tokens.span(words[0])
                raise self.trouble.stop(e09_cassandra.wrong_size(kind, size, MAX_STATES, span))
            self.declared[kind] = Variable(singular, size)
            return
        if listed := next((word for word in words if "," in word.text), None):
            self.tokens.unexpected(listed, f"a name of the {kind}", "put blanks between names, no commas")
        first: dict[str, Word] = {}
        for word in words:
            if first.setdefault(word.text, word) is not word:
                self.trouble.add(e09_cassandra.duplicate_name(singular, word.text, self.tokens.span(word)))
        self.declared[kind] = Variable(singular, len(words), tuple(w.text for w in words))

    def _start(self, heading: Word) -> None:
        form = ""
        if self.tokens.peek().text.lower() in ("include", "exclude"):
            form = self.tokens.next().text.lower()
        if self._colon(heading):
            self.pending_start = (form, [heading, *self.tokens.words()])

    # Tables --------------------------------------------------------------------------------------

    def _begin_tables(self, place: Word) -> None:
        for kind in ("states", "actions"):
            if kind not in self.declared:
                raise self.trouble.stop(e09_cassandra.not_declared(kind, self.tokens.span(place)))
        states, actions = self.declared["states"], self.declared["actions"]
        seen = self.declared.get("observations")
        if states.size * actions.size > MAX_ROWS:
            span = self.tokens.span(place)
            raise self.trouble.stop(e09_cassandra.many_rows(states.size, actions.size, MAX_ROWS, span))
        moves = Probabilities(self.tokens, self.sums, "T", (actions, states), states)
        sensor = None if seen is None else Probabilities(self.tokens, self.sums, "O", (actions, states), seen)
        self.tables = moves, sensor, Rewards(self.tokens, actions, states, seen)

    def _entry(self, heading: Word) -> None:
        if not self._colon(heading):
            return
        if self.tables is None:
            self._begin_tables(heading)
        assert self.tables is not None
        moves, sensor, rewards = self.tables
        kind = heading.text.upper()
        if kind == "O" and sensor is None:
            raise self.trouble.stop(e09_cassandra.not_declared("observations", self.tokens.span(heading)))
        table = {"T": moves, "O": sensor, "R": rewards}[kind]
        assert table is not None
        if not table.read(heading):
            self.tokens.skip_to_heading()

    # The model -----------------------------------------------------------------------------------

    def _model(self) -> ForeignModel:
        assert self.tables is not None
        moves, sensor, rewards = self.tables
        states, actions = self.declared["states"], self.declared["actions"]
        start = self._start_row(states)
        self.trouble.raise_any()
        moves.reset_to(start)
        reached = moves.reached()
        moves.check(None)
        if sensor is not None:
            sensor.check(reached)
        self.sums.tell()
        self.trouble.raise_any()
        step = Law((_ACTION, _STATE), moves.rows())
        sight = () if sensor is None else (Law((_ACTION, _NEXT), sensor.rows()),)
        notes = self._notes(sensor)
        gain = rewards.gain(step, sight[0] if sight else None, -1.0 if self.is_cost else 1.0, notes)
        seen = self.declared.get("observations")
        return ForeignModel(
            format="Cassandra's format",
            discount=1.0 if self.discount is None else self.discount,
            discount_place=self.discount_place,
            actions=(actions,),
            states=(Variable("state", states.size, states.names, visible=sensor is None),),
            observations=() if seen is None else (seen,),
            starts=(Law((), Table.of((), [start])),),
            transitions=(step,),
            sensors=sight,
            rewards=(gain,),
            notes=tuple(notes),
        )

    def _notes(self, sensor: Probabilities | None) -> list[str]:
        notes = []
        if self.discount is None:
            notes.append("The file gives no discount: it is 1.")
        if self.is_cost:
            notes.append("The file gives costs: their signs are changed.")
        if sensor is None:
            notes.append("The file declares no observations: the state is visible.")
        return notes + self.sums.notes()

    def _start_row(self, states: Variable) -> Row:
        everywhere = row_of([1.0 / states.size] * states.size)
        if self.pending_start is None:
            return everywhere
        form, (heading, *words) = self.pending_start
        if not words:
            self.tokens.unexpected(self.tokens.peek(), "the start")
            return everywhere
        if not form and len(words) == states.size and _are_numbers(words) and not _is_one(words, states):
            return self._start_vector(words)
        if not form and words[0].text.lower() == "uniform" and len(words) == 1:
            return everywhere
        if not form and len(words) > 1 and _are_numbers(words):
            self.trouble.add(e09_cassandra.wrong_start(states.size, len(words), self.tokens.span(heading)))
            return everywhere
        assert self.tables is not None
        named = [self.tables[0].resolve(word, states) for word in words]
        if None in named:
            return everywhere
        chosen = {state for found in named if found is not None for state in found}
        if form == "exclude":
            chosen = set(range(states.size)) - chosen
        if not chosen:
            self.trouble.add(e09_cassandra.no_start(self.tokens.span(heading)))
            return everywhere
        return tuple((s, 1.0 / len(chosen)) for s in sorted(chosen))

    def _start_vector(self, words: list[Word]) -> Row:
        values = [float(w.text) for w in words]
        negative = [word for word, value in zip(words, values, strict=True) if value < 0]
        if negative:
            span = self.tokens.span(negative[0])
            self.trouble.add(e09_cassandra.negative_start(float(negative[0].text), span))
        else:
            self.sums.check("the start", sum(values), self.tokens.span(words[0]))
        return row_of(values)


def _are_numbers(words: list[Word]) -> bool:
    return all(re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", w.text) for w in words)


def _is_one(words: list[Word], states: Variable) -> bool:
    """Return whether the words name the only state there is: `start: 0`."""
    return states.size == 1 and words[0].text == "0"
