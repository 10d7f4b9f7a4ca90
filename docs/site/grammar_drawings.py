# SPDX-License-Identifier: Apache-2.0
"""Railroad diagrams of the language, drawn from the grammar that the parser is made of."""

import io
from collections.abc import Iterator
from pathlib import Path

import lark
import railroad
from lark import Token, Tree

_GRAMMAR = Path(__file__).parents[2] / "dsl" / "syntax" / "pomdp.lark"
_LARKS_OWN = Path(lark.__file__).parent / "grammars" / "lark.lark"


def drawings() -> Iterator[tuple[str, str, str]]:
    """Yield the name, the text and the drawing, as SVG, of each rule; lexical ones are in capitals."""
    text = _GRAMMAR.read_text(encoding="utf-8")
    own = lark.Lark(_LARKS_OWN.read_text(encoding="utf-8"), parser="lalr", maybe_placeholders=False)
    rules = [tree for tree in own.parse(text + "\n").children if isinstance(tree, Tree)]
    words = {
        str(t.children[0]): t.children[-1] for t in rules if t.data == "token" and _is_word(t.children[-1])
    }
    for rule in rules:
        if rule.data not in ("rule", "token") or str(rule.children[0]) in words:
            continue
        name = _plain(rule.children[0])
        drawn = io.StringIO()
        railroad.Diagram(_item(rule.children[-1], words)).writeSvg(drawn.write)
        yield name, _spelled(rule.children[-1], words), drawn.getvalue()


def _is_word(tree: Tree[Token]) -> bool:
    return tree.data == "literal" and tree.children[0].type == "STRING"


def _plain(name: object) -> str:
    return str(name).lstrip("?!_")


def _item(tree: Tree[Token], words: dict[str, Tree[Token]]) -> railroad.DiagramItem:
    parts = [part for part in tree.children if part is not None]
    match tree.data:
        case "expansions":
            return railroad.Choice(0, *(_item(part, words) for part in parts))
        case "alias":
            return _item(parts[0], words)
        case "expansion":
            return railroad.Sequence(*(_item(part, words) for part in parts))
        case "maybe":
            return railroad.Optional(_item(parts[0], words))
        case "expr":
            again = railroad.ZeroOrMore if parts[1] == "*" else railroad.OneOrMore
            return again(_item(parts[0], words))
        case "literal":
            return railroad.Terminal(_unquoted(parts[0]))
        case _:
            name = str(parts[0])
            return (
                _item(words[name], words)
                if name in words
                else railroad.NonTerminal(_plain(name), f"#{_anchor(name)}")
            )


def _spelled(tree: Tree[Token], words: dict[str, Tree[Token]]) -> str:
    """Return a rule's right side in EBNF."""
    parts = [part for part in tree.children if part is not None]
    match tree.data:
        case "expansions":
            return " | ".join(_spelled(part, words) for part in parts)
        case "alias":
            return _spelled(parts[0], words)
        case "expansion":
            return " ".join(_grouped(part, words) for part in parts)
        case "maybe":
            return f"[{_spelled(parts[0], words)}]"
        case "expr":
            return f"{_grouped(parts[0], words)}{parts[1]}"
        case "literal":
            return str(parts[0])
        case _:
            name = str(parts[0])
            return _spelled(words[name], words) if name in words else _plain(name)


def _grouped(tree: Tree[Token], words: dict[str, Tree[Token]]) -> str:
    text = _spelled(tree, words)
    return f"({text})" if tree.data == "expansions" or (tree.data == "expansion" and " " in text) else text


def _unquoted(token: Token) -> str:
    return token[1:-1] if token.type == "STRING" else str(token)


def _anchor(name: str) -> str:
    return f"rule-{_plain(name).lower().replace('_', '-')}"
