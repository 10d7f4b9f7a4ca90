# SPDX-License-Identifier: Apache-2.0
"""The parser's tables in the package: in step with the grammar, and nothing runs when they are read."""

import json
import os
import pickle
from pathlib import Path

import lark
import pytest

from hypgen.dsl.syntax import parser_tables

FOLDER = Path(parser_tables.__file__).parent
GRAMMAR = (FOLDER / parser_tables.GRAMMAR).read_text(encoding="utf-8")
MODEL = Path(__file__).parents[4] / "examples" / "tag.pomdp"


def test_the_tables_in_the_package_are_those_of_the_grammar() -> None:
    path = FOLDER / parser_tables.TABLES
    found = json.loads(path.read_text(encoding="utf-8"))
    if found["lark"] != lark.__version__ and os.environ.get("HYPGEN_UPDATE") != "1":
        pytest.skip(f"the tables are of lark {found['lark']}")
    made = parser_tables.pack(parser_tables.make_parser(GRAMMAR), GRAMMAR)
    text = json.dumps(made, separators=(",", ":")) + "\n"
    if os.environ.get("HYPGEN_UPDATE") == "1":
        path.write_text(text, encoding="utf-8")
    assert path.read_text(encoding="utf-8") == text, "HYPGEN_UPDATE=1 writes them"


@pytest.mark.parametrize("what", ["options", "lark"])
def test_tables_of_another_grammar_or_lark_are_not_used(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []
    monkeypatch.setattr(parser_tables, "make_parser", lambda grammar: made.append(grammar))
    parser_tables.load_parser()
    assert made == []
    if what == "lark":
        monkeypatch.setattr(lark, "__version__", "0.0")
    else:
        monkeypatch.setitem(parser_tables.OPTIONS, "start", ["file"])
    parser_tables.load_parser()
    assert made == [GRAMMAR]


def test_the_packed_parser_is_the_parser_of_the_grammar() -> None:
    packed, made = parser_tables.load_parser(), parser_tables.make_parser(GRAMMAR)
    text = MODEL.read_text(encoding="utf-8")
    assert packed.parse(text, start="file") == made.parse(text, start="file")
    assert [t.name for t in packed.terminals] == [t.name for t in made.terminals]
    with pytest.raises(lark.UnexpectedInput) as wrong:
        made.parse("model {", start="file")
    with pytest.raises(lark.UnexpectedInput) as found:
        packed.parse("model {", start="file")
    assert str(found.value) == str(wrong.value)


def test_no_pickle_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError("a pickle can run code")

    monkeypatch.setattr(pickle, "load", refuse)
    monkeypatch.setattr(pickle, "loads", refuse)
    parser_tables.load_parser()
