# SPDX-License-Identifier: Apache-2.0
"""Signs and statements that this language lacks: `::`, `->`, `<<`, `a[1:3]`, `[go] x=1 -> ..`."""

from __future__ import annotations

import re

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.syntax.errors.situation import CLOSERS, Situation
from hypgen.dsl.types.builtin_names import DRAWS, FOREIGN_FUNCTIONS, QUANTIFIERS

_NAMESPACES = ("std", "np", "numpy", "math", "boost", "torch", "jnp")
_TYPE_WORDS = {
    "FLOAT_TYPE": "leave it out: an int becomes a float where one is needed",
    "PROB": "leave it out: a number from 0 to 1 is a probability",
    "INT_TYPE": "write floor(..), ceil(..) or round(..)",
    "BOOL": "compare, as in x > 0",
}
_QUANTIFIER_WORDS = {"exists": "any", "forall": "all", **{name: name for name in QUANTIFIERS}}
_ENDS_OF_TYPE = re.compile(r"\b(int|real|float|prob|vector|array)\s*<\s*(?:lower|upper)\b")
_COMMAND = re.compile(r"\s*(\[\s*\w*\s*\])[^\n]*->")


def _scope_sign(s: Situation) -> Diagnostic | None:
    """Know `Act::listen`, `std::max(a, b)` and `fn near(a::Pipe)`."""
    first = s.token if s.rest.startswith("::") else s.previous()
    if first is None or first.type != "COLON" or not s.source.text.startswith("::", first.start_pos or 0):
        return None
    if first is not s.token and s.token.type != "COLON":
        return None
    at = next((n for n, t in enumerate(s.before) if t is first), len(s.before))
    left = s.before[at - 1] if at else None
    right = re.match(r"::\s*(\w+)", s.source.text[first.start_pos or 0 :])
    if left is None or left.type != "NAME" or right is None:
        return None
    if left in _NAMESPACES:
        written = right[1]
    elif {"BOOL", "PROB"} <= s.accepts or first is s.token and s.accepts <= {"COLON", "COMMA"}:
        written = f"{left}: {right[1]}"
    else:
        written = f"{left}.{right[1]}"
    return Diagnostic("E0106", "'::' is not an operator", s.span(first, length=2), f"write `{written}`")


def _pointer_sign(s: Situation) -> Diagnostic | None:
    """Know `robot->at`."""
    if s.token.type != "GT" or not s.follows("MINUS") or not s.touches_previous:
        return None
    owner, field = s.previous(2), re.match(r">\s*([A-Za-z_]\w*)", s.rest)
    if owner is None or owner.type not in ("NAME", "RSQB") or field is None:
        return None
    before = f"{owner}" if owner.type == "NAME" else ".."
    at = s.span(s.previous()).to(s.span())
    return Diagnostic("E0106", "'->' is not an operator", at, f"write `{before}.{field[1]}`")


def _shift(s: Situation) -> Diagnostic | None:
    """Know `x << 2` and `x >> 2`."""
    if s.token.type not in ("LT", "GT") or not s.follows(s.token.type) or not s.touches_previous:
        return None
    remedy = "write `x * 2 ** n`" if s.token.type == "LT" else "write `x // 2 ** n`"
    at = s.span(s.previous()).to(s.span())
    return Diagnostic("E0106", f"'{s.token * 2}' is not an operator", at, remedy)


def _not_sign(s: Situation) -> Diagnostic | None:
    """Know `a and ~b`."""
    if s.token.type != "TILDE" or not s.expects_expression:
        return None
    return Diagnostic("E0106", "'~' draws", s.span(), "write `not` for the opposite of a condition")


def _slice(s: Situation) -> Diagnostic | None:
    """Know `price[1:3]` and `price[:3]`."""
    opened = s.open_bracket
    if s.token.type != "COLON" or opened is None or opened.type != "LSQB":
        return None
    at = next(n for n, t in enumerate(s.before) if t is opened)
    array = s.before[at - 1] if at else None
    inside = s.before[at + 1 :]
    if array is None or array.type != "NAME" or array.end_pos != opened.start_pos:
        return None
    if any(t.type in ("IN", "COMMA") for t in inside) or "ELEMENT" in (t.type for t in s.before[at - 2 : at]):
        return None
    remedy = f"write one index; several entries are an array, `[i in Type: {array}[..]]`"
    return Diagnostic("E0149", "an index is one value, and no slice", s.span(), remedy)


