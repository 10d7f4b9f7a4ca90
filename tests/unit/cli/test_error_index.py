# SPDX-License-Identifier: Apache-2.0
"""The corpus of wrong models: what is said of each, word for word; docs/reference/errors is made of it.

``HYPGEN_UPDATE=1 pytest tests/unit/cli/test_error_index.py`` writes what is said now into the corpus and the
pages anew; review the difference.
"""

import os
import re
import textwrap
from pathlib import Path

import pytest
from support.error_corpus import accept, diagnose, prepare, shown, told
from support.paths import ROOT

from hypgen.cli import main
from hypgen.cli.show.error_index import BEGINNING, Case, Entry, Example, cases, entries

PAGES = ROOT / "docs" / "reference" / "errors"
UPDATE = os.environ.get("HYPGEN_UPDATE") == "1"
ENTRIES = entries()
CASES = cases()
CLASSES = {
    "E00": "Files and settings",
    "E01": "Syntax",
    "E02": "Names",
    "E03": "Types",
    "E04": "Inits and updates",
    "E05": "What agent and policy may know",
    "E06": "Ranges",
    "E07": "Draws",
    "E08": "Parts of a model",
    "E09": "Other formats",
    "W": "Warnings",
    "C": "Found by sampling",
}
HEADING = """\
# Messages

Every message of hypgen has a code. A page for each group of codes says what each code means. It
shows a model that has the mistake, what hypgen prints, and the model put right. `hypgen error CODE`
prints the same in the terminal. Tests make these pages from `cli/show/errors/`, which is the place
to change: `HYPGEN_UPDATE=1 pytest tests/unit/cli/test_error_index.py`.
"""
GOES_ON = """\
## The examples

An example is the file `example.pomdp`. Unless it begins with `model`, `instance` or `library`, the
page leaves out its first line, `model Example`. The example goes on with the following
declarations, except those that it makes itself:
"""
GROUP = """\
# {title}

[All messages](README.md) | [how an example goes on](README.md#the-examples)
"""


def test_every_code_has_its_entry() -> None:
    files = [path for layer in ("dsl", "codegen", "cli") for path in (ROOT / layer).rglob("*.py")]
    code = re.compile(r'"([EC]0\d{3}|W\d\d)"')
    used = {found for file in files for found in code.findall(file.read_text())}
    assert used == set(ENTRIES)


@pytest.mark.parametrize("entry", ENTRIES.values(), ids=ENTRIES)
def test_the_mistake_is_told_word_for_word(
    entry: Entry, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    prepare(entry, entry.wrong, tmp_path)
    monkeypatch.chdir(tmp_path)
    codes, text = told(entry, entry.wrong)
    assert codes == {entry.code}, text
    if UPDATE:
        accept(entry, shown(text))
    else:
        assert shown(text) == entry.says


@pytest.mark.parametrize("entry", ENTRIES.values(), ids=ENTRIES)
def test_nothing_is_told_of_the_correction(
    entry: Entry, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if entry.right is not None:
        prepare(entry, entry.right, tmp_path)
        monkeypatch.chdir(tmp_path)
        assert told(entry, entry.right) == (set(), "")


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.code}, {case.what}")
def test_the_case_is_told_word_for_word(case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / case.name).write_text(case.text)
    monkeypatch.chdir(tmp_path)
    found, text = diagnose(case)
    assert {d.code for d in found} == {case.code} or case.code == "several" and len(found) > 1
    assert all(d.remedy and d.span is not None for d in found)
    if UPDATE:
        accept(case, text)
    else:
        assert text == case.says


def test_each_case_is_another() -> None:
    assert len({(case.code, case.what) for case in CASES}) == len({case.text for case in CASES}) == len(CASES)


def block(example: Example) -> str:
    text = example.text.rstrip("\n")
    if example.options:
        text = f"# hypgen check example.pomdp {' '.join(example.options)}\n{text}"
    for name, other in example.named_files().items():
        if "\n" in other:
            text += f"\n\n# {name}:\n{other.rstrip()}"
    return f"```\n{text}\n```\n"


def wrapped(text: str) -> str:
    return textwrap.fill(text, 100, break_long_words=False, break_on_hyphens=False)


def pages() -> dict[str, str]:
    """Return the pages of docs/reference/errors by name: the index and one for each group of codes."""
    result, index = {}, [HEADING]
    listed = entries().values()  # those in the files now, which the tests above may have written
    for prefix, title in CLASSES.items():
        group = [entry for entry in listed if entry.code.startswith(prefix)]
        parts, rows = [GROUP.format(title=title)], ["| code | meaning |", "|---|---|"]
        for entry in group:
            parts += [f"## {entry.code}\n", f"{wrapped(entry.meaning)}\n"]
            parts += [block(entry.wrong), f"```\n{entry.says}```\n"]
            parts += ["Right:\n", block(entry.right)] if entry.right else []
            rows.append(f"| [{entry.code}]({prefix.lower()}.md#{entry.code.lower()}) | {entry.meaning} |")
        result[f"{prefix.lower()}.md"] = "\n".join(parts)
        index += [f"## [{title}]({prefix.lower()}.md)\n", *rows, ""]
    result["README.md"] = "\n".join([*index, GOES_ON, f"```\n{BEGINNING}```\n"])
    return result


def test_the_pages_are_up_to_date() -> None:
    made = pages()
    if UPDATE:
        for name, text in made.items():
            (PAGES / name).write_text(text)
    assert {path.name: path.read_text() for path in PAGES.iterdir()} == made


def test_a_code_is_explained_in_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["error", "e0301"]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("E0301: ") and "Right:\n\n    reward goal" in printed
    assert main.run(["error"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == len(ENTRIES)
    assert main.run(["error", "E9999"]) == 2
    assert "hypgen error lists" in capsys.readouterr().err
