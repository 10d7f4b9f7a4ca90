# SPDX-License-Identifier: Apache-2.0
"""Syntax mistakes of those who know C++ or Python: types before names, methods, `return`, `++`, `80%`."""

from __future__ import annotations

import re

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.syntax.errors.situation import Situation
from hypgen.dsl.types.builtin_names import FOREIGN_FUNCTIONS, QUANTIFIERS

_TYPE_WORDS = ("BOOL", "INT_TYPE", "FLOAT_TYPE", "PROB")
_DECLARES = ("VISIBLE", "HIDDEN", "FIXED", "CONST", "PARAM", "MEMORY", "OBSERVE", "LPAR", "COMMA", "LBRACE")
_BEFORE_VALUES = ("EQUAL", "TILDE", "THEN", "ELSE", "_ARROW", "COLON")
_BEFORE_OPERANDS = ("IF", "AND", "OR", "NOT", "WHEN", "WHERE", "EQUAL", "DOT")
_ENDS_OPERAND = ("NAME", "INT", "FLOAT", "RPAR", "RSQB", "QUOTE", "TRUE", "FALSE")
_FN = "write `fn name(x: type): type = expression`"
_FOREIGN_ITEMS = {
    **dict.fromkeys(("def", "func", "function", "fun"), _FN),
    **dict.fromkeys(("struct", "class"), "write `record Name { x: type }`, or an element for state"),
    **dict.fromkeys(("actions", "action_space"), "write `enum Act { .. }` and `action act: Act`"),
    **dict.fromkeys(
        ("states", "variables"), "write `element name { hidden x: type }`, its `init` and update"
    ),
    **dict.fromkeys(("transition", "transitions", "dynamics"), "write `x' = ..` in the element that owns x"),
    **dict.fromkeys(("start", "initial"), "write `init x = ..` in the element that owns x"),
    **dict.fromkeys(
        ("observation", "observations", "obs", "sensor"), "write `observe name: type ~ distribution`"
    ),
    "gamma": "write `discount 0.95`; gamma is its value in expressions",
    **dict.fromkeys(("var", "state"), "write `element name { visible x: type }`, its `init` and update"),
    "using": 'write `type Name = 0 .. 9`, or `import "file.pomdp"`',
    "from": 'write `import "file.pomdp"`',
    **dict.fromkeys(("done", "goal", "end", "terminated"), "write `terminal when condition`"),
    **dict.fromkeys(("max_steps", "steps", "time_limit", "episode_length"), "write `horizon 100`"),
    **dict.fromkeys(("agent", "object", "entity", "process"), "write `element name { .. }`"),
    "module": "write `element name { .. }`",
    **dict.fromkeys(("formula", "macro"), "write `fn name(): type = expression`"),
    "label": "write `success when condition`, `invariant condition` or `fn name(): bool = condition`",
    "pvariables": "write `element name { hidden x: type }`, its `init` and update",
    "cpfs": "write `x' ~ ..` in the element that owns x",
    **dict.fromkeys(("data", "parameters"), "write `param name: type`"),
}


def _type_before_name(s: Situation) -> Diagnostic | None:
    """Know `visible int x`, `const float x = 1`, `let Cell x`, `fn f(Pos p)`, and the variant `move: Dir`."""
    previous = s.previous()
    if previous is None:
        return None
    if s.token.type == "COLON" and s.open_bracket is not None and previous.type == "NAME":
        at = next(n for n, t in enumerate(s.before) if t is s.open_bracket)
        argument = re.match(r":\s*(\w+)", s.rest)
        if at > 1 and s.before[at - 2].type == "ENUM" and argument is not None:
            message = "what a variant carries stands in parentheses"
            return Diagnostic("E0147", message, s.span(), f"write `{previous}({argument[1]})`")
    if s.token.type in _TYPE_WORDS and previous.type in _DECLARES and "NAME" in s.accepts:
        named = re.match(r"(\w+)[ \t]+([A-Za-z_]\w*)\b", s.rest)
        if named is None or s.expects_expression:
            return None
        type_, name, at_span = named[1], named[2], s.span()
    elif s.token.type == "NAME" and previous.type == "NAME" and not s.on_new_line and "COLON" in s.accepts:
        before = s.previous(2)
        let = s.follows("LET", "NAME")
        declares = before is not None and before.type in _DECLARES and s.accepts <= {"COLON", "COMMA"}
        if not (let or declares):
            return None
        type_, name, at_span = str(previous), str(s.token), s.span(previous).to(s.span())
        if name[0].isupper() > type_[0].isupper():  # `visible at Cell`: types are written large
            message = "between a name and its type stands a colon"
            return Diagnostic("E0147", message, at_span, f"write `{type_}: {name}`")
    else:
        return None
    return Diagnostic("E0147", "a type follows its name", at_span, f"write `{name}: {type_}`")


