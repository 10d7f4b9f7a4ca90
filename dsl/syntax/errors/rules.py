# SPDX-License-Identifier: Apache-2.0
"""Common syntax mistakes, each recognised by one rule and answered with its own remedy.

The rules are asked in the order of ``MISTAKES``; the first that knows the mistake answers.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable

from lark import Token

from hypgen.dsl.messages.diagnostic import Diagnostic
from hypgen.dsl.messages.source import Span
from hypgen.dsl.syntax.errors.brackets import BRACKET_MISTAKES
from hypgen.dsl.syntax.errors.comments import foreign_comment
from hypgen.dsl.syntax.errors.families import family_index
from hypgen.dsl.syntax.errors.foreign_signs import SIGN_MISTAKES
from hypgen.dsl.syntax.errors.other_languages import FOREIGN_MISTAKES
from hypgen.dsl.syntax.errors.situation import CLOSERS, END, SIGNS, UNKNOWN, Situation, shown
from hypgen.dsl.syntax.errors.small_forms import SMALL_FORM_MISTAKES, braces_behind_value, record_behind_bar
from hypgen.dsl.syntax.errors.targets import TARGET_MISTAKES
from hypgen.dsl.syntax.errors.variants import variant_value

_COMPARISONS = ("EQ", "NE", "LE", "GE", "LT", "GT")
_OPERATORS = (
    *_COMPARISONS,
    "PLUS",
    "MINUS",
    "STAR",
    "SLASH",
    "FLOORDIV",
    "PERCENT",
    "POWER",
    "AND",
    "OR",
    "NOT",
)
_ELEMENT_ONLY = ("VISIBLE", "HIDDEN", "INIT", "LET")
_MODEL_ONLY = (
    "CONST", "PARAM", "TYPE", "ENUM", "RECORD", "FN", "ACTION", "ELEMENT", "DISCOUNT", "HORIZON", "TERMINAL",
    "LEGAL", "SUCCESS", "POLICY", "BOUND", "DRAW", "MODEL", "IMPORT",
)  # fmt: skip
_ANY_ITEM = (*_MODEL_ONLY, *_ELEMENT_ONLY, "REWARD", "OBSERVE", "INVARIANT")
_ELEMENT_ITEM = (*_ELEMENT_ONLY, "REWARD", "OBSERVE", "INVARIANT")
_IF_NEEDS = {"IF": "THEN", "THEN": "ELSE"}
_SIGNS = {"&": "and", "|": "or", "!": "not", "^": "**"}
_OPERATOR_WORDS = {
    "xor": "write `(a) != (b)`",
    "implies": "write `not a or b`",
    "mod": "write `%`",
    "div": "write `//`",
}
_ASSIGNMENTS = (":=", "<-", "+=", "-=", "*=", "/=")
_LOOKALIKES = {
    "≤": "<=", "≥": ">=", "≠": "!=", "∧": "and", "∨": "or", "¬": "not", "×": "*", "−": "-", "–": "-",
    "∈": "in", "÷": "//", "’": "'", "′": "'", "“": '"', "”": '"', "→": "=>", "γ": "gamma", "π": "pi",
}  # fmt: skip


def _foreign_operator(s: Situation) -> Diagnostic | None:
    sign = s.rest[:1]
    if sign not in _SIGNS or s.rest.startswith("!=") or "_ARROW" in s.accepts:
        return None
    written = sign * 2 if s.rest.startswith(sign * 2) and sign in "&|" else sign
    remedy = f"write `{_SIGNS[sign]}` in its place"
    if sign == "^":
        remedy = "write `**` for a power, and `and` to join conditions"
    return Diagnostic("E0106", f"'{written}' is not an operator here", s.span(length=len(written)), remedy)


def _word_operator(s: Situation) -> Diagnostic | None:
    if s.token.type != "NAME" or s.token not in _OPERATOR_WORDS or "NAME" in s.accepts:
        return None
    return Diagnostic("E0106", f"'{s.token}' is not an operator", s.span(), _OPERATOR_WORDS[s.token])


def _semicolon(s: Situation) -> Diagnostic | None:
    if s.rest[:1] != ";":
        return None
    return Diagnostic(
        "E0107", "nothing is ended by ';'", s.span(), "leave it out: a new line or a space is enough"
    )


def _assignment_sign(s: Situation) -> Diagnostic | None:
    previous = s.previous()
    sign = next((a for a in _ASSIGNMENTS if s.rest.startswith(a)), None)
    at = s.span(length=2)
    if (
        sign is None
        and s.rest[:1] == "="
        and previous is not None
        and s.touches_previous
        and previous.type == "COLON"
    ):
        sign, at = ":=", s.span(previous).to(s.span())
    if sign is None:
        return None
    remedy = "write `=` for an exact value or `~` for a draw"
    if sign[0] in "+-*/":
        remedy = f"write the old value out, as in `x' = x {sign[0]} 1`"
    return Diagnostic("E0111", f"'{sign}' does not define anything", at, remedy)


def _elif(s: Situation) -> Diagnostic | None:
    if s.token.type != "NAME" or s.token not in ("elif", "elsif", "elseif"):
        return None
    return Diagnostic("E0112", f"there is no '{s.token}'", s.span(), "write `else if condition then ...`")


def _loop(s: Situation) -> Diagnostic | None:
    words = [t for t in (s.previous(2), s.previous(), s.token) if t in ("for", "while")]
    if not words or (s.token.type != "NAME" and words[-1] is not s.previous(2)):
        return None
    word = words[-1]
    remedy = "write `sum(i in Type: e)` for one number, or `[i in Type: e]` for an array"
    return Diagnostic("E0142", f"there is no '{word}': nothing is done in a loop", s.span(word), remedy)


def _unterminated_text(s: Situation) -> Diagnostic | None:
    if s.token.type != UNKNOWN or s.token != '"':
        return None
    length = len(s.rest.split("\n")[0])
    return Diagnostic(
        "E0120", "this text has no end", s.span(length=length), 'close it with `"` on the same line'
    )


def _conditional_sign(s: Situation) -> Diagnostic | None:
    if s.token.type != UNKNOWN or s.token != "?":
        return None
    name = re.match(r"\?(\w+)", s.rest)
    if name is not None and (s.expects_expression or s.accepts == {"NAME"} or s.follows("LBRACE")):
        return Diagnostic("E0119", "a name has no '?' before it", s.span(), f"write `{name[1]}`")
    return Diagnostic("E0119", "there is no '?' operator", s.span(), "write `if condition then a else b`")


def _unknown_character(s: Situation) -> Diagnostic | None:
    if s.token.type != UNKNOWN:
        return None
    name = str(s.token) if s.token.isprintable() else f"U+{ord(s.token):04X}"
    remedy = "names are made of the letters a-z and A-Z, digits and `_`"
    if s.token in _LOOKALIKES:
        remedy = f"write `{_LOOKALIKES[s.token]}`"
    return Diagnostic("E0102", f"the character '{name}' has no meaning in a model", s.span(), remedy)


def _number_form(s: Situation) -> Diagnostic | None:
    last, before_last = s.previous(), s.previous(2)
    if s.token.type == "DOT" and re.match(r"\.\d", s.rest) and s.expects_expression:
        digits = re.match(r"\.\d+", s.rest)
        length = len(digits.group()) if digits else 1
        return Diagnostic(
            "E0122", "a number starts with a digit", s.span(length=length), f"write `0{s.rest[:length]}`"
        )
    if s.follows("INT", "DOT") and last is not None and before_last is not None:
        at = s.span(before_last).to(s.span(last))
        return Diagnostic("E0122", "a number ends with a digit", at, f"write `{before_last}.0`")
    if s.follows("FLOAT", "DOT") and s.touches_previous and last is not None and before_last is not None:
        at = s.span(before_last).to(s.span())
        return Diagnostic("E0122", "a number has one point", at, f"write `{before_last}`, or other digits")
    if s.token.type == "NAME" and s.touches_previous and last is not None and last.type in ("INT", "FLOAT"):
        at = s.span(last).to(s.span())
        remedy = "write digits only for a number (no `_`, `0x` or suffix), and `*` for a product"
        return Diagnostic("E0122", f"'{last}{s.token}' is neither a number nor a name", at, remedy)
    return None


def _unit_of_number(s: Situation) -> Diagnostic | None:
    """Know `= 2 m`, also where the `m` was taken for the next name that is defined."""
    taken = s.accepts in ({"QUOTE"}, {"EQUAL"}) and s.token.type not in ("COLON", "EQUAL", "TILDE")
    words = s.before if taken else (*s.before, s.token)
    if len(words) < 4 or "EQUAL" not in (words[-4].type, words[-3].type):
        return None
    number, unit = words[-2:]
    if number.type not in ("INT", "FLOAT") or unit.type != "NAME" or number.line != unit.line:
        return None
    remedy = "leave it out, as in `const d: float<m> = 2`; a product is written with `*`"
    message = f"a unit stands in the type, not after the number {number}"
    return Diagnostic("E0122", message, s.span(unit), remedy)


def _reserved_word(s: Situation) -> Diagnostic | None:
    word = s.previous()
    if s.token.type == "QUOTE" and s.accepts == {"NAME"} and word is not None:
        return _reserved(word, s.span(word))
    if s.token.type == "NAME" or not s.token.isidentifier() or "NAME" not in s.accepts:
        return None
    previous = s.previous()
    if re.match(r"\w+\s*'\s*[=~]", s.rest) and s.expects_member:
        meant = True
    elif s.expects_expression:
        in_expressions = ("THEN", "ELSE", "WHERE", "IN", "AND", "OR", "IF", "LET", "MATCH", "NOT")
        meant = s.token.type not in in_expressions and not s.on_new_line
    elif s.expects_member or s.expects_item:
        meant = False
    else:
        meant = not s.on_new_line or (previous is not None and previous.type in ("COMMA", "LBRACE"))
    if not meant:
        return None
    return _reserved(s.token, s.span())


def _misspelt_keyword(s: Situation) -> Diagnostic | None:
    word = s.previous() if s.accepts == {"QUOTE"} else s.token
    expected = _ELEMENT_ITEM if s.accepts == {"QUOTE"} or s.expects_member else _ANY_ITEM
    if word is None or word.type != "NAME" or s.token.type not in ("NAME", "STRING"):
        return None
    if word is s.token and not (s.on_new_line and (s.expects_item or s.expects_member)):
        return None
    close = difflib.get_close_matches(word, [w.lower() for w in expected], n=1, cutoff=0.7)
    if not close or not re.match(r"\s*[\w\"]", s.source.text[word.end_pos or 0 :]):
        return None
    return Diagnostic(
        "E0141", f"nothing is declared by the word '{word}'", s.span(word), f"did you mean `{close[0]}`?"
    )


def _reserved(word: Token, span: Span) -> Diagnostic:
    remedy = f"choose another name, such as `{word}_`"
    return Diagnostic("E0113", f"'{word}' is a word of the language and cannot be a name", span, remedy)


def _missing_when(s: Situation) -> Diagnostic | None:
    kind = s.previous()
    if "WHEN" not in s.accepts or kind is None:
        return None
    message = f"'{kind}' is followed by 'when'; found {shown(s.token)}"
    return Diagnostic("E0114", message, s.span(), f"write `{kind} when condition`")


def _table_without_weights(s: Situation) -> Diagnostic | None:
    opened = s.open_bracket
    if "COLON" not in s.accepts or s.token.type not in ("COMMA", "RBRACE") or opened is None:
        return None
    at = next(i for i, t in enumerate(s.before) if t is opened)
    if opened.type != "LBRACE" or s.before[at - 1].type in ("NAME", "RSQB"):
        return None
    if at > 1 and s.before[at - 2] == "uniform":
        message = "'uniform' draws from a type, not from a list of values"
        remedy = "write `uniform(i in Type where condition of i)`, or the table `{ a: 0.5, else b }`"
        return Diagnostic("E0144", message, s.span(opened), remedy)
    first = "".join(s.before[at + 1 :])
    message = f"a table gives each value its probability; found {shown(s.token)}"
    return Diagnostic(
        "E0144", message, s.span(), f"write `{{ {first}: 0.5, .. }}`, or the value without braces"
    )


def _missing_type(s: Situation) -> Diagnostic | None:
    name = s.previous()
    if "COLON" not in s.accepts or not s.accepts <= {"COLON", "COMMA"} or name is None:
        return None
    what = "the function's result" if name.type == "RPAR" else f"'{name}'"
    written = ")" if name.type == "RPAR" else name
    value = re.match(r"=\s*-?\d+(\.\d)?", s.rest)
    example = "bool" if value is None else "float" if value[1] else "int"
    message = f"{what} needs a type; found {shown(s.token)}"
    return Diagnostic("E0115", message, s.span(), f"write `{written}: type`, such as `{written}: {example}`")


def _single_equals(s: Situation) -> Diagnostic | None:
    if s.token.type == "EQUAL" and "EQ" in s.accepts:
        return Diagnostic("E0103", "'=' defines; it does not compare", s.span(), "write `==` to compare")
    if s.token.type == "EQ" and "EQUAL" in s.accepts:
        return Diagnostic("E0134", "'==' compares; it does not define", s.span(), "write one `=`")
    return None


def _draw_where_exact(s: Situation) -> Diagnostic | None:
    if s.token.type != "TILDE" or "EQUAL" not in s.accepts or "TILDE" in s.accepts:
        return None
    remedy = "write `=`; name a draw in an element with `let x ~ ...`, and use x here"
    return Diagnostic("E0116", "this cannot be drawn: it has one exact value", s.span(), remedy)


def _chained_comparison(s: Situation) -> Diagnostic | None:
    if s.token.type not in _COMPARISONS or "PLUS" not in s.accepts:
        return None
    remedy = "compare twice and join with `and`, as in `a < b and b < c`"
    return Diagnostic("E0117", "comparisons cannot be chained", s.span(), remedy)


def _bare_operand(s: Situation) -> Diagnostic | None:
    previous = s.previous()
    if s.token.type not in ("IF", "LET", "MATCH") or not s.expects_expression or previous is None:
        return None
    if previous.type not in _OPERATORS:
        return None
    message = f"'{s.token}' after the operator '{previous}' needs parentheses"
    return Diagnostic("E0118", message, s.span(), f"write `{previous} ({s.token} ...)`")


def _closing_bracket(s: Situation) -> Diagnostic | None:
    if s.token.type not in CLOSERS.values():
        return None
    opened = s.open_bracket
    if opened is None:
        return Diagnostic("E0110", f"'{s.token}' closes nothing", s.span(), "leave it out, or open it before")
    return _unclosed(s, opened) if CLOSERS[opened.type] != s.token.type else None


def _unfinished_if(s: Situation) -> Diagnostic | None:
    opened = s.open[-1] if s.open else None
    if opened is None or opened.type not in _IF_NEEDS or _IF_NEEDS[opened.type] not in s.accepts:
        return None
    at, note = s.span(), (s.span(opened), f"this '{opened}'")
    if s.on_new_line:
        at, note = s.span(opened), (s.span(), "something else starts here")
    if opened.type == "IF":
        message = f"this 'if' has no 'then'; found {shown(s.token)}"
        return Diagnostic("E0105", message, at, "write `if condition then a else b`", (note,))
    message = f"this 'if' has no 'else'; found {shown(s.token)}"
    remedy = "write `if condition then a else b`: an expression needs a value in both cases"
    return Diagnostic("E0104", message, at, remedy, (note,))


def _outside_element(s: Situation) -> Diagnostic | None:
    if not s.expects_item or s.open_bracket is not None:
        return None
    updates = s.token.type == "NAME" and re.match(r"\w+\s*'", s.rest)
    if not updates and s.token.type not in _ELEMENT_ONLY:
        return None
    what = f"the update of '{s.token}'" if updates else f"'{s.token}'"
    remedy = "put it inside the braces of the element that owns the variable"
    if s.token.type == "LET":
        remedy = "put it inside the braces of an element, or write `fn name(): type = expression`"
    return Diagnostic("E0108", f"{what} stands outside an element", s.span(), remedy)


def _missing_keyword(s: Situation) -> Diagnostic | None:
    name = s.previous()
    if s.accepts == {"QUOTE"} and name is not None:
        owner = next((t.type for t in reversed(s.before) if t.type in ("POLICY", "ELEMENT")), "")
        is_action = re.search(rf"\baction\s+{name}\b", s.source.text) is not None
        if owner == "POLICY" and (name in ("return", "action") or is_action):
            remedy = "write `choose = action`"
            return Diagnostic("E0123", "what a policy does is said by 'choose'", s.span(name), remedy)
        if owner == "POLICY" and s.token.type in ("EQUAL", "TILDE"):
            remedy = f"write `{name}' =` for what memory holds next, or `let {name} =` for a temporary"
            return Diagnostic(
                "E0123", f"it is not said what of '{name}' is defined here", s.span(name), remedy
            )
        if s.token.type in ("EQUAL", "TILDE"):
            remedy = f"write `{name}' {s.token}` for the value after a step, "
            remedy += f"`init {name} {s.token}` for the first one, or `let {name} {s.token}` for a temporary"
            return Diagnostic(
                "E0123", f"it is not said what of '{name}' is defined here", s.span(name), remedy
            )
        if s.token.type in ("COLON", "COMMA"):
            remedy = f"write `hidden {name}: type`, or `visible` if the agent always knows it"
            return Diagnostic(
                "E0123", f"the variable '{name}' is neither visible nor hidden", s.span(name), remedy
            )
    if (
        s.expects_item
        and s.open_bracket is None
        and s.token.type == "NAME"
        and re.match(r"\w+\s*[:=~(]", s.rest)
    ):
        remedy = "start it with `const`, `param`, `type`, `fn`, `element`, `reward`, `observe` or the like"
        return Diagnostic("E0123", f"it is not said what kind of thing '{s.token}' is", s.span(), remedy)
    return None


def _unknown_declaration(s: Situation) -> Diagnostic | None:
    """Know a word at the start of a line that declares nothing, as in `agent robot {`."""
    starts = s.expects_item and s.on_new_line and s.open_bracket is None and s.token.column == 1
    if not starts or s.token.type != "NAME" or re.match(r"\w+\s*'", s.rest):
        return None
    remedy = (
        "start it with `element`, `const`, `param`, `type`, `fn`, `reward`, `observe`, `policy` or the like"
    )
    return Diagnostic("E0141", f"nothing is declared by the word '{s.token}'", s.span(), remedy)


def _unclosed_bracket(s: Situation) -> Diagnostic | None:
    opened = s.open_bracket
    if opened is None:
        return None
    next_item = s.token.type in _ANY_ITEM and (opened.type != "LBRACE" or s.token.type not in s.accepts)
    next_update = s.token.type == "NAME" and s.on_new_line and re.match(r"\w+\s*'\s*[=~]", s.rest)
    return _unclosed(s, opened) if next_item or next_update or s.token.type == END else None


def _unclosed(s: Situation, opened: Token) -> Diagnostic:
    closer = SIGNS[CLOSERS[opened.type]]
    message = f"'{opened}' of line {opened.line} is not closed before {shown(s.token)}"
    remedy = f"write the missing `{closer}`"
    if s.expects_member and s.token.type in _MODEL_ONLY:
        remedy += f", or move `{s.token}` out of the element"
    if s.on_new_line:
        note = (s.span(), "something else starts here")
        return Diagnostic("E0109", message, s.span(opened), remedy, (note,))
    return Diagnostic("E0109", message, s.span(), remedy, ((s.span(opened), "opened here"),))


def _missing_comma(s: Situation) -> Diagnostic | None:
    starts = s.token.type in ("NAME", "INT", "FLOAT", "STRING", "TRUE", "FALSE", "NOT")
    if not starts or "COMMA" not in s.accepts or s.open_bracket is None:
        return None
    return Diagnostic(
        "E0124", f"a ',' is missing before {shown(s.token)}", s.span(), "separate the entries with `,`"
    )


def _arm_sign(s: Situation) -> Diagnostic | None:
    if s.token.type == "COMMA" and {"_ARROW", "VBAR"} <= s.accepts:
        remedy = "write `first | second => expression`"
        return Diagnostic("E0125", "patterns of one arm are joined by '|', not by ','", s.span(), remedy)
    if "_ARROW" not in s.accepts or s.token.type not in ("COLON", "MINUS", "EQUAL", "THEN"):
        return None
    length = 2 if s.rest.startswith("->") else len(s.token)
    message = f"a pattern is followed by '=>', not by '{s.rest[:length]}'"
    return Diagnostic("E0125", message, s.span(length=length), "write `pattern => expression`")


def _result_arrow(s: Situation) -> Diagnostic | None:
    if not s.rest.startswith("->") or s.accepts != {"COLON"}:
        return None
    return Diagnostic(
        "E0129", "a result's type follows ':', not '->'", s.span(length=2), "write `fn f(x: T): U = ...`"
    )


def _negative_arm(s: Situation) -> Diagnostic | None:
    if s.token.type != "_ARROW" or not s.follows("MINUS", "INT"):
        return None
    first, last = s.previous(2), s.previous()
    at: Span = s.span(first).to(s.span(last))
    message = "a negative pattern right after an arm reads as a subtraction"
    return Diagnostic("E0132", message, at, "write a `,` at the end of the arm before it")


def _file_start(s: Situation) -> Diagnostic | None:
    if s.before or s.accepts != {"MODEL", "INSTANCE", "LIBRARY"}:
        return None
    if s.token.type == END:
        return Diagnostic("E0100", "the file declares nothing", s.span(), "start it with `model Name`")
    return Diagnostic(
        "E0126", f"a model starts with its name; found {shown(s.token)}", s.span(), "write `model Name`"
    )


Mistake = Callable[[Situation], Diagnostic | None]
MISTAKES: tuple[Mistake, ...] = (
    foreign_comment,
    _file_start,
    family_index,
    variant_value,
    record_behind_bar,
    *SIGN_MISTAKES,
    _foreign_operator,
    _word_operator,
    _semicolon,
    _assignment_sign,
    _elif,
    _loop,
    _unterminated_text,
    _conditional_sign,
    _unknown_character,
    _number_form,
    _unit_of_number,
    *SMALL_FORM_MISTAKES,
    *FOREIGN_MISTAKES,
    *BRACKET_MISTAKES,
    braces_behind_value,
    _misspelt_keyword,
    _reserved_word,
    _missing_when,
    _result_arrow,
    _table_without_weights,
    _missing_type,
    _single_equals,
    _draw_where_exact,
    _chained_comparison,
    _bare_operand,
    _closing_bracket,
    _arm_sign,
    _negative_arm,
    _unfinished_if,
    _outside_element,
    _missing_keyword,
    _unknown_declaration,
    *TARGET_MISTAKES,
    _unclosed_bracket,
    _missing_comma,
)
