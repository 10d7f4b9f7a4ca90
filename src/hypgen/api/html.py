# SPDX-License-Identifier: Apache-2.0
"""Small tables for notebooks."""

from collections.abc import Iterable
from html import escape


def table(title: str, rows: Iterable[tuple[str, object]]) -> str:
    """Return a table of HTML with a caption and a row for each name and value; all texts are escaped."""
    cells = (
        f'<tr><th style="text-align:left">{escape(name)}</th>'
        f'<td style="text-align:left">{escape(str(value))}</td></tr>'
        for name, value in rows
    )
    return f"<table><caption>{escape(title)}</caption>{''.join(cells)}</table>"