def _first_value(s: Situation) -> Diagnostic | None:
    """Know `visible x: T = 0`."""
    if s.token.type not in ("EQUAL", "TILDE") or not s.expects_member:
        return None
    at = max((n for n, t in enumerate(s.before) if t.type in ("VISIBLE", "HIDDEN")), default=None)
    if at is None:
        return None
    declared = [str(t) for t in s.before[at:]]
    if "=" in declared or "~" in declared or ":" not in declared:
        return None
    name = declared[declared.index(":") - 1]
    remedy = f"leave it out, and write `init {name} {s.token} ..` below"
    return Diagnostic(
        "E0148", f"the first value of '{name}' is not given where it is declared", s.span(), remedy
    )


def _foreign_item(s: Situation) -> Diagnostic | None:
    """Know `def f(x)` and `struct P`."""
    if not s.expects_item or s.open_bracket is not None or s.token not in _FOREIGN_ITEMS:
        return None
    return Diagnostic("E0149", f"nothing is declared by '{s.token}'", s.span(), _FOREIGN_ITEMS[s.token])


def _return(s: Situation) -> Diagnostic | None:
    word, before = s.previous(), s.previous(2)
    if word != "return" or before is None or before.type not in _BEFORE_VALUES:
        return None
    remedy = "leave it out: what stands behind `=` is the value"
    return Diagnostic("E0149", "there is no 'return'", s.span(word), remedy)


def _method(s: Situation) -> Diagnostic | None:
    name = s.previous()
    if s.token.type != "LPAR" or name is None or not s.follows("DOT", "NAME") or not s.touches_previous:
        return None
    own = FOREIGN_FUNCTIONS.get(name.lower())
    remedy = f"write {own}" if own else f"write `{name}(..)`, with the value as an argument"
    if name in QUANTIFIERS:
        remedy = f"write `{name}(i in Type: ..)`"
    return Diagnostic("E0149", f"values have no methods such as '{name}'", s.span(name), remedy)


def _in_values(s: Situation) -> Diagnostic | None:
    """Know `act in [a, b]`; a name right behind a bracket is that of a binder."""
    value, before = s.previous(), s.previous(2)
    if s.token.type != "IN" or value is None or before is None:
        return None
    if before.type not in _BEFORE_OPERANDS and value.type not in ("RSQB", "QUOTE"):
        return None
    remedy = "compare with each: `x == a or x == b`, or with the ends: `low <= x and x <= high`"
    return Diagnostic("E0149", "there is no 'in' for values", s.span(), remedy)


def _case(s: Situation) -> Diagnostic | None:
    """Know `case act of left -> right` and `case when c then a else b end`."""
    word = s.previous()
    if word != "case" or s.on_new_line or s.token.type not in ("NAME", "WHEN"):
        return None
    remedy = "write `match value { first => a  second => b  else => c }`"
    if s.token.type == "WHEN":
        remedy = "write `if condition then a else b`"
    return Diagnostic("E0149", "there is no 'case'", s.span(word), remedy)


def _quoted(s: Situation) -> Diagnostic | None:
    """Know `'listen'`."""
    text = re.match(r"'(\w+)'", s.rest)
    if s.token.type != "QUOTE" or not s.expects_expression or text is None:
        return None
    at = s.span(length=len(text[0]))
    return Diagnostic("E0149", "a name has no quotes", at, f"write `{text[1]}`")


def _number_as_index_type(s: Situation) -> Diagnostic | None:
    """Know `visible lit: bool[2]`."""
    count = s.previous()
    if s.token.type not in ("RSQB", "COMMA") or count is None or not s.follows("LSQB", "INT"):
        return None
    if "_DOTDOT" not in s.accepts or int(count) < 1:
        return None
    remedy = f"write `[0 .. {int(count) - 1}]`, or the name of a type"
    return Diagnostic("E0149", "an array is indexed by the values of a type", s.span(count), remedy)


