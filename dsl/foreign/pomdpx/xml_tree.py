# SPDX-License-Identifier: Apache-2.0
"""XML as a tree with places. Nothing but elements is taken: a document type or an entity ends the reading."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

from hypgen.dsl.foreign.tables.trouble import Trouble
from hypgen.dsl.messages import e09_pomdpx
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.source import Span

MAX_DEPTH = 200
_TAG = re.compile(r"""<(?:"[^"]*"|'[^']*'|[^>"'])*>\s*""")


@dataclass
class Element:
    """An element, and how many characters into the text it and its text start."""

    tag: str
    attributes: dict[str, str]
    start: int
    text_start: int
    children: list[Element] = field(default_factory=list)
    parts: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """Return the text directly inside."""
        return "".join(self.parts).strip()

    def child(self, tag: str) -> Element | None:
        """Return the first child with this tag."""
        return next(self.all(tag), None)

    def all(self, tag: str) -> Iterator[Element]:
        """Yield the children with this tag."""
        return (c for c in self.children if c.tag == tag)


def place_of(element: Element, trouble: Trouble) -> Span:
    """Return where an element starts: its bracket and its name."""
    return trouble.span(element.start, len(element.tag) + 1)


def parse(trouble: Trouble) -> Element:
    """Return the root element of a text; raises ``ModelError``."""
    return _Builder(trouble).run()


class _Builder:
    def __init__(self, trouble: Trouble) -> None:
        self.trouble = trouble
        self.open: list[Element] = []
        self.root: Element | None = None
        # The text has been decoded already, whatever its declaration says.
        self.parser = expat.ParserCreate(encoding="utf-8")
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._characters
        self.parser.StartDoctypeDeclHandler = self._refuse
        self.parser.EntityDeclHandler = self._refuse
        self.parser.UnparsedEntityDeclHandler = self._refuse
        self.parser.ExternalEntityRefHandler = self._refuse

    def run(self) -> Element:
        try:
            self.parser.Parse(self.trouble.source.text.encode("utf-8", "replace"), True)
        except expat.ExpatError as error:
            place = self.trouble.offset(error.lineno, error.offset)
            reason = expat.ErrorString(error.code)
            cut = self.root is None or not self.trouble.source.text[place + 1 :].strip()
            span = self.trouble.span(place, 1)
            raise self.trouble.stop(e09_pomdpx.malformed(reason, cut, span)) from None
        assert self.root is not None
        return self.root

    def _place(self) -> int:
        return self.trouble.offset(self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        start = self._place()
        if len(self.open) == MAX_DEPTH:
            span = self.trouble.span(start, len(tag) + 1)
            raise self.trouble.stop(e09_pomdpx.deep_elements(MAX_DEPTH, span))
        element = Element(tag, attributes, start, start)
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def _end(self, tag: str) -> None:
        self.open.pop()

    def _characters(self, text: str) -> None:
        if text.strip() and self.open:
            element = self.open[-1]
            if not element.parts:
                # The parser gathers a text and gives it where the next tag is.
                tag = _TAG.match(self.trouble.source.text, element.start)
                element.text_start = tag.end() if tag else element.start
            element.parts.append(text)

    def _refuse(self, *_: object) -> int:
        raise self._refusal()

    def _refusal(self) -> ModelError:
        return self.trouble.stop(e09_pomdpx.refused_declaration(self.trouble.span(self._place(), 9)))
