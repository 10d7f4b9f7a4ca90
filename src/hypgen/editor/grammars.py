# SPDX-License-Identifier: Apache-2.0
"""The table of words as colours of other tools: TextMate's grammar and Monarch's mode.

``python -m hypgen.editor.grammars FOLDER`` writes them below a folder, which is ``editors/``.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from hypgen.editor.answers import SNIPPETS
from hypgen.editor.words import Words, words

# A field of Words or a pattern: TextMate's scope, Monarch's token.
SCOPES = {
    "declarations": ("keyword.declaration", "keyword"),
    "control": ("keyword.control", "keyword"),
    "operators": ("keyword.operator.word", "keyword"),
    "types": ("storage.type", "type"),
    "constants": ("constant.language", "constant"),
    "functions": ("support.function", "predefined"),
    "values": ("support.constant", "predefined"),
}
_TOKENS = {
    "COMMENT": ("comment.line.number-sign", "comment"),
    "STRING": ("string.quoted.double", "string"),
    "FLOAT": ("constant.numeric.float", "number.float"),
    "INT": ("constant.numeric.integer", "number"),
    "NAME": ("variable.other", "identifier"),
}


def textmate(table: Words) -> dict[str, Any]:
    """Return the grammar of TextMate, which VS Code, Sublime Text and GitHub read."""
    fixed = [
        {"name": f"{scope}.pomdp", "match": rf"\b(?:{'|'.join(getattr(table, kind))})\b"}
        for kind, (scope, _) in SCOPES.items()
    ]
    tokens = {n: {"name": f"{s}.pomdp", "match": table.patterns[n]} for n, (s, _) in _TOKENS.items()}
    symbols = "|".join(_escaped(s) for s in table.symbols)
    return {
        "name": "hypgen",
        "scopeName": "source.pomdp",
        "fileTypes": ["pomdp"],
        "patterns": [
            tokens["COMMENT"],
            tokens["STRING"],
            *fixed,
            tokens["NAME"],
            tokens["FLOAT"],
            tokens["INT"],
            {"name": "keyword.operator.pomdp", "match": symbols},
        ],
    }


def monarch(table: Words) -> dict[str, Any]:
    """Return the mode of Monaco's Monarch; ``regex`` texts are sources of JavaScript's expressions."""
    kinds = {kind: list(getattr(table, kind)) for kind in SCOPES}
    cases = {f"@{kind}": token for kind, (_, token) in SCOPES.items()}
    root: list[Any] = [
        [table.patterns["COMMENT"], "comment"],
        [table.patterns["STRING"], "string"],
        [table.patterns["NAME"], {"cases": cases | {"@default": "identifier"}}],
        [table.patterns["FLOAT"], "number.float"],
        [table.patterns["INT"], "number"],
        ["|".join(_escaped(s) for s in table.symbols), "delimiter"],
    ]
    return {"defaultToken": "", "tokenPostfix": ".pomdp", **kinds, "tokenizer": {"root": root}}


def files() -> dict[str, str]:
    """Return the generated files by their path below ``editors/``."""
    made = {
        "vscode/syntaxes/pomdp.tmLanguage.json": textmate(words()),
        "vscode/snippets/pomdp.json": {w: {"prefix": w, "body": b.split("\n")} for w, b in SNIPPETS.items()},
        "web/pomdp.monarch.json": monarch(words()),
    }
    return {path: json.dumps(content, indent=1) + "\n" for path, content in made.items()}


def _escaped(symbol: str) -> str:
    return "".join(c if c.isalnum() else f"\\{c}" if c in "^$.|?*+()[]{}\\/" else c for c in symbol)


if __name__ == "__main__":
    for path, text in files().items():
        (Path(sys.argv[1]) / path).write_text(text, encoding="utf-8")
