# SPDX-License-Identifier: Apache-2.0
"""The grammar's parser, made of tables that stand in the package: JSON, which runs nothing when it is read.

Lark takes 150 ms to make the tables of the grammar and 10 ms to read them. It can keep them only as a
pickle, which runs what it says. ``pomdp.tables.json`` says what it was made of; where that is another
grammar or another version of lark, the parser is made of the grammar.
"""

from __future__ import annotations

import hashlib
import json
from importlib import resources
from typing import Any

import lark
from lark.grammar import Rule
from lark.lexer import TerminalDef

GRAMMAR = "pomdp.lark"
TABLES = "pomdp.tables.json"
OPTIONS: dict[str, Any] = {
    "parser": "lalr",
    "lexer": "basic",
    "start": ["file", "expression"],
    "propagate_positions": True,
}
_NO_END = 2**32 - 1  # the width of a pattern that may match any length


def load_parser() -> lark.Lark:
    """Return the parser of the package's grammar."""
    folder = resources.files("hypgen.dsl.syntax")
    grammar = folder.joinpath(GRAMMAR).read_text(encoding="utf-8")
    tables = json.loads(folder.joinpath(TABLES).read_text(encoding="utf-8"))
    return unpack(tables) if tables["of"] == origin(grammar) else make_parser(grammar)


def make_parser(grammar: str) -> lark.Lark:
    """Return the parser of a grammar, its tables made anew."""
    return lark.Lark(grammar, **OPTIONS)


def origin(grammar: str) -> str:
    """Return a digest of all that the tables of a grammar depend on."""
    return hashlib.sha256(f"{lark.__version__}\n{OPTIONS}\n{grammar}".encode()).hexdigest()


def pack(parser: lark.Lark, grammar: str) -> dict[str, Any]:
    """Return a parser's tables as data for JSON; ``unpack`` makes the parser of them.

    Lark's own data have an entry for each state and token. Here a state has its shifts, and then each rule
    that it reduces by with the tokens for it. Few sets of tokens occur, so a state has their numbers. Lark's
    order is another one each time, so tokens are sorted, and states stand in the order in which they are met.
    """
    data, memo = parser.memo_serialize([TerminalDef, Rule])
    table = data["parser"]["parser"]
    names = sorted(table["tokens"].values())
    sets: dict[tuple[int, ...], int] = {}
    order = list(dict.fromkeys(table["start_states"].values()))
    met = {state: number for number, state in enumerate(order)}
    states = []
    for state in order:  # which grows by the states that it leads to
        shifts: dict[int, int] = {}
        reductions: dict[int, list[int]] = {}
        row = {
            names.index(table["tokens"][token]): action for token, action in table["states"][state].items()
        }
        for token, (is_reduction, to) in sorted(row.items()):
            if is_reduction:
                reductions.setdefault(to["@"], []).append(token)
            else:
                shifts[token] = met.setdefault(to, len(order))
                order += [to] if len(met) > len(order) else []
        by_rule = [(sets.setdefault(tuple(tokens), len(sets)), rule) for rule, tokens in reductions.items()]
        shifted = sets.setdefault(tuple(shifts), len(sets))
        states.append([shifted, list(shifts.values()), *(n for pair in by_rule for n in pair)])
    for ends in ("start_states", "end_states"):
        table[ends] = {name: met[state] for name, state in sorted(table[ends].items())}
    table.update(tokens=names, states=states, sets=list(sets))
    for terminal in memo.values():
        if "_width" in (pattern := terminal.get("pattern", {})):
            # Versions of Python differ in what stands for a width without an end.
            pattern["_width"] = [min(int(width), _NO_END) for width in pattern["_width"]]
    return {"lark": lark.__version__, "of": origin(grammar), "data": data, "memo": memo}


def unpack(tables: dict[str, Any]) -> lark.Lark:
    """Return the parser of packed tables, which are then no longer packed."""
    table = tables["data"]["parser"]["parser"]
    sets, states = table["sets"], {}
    for state, (shifted, targets, *by_rule) in enumerate(table["states"]):
        row = {token: (0, to) for token, to in zip(sets[shifted], targets, strict=True)}
        for tokens, rule in zip(by_rule[::2], by_rule[1::2], strict=True):
            row.update(dict.fromkeys(sets[tokens], (1, {"@": rule})))
        states[state] = row
    table["states"], table["tokens"] = states, dict(enumerate(table["tokens"]))
    memo = {int(number): content for number, content in tables["memo"].items()}
    return lark.Lark.__new__(lark.Lark)._load({"data": tables["data"], "memo": memo})
