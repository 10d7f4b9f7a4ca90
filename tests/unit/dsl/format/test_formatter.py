# SPDX-License-Identifier: Apache-2.0
"""The formatter: one layout, the same tokens and comments, and nothing left to do the second time."""

from __future__ import annotations

import os
import re
import textwrap
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.paths import EXAMPLES, ROOT

from hypgen.dsl.format.formatter import format_source
from hypgen.dsl.messages.source import Source
from hypgen.dsl.syntax.parse import parse_concrete

MODELS = sorted(EXAMPLES.glob("*.pomdp"))


def formatted(text: str) -> str:
    return format_source(Source("x.pomdp", text))


def tokens(text: str) -> list[str]:
    return [str(token) for token in parse_concrete(Source("x.pomdp", text))[1]]


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.name)
def test_the_examples_are_formatted(path: Path) -> None:
    assert formatted(path.read_text()) == path.read_text()


@pytest.mark.parametrize("page", ["README.md", "docs/reference/language.md"])
def test_the_documentation_is_formatted(page: str) -> None:
    """HYPGEN_UPDATE=1 formats it."""
    text = (ROOT / page).read_text()

    def layout(block: re.Match[str]) -> str:
        head = "" if re.match(r"(model|library)\b", block[1]) else "model M\n"
        return f"```pomdp\n{formatted(head + block[1]).removeprefix(head)}```"

    shown = re.sub(r"```pomdp\n(.*?)```", layout, text, flags=re.DOTALL)
    if os.environ.get("HYPGEN_UPDATE") == "1":
        (ROOT / page).write_text(shown)
    assert (ROOT / page).read_text() == shown, "run this file with HYPGEN_UPDATE=1"


def check(before: str, after: str) -> None:
    """Compare formatted text, given without the common indentation and the model's name."""
    before, after = (f"model M\n\n{textwrap.dedent(text)}" for text in (before, after))
    assert formatted(before) == after


def test_spaces_follow_from_the_tokens() -> None:
    check(
        "const a:int=-3+4   *( -2 )//b [ 1,2 ]**-c\ntype T=bool [ R ,S]\n"
        "reward r=if not(x'==- 1)then{a : 1.0,else b}else e . x\n",
        "const a: int = -3 + 4 * (-2) // b[1, 2] ** -c\ntype T = bool[R, S]\n"
        "reward r = if not (x' == -1) then { a: 1.0, else b } else e.x\n",
    )
    check("param v : float < m / s ^ 2 > [ I ]\n", "param v: float<m/s^2>[I]\n")


def test_members_are_indented_and_blank_lines_are_single() -> None:
    check(
        """\
        element e[ i in R ]{

              hidden x:bool
           # about the next line


           init x=true


           }
        # the end


        """,
        """\
        element e[i in R] {
          hidden x: bool
          # about the next line

          init x = true
        }
        # the end
        """,
    )


def test_what_is_aligned_stays_aligned_and_mends() -> None:
    check(
        """\
        type Column  = 0 .. 3
        type Row  = 0 .. 3     # rows
        type Rock = 0 .. 3     # rocks
        const a: int   = 1
        const bcd: int = match  x {
            north => 1
            east  => 2
            southern => 3
        }
        """,
        """\
        type Column = 0 .. 3
        type Row    = 0 .. 3   # rows
        type Rock   = 0 .. 3   # rocks
        const a: int   = 1
        const bcd: int = match x {
          north    => 1
          east     => 2
          southern => 3
        }
        """,
    )


def test_numbers_of_a_table_may_be_aligned_at_their_ends() -> None:
    check(
        """\
        const a: int[X, Y] = [
            [ 1,-20,  3],
            [10,  2, 33],
            [ 1, 2, 3]
        ]
        """,
        """\
        const a: int[X, Y] = [
          [ 1, -20,  3],
          [10,   2, 33],
          [ 1, 2, 3]
        ]
        """,
    )


def test_continued_lines_keep_their_place() -> None:
    check(
        """\
        reward a = if x  then 1
                         else 2
        reward b =  sum(r in R:
                        c)
                 +  3
        reward c =
              1
        reward d =
            1
          + 2
        """,
        """\
        reward a = if x then 1
                        else 2
        reward b = sum(r in R:
                       c)
                 + 3
        reward c =
            1
        reward d =
            1
          + 2
        """,
    )


