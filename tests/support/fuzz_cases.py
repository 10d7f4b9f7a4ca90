# SPDX-License-Identifier: Apache-2.0
"""Bad input of many kinds, and what must hold whatever the input is.

A case is a function of a seed. Its text comes from a valid file that is mutated, from the grammar, or from
nowhere; hypgen must answer with a model or with diagnostics, soon and in little memory.
"""

from __future__ import annotations

import random
import re
import resource
import time
from functools import cache
from pathlib import Path

from lark.grammar import NonTerminal, Symbol

from hypgen.cli.show.error_index import cases
from hypgen.dsl.load import load_any
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.render import render_all
from hypgen.dsl.syntax.parse import _load_lark
from support.paths import ROOT
from support.random_models.generator import model

FOLDERS = ("examples", "tests/unit/dsl/interpret/findings", "tests/differential/models")
SECONDS, MEGABYTES = 1.0, 256
TRIES = 4

# A plain file with which a case that seems slow is compared, and the CPU time that it takes on an idle core.
PLAIN = "model M\ndiscount 0.9\naction act: bool\n" + "".join(f"const c{i}: int = {i}\n" for i in range(1000))
PLAIN_SECONDS = 0.15

_TOKEN = re.compile(r'"[^"\n]*"|#[^\n]*\n|\w+(?:\.\w+)*|\.\.|[<>=!]=|=>|\*\*|//|\s+|[^\s\w]')
_NUMBERS = (
    *("0", "1", "-1", "2", "255", "2147483647", "2147483648", "-2147483649", "1" + "0" * 22),
    *("0.0", "0.1", "1e-50", "1e38", "1e400"),
)
_ODD = (*"\x00\x07\x1b\"\\\ré漢\U0001f600\u202e\ufeff()[]{},:'=~", " ", "..")


class Failure(AssertionError):
    """Something that must hold did not."""


# What must hold ----------------------------------------------------------------------------------


def check(content: bytes, folder: Path) -> str:
    """Read ``content`` as a model file; return the first diagnostic's code, or that it is fine.

    Raises ``Failure`` for slow, hungry or wordless answers; any other exception is a failure as well.
    """
    path = folder / "case.pomdp"
    path.write_bytes(content)
    peak = _peak_megabytes()
    code, seconds = _timed_answer(path)
    megabytes = _peak_megabytes() - peak
    for _ in range(TRIES - 1):
        if seconds > SECONDS:
            seconds = min(seconds, _timed_answer(path)[1] / _slowness(folder))
    if seconds > SECONDS:
        raise Failure(f"took {seconds:.2f} s of CPU")
    if megabytes > MEGABYTES:
        raise Failure(f"took {megabytes:.0f} MB")
    return code


def _timed_answer(path: Path) -> tuple[str, float]:
    start = time.process_time()
    return _answer(path), time.process_time() - start


def _slowness(folder: Path) -> float:
    """Return how many times longer a plain file takes now than on an idle core; at least 1.

    Other processes slow a core down through its caches, its clock and its second thread.
    """
    path = folder / "plain.pomdp"
    path.write_text(PLAIN)
    return max(1.0, min(_timed_answer(path)[1] for _ in range(3)) / PLAIN_SECONDS)


def _answer(path: Path) -> str:
    try:
        load_any(path)
    except ModelError as error:
        if not error.diagnostics:
            raise Failure("no diagnostic") from error
        for diagnostic in error.diagnostics:
            if not (diagnostic.code and diagnostic.message and diagnostic.remedy):
                raise Failure(f"a diagnostic without words: {diagnostic}") from error
        if not render_all(error.diagnostics, error.sources):
            raise Failure("nothing to show") from error
        return error.diagnostics[0].code
    return "fine"


def _peak_megabytes() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


# Cases -------------------------------------------------------------------------------------------


def case(seed: int) -> bytes:
    """Return the file of a seed: noise (one of ten), what the grammar allows (two), or a mutated file."""
    rng = random.Random(seed)
    kind = rng.randrange(10)
    if kind == 0:
        return rng.choice((_bytes, _tokens))(rng)
    if kind <= 2:
        return Grower(rng, _names("")).file().encode()
    return _mutated(rng).encode("utf-8", "surrogatepass")


def small_case(seed: int) -> bytes:
    """Return a file of less than 200 bytes."""
    rng = random.Random(seed)
    if rng.randrange(4) == 0:
        return _bytes(rng)[:199]
    start = rng.choice(("", "model M ", "model M\n", "library L ", 'instance I of "case.pomdp" {'))
    text = start + Grower(rng, _names(""), depth=6).items(rng.randrange(1, 4))
    return _cut(rng, text).encode()[:199] if rng.randrange(2) else text.encode()[:199]


def _bytes(rng: random.Random) -> bytes:
    return rng.randbytes(rng.randrange(200))


def _tokens(rng: random.Random) -> bytes:
    words = _TOKEN.findall(rng.choice(corpus()))
    return " ".join(rng.choices(words, k=rng.randrange(1, 60))).encode()


@cache
def corpus() -> tuple[str, ...]:
    """Return the texts that cases are made from, small ones first; not those that are there to take long."""
    paths = [path for folder in FOLDERS for path in sorted((ROOT / folder).glob("*.pomdp"))]
    wrong = [case.text for case in cases() if case.code != "E0609"]
    return tuple(sorted([*(path.read_text() for path in paths), *wrong], key=len))


def _mutated(rng: random.Random) -> str:
    # A random model has every form of the language; it takes as long as ten files of the corpus.
    text = rng.choice(corpus()) if rng.randrange(20) else str(model(rng.getrandbits(32)))
    for _ in range(rng.choice((1, 1, 2, 4))):
        text = rng.choice(_MUTATIONS)(rng, text)
    return text


