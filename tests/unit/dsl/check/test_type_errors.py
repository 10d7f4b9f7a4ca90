"""One invalid model for each rule, and all that is said of it, word for word.

HYPGEN_UPDATE=1 rewrites the expected texts; review the difference.
"""

import os
from pathlib import Path

import pytest

from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.render import render_all
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse

MODELS = sorted((Path(__file__).parent / "errors").glob("*.pomdp"))


def diagnose(path: Path) -> ModelError:
    source = Source(path.name, path.read_text())
    with pytest.raises(ModelError) as caught:
        lower(parse(source), {}, source)
    return caught.value


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_the_mistake_is_told_word_for_word(path: Path) -> None:
    error = diagnose(path)
    text = render_all(error.diagnostics, {path.name: Source(path.name, path.read_text())})
    expected = path.with_suffix(".expected")
    if os.environ.get("HYPGEN_UPDATE"):
        expected.write_text(text)
    assert text == expected.read_text()


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_the_file_is_named_after_the_code_it_shows(path: Path) -> None:
    codes = {d.code.lower() for d in diagnose(path).diagnostics}
    assert path.stem.startswith("several") or codes == {path.stem.split("_")[0]}


def test_every_diagnostic_has_a_remedy_and_a_place() -> None:
    for path in MODELS:
        for diagnostic in diagnose(path).diagnostics:
            assert diagnostic.remedy and diagnostic.span is not None
