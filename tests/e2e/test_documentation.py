"""The examples of the documentation are models: each is checked, with the items that it leaves out."""

import re
from pathlib import Path

import pytest

from hypgen.cli import main

ROOT = Path(__file__).parent.parent.parent
PAGES = ("README.md", "docs/language.md")
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
