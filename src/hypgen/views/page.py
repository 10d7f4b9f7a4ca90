# SPDX-License-Identifier: Apache-2.0
"""The page of an episode: one HTML file with style, script and data inside."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import jinja2
from markupsafe import Markup

from hypgen import __version__
from hypgen.dsl.types.palette import PALETTE
from hypgen.views.texts import number

_SCRIPTS = (
    *("values", "world", "variables", "decision", "tree"),
    *("curves", "history", "time_line", "live", "start"),
)

_TEMPLATES = jinja2.Environment(
    loader=jinja2.PackageLoader("hypgen", "."),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
_TEMPLATES.filters["number"] = number


def page_of(view: Mapping[str, Any]) -> str:
    """Return the page that shows what ``view_of`` gives.

    With a member ``live`` it asks its server for what is new, and for nothing else.
    """
    return _TEMPLATES.get_template("views/page.html.j2").render(
        view=view,
        version=__version__,
        style=_text("colours.css") + _palette() + _text("views/page.css"),
        script=Markup("\n").join(_text(f"views/{name}.js") for name in _SCRIPTS),
        data=as_json(view),
    )


def _text(name: str) -> Markup:
    assert _TEMPLATES.loader is not None
    return Markup(_TEMPLATES.loader.get_source(_TEMPLATES, name)[0])


def _palette() -> Markup:
    """Return the colours of drawings as ``--c-NAME``, for light and for dark ground."""
    light, dark = (
        "".join(f"--c-{name}: {both[ground]}; " for name, both in PALETTE.items()) for ground in (0, 1)
    )
    return Markup(
        f":root {{ {light}}}\n@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark}}} }}\n"
    )


def as_json(value: Any) -> Markup:
    """Return data as JSON that may stand in an element of script: no text in it ends the element."""
    text = json.dumps(finite(value), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return Markup(text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029"))


def finite(value: Any) -> Any:
    """Return data without numbers that JSON lacks: they are unknown."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [finite(one) for one in value]
    return value
