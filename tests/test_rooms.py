# SPDX-License-Identifier: Apache-2.0
"""The rules of the documentation that can be read off the files: rooms, lines, sentences, names and links."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from support import import_graph

ROOT = Path(__file__).parent.parent
MAX_README_LINES = 15
MAX_COLUMNS = 100
MEAN_WORDS, MOST_WORDS = 18, 40

FOLDERS = ("dsl", "codegen", "runtime", "cli", "src", "tests", "benchmarks", "docs", "examples")
PACKAGES = sorted(
    p.parent.relative_to(ROOT)
    for folder in (*import_graph.LAYERS, "src/hypgen", "tests/support")
    for p in (ROOT / folder).rglob("__init__.py")
)
ROOMS = [*PACKAGES, Path("benchmarks")]
INTERNALS = sorted((ROOT / "docs" / "internals").glob("*.md"))
DECISIONS = sorted((ROOT / "docs" / "decisions").glob("*.md"))
PLAIN = [ROOT / "ARCHITECTURE.md", *INTERNALS]


def pages() -> list[Path]:
    """Return the Markdown that people write; README.md of generated projects is under tests/golden."""
    own = [ROOT.glob("*.md"), *((ROOT / folder).rglob("*.md") for folder in FOLDERS)]
    return sorted(p for found in own for p in found if "golden" not in p.parts)


def prose(text: str) -> Iterator[str]:
    """Yield paragraphs and list items, each as one line, without code blocks, tables and headings."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)
    for block in re.split(r"\n\s*\n|\n(?=\s*(?:[-*]|\d+\.) )", text):
        if block.strip() and not block.lstrip().startswith(("|", "#")):
            yield " ".join(re.sub(r"^\s*(?:[-*]|\d+\.) ", "", block.strip("\n")).split())


def sentences(text: str) -> list[int]:
    """Return the number of words of each sentence; code and the target of a link count as one word."""
    plain = (re.sub(r"`[^`]*`", "Code", re.sub(r"\]\([^)]*\)", "]", p)) for p in prose(text))
    split = (re.split(r"(?<=[.!?])[)*\"']*\s+(?=[A-Z\[(*])", p) for p in plain)
    counts = (sum(1 for word in s.split() if re.search(r"\w", word)) for found in split for s in found)
    return [n for n in counts if n]


def parts_of(room: Path) -> dict[str, set[str]]:
    """Return a room's modules and sub-packages as its README names them, each with those that it imports."""
    folder = ROOT / room
    names = {f"{p.name}/" for p in folder.iterdir() if (p / "__init__.py").is_file()}
    names |= {p.name for p in folder.glob("*.py") if p.name != "__init__.py"}
    prefix = dotted(room)
    graph: dict[str, set[str]] = {}
    for name in names:
        part = (folder / name).resolve()
        files = [part] if part.is_file() else import_graph.python_files(part)
        imported = [n for path in files for n in imports(path) if n.startswith(prefix)]
        first = {n.removeprefix(prefix).partition(".")[0] for n in imported}
        graph[name] = {t for t in names if t.rstrip("/").removesuffix(".py") in first} - {name}
    return graph


def dotted(room: Path) -> str:
    """Return how full names of a room's modules begin."""
    if room == Path("benchmarks"):
        return ""  # scripts, which import each other by name
    kept = room.parts[1:] if room.parts[0] in ("src", "tests") else ("hypgen", *room.parts)
    return ".".join(kept) + "."


def imports(path: Path) -> list[str]:
    """Return the full names of what a module imports."""
    nodes = [n for n in ast.walk(ast.parse(path.read_text())) if not getattr(n, "level", 0)]
    names = [a.name for n in nodes if isinstance(n, ast.Import) for a in n.names]
    return names + [f"{n.module}.{a.name}" for n in nodes if isinstance(n, ast.ImportFrom) for a in n.names]


def listed_in(readme: Path) -> list[str]:
    """Return the files that a README lists: those in backticks before the colon of an item."""
    items = [line.partition(":")[0] for line in readme.read_text().splitlines() if line.startswith("- ")]
    return [name for item in items for name in re.findall(r"`([^`]+)`", item)]


@pytest.mark.parametrize("room", ROOMS, ids=str)
def test_a_room_lists_its_files_each_after_what_it_imports(room: Path) -> None:
    readme = ROOT / room / "README.md"
    assert len(readme.read_text().splitlines()) <= MAX_README_LINES
    listed = listed_in(readme)
    assert len(listed) == len(set(listed)), "a file is listed twice"
    parts = parts_of(room)
    assert set(parts) <= set(listed), f"not listed: {set(parts) - set(listed)}"
    gone = {name for name in listed if not (ROOT / room / name).exists()}
    assert not gone, f"listed, and not there: {gone}"
    for name, needed in parts.items():
        early = {t for t in needed if listed.index(t) > listed.index(name)}
        assert not early, f"{name} stands before {early}, which it imports"


def test_lines_of_prose_have_at_most_100_columns() -> None:
    """Rows of tables, blocks of code and single words, such as addresses, cannot be broken."""
    for page in (*pages(), *(ROOT / "tests" / "golden").rglob("*.md")):
        text = re.sub(r"^\s*```.*?^\s*```", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
        long = [n for n in text.splitlines() if len(n) > MAX_COLUMNS and not n.startswith("|")]
        assert not [n for n in long if len(n.split()) > 2], f"{page}: {long}"


@pytest.mark.parametrize("page", PLAIN, ids=lambda page: page.stem)
def test_sentences_are_short(page: Path) -> None:
    counts = sentences(page.read_text())
    assert sum(counts) / len(counts) <= MEAN_WORDS
    assert max(counts) <= MOST_WORDS


@pytest.mark.parametrize("page", [ROOT / "CONTRIBUTING.md", *PLAIN, *DECISIONS], ids=lambda page: page.stem)
def test_files_that_are_named_are_there(page: Path) -> None:
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
    named = {n for n in re.findall(r"`([\w/.]+)`", text) if n.partition("/")[0] in FOLDERS and "/" in n}
    assert not [name for name in named if not (ROOT / name).exists()]


def test_links_between_pages_lead_somewhere() -> None:
    for page in pages():
        text = re.sub(r"^```.*?^```|`[^`\n]*`", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
        for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text):
            assert "://" in target or (page.parent / target).exists(), f"{page}: {target}"


def test_pages_that_sources_name_are_there() -> None:
    for path in (p for folder in FOLDERS for p in (ROOT / folder).rglob("*.*")):
        if path.suffix in (".py", ".hpp", ".cpp", ".cuh", ".cu", ".j2", ".toml") and path.is_file():
            named = set(re.findall(r"\bdocs/[\w/-]+\.md\b", path.read_text()))
            assert not [name for name in named if not (ROOT / name).exists()], path
