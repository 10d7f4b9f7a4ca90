# SPDX-License-Identifier: Apache-2.0
"""The examples of the documentation are models: each is checked, with the items that it leaves out."""

import re
from pathlib import Path

import pytest

from hypgen.cli import main
from hypgen.dsl.types import builtin_names

ROOT = Path(__file__).parent.parent.parent
GUIDES = sorted(str(path.relative_to(ROOT)) for path in (ROOT / "docs" / "guide").glob("*.md"))
PAGES = ("README.md", "docs/reference/language.md", *GUIDES)
LEFT_OUT = {"action": "action unused_action: bool", "discount": "discount 0.5"}


def fragments() -> list[tuple[str, str]]:
    return [
        (f"{Path(page).stem}-{number}", text)
        for page in PAGES
        for number, text in enumerate(re.findall(r"```pomdp\n(.*?)```", (ROOT / page).read_text(), re.DOTALL))
    ]


@pytest.mark.parametrize(("name", "text"), fragments(), ids=lambda value: value if len(value) < 20 else "")
def test_fragment(name: str, text: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    if not re.match(r"model\b", text):
        missing = [
            item for word, item in LEFT_OUT.items() if not re.search(rf"^\s*{word}\b", text, re.MULTILINE)
        ]
        text = "model Fragment\n" + text + "\n".join(missing) + "\n"
    path = tmp_path / "fragment.pomdp"
    path.write_text(text)
    code = main.run(["check", str(path)])
    assert code == 0, capfd.readouterr().err


def test_every_word_of_the_language_has_an_example() -> None:
    page = (ROOT / "docs" / "reference" / "language.md").read_text()
    examples = "\n".join(re.findall(r"```pomdp[a-z-]*\n(.*?)```", page, re.DOTALL))
    examples = re.sub(r"#.*", "", examples)
    grammar = (ROOT / "dsl" / "syntax" / "pomdp.lark").read_text()
    words = {
        *re.findall(r'"([a-z]+)"', grammar),
        *builtin_names.RESERVED_CALLS,
        *builtin_names.RESERVED_VALUES,
    }
    assert {word for word in words if not re.search(rf"\b{word}\b", examples)} == set()
    signs = re.findall(r'^\w+: "([^a-z"]+)"$', grammar, re.MULTILINE)
    assert {sign for sign in signs if sign not in examples} == set()


def test_an_import_of_the_library_that_is_shown(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "reference" / "language.md").read_text()
    (library,) = re.findall(r"```pomdp-library\n(.*?)```", page, re.DOTALL)
    (model,) = re.findall(r"```pomdp-import\n(.*?)```", page, re.DOTALL)
    (tmp_path / "grids.pomdp").write_text(library)
    (tmp_path / "maze.pomdp").write_text(model + "\n".join(LEFT_OUT.values()))
    assert main.run(["check", str(tmp_path / "maze.pomdp")]) == 0
