# SPDX-License-Identifier: Apache-2.0
"""The tables T and O of Cassandra's format: later specifications override earlier ones, entry by entry."""

from __future__ import annotations

from collections.abc import Sequence

from hypgen.dsl.foreign.cassandra.tokens import Tokens, Word
from hypgen.dsl.foreign.tables.foreign_model import Row, Variable
from hypgen.dsl.foreign.tables.rows import TOLERANCE, normalised
from hypgen.dsl.foreign.tables.sums import Sums
from hypgen.dsl.foreign.tables.table import Table
from hypgen.dsl.messages import e09_cassandra

MAX_WRITTEN = 20_000_000  # entries, those that are written again included: ten seconds
_SHOWN = 5  # numbers of a row that are no probabilities
_RESET: dict[int, float] = {-1: 1.0}  # stands for the start, which may be given below


def fields(tokens: Tokens, variables: Sequence[Variable]) -> list[Sequence[int]] | None:
    """Return the values that ``a : b : ..`` names, a sequence each; None after a mistake."""
    result: list[Sequence[int]] = []
    while True:
        found = resolve(tokens, tokens.next(), variables[len(result)])
        if found is None:
            return None
        result.append(found)
        if len(result) == len(variables):
            tokens.skip_colon()  # some writers have one before the number too
            return result
        if not tokens.skip_colon():
            return result


def resolve(tokens: Tokens, word: Word, variable: Variable) -> Sequence[int] | None:
    """Return the values that a word stands for; None after a mistake."""
    text, what = word.text, variable.name
    if text == "*":
        return range(variable.size)
    if not text or text == ":":
        tokens.unexpected(word, f"{'an' if what[0] in 'ao' else 'a'} {what}")
        return None
    names = variable.numbers
    if text in names:
        return (names[text],)
    if text.isascii() and text.isdigit() and len(text) < 10:
        if int(text) < variable.size:
            return (int(text),)
        tokens.trouble.add(e09_cassandra.unknown_number(what, text, variable.size, tokens.span(word)))
        return None
    alike = [number for name, number in names.items() if name.lower() == text.lower()]
    if len(alike) == 1:
        return (alike[0],)
    tokens.trouble.add(e09_cassandra.unknown_name(what, text, names, tokens.span(word)))
    return None


