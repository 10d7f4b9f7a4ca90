# SPDX-License-Identifier: Apache-2.0
"""What the documentation site takes from the sources: options, grammar, words, and the playground's calls."""

import re
import runpy
from pathlib import Path

import browser
import pytest

ROOT = Path(__file__).parents[2]
TIGER = ROOT / "examples" / "tiger.pomdp"


def test_pages_link_to_pages_that_the_site_has() -> None:
    """Sphinx says so too, but a build takes a minute."""
    matching = pytest.importorskip("sphinx.util.matching", reason="needs Sphinx, of [docs]")
    conf = runpy.run_path(str(ROOT / "docs" / "site" / "conf.py"))
    included, excluded = conf["include_patterns"], [*conf["exclude_patterns"], "**/_*"]
    pages = [ROOT / name for name in matching.get_matching_files(ROOT, included, excluded)]
    for page in (p for p in pages if p.suffix == ".md"):
        text = re.sub(r"^```.*?^```|`[^`\n]*`", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
        linked = re.findall(r"\]\(([^():#\s]+\.md)[)#]", text)
        assert {(page.parent / name).resolve() for name in linked} <= set(pages), page


def test_options_are_those_of_the_guide() -> None:
    option_tables = pytest.importorskip("option_tables")
    found = option_tables.read("solver/options.cpp")
    guide = (ROOT / "docs" / "guide" / "solver.md").read_text()
    table = guide[guide.index("## Options") : guide.index("### Modes")]
    assert {o.name for o in found} == set(re.findall(r"^\| .*?(--[a-z-]+)", table, re.MULTILINE)) | {
        "--version"
    }
    (time,) = [o for o in found if o.name == "--time"]
    assert time.metavar == "SECONDS" and time.help.startswith("time to plan a step (0.1")


@pytest.mark.parametrize("file", ["exact/exact_options.cpp", "verify/verify_options.cpp"])
def test_other_tables_are_understood(file: str) -> None:
    option_tables = pytest.importorskip("option_tables")
    assert {"--help", "--version"} < {o.name for o in option_tables.read(file)}


def test_every_rule_is_drawn_and_links_lead_to_rules() -> None:
    grammar_drawings = pytest.importorskip("grammar_drawings", reason="needs railroad-diagrams, of [docs]")
    drawn = list(grammar_drawings.drawings())
    rules = {f"#rule-{name.lower().replace('_', '-')}" for name, _, _ in drawn}
    assert {"#rule-model-file", "#rule-expr", "#rule-name"} < rules
    links = {link for _, _, svg in drawn for link in re.findall(r'href="(#[^"]*)"', svg)}
    assert links <= rules
    texts = {name: text for name, text, _ in drawn}
    assert texts["update"] == 'NAME "\'" rhs'
    assert texts["setting"] == '("discount" | "horizon") expr'


def test_examples_have_colours() -> None:
    colours = pytest.importorskip("colours", reason="needs Pygments, of [docs]")
    from pygments.token import Error, Keyword

    for path in (ROOT / "examples").rglob("*.pomdp"):
        found = list(colours.ModelLexer().get_tokens(path.read_text()))
        assert not [text for kind, text in found if kind is Error], path
    kinds = {text: kind for kind, text in colours.ModelLexer().get_tokens(TIGER.read_text())}
    assert kinds["hidden"] in Keyword and kinds["prob"] is Keyword.Type


def test_the_playground_checks_and_explains(tmp_path: Path) -> None:
    text = TIGER.read_text()
    assert browser.check(text, "tiger.pomdp")["line"].startswith("OK: Tiger: 1 bit of state")
    wrong = browser.check(text.replace("room.tiger == left", "rom.tiger == left"), "tiger.pomdp")
    assert wrong["line"] == "1 mistake"
    assert wrong["diagnostics"][0]["code"] == "E0201"
    assert browser.explain(text, "tiger.pomdp").startswith("Tiger: discount 0.95")
    assert "E0005" in str(browser.check("", str(tmp_path / "empty.pomdp")))


def test_the_playground_plays() -> None:
    begun = browser.play(TIGER.read_text(), "tiger.pomdp", 0)
    assert [name for _, name in begun["legal"]] == ["listen", "open_left", "open_right"]
    assert "reward -1" in browser.act("0")["text"]
    assert "left" in browser.act("belief")["text"]
    assert "back before step 0" in browser.act("undo")["text"]
    assert "step 0:" in browser.act("policy")["text"]
    assert "step 1:" in browser.act("random")["text"]
    assert browser.play("model", "wrong.pomdp", 0)["ended"]
