# SPDX-License-Identifier: Apache-2.0
"""Every editor's colours come from the grammar, and know all that examples and reference hold."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from pygments.lexers import get_lexer_by_name, get_lexer_for_filename
from pygments.token import Error

from hypgen.dsl.messages.source import Source
from hypgen.dsl.syntax.parse import parse_concrete
from hypgen.editor import grammars
from hypgen.editor.pygments_lexer import ModelLexer
from hypgen.editor.words import lexemes, words

ROOT = Path(__file__).parents[3]
EXAMPLES = sorted((ROOT / "examples").rglob("*.pomdp"))
REFERENCE = (ROOT / "docs" / "reference" / "language.md").read_text()
BLOCKS = re.findall(r"^```pomdp[a-z-]*\n(.*?)^```", REFERENCE, re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_tokens_of_examples_are_those_of_the_parser(path: Path) -> None:
    text = path.read_text()
    _, tokens = parse_concrete(Source(str(path), text))
    ours = [(t.start, t.text) for t in lexemes(text) if t.kind != "COMMENT"]
    assert ours == [(t.start_pos, str(t)) for t in tokens]


def test_every_construct_of_the_reference_has_colours() -> None:
    """All words, functions, values and symbols occur there, and Pygments and TextMate know each token."""
    table, used = words(), set()
    for block in BLOCKS:
        text = block.replace("…", "")
        tokens = list(lexemes(text))
        assert not [t for t in tokens if t.kind == "OTHER"], block
        assert not [t for _, kind, t in ModelLexer().get_tokens_unprocessed(text) if kind is Error]
        assert textmate_starts(text) == [t.start for t in tokens]
        used |= {t.text for t in tokens}
    known = {*table.reserved, *table.functions, *table.values, *table.symbols}
    assert known - used == set()


def test_every_word_of_the_grammar_is_in_one_group() -> None:
    table = words()
    groups = (table.declarations, table.control, table.operators, table.types, table.constants)
    assert sum(map(len, groups)) == len(table.reserved)
    grammar = (ROOT / "dsl" / "syntax" / "pomdp.lark").read_text()
    assert set(re.findall(r'"([a-z]+)"', grammar)) == table.reserved


@pytest.mark.parametrize("path", grammars.files())
def test_generated_grammars_are_up_to_date(path: str) -> None:
    text = (ROOT / "editors" / path).read_text()
    assert text == grammars.files()[path], "run python -m hypgen.editor.grammars editors"


def textmate_starts(text: str) -> list[int]:
    """Return where TextMate's grammar finds tokens."""
    return _starts(tuple(re.compile(p["match"]) for p in grammars.textmate(words())["patterns"]), text)


def _starts(rules: tuple[re.Pattern[str], ...], text: str) -> list[int]:
    """First match of a list wins in Monarch, leftmost match in TextMate; both see the lexer's tokens."""
    at, found = 0, []
    while at < len(text):
        match = next((m for r in rules if (m := r.match(text, at))), None)
        if match is None:
            assert text[at].isspace(), text[at : at + 20]
            at += 1
            continue
        found.append(match.start())
        at = match.end()
    return found


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_textmate_and_monarch_colour_all_tokens(path: Path) -> None:
    text = path.read_text()
    mode = tuple(re.compile(rule[0]) for rule in grammars.monarch(words())["tokenizer"]["root"])
    assert textmate_starts(text) == _starts(mode, text) == [t.start for t in lexemes(text)]


def test_pygments_gives_the_text_back_and_knows_cassandras_files() -> None:
    for path in EXAMPLES:
        text = path.read_text()
        found = list(ModelLexer().get_tokens_unprocessed(text))
        assert "".join(t for _, _, t in found) == text
        assert not [t for _, kind, t in found if kind is Error]
    assert ModelLexer.analyse_text("discount: 0.95\nvalues: reward\n") == 0.0
    assert ModelLexer.analyse_text("model Tiger") > 0


def test_pygments_finds_the_lexer_by_the_packages_entry_point(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Metadata are made of pyproject.toml, as a clone may have been installed before it changed."""
    points = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]
    ((name, target),) = points["pygments.lexers"].items()
    installed = tmp_path / "colours-1.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: colours\nVersion: 1\n")
    (installed / "entry_points.txt").write_text(f"[pygments.lexers]\n{name} = {target}\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert isinstance(get_lexer_by_name("pomdp"), ModelLexer)
    assert isinstance(get_lexer_for_filename("tiger.pomdp"), ModelLexer)