def _type_as_value(s: Situation) -> Diagnostic | None:
    """Know `float(x)`, `int(x)` and `static_cast<bool>(x)`."""
    if s.token.type not in _TYPE_WORDS or not s.expects_expression or s.expects_item or s.expects_member:
        return None
    if re.match(r"\w+[ \t]+[A-Za-z_]", s.rest):
        return None  # a declaration of another language
    message = f"'{s.token}' is a type, and a value is asked for here"
    return Diagnostic("E0149", message, s.span(), _TYPE_WORDS[s.token.type])


def _quantifier_word(s: Situation) -> Diagnostic | None:
    """Know `exists p in Pipe: c`, `forall_{?p : Pipe} c` and `sum i in T: e`."""
    word = s.previous()
    if word is None or word.type != "NAME" or s.expects_item and s.on_new_line:
        return None
    kind = _QUANTIFIER_WORDS.get(word.rstrip("_"))
    bound = re.match(r"\{?\s*\??(\w+)\s*(?::|\bin\b)\s*(\w+)", s.rest)
    if kind is None or bound is None or s.token.type not in ("NAME", "LBRACE"):
        return None
    remedy = f"write `{kind}({bound[1]} in {bound[2]}: ..)`"
    return Diagnostic("E0145", f"what '{kind}' runs over stands in parentheses", s.span(word), remedy)


def _weights_in_call(s: Situation) -> Diagnostic | None:
    """Know `Discrete(Pipe, 0: 0.5, 1: 0.5)`."""
    opened = s.open_bracket
    if s.token.type != "COLON" or opened is None or opened.type != "LPAR":
        return None
    called = next((t for t in s.before if t.end_pos == opened.start_pos), None)
    if called is None or (called.lower() not in FOREIGN_FUNCTIONS and called.lower() not in DRAWS):
        return None
    message = "probabilities of values stand in a table"
    return Diagnostic("E0149", message, s.span(called), "write `{ a: 0.6, b: 0.3, else c }`")


def _ends_of_type(s: Situation) -> Diagnostic | None:
    """Know `real<lower=0, upper=1> p` and `int<lower=0> n`."""
    start = s.source.text.rfind("\n", 0, s.token.start_pos or 0) + 1
    found = _ENDS_OF_TYPE.search(s.source.text.split("\n")[(s.token.line or 1) - 1])
    if found is None or (s.token.start_pos or 0) < start + found.start():
        return None
    remedy = "write `name: 0 .. 9` for ints; `prob` is a float from 0 to 1, and other floats have no ends"
    return Diagnostic("E0149", "a type has no 'lower' and 'upper'", s.span(), remedy)


def _unit_of_type(s: Situation) -> Diagnostic | None:
    """Know `float(m)`, `int<m>`, `float<m per s>` and `float<m*s^-2>`."""
    before = s.previous()
    if s.token.type == "LPAR" and s.follows("FLOAT_TYPE") and (unit := re.match(r"\(([^)\n]+)\)", s.rest)):
        return Diagnostic("E0149", "a unit stands in '<' and '>'", s.span(), f"write `float<{unit[1]}>`")
    unit = re.match(r"<([^>\n]+)>", s.rest)
    if unit is not None and before is not None and before.type in ("INT_TYPE", "PROB", "BOOL"):
        message = f"only a float has a unit, and no {before}"
        return Diagnostic("E0149", message, s.span(), f"write `float<{unit[1]}>`")
    if s.token == "per" and before is not None and "SLASH" in s.accepts:
        return Diagnostic("E0149", "a unit is divided by '/'", s.span(), f"write `{before}/..`")
    power = re.match(r"-\s*(\d+)", s.rest)
    if power is not None and s.follows("CARET") and s.accepts == {"INT"}:
        whole = "" if power[1] == "1" else f"^{power[1]}"
        remedy = f"write `/{s.previous(2)}{whole}`, as in `float<1/s>`"
        return Diagnostic("E0149", "a unit has no negative power", s.span(), remedy)
    return None


def _text_as_comment(s: Situation) -> Diagnostic | None:
    """Know a docstring."""
    if s.token.type != "STRING" or not s.on_new_line or not (s.expects_item or s.expects_member):
        return None
    return Diagnostic("E0121", "a text does not start a comment", s.span(), "comments start with `#`")


