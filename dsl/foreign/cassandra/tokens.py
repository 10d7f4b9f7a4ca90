"""The words of a file in Cassandra's format, with their places."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from hypgen.dsl.foreign.tables.trouble import Trouble
from hypgen.dsl.messages.diagnostic import did_you_mean

HEADINGS = ("discount", "values", "states", "actions", "observations", "start")
_FORM = "write `T : action : state : next-state probability`, and `O` and `R` likewise"
_GIVE = "give the numbers that are missing"
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

    def numbers(self, count: int, what: str, remedy: str = _GIVE) -> list[float] | None:
        """Return the next ``count`` numbers; None where there are fewer, a mistake with that ``remedy``."""
        self.taken = f"{what} takes {_numbers(count)}"
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

    def number(self, what: str, remedy: str = "") -> float | None:
        """Return the next number."""
        self.taken = f"{what} is one number"
        word = self.peek()
        if not _NUMBER.fullmatch(word.text) or not math.isfinite(float(word.text)):
            self.unexpected(word, what, remedy or _number_like(word))
            return None
        self.next()
        return float(word.text)

    def unexpected(self, word: Word, what: str, remedy: str = _FORM) -> None:
        """Note that ``what`` was expected and ``word`` found."""
        if not word.text:
            self.trouble.add(
                "E0901", f"{what} is expected, but the file ends", word.start - 1, 1, "complete the file"
            )
            return
        self.trouble.add(
            "E0901", f"{what} is expected, but found '{_cut(word.text)}'", word.start, len(word.text), remedy
        )

    def _slowly(self, count: int, what: str, remedy: str) -> list[float] | None:
        first = self.peek()
        values: list[float] = []
        for _ in range(count):
            word = self.peek()
            if not _NUMBER.fullmatch(word.text) or not math.isfinite(float(word.text)):
                if self.at_heading() or not values:
                    self._too_few(count, len(values), first, word, what, remedy)
                else:
                    self.unexpected(word, f"number {len(values) + 1} of {what}", _number_like(word))
                return None
            values.append(float(self.next().text))
        return values

    def _too_few(self, count: int, given: int, first: Word, word: Word, what: str, remedy: str) -> None:
        if word.text and not given:
            self.unexpected(word, what, remedy if self.at_heading() else _number_like(word))
            return
        end = "the file ends" if not word.text else "the next specification starts"
        message = f"{what} takes {_numbers(count)}, but {end} after {given}"
        place = (first if given else word).start - (0 if first.text else 1)
        self.trouble.add("E0903", message, place, max(len(first.text), 1), remedy)


def _numbers(count: int) -> str:
    return f"{count} number{'' if count == 1 else 's'}"


def _number_like(word: Word) -> str:
    """Return what to write instead of a word where numbers are expected."""
    return did_you_mean(word.text.lower(), ("identity", "uniform", "reset")) or "write a number, such as 0.25"


def _cut(text: str) -> str:
    return text if len(text) <= 30 else text[:27] + "..."