def test_long_lines_are_broken() -> None:
    term = "sum(r in Rock where rock[r].good: value_of_a_rock(r))"
    check(f"reward a = {term} + {term}\n", f"reward a = {term}\n    + {term}\n")
    long = "value_of_what_is_expected_here(a, b)"
    check(
        f"reward a = if a then {long} else if b then {long} else 0\n",
        f"reward a = if a then {long}\n                else if b then {long} else 0\n",
    )
    check(
        "discount 0.5 element e { hidden " + "x" * 80 + ": bool init x = true }\n",
        "discount 0.5\nelement e {\n  hidden " + "x" * 80 + ": bool\n  init x = true\n}\n",
    )


NESTED = """\
model M
element e {
  x' = if act == north and robot.battery > 0
      then if y > 3 then clamp(cell + width * stride) else clamp(cell - other)
      else if act == south and robot.battery > 0 then if zz then clamp(cell - width) else 3
      else cell
  mode' = if (if act == north then robot.battery > threshold_for_return
                              else robot.battery > threshold_for_charge)
      then (if mode == idle then moving else if mode == charging then idle else mode) else mode
  temp' ~ if act == heat
      then if window.open then { clamp(temp + 1): 0.5, temp: 0.3, else clamp(temp - 1) }
                          else { clamp(temp + 2): 0.6, clamp(temp + 1): 0.3, else temp }
      else if window.open then clamp(temp - 1) else temp
}
reward r = (if robot.cell == goal and robot.cell' != goal then 100 else 0)
    + (if robot.battery' == 0 then -50 else if robot.battery' < 3 then -10 else 0)
    + (if act == wait then -1 else -2)
"""


def test_a_long_conditional_is_broken_at_its_outermost_branches() -> None:
    unbroken = re.sub(r"\n {4,}", " ", NESTED)
    assert max(map(len, unbroken.split("\n"))) > 180
    assert formatted(unbroken) == NESTED


def test_instances_and_libraries_are_files_too() -> None:
    assert formatted('instance a of "b.pomdp" {n=1 k=2}') == 'instance a of "b.pomdp" { n = 1  k = 2 }\n'
    assert formatted("library l const a:int=1") == "library l\nconst a: int = 1\n"


def comments(text: str) -> list[str]:
    """Return the comments; a ``#`` in a glyph starts none."""
    return re.findall("#.*", re.sub('"[^"\n]*"', '""', text))


# Between two tokens: what a careless or a careful author may have left there.
SPACES = st.sampled_from(
    [" ", "  ", "   ", "\t", "\n", "\n\n\n", "\n    ", "\n        ", " # why\n", "\n  # why\n"]
)


LAYOUTS = given(st.data(), st.sampled_from(MODELS))
FEW, MANY = settings(max_examples=4, deadline=None), settings(max_examples=60, deadline=None)


def check_any_layout(data: st.DataObject, path: Path) -> None:
    """Put any space between 120 tokens of a file."""
    words = tokens(path.read_text())
    start = data.draw(st.integers(0, max(0, len(words) - 120)))
    separators = data.draw(st.lists(SPACES, min_size=120, max_size=120))
    pairs = zip(words[start:], separators, strict=False)
    text = " ".join(words[:start]) + "\n" + "".join(w + s for w, s in pairs) + " ".join(words[start + 120 :])
    once = formatted(text)
    assert tokens(once) == words
    assert comments(once) == comments(text)
    assert formatted(once) == once


def check_careless_edit(data: st.DataObject, path: Path) -> None:
    """Insert or remove space at a few places of a file that is formatted."""
    text = path.read_text()
    places = [m.span() for m in re.finditer(r"(?<=[,\s]) +|\n", text)]
    for start, end in sorted(
        data.draw(st.lists(st.sampled_from(places), max_size=8, unique=True)), reverse=True
    ):
        before = text[text.rfind("\n", 0, start) + 1 : start]
        if "#" not in before and before.count('"') % 2 == 0:  # neither in a comment nor in a string
            text = text[:start] + data.draw(SPACES) + text[end:]
    once = formatted(text)
    assert tokens(once) == tokens(text)
    assert formatted(once) == once


@FEW
@LAYOUTS
def test_any_layout_of_the_same_tokens_settles_at_once(data: st.DataObject, path: Path) -> None:
    check_any_layout(data, path)


@FEW
@LAYOUTS
def test_a_careless_edit_settles_at_once(data: st.DataObject, path: Path) -> None:
    check_careless_edit(data, path)


@pytest.mark.property
@MANY
@LAYOUTS
def test_many_layouts_of_the_same_tokens_settle_at_once(data: st.DataObject, path: Path) -> None:
    check_any_layout(data, path)


@pytest.mark.property
@MANY
@LAYOUTS
def test_many_careless_edits_settle_at_once(data: st.DataObject, path: Path) -> None:
    check_careless_edit(data, path)
