# SPDX-License-Identifier: Apache-2.0
"""The words of a file in Cassandra's format, with their places."""

from __future__ import annotations

import math
import re
from itertools import islice
from typing import NamedTuple

from hypgen.dsl.foreign.tables.trouble import Trouble
from hypgen.dsl.messages import e09_cassandra
from hypgen.dsl.messages.source import Span
from hypgen.dsl.messages.words import counted

HEADINGS = ("discount", "values", "states", "actions", "observations", "start")
_COMMENT = re.compile(r"#[^\n]*")
_WORD = re.compile(r"\s*(:|[^\s:]+)")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_HEADING = re.compile(
    r"(?<!\S)(?:" + "|".join(HEADINGS[:-1]) + r"|start(?:\s+(?:include|exclude))?|[TOR])\s*:", re.IGNORECASE
)


class Word(NamedTuple):
    """A word, and how many characters into the text it starts; an empty one is the end of the file."""

    text: str
    start: int


class Tokens:
    """Reads words one by one, and long runs of numbers at once."""

    def __init__(self, trouble: Trouble) -> None:
        self.trouble = trouble
        # Comments become blanks, so that places stay what they are.
        self.text = _COMMENT.sub(lambda m: " " * len(m.group()), trouble.source.text)
        self.taken = ""  # what the numbers just read were, in words; empty behind a heading
        self.at, self.seen_at = 0, -1
        self.seen = Word("", 0)

    def peek(self) -> Word:
        """Return the next word."""
        if self.seen_at != self.at:  # one word is looked at two or three times
            match = _WORD.match(self.text, self.at)
            self.seen = Word(match[1], match.start(1)) if match else Word("", len(self.text.rstrip()))
            self.seen_at = self.at
        return self.seen

    def next(self) -> Word:
        """Return the next word and go past it."""
        word = self.peek()
        self.at = word.start + len(word.text)
        return word

    def skip_colon(self) -> bool:
        """Go past a colon if that is next; return whether it was."""
        word = self.peek()
        if word.text == ":":
            self.at = word.start + 1
        return word.text == ":"

    def at_heading(self) -> bool:
        """Return whether a new specification starts here, or the file ends."""
        word = self.peek()
        return not word.text or _HEADING.match(self.text, word.start) is not None

    def skip_to_heading(self) -> None:
        """Go to where the next specification starts."""
        match = _HEADING.search(self.text, self.at)
        self.at = match.start() if match else len(self.text)

    def words(self) -> list[Word]:
        """Return all words up to the next specification."""
        result = []
        while not self.at_heading():
            result.append(self.next())
        return result

    def numbers(
        self, count: int, what: str, remedy: str = e09_cassandra.MISSING_NUMBERS
    ) -> list[float] | None:
        """Return the next ``count`` numbers; None where there are fewer, a mistake with that ``remedy``."""
        self.taken = f"{what} takes {counted(count, 'number')}"
        window = self.text[self.at : self.at + 24 * count + 64]
        words = window.split(None, count)
        if len(words) > count and "_" not in window:
            try:
                values = list(map(float, words[:count]))
            except ValueError:
                return self._slowly(count, what, remedy)
            if math.isfinite(math.fsum(values)):
                self.at += len(window) - len(words[count])
                return values
        return self._slowly(count, what, remedy)

    def behind(self, word: Word, number: int) -> Word:
        """Return the word that stands ``number`` words behind ``word``."""
        found = next(islice(_WORD.finditer(self.text, word.start), number, None))
        return Word(found[1], found.start(1))

    def number(self, what: str, remedy: str = "") -> float | None:
        """Return the next number."""
        self.taken = f"{what} is one number"
        word = self.peek()
        if not _NUMBER.fullmatch(word.text) or not math.isfinite(float(word.text)):
            self.unexpected(word, what, remedy or e09_cassandra.number_remedy(word.text))
            return None
        self.next()
        return float(word.text)

    def span(self, word: Word) -> Span:
        """Return a word's place."""
        return self.trouble.span(word.start, len(word.text))

    def unexpected(self, word: Word, what: str, remedy: str = e09_cassandra.FORM) -> None:
        """Note that ``what`` was expected and ``word`` found."""
        if not word.text:
            self.trouble.add(e09_cassandra.early_end(what, self.trouble.span(word.start - 1, 1)))
            return
        self.trouble.add(e09_cassandra.unexpected(what, word.text, remedy, self.span(word)))

    def _slowly(self, count: int, what: str, remedy: str) -> list[float] | None:
        first = self.peek()
        values: list[float] = []
        for _ in range(count):
            word = self.peek()
            if not _NUMBER.fullmatch(word.text) or not math.isfinite(float(word.text)):
                if self.at_heading() or not values:
                    self._too_few(count, len(values), first, word, what, remedy)
                else:
                    remedy = e09_cassandra.number_remedy(word.text)
                    self.unexpected(word, f"number {len(values) + 1} of {what}", remedy)
                return None
            values.append(float(self.next().text))
        return values

    def _too_few(self, count: int, given: int, first: Word, word: Word, what: str, remedy: str) -> None:
        if word.text and not given:
            self.unexpected(
                word, what, remedy if self.at_heading() else e09_cassandra.number_remedy(word.text)
            )
            return
        start = (first if given else word).start - (0 if first.text else 1)
        span = self.trouble.span(start, max(len(first.text), 1))
        self.trouble.add(e09_cassandra.numbers_missing(what, count, given, not word.text, remedy, span))