def _init_in(s: Situation) -> Diagnostic | None:
    """Know `init x in T`."""
    of = re.match(r"in\s+(\w+)", s.rest)
    if s.token.type != "IN" or not s.follows("INIT", "NAME") or of is None:
        return None
    return Diagnostic(
        "E0149", "an init says a value or a draw", s.span(), f"write `init {s.previous()} ~ uniform({of[1]})`"
    )


def _switch(s: Situation) -> Diagnostic | None:
    words = [t for t in s.before if t.lower() in ("switch", "case") and t.line == s.token.line]
    if s.token.type != "LBRACE" or not s.follows("RPAR") or not words:
        return None
    remedy = "write `match value { first => a  second => b  else => c }`"
    return Diagnostic("E0149", f"there is no '{words[-1]}'", s.span(words[-1]), remedy)


def _condition_behind(s: Situation) -> Diagnostic | None:
    """Know `a if c else b`."""
    value = s.previous()
    if s.token.type != "IF" or s.on_new_line or "WHERE" in s.accepts:
        return None
    if value is None or value.type not in _ENDS_OPERAND or not re.match(r"[^\n]*\belse\b", s.rest):
        return None
    remedy = "write `if condition then a else b`"
    return Diagnostic("E0149", "a condition stands before both values", s.span(), remedy)


def _increment(s: Situation) -> Diagnostic | None:
    if s.token.type != "PLUS" or not s.follows("NAME", "PLUS") or not s.touches_previous:
        return None
    at = s.span(s.previous()).to(s.span())
    return Diagnostic("E0111", "'++' does not define anything", at, f"write `{s.previous(2)} + 1`")


def _range_as_value(s: Situation) -> Diagnostic | None:
    """Know `uniform(1 .. 6)`."""
    low = s.previous()
    if s.token.type != "_DOTDOT" or low is None or s.open_bracket is None:
        return None
    high = re.match(r"\.\.\s*([\w.]+)", s.rest)
    called = next((t for t in s.before if t.end_pos == s.open_bracket.start_pos), None)
    remedy = "write both ends where they are needed, or declare `type Name = low .. high`"
    if called == "uniform" and high is not None and s.previous(2) is s.open_bracket:
        remedy = f"write `uniform({low}, {high[1]})`"
    return Diagnostic("E0150", "'..' makes a type, and a value is asked for here", s.span(), remedy)


def _percentage(s: Situation) -> Diagnostic | None:
    """Know `80%`."""
    sign, number = s.previous(), s.previous(2)
    if sign is None or number is None or sign.type != "PERCENT" or number.type not in ("INT", "FLOAT"):
        return None
    at = s.span(number).to(s.span(sign))
    return Diagnostic("E0122", "'%' is the remainder of a division", at, f"write `{float(number) / 100:g}`")


def _foreign_pattern(s: Situation) -> Diagnostic | None:
    """Know the patterns `move(Dir d) =>` and `Act.wait =>`."""
    variant = re.match(r"\.\s*(\w+)", s.rest)
    if s.follows("NAME") and variant is not None and s.accepts == {"_ARROW", "VBAR", "LPAR"}:
        at = s.span(s.previous()).to(s.span())
        return Diagnostic("E0125", "a pattern is a variant's name alone", at, f"write `{variant[1]}`")
    if s.accepts != {"RPAR"} or s.token.type != "NAME" or not s.follows("NAME", "LPAR", "NAME"):
        return None
    at = s.span(s.previous()).to(s.span())
    remedy = f"write `{s.previous(3)}({s.token}) => expression`"
    return Diagnostic("E0125", "a pattern gives a variant's value a name, without a type", at, remedy)


FOREIGN_MISTAKES = (
    _type_before_name,
    _first_value,
    _foreign_item,
    _return,
    _method,
    _in_values,
    _case,
    _quoted,
    _number_as_index_type,
    _init_in,
    _switch,
    _condition_behind,
    _increment,
    _range_as_value,
    _percentage,
    _foreign_pattern,
)
