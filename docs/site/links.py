# SPDX-License-Identifier: Apache-2.0
"""Makes the Markdown files, which are written for a repository, into pages of one site.

Links to folders go to a page that tells of the folder. The first page gets the table of contents.
"""

import re
from pathlib import Path

from sphinx.application import Sphinx

ROOT = Path(__file__).parents[2]
_CONTENTS = Path(__file__).with_name("contents.txt")
_LINK = re.compile(r"\[([^\[\]]*)\]\(([^()#\s]+)\)")
_EXAMPLES = ROOT / "docs" / "reference" / "examples.md"


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the rewriting with Sphinx."""
    app.connect("source-read", _rewrite)
    return {"parallel_read_safe": True}


def _rewrite(app: Sphinx, docname: str, source: list[str]) -> None:
    page = ROOT / f"{docname}.md"
    source[0] = _LINK.sub(lambda link: _to_a_page(link, page), source[0])
    if docname == app.config.root_doc:
        app.env.note_dependency(str(_CONTENTS))
        source[0] += "\n" + _CONTENTS.read_text(encoding="utf-8")


def _to_a_page(link: re.Match[str], page: Path) -> str:
    """Return a link of ``page`` to a folder as one to its page, or as text where it has none."""
    text, target = link.groups()
    if ":" in target or not (folder := (page.parent / target).resolve()).is_dir():
        return link[0]
    is_example = folder.is_relative_to(ROOT / "examples")
    inside = _EXAMPLES if is_example else folder / "README.md"
    if not inside.exists():
        return text
    return f"[{text}](/{inside.relative_to(ROOT)})"
