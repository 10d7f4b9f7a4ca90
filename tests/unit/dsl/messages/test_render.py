# SPDX-License-Identifier: Apache-2.0
"""How diagnostics look."""

import json

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.render import render, render_all, to_json
from hypgen.dsl.messages.source import Source, Span

SOURCES = {"m.pomdp": Source("m.pomdp", "model M\n\tlegal when act = sample\n" + "\n" * 7 + "reward r = a\n")}


def at(line: int, column: int, end_column: int, end_line: int | None = None) -> Span:
    return Span("m.pomdp", line, column, end_line or line, end_column)


def test_frame_with_note_and_remedy() -> None:
    note = ((at(10, 1, 7), "opened here"),)
    text = render(Diagnostic("E0103", "wrong", at(2, 2, 7), "write `==`", note), SOURCES)
    assert text == (
        "error[E0103]: wrong\n"
        "  --> m.pomdp:2:2\n"
        "   |\n"
        " 2 |     legal when act = sample\n"
        "   |     ^^^^^\n"
        "note: opened here\n"
        "  --> m.pomdp:10:1\n"
        "   |\n"
        "10 | reward r = a\n"
        "   | ^^^^^^\n"
        "help: write `==`\n"
    )


def test_span_over_lines_marks_the_first() -> None:
    text = render(Diagnostic("E0103", "wrong", at(2, 7, 3, end_line=10), "help"), SOURCES)
    assert text.splitlines()[4] == "  |" + " " * 10 + "^" * 18


def test_end_of_line_and_missing_source() -> None:
    text = render(Diagnostic("E0101", "wrong", at(10, 13, 14), "help"), SOURCES)
    assert text.splitlines()[4] == "   | " + " " * 12 + "^"
    assert render(Diagnostic("E0001", "no file", None, "look"), {}) == "error[E0001]: no file\nhelp: look\n"
    assert "--> m.pomdp:1:1" in render(Diagnostic("E0101", "wrong", at(1, 1, 2), "help"), {})


def test_long_lines_are_cropped_around_the_span() -> None:
    line = "a" * 500 + "HERE" + "b" * 500
    sources = {"m.pomdp": Source("m.pomdp", line)}
    rows = render(Diagnostic("E0101", "wrong", at(1, 501, 505), "help"), sources).splitlines()
    assert all(len(row) <= 110 for row in rows)
    marked = rows[4].index("^")
    assert rows[3][marked : marked + 4] == "HERE"
    assert rows[4].count("^") == 4
    assert rows[3][4:7] == rows[3][-3:] == "..."


def test_control_and_wide_characters_keep_the_caret_in_place() -> None:
    sources = {"m.pomdp": Source("m.pomdp", "\x1b[31m漢字 x")}
    rows = render(Diagnostic("E0102", "wrong", at(1, 9, 10), "help"), sources).splitlines()
    assert "\x1b" not in rows[3]
    assert rows[4].index("^") == len("1 | ?[31m") + 2 * 2 + 1


def test_render_all_and_json() -> None:
    one = Diagnostic("E0101", "wrong", at(10, 1, 7), "help", ((at(1, 1, 6), "here"),))
    assert render_all([one, one], SOURCES) == render(one, SOURCES) + "\n" + render(one, SOURCES)
    data = json.loads(json.dumps(to_json(one)))
    assert data["span"] == {"file": "m.pomdp", "line": 10, "column": 1, "end_line": 10, "end_column": 7}
    assert data["notes"][0]["text"] == "here"
    assert to_json(Diagnostic("E0001", "no", None, "help"))["span"] is None


def test_of_very_many_diagnostics_the_first_are_shown() -> None:
    text = render_all([Diagnostic("E0001", f"mistake {i}", None, "none") for i in range(60)], {})
    assert "mistake 49" in text and "mistake 50" not in text
    assert text.endswith("\nand 10 more\n")
