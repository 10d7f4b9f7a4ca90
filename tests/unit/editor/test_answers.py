# SPDX-License-Identifier: Apache-2.0
"""Answers and fixes of a document, without a protocol."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hypgen.dsl.load import Loaded
from hypgen.dsl.types import builtin_names
from hypgen.editor import answers, renames
from hypgen.editor.document import Document, Stopped
from hypgen.editor.facts import facts
from hypgen.editor.fixes import fixes
from hypgen.editor.forms import FORMS, VALUES

EXAMPLES = Path(__file__).parents[3] / "examples"
TIGER = (EXAMPLES / "tiger.pomdp").read_text()
OPEN_LEFT = "  open_left  => if room.tiger == left  then -100 else 10\n"
UNITS = "const cm: float<m> = 0.5\n"
ADRIFT = """
const fast: float<m/s> = 2
element boat {
  hidden fixed drift: float<m/s>
  init drift ~ uniform(0.5, 1.5)
}
"""


def opened(tmp_path: Path, text: str = TIGER, good: str | None = None) -> Document:
    """Return a checked document; ``good`` is an earlier text of it."""
    document = Document(str(tmp_path / "model.pomdp"), good or text)
    document.check()
    document.text = text
    document.check()
    return document


@pytest.mark.parametrize(
    ("before", "after", "title"),
    [
        ("room.tiger ==", "room.tigr ==", "Write tiger"),
        ("init tiger ~", "init tiger =", "Write ~ for ="),
        ("act == listen then tiger", "act = listen then tiger", "Write =="),
        (OPEN_LEFT, "", "Add open_left with the value if room.tiger == right then -100 else 10"),
        ("  init tiger ~ uniform(Door)\n", "", "Add init tiger ~ uniform(Door)"),
        ("  tiger' ~ if act == listen then tiger else uniform(Door)\n", "", "Add tiger' = tiger"),
        ("hidden tiger: Door", "hidden tiger: Dor", "Write Door"),
        ("param hearing: prob = 0.85", UNITS + "param hearing: prob = cm", "Write value(cm)"),
        ("uniform(Door)\n  tiger'", "uniform(Door\n  tiger'", "Insert )"),
    ],
)
def test_fixes_take_mistakes_away(tmp_path: Path, before: str, after: str, title: str) -> None:
    document = opened(tmp_path, TIGER.replace(before, after, 1))
    assert document.checked.found
    found = [f for mistake in document.checked.found for f in fixes(document, mistake)]
    assert title in [f.title for f in found]


def test_a_name_that_is_declared_twice_is_not_renamed(tmp_path: Path) -> None:
    twice = TIGER.replace("element room {", "element hall {\n  hidden tiger: Door\n}\nelement room {")
    document = opened(tmp_path, twice, TIGER)
    with pytest.raises(renames.RenameRefused):
        renames.rename(document, twice.index("tiger: Door"), "beast")
    document = opened(tmp_path)
    for taken in ("listen", "model", "a b", ""):
        with pytest.raises(renames.RenameRefused):
            renames.rename(document, TIGER.index("tiger: Door"), taken)


HALL = """
element hall {
  hidden tiger: Door
  init tiger ~ uniform(Door)
  tiger' = if tiger == room.tiger then tiger else left
}
fn same(tiger: Door): bool = tiger == left
reward both = if same(hall.tiger) then 1 else 0
"""


def test_a_name_of_two_elements_is_renamed_in_one(tmp_path: Path) -> None:
    text = TIGER + HALL
    document = opened(tmp_path, text)
    edits = renames.rename(document, text.index("room.tiger'") + 5, "beast")
    changed = text
    for edit in sorted(edits, key=lambda e: -e.start):
        changed = changed[: edit.start] + edit.text + changed[edit.end :]
    assert "  beast' ~ if act == listen then beast else" in changed and "if room.beast == left" in changed
    assert HALL.replace("room.tiger", "room.beast") in changed
    assert {e.start for e in edits} == {
        t.start for t in answers.references(document, text.index("hidden tiger") + 7)
    }


def test_a_name_of_a_library_is_renamed_in_all_that_import_it(tmp_path: Path) -> None:
    library = "library Lib\nfn twice(x: int): int = 2 * x\n"
    user = TIGER.replace("model Tiger\n", 'model Tiger\nimport "lib.pomdp"\n') + "reward more = twice(%s)\n"
    own = "if act == listen then 1 else 0"
    (tmp_path / "lib.pomdp").write_text(library)
    (tmp_path / "other.pomdp").write_text(user % own)
    (tmp_path / "third.pomdp").write_text(TIGER)
    document = opened(tmp_path, user % own)
    edits = renames.rename(document, document.text.index("twice"), "double")
    assert sorted(Path(e.path).name for e in edits) == ["lib.pomdp", "model.pomdp", "other.pomdp"]
    inside = Document(str(tmp_path / "lib.pomdp"), library)
    inside.check()
    assert {Path(e.path).name for e in renames.rename(inside, library.index("twice"), "double")} == {
        "lib.pomdp",
        "other.pomdp",
    }
    (tmp_path / "other.pomdp").write_text(user % own + "const double: int = 2\n")
    with pytest.raises(renames.RenameRefused, match="taken in other.pomdp"):
        renames.rename(document, document.text.index("twice"), "double")


def test_a_param_is_renamed_in_instances_too(tmp_path: Path) -> None:
    document = opened(tmp_path)
    (tmp_path / "model.pomdp").write_text(TIGER)
    (tmp_path / "deaf.pomdp").write_text('instance deaf of "model.pomdp" { hearing = 0.5 }\n')
    edits = renames.rename(document, TIGER.index("hearing"), "ears")
    assert [Path(e.path).name for e in edits] == ["model.pomdp", "model.pomdp", "deaf.pomdp"]


def test_completions_are_of_the_scope_and_work_half_typed(tmp_path: Path) -> None:
    text = TIGER + "\nreward late = room."
    document = opened(tmp_path, text, TIGER)
    assert [i.label for i in answers.completions(document, len(text))] == ["tiger"]
    names = {i.label: i for i in answers.completions(document, text.index("reward late"))}
    assert {"room", "Door", "listen", "hearing", "match", "uniform"} <= set(names)
    assert "${1" in names["match"].snippet


def test_signatures_name_formals(tmp_path: Path) -> None:
    good = TIGER + "\nfn pay(a: Act, b: Door): int = 0\n"
    text = good + "\nreward late = pay(listen, "
    document = opened(tmp_path, text, good)
    assert answers.signature(document, len(text)) == ("pay(a: Act, b: Door)", ["a: Act", "b: Door"], 1)


def test_forms_are_those_of_the_language(tmp_path: Path) -> None:
    assert set(FORMS) == builtin_names.RESERVED_CALLS and set(VALUES) == builtin_names.RESERVED_VALUES
    assert all(call.startswith(f"{name}(") for name, form in FORMS.items() for call in form.calls)
    text = TIGER + "\nreward late = clamp(3, "
    document = opened(tmp_path, text, TIGER)
    assert answers.signature(document, len(text)) == ("clamp(x, low, high)", ["x", "low", "high"], 1)
    shown = answers.hover(document, text.index("noisy("))
    assert shown == "noisy(value, p)\n# a draw: the value with probability p, else another one"
    assert answers.hover(document, text.index("gamma")).startswith("gamma  # the discount")


def test_fixes_are_tried_once_each_and_leave_no_other_mistake(tmp_path: Path) -> None:
    document = opened(tmp_path, TIGER.replace(OPEN_LEFT, ""))
    (fix,) = fixes(document, document.checked.found[0])
    assert document.diagnostics_of(document.text[: fix.start] + fix.text + document.text[fix.end :]) == ()


def test_hovers_name_units_and_ranges(tmp_path: Path) -> None:
    text = TIGER + ADRIFT
    document = opened(tmp_path, text)
    assert isinstance(document.loaded, Loaded), document.checked.found
    shown = answers.hover(document, text.index("drift: float"))
    assert shown == "hidden fixed boat.drift: float<m/s>"
    assert answers.hover(document, text.index("fast:")) == "const fast: float<m/s> = 2"
    assert answers.hover(document, text.index("hearing")) == "param hearing: prob = 0.85"
    assert answers.hover(document, text.index("heard: Door")) == "observe heard: Door, 1 bit"


def test_hints_of_rewards_are_the_values_that_they_reach(tmp_path: Path) -> None:
    more = "element late { let twice = if act == listen then 2 else -2  let slip ~ bernoulli(0.1) }\n"
    document = opened(tmp_path, TIGER + more)
    assert isinstance(document.loaded, Loaded), document.checked.found
    hints = {f.name: f.hint for f in facts(document.loaded)}
    assert (hints["late.twice"], hints["late.slip"], hints["heard"]) == ("-2 .. 2", "bool", "1 bit")
    assert hints["outcome"] == "-100 .. 10" and hints["room.tiger"] == "1 bit"


def test_references_keep_to_their_scope_and_reach_no_comments(tmp_path: Path) -> None:
    text = TIGER + "\nfn same(tiger: Door): bool = tiger == left  # the tiger\n"
    document = opened(tmp_path, text)
    found = [t.start for t in answers.references(document, text.index("tiger: Door"))]
    lines = {text[:at].count("\n") for at in found}
    assert len(found) == 7 and len(lines) == 6
    formals = answers.references(document, text.index("tiger: Door)"))
    assert [t.start for t in formals] == [text.index("tiger: Door)"), text.index("tiger == left  # the")]
    assert not any("#" in text[text.rfind("\n", 0, at) + 1 : at] for at in found)


def test_a_check_ends_between_passes_once_it_is_told_to(tmp_path: Path) -> None:
    asked = []

    def stopped() -> bool:
        asked.append(True)
        return len(asked) == 4

    document = opened(tmp_path)
    with pytest.raises(Stopped):
        document.examine(TIGER, stopped)
    assert len(asked) == 4


def test_open_texts_stand_for_files_of_imports_and_instances(tmp_path: Path) -> None:
    (tmp_path / "lib.pomdp").write_text("library Lib\nfn one(): int = 1\n")
    edited = {str(tmp_path.resolve() / "lib.pomdp"): b"library Lib\nfn two(): int = 2\n"}
    text = TIGER.replace("model Tiger\n", 'model Tiger\nimport "lib.pomdp"\n') + "const more: int = two()\n"
    document = Document(str(tmp_path / "model.pomdp"), text, edited)
    assert [d.code for d in document.check()] == ["W01"]
    document.edited = {}
    assert [d.severity for d in document.check()] == ["error"]
    instance = Document(str(tmp_path / "deaf.pomdp"), 'instance deaf of "new.pomdp" { hearing = 0.5 }\n')
    assert [d.code for d in instance.check()] == ["E0001"]
    instance.edited = {str(tmp_path.resolve() / "new.pomdp"): TIGER.encode()}
    assert instance.check() == ()


def _edit(rng: random.Random, text: str) -> str:
    """Return a text with a letter of a name left out, or with a piece of it replaced by another."""
    if rng.random() < 0.5:
        at = rng.choice([m.start() for m in re.finditer(r"\w", text)] or [0])
        return text[:at] + text[at + 1 :]
    start = rng.randrange(len(text) + 1)
    end = min(len(text), start + rng.choice((0, 0, 1, 5, 40)))
    piece = rng.choice(
        ("", "{", "}", "(", "'", '"', "#", "\n", "let ", ".", "é", "~", "9", "if ", "match x {")
    )
    return text[:start] + piece + text[end:]


ASKED: tuple[Callable[[Document, int], Any], ...] = (
    answers.hover,
    answers.references,
    answers.completions,
    answers.signature,
)


@pytest.mark.parametrize("edits", [12, pytest.param(1000, marks=pytest.mark.slow)])
def test_random_edits_end_no_answer(tmp_path: Path, edits: int) -> None:
    """Each edit is checked, asked about at a random place, fixed, and a name of it is renamed."""
    rng = random.Random(7)
    document, fixed, renamed = opened(tmp_path), 0, 0
    for number in range(edits):
        document.text = _edit(rng, document.text if rng.random() < 0.3 else TIGER) or TIGER
        found = document.check()
        for ask in ASKED:
            ask(document, rng.randrange(len(document.text) + 1))
        if found and number % 4 == 0:
            fixed += len(fixes(document, rng.choice(found)))
        try:
            renamed += len(renames.rename(document, rng.randrange(len(document.text) + 1), "fresh"))
        except renames.RenameRefused:
            continue
    assert edits < 1000 or (fixed > 20 and renamed > 20)