def _number_of_member(s: Situation) -> Diagnostic | None:
    """Know `rock.0.good`."""
    if s.token.type not in ("INT", "FLOAT") or not s.follows("NAME", "DOT"):
        return None
    number = str(s.token).split(".")[0]
    message = "a member of a family, or an entry of an array, stands in brackets"
    return Diagnostic("E0149", message, s.span(), f"write `{s.previous(2)}[{number}]`")


def _bracketed_range(s: Situation) -> Diagnostic | None:
    """Know `visible at: [0 .. 5]` and `type Door = {left, right}`."""
    if not {"BOOL", "PROB"} <= s.accepts or s.token.type not in CLOSERS:
        return None
    ends = re.match(r"[\[({]\s*(-?\w+)\s*(?:\.\.+|:|,)\s*(-?\w+)\s*[\])}]", s.rest)
    if s.token.type == "LBRACE":
        values = re.match(r"\{([\w\s,]*)\}", s.rest)
        named = values is not None and re.match(r"\s*[A-Za-z_]", values[1])
        if values is not None and named:
            remedy = f"declare `enum Name {{ {values[1].strip()} }}`, and write `Name` here"
            return Diagnostic("E0149", "values with names make an enum", s.span(), remedy)
    if ends is None:
        return None
    message = "a range stands without brackets"
    return Diagnostic("E0149", message, s.span(), f"write `{ends[1]} .. {ends[2]}`")


def _type_before_declaration(s: Situation) -> Diagnostic | None:
    """Know `int n = 6` where a declaration should start."""
    if s.token.type not in _TYPE_WORDS or not (s.expects_item or s.expects_member) or not s.on_new_line:
        return None
    named = re.match(r"(\w+)[^\n=;A-Za-z]*([A-Za-z_]\w*)?", s.rest)
    name = named[2] if named is not None and named[2] else "name"
    kinds = f"`const {name}: {s.token} = ..`, `param {name}: {s.token}`"
    if s.expects_member and not s.expects_item:
        kinds = f"`visible {name}: {s.token}`, `hidden {name}: {s.token}`, `let {name}: {s.token} = ..`"
    return Diagnostic("E0149", "a declaration starts with its keyword", s.span(), f"write {kinds}")


def _statement(s: Situation) -> Diagnostic | None:
    """Know `if act == go { x' = 1 } else { x' = 2 }` in place of an update."""
    if s.token.type not in ("IF", "MATCH") or not s.on_new_line or s.open_bracket is None:
        return None
    if not s.expects_member or s.expects_expression:
        return None
    form = "if condition then a else b" if s.token.type == "IF" else "match value { first => a  else => b }"
    message = f"'{s.token}' is a value, and no statement: each variable has one update"
    return Diagnostic("E0149", message, s.span(), f"write `x' = {form}`")


def _command(s: Situation) -> Diagnostic | None:
    """Know PRISM's `[go] x=0 -> 0.5:(x'=1) + 0.5:(x'=0);`, and `(x' = 1) & (y' = 2)`."""
    lines = s.source.text.split("\n")
    command = _COMMAND.match(lines[(s.token.line or 1) - 1])
    if command is not None and any(t.type == "ELEMENT" for t in s.before):
        remedy = "write one update for each variable: x' ~ if guard then { a: 0.5, else b } else x"
        return Diagnostic("E0149", "there are no commands with a guard", s.span(), remedy)
    opened = s.open_bracket
    if s.token.type != "EQUAL" or not s.follows("LPAR", "NAME", "QUOTE") or opened is None:
        return None
    message = "an update stands alone, without parentheses"
    return Diagnostic("E0149", message, s.span(), f"write `{s.previous(2)}' = ..` for each variable")


def _setting_of_model(s: Situation) -> Diagnostic | None:
    """Know `discount(m) = 0.95`."""
    if s.token.type != "EQUAL" or not s.follows("LPAR", "NAME", "RPAR"):
        return None
    setting = s.previous(4)
    if setting is None or setting.type not in ("DISCOUNT", "HORIZON"):
        return None
    example = "0.95" if setting.type == "DISCOUNT" else "100"
    return Diagnostic(
        "E0149", f"'{setting}' is a number, and no function", s.span(), f"write `{setting} {example}`"
    )


SIGN_MISTAKES = (
    _command,
    _scope_sign,
    _pointer_sign,
    _shift,
    _not_sign,
    _slice,
    _ends_of_type,
    _unit_of_type,
    _text_as_comment,
    _number_of_member,
    _type_as_value,
    _quantifier_word,
    _weights_in_call,
    _bracketed_range,
    _type_before_declaration,
    _statement,
    _setting_of_model,
)