class Probabilities:
    """T or O: a row of probabilities over ``values`` for each action and state."""

    def __init__(
        self, tokens: Tokens, sums: Sums, name: str, given: tuple[Variable, Variable], values: Variable
    ) -> None:
        self.tokens, self.sums, self.name, self.given, self.values = tokens, sums, name, given, values
        self.written = 0
        actions, states = given
        self.table: list[list[dict[int, float] | None]] = [[None] * states.size for _ in range(actions.size)]
        # Rows that several actions or states share are copied before a single entry is changed.
        self.is_own: list[bytearray] = [bytearray(states.size) for _ in range(actions.size)]
        self.places: list[dict[int, int]] = [{} for _ in range(actions.size)]  # of the last specification

    def resolve(self, word: Word, variable: Variable) -> Sequence[int] | None:
        """Return the values that a word stands for; None after a mistake."""
        return resolve(self.tokens, word, variable)

    def read(self, heading: Word) -> bool:
        """Read a specification from behind its heading; return False after a mistake."""
        found = fields(self.tokens, (*self.given, self.values))
        if found is None:
            return False
        if len(found) == 1:
            return self._matrix(found[0], heading.start)
        if len(found) == 2:
            row = self._row(f"a row of {self.name}")
            if row is not None:
                self._set(found[0], found[1], row, heading.start)
            return row is not None
        return self._entries(found, heading.start)

    def _entries(self, found: list[Sequence[int]], place: int) -> bool:
        actions, states, values = found
        probability = self._probability()
        if probability is None:
            return False
        self._count(len(actions) * len(states) * len(values), place)
        if len(values) == self.values.size:
            row = dict.fromkeys(values, probability) if probability else {}
            self._set(actions, states, row, place)
            return True
        for a in actions:
            for s in states:
                row = self.table[a][s] or {}
                if not self.is_own[a][s] or row is _RESET:
                    row = {} if row is _RESET else dict(row)
                    self.table[a][s] = row
                    self.is_own[a][s] = 1
                for v in values:
                    row[v] = probability
                self.places[a][s] = place
        return True

    def _matrix(self, actions: Sequence[int], place: int) -> bool:
        states, size = self.given[1].size, self.values.size
        word = self.tokens.peek()
        form = word.text.lower()
        if form == "identity":
            self.tokens.next()
            if states != size:
                self.tokens.trouble.add(e09_cassandra.not_square(self.values.name, self.tokens.span(word)))
            for s in range(states):
                self._set(actions, (s,), {s: 1.0}, place)
            return True
        if form == "reset":
            self.tokens.trouble.add(e09_cassandra.reset_of_matrix(self.name, self.tokens.span(word)))
            return False
        if form == "uniform":
            row = self._row("")
            assert row is not None
            self._set(actions, range(states), row, place)
            return True
        for s in range(states):
            row = self._row(f"row {s + 1} of {self.name}'s matrix")
            if row is None:
                return False
            self._set(actions, (s,), row, place)
        return True

    def _row(self, what: str) -> dict[int, float] | None:
        word, size = self.tokens.peek(), self.values.size
        form = word.text.lower()
        if form in ("uniform", "reset"):
            self.tokens.next()
            if form == "reset" and self.name == "T":
                return _RESET
            return dict.fromkeys(range(size), 1.0 / size)
        numbers = self.tokens.numbers(size, what)
        if numbers is None:
            return None
        if min(numbers) < 0 or max(numbers) > 1:
            wrong = [n for n, p in enumerate(numbers) if not self.sums.is_probability(p)]
            for n in wrong[:_SHOWN]:
                self._no_probability(numbers[n], self.tokens.behind(word, n))
        return {v: p for v, p in enumerate(numbers) if p}

    def _probability(self) -> float | None:
        word = self.tokens.peek()
        number = self.tokens.number("a probability")
        if number is not None and not self.sums.is_probability(number):
            self._no_probability(number, word)
        return number

    def _no_probability(self, number: float, word: Word) -> None:
        self.tokens.trouble.add(e09_cassandra.no_probability(number, self.tokens.span(word)))

    def _count(self, entries: int, place: int) -> None:
        self.written += entries
        if self.written > MAX_WRITTEN:
            trouble = self.tokens.trouble
            raise trouble.stop(e09_cassandra.many_rewrites(trouble.span(place, 1)))

    def _set(self, actions: Sequence[int], states: Sequence[int], row: dict[int, float], place: int) -> None:
        self._count(len(actions) * len(states), place)
        for a in actions:
            for s in states:
                self.table[a][s] = row
                self.is_own[a][s] = 0
                self.places[a][s] = place

    # Afterwards ----------------------------------------------------------------------------------

    def reset_to(self, start: Row) -> None:
        """Put the start in the place of `reset`."""
        for rows in self.table:
            for s, row in enumerate(rows):
                if row is _RESET:
                    rows[s] = dict(start)

    def reached(self) -> list[set[int]]:
        """Return for each action the values that it can lead to."""
        return [{v for row in rows if row for v, p in row.items() if p > 0} for rows in self.table]

    def check(self, needed: Sequence[set[int]] | None) -> None:
        """Note rows that are missing or do not sum to 1; of O those of states that are ``needed``."""
        missing: list[str] = []
        trouble = self.tokens.trouble
        for a, rows in enumerate(self.table):
            for s, row in enumerate(rows):
                total = sum(row.values()) if row else 0.0
                if abs(total - 1) <= TOLERANCE:
                    continue
                if needed is not None and s not in needed[a] and not total:
                    rows[s] = {0: 1.0}  # is never drawn
                    continue
                if s not in self.places[a]:
                    missing.append(self._row_name(a, s))
                    continue
                span = trouble.span(self.places[a][s], 1)
                self.sums.check(f"row {self._row_name(a, s)}", total, span)
        if missing:
            place = min((p for places in self.places for p in places.values()), default=0)
            trouble.add(e09_cassandra.rows_missing(missing, trouble.span(place, 1)))

    def _row_name(self, action: int, state: int) -> str:
        actions, states = self.given
        return f"{self.name} : {actions.shown(action)} : {states.shown(state)}"

    def rows(self) -> Table[Row]:
        """Return the rows of all actions and states."""
        known: dict[int, Row] = {}  # by the dictionary, which many rows may share
        result = []
        for rows in self.table:
            for row in rows:
                assert row is not None
                if id(row) not in known:
                    known[id(row)] = normalised(row.items())
                result.append(known[id(row)])
        return Table.of([v.size for v in self.given], result)