def _places(rng: random.Random, text: str, pattern: str = r"\S") -> tuple[int, int]:
    """Return where a random token that fits the pattern starts and ends."""
    found = [m.span() for m in _TOKEN.finditer(text) if re.match(pattern, m[0])]
    return rng.choice(found) if found else (0, 0)


def _swap(rng: random.Random, text: str) -> str:
    (a, b), (c, d) = sorted((_places(rng, text), _places(rng, text)))
    return text if b > c else text[:a] + text[c:d] + text[b:c] + text[a:b] + text[d:]


def _cut(rng: random.Random, text: str) -> str:
    (start, _), (_, end) = sorted((_places(rng, text), _places(rng, text)))
    return text[:start] + text[end:] if rng.randrange(3) else text[:start]


def _repeat(rng: random.Random, text: str) -> str:
    (start, _), (_, end) = sorted((_places(rng, text), _places(rng, text)))
    return text[:end] + text[start:end][:400] * rng.choice((1, 1, 1, 30)) + text[end:]


def _number(rng: random.Random, text: str) -> str:
    start, end = _places(rng, text, r"\d")
    return text[:start] + rng.choice(_NUMBERS) + text[end:]


def _character(rng: random.Random, text: str) -> str:
    place = rng.randrange(len(text) + 1)
    return text[:place] + rng.choice(_ODD) + text[place:]


def _foreign(rng: random.Random, text: str) -> str:
    other = rng.choice(corpus())
    start, end = _places(rng, text)
    a, b = _places(rng, other)
    return text[:start] + other[a:b] + text[end:]


def _grow(rng: random.Random, text: str) -> str:
    """Put a random expression of the text's own names in the place of a name or number."""
    operands = [m.span(1) for m in re.finditer(r"(?:[=~+*/<>(:,-]|then|else)\s*(\w+)", text)]
    start, end = rng.choice(operands) if operands else (0, 0)
    return f"{text[:start]}({Grower(rng, _names(text), depth=5).expression()}){text[end:]}"


def _rename(rng: random.Random, text: str) -> str:
    """Let a name be another name of the text: what parses and means something else, or nothing."""
    start, end = _places(rng, text, r"[A-Za-z_]")
    return text[:start] + rng.choice(_names(text)) + text[end:]


_MUTATIONS = (_swap, _cut, _repeat, _character, _foreign, *(_number, _rename, _grow) * 3)


def _names(text: str) -> tuple[str, ...]:
    own = tuple(dict.fromkeys(re.findall(r"[A-Za-z_]\w*", re.sub(r"#[^\n]*", "", text))))
    return own or ("a", "b", "x", "T", "uniform", "min", "act")


# Texts that the grammar allows -------------------------------------------------------------------


class Grower:
    """Grows random texts from the grammar's own rules."""

    def __init__(self, rng: random.Random, names: tuple[str, ...], depth: int = 12, words: int = 150) -> None:
        self._rng = rng
        self._names = names
        self._depth = depth
        self._left = words  # after these, only the shortest endings

    def file(self) -> str:
        """Return a model file."""
        return f"model M\n{self.items(self._rng.randrange(1, 12))}"

    def items(self, count: int) -> str:
        """Return so many items of a file."""
        grown = (self._grow(NonTerminal("_item"), self._depth) for _ in range(count))
        return "\n".join(item for item in grown if not item.startswith("import") or self._rng.random() < 0.05)

    def expression(self) -> str:
        """Return an expression."""
        return self._grow(NonTerminal("expr"), self._depth)

    def _grow(self, symbol: Symbol, depth: int) -> str:
        if symbol.is_term:
            return self._terminal(symbol.name)
        options = (_rules() if depth > 0 and self._left > 0 else _endings())[symbol.name]
        return " ".join(self._grow(inner, depth - 1) for inner in self._rng.choice(options))

    def _terminal(self, name: str) -> str:
        self._left -= 1
        if name == "NAME":
            return self._rng.choice(self._names)
        if name == "INT":
            return self._rng.choice(("0", "1", "2", "3", "7", "1000000", "99999999999"))
        if name == "FLOAT":
            return self._rng.choice(("0.0", "0.5", "1.0", "2.5e3", "1e-9"))
        return '"#.."' if name == "STRING" else _words()[name]


@cache
def _rules() -> dict[str, list[tuple[Symbol, ...]]]:
    result: dict[str, list[tuple[Symbol, ...]]] = {}
    for rule in _load_lark().rules:
        result.setdefault(rule.origin.name, []).append(tuple(rule.expansion))
    return result


@cache
def _words() -> dict[str, str]:
    return {t.name: str(t.pattern.value) for t in _load_lark().terminals}


@cache
def _endings() -> dict[str, list[tuple[Symbol, ...]]]:
    """Return of each rule the options whose trees are lowest."""
    least = {name: min(map(_height, options)) for name, options in _rules().items()}
    return {name: [o for o in options if _height(o) == least[name]] for name, options in _rules().items()}


@cache
def _heights() -> dict[str, int]:
    """Return how deep the lowest tree of each rule is."""
    heights: dict[str, int] = {}
    changed = True
    while changed:
        changed = False
        for name, options in _rules().items():
            known = [o for o in options if all(s.is_term or s.name in heights for s in o)]
            if known:
                least = 1 + min(max((heights[s.name] for s in o if not s.is_term), default=0) for o in known)
                if least < heights.get(name, least + 1):
                    heights[name], changed = least, True
    return heights


def _height(option: tuple[Symbol, ...]) -> int:
    return max((_heights()[s.name] for s in option if not s.is_term), default=0)
