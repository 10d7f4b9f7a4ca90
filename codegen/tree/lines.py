# SPDX-License-Identifier: Apache-2.0
"""The tree of C++ as lines of text: parentheses, indentation, and where long lines break."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from hypgen.codegen.layout.limits import LINE_LENGTH
from hypgen.codegen.tree.expr import (
    ADD,
    AND,
    COMPARE,
    EQUAL,
    MULTIPLY,
    OR,
    PRIMARY,
    UNARY,
    Braces,
    Call,
    Choice,
    Expr,
    Index,
    Literal,
    Member,
    Name,
    Operation,
    Postfix,
    Prefix,
    starts_with,
)
from hypgen.codegen.tree.statements import (
    Assign,
    Block,
    Comment,
    Declare,
    Do,
    For,
    ForEach,
    Function,
    If,
    Jump,
    Lambda,
    Return,
    Statement,
    Text,
    While,
    names_in,
)

# Parentheses that C++ does not need, but its compilers ask for: && in ||, ! and == in ==.
_INNER = {OR: EQUAL - 1, EQUAL: ADD - 1, EQUAL - 1: ADD - 1, COMPARE: ADD - 1, ADD - 1: ADD}


class Line:
    """A line of text under construction, in pieces between which it may break."""

    def __init__(self) -> None:
        self.pieces: list[str] = [""]

    def add(self, text: str) -> None:
        """Append text."""
        self.pieces[-1] += text

    def split(self) -> None:
        """Let the line break here if it is too long."""
        self.pieces.append("")

    def list(self, before: str, entries: Sequence[Expr], after: str) -> None:
        """Append expressions between commas."""
        self.add(before)
        for n, entry in enumerate(entries):
            if n:
                self.add(", ")
                self.split()
            self.expr(entry)
        self.add(after)

    def expr(self, expr: Expr, level: int = 0) -> None:
        """Append an expression, in parentheses if it binds less tightly than ``level``."""
        if expr.level < level:
            self.add("(")
            self._expr(expr)
            self.add(")")
        else:
            self._expr(expr)

    def _expr(self, expr: Expr) -> None:
        match expr:
            case Name(text, given):
                self.add(f"{text}<{', '.join(given)}>" if given else text)
            case Literal(text):
                self.add(text)
            case Call(function, arguments):
                self.expr(function, PRIMARY)
                self.list("(", arguments, ")")
            case Member(owner, member):
                self.expr(owner, PRIMARY)
                self.add(f".{member}")
            case Index(array, index):
                self.expr(array, PRIMARY)
                self.add("[")
                self.expr(index)
                self.add("]")
            case Operation():
                self._operation(expr)
            case Prefix(sign, operand):
                self.add(sign)
                self.expr(operand, PRIMARY if sign == "-" and starts_with(operand, "-") else UNARY)
            case Postfix(operand, sign):
                self.expr(operand, PRIMARY)
                self.add(sign)
            case Choice(condition, then, otherwise):
                self.expr(condition, OR)
                self.add(" ")
                self.split()
                self.add("? ")
                self.expr(then, OR)
                self.add(" ")
                self.split()
                self.add(": ")
                self.expr(otherwise, OR)
            case Braces(type_, values):
                self.list(f"{type_}{{", values, "}")
            case _:
                raise TypeError(f"no text for {type(expr).__name__}")

    def _operation(self, expr: Operation) -> None:
        level, sign = expr.level, expr.sign
        inner = _INNER.get(level, level)
        chained = level in (AND, OR) and isinstance(expr.left, Operation) and expr.left.sign == sign
        self._operand(expr.left, level if chained else inner, level)
        if sign == "+":
            self.add(" ")
            self.split()
            self.add("+ ")
        else:
            self.add(f" {sign} ")
            if sign in ("&&", "||"):
                self.split()
        self._operand(expr.right, level + 1 if level in (ADD, MULTIPLY) else inner, level)

    def _operand(self, expr: Expr, least: int, level: int) -> None:
        self.expr(expr, PRIMARY if level in (EQUAL, COMPARE) and starts_with(expr, "!") else least)


def text_of(expr: Expr) -> str:
    """Return an expression in one line."""
    line = Line()
    line.expr(expr)
    return "".join(line.pieces)


def wrapped(line: Line, indent: str, length: int = LINE_LENGTH - 4) -> list[str]:
    """Break a long line between its pieces, with a hanging indent."""
    text, ends, end = "".join(line.pieces), [], 0
    for piece in line.pieces[:-1]:
        end += len(piece)
        ends.append(end)
    result: list[str] = []
    outer, at, k = len(indent), 0, 0
    least = 8  # no line is shorter
    while len(indent) + len(text) - at > length:
        last = None
        while k < len(ends) and len(indent) + ends[k] - at <= length:
            last = ends[k]
            k += 1
        if last is None or len(indent) + last - at <= outer + least:
            break
        result.append((indent + text[at:last]).rstrip())
        at, least = last, 12
        indent = " " * (outer + (4 if len(result) == 1 else 8))
    return [*result, indent + text[at:]]


def statements(block: Block, depth: int = 0) -> Iterator[str]:
    """Yield the lines of a block."""
    for statement in block:
        yield from _statement(statement, "  " * depth, depth)


def _statement(statement: Statement, indent: str, depth: int) -> Iterator[str]:
    match statement:
        case If():
            yield from _if(statement, indent, depth)
        case For() | ForEach() | While():
            yield from _short(statement.short, _loop_head(statement), statement.body, indent, depth)
        case Comment(text):
            yield f"{indent}// {text}"
        case Declare(value=Braces(values=values, rows=True) as rows):
            line = _simple(replace(statement, value=None))
            line.add(f" = {rows.type}{{")
            yield f"{indent}{''.join(line.pieces)}"
            for value in values:
                row = Line()
                row.expr(value)
                row.add(",")
                yield from wrapped(row, f"{indent}  ")
            yield f"{indent}}};"
        case Declare(value=Lambda(arguments, body)):
            line = _simple(replace(statement, value=None))
            line.add(f" = []({', '.join(arguments)}) {{")
            yield f"{indent}{''.join(line.pieces)}"
            yield from statements([*body], depth + 1)
            yield f"{indent}}};"
        case Text(lines):
            yield from (f"{indent}{line}" for line in lines)
        case _:
            line = _simple(statement)
            line.add(";")
            yield from wrapped(line, indent)


def _simple(statement: Statement) -> Line:
    """Return a statement without blocks, up to its semicolon."""
    line = Line()
    match statement:
        case Declare(type_, name, value, dimensions, arguments, unused):
            line.add(f"{'[[maybe_unused]] ' if unused else ''}{type_} {name}")
            line.add("".join(f"[{d}]" for d in dimensions))
            if arguments:
                line.list("(", arguments, ")")
            elif value == Braces("", ()) and not dimensions:
                line.add("{}")
            elif value is not None:
                line.add(" = ")
                line.split()
                line.expr(value)
        case Assign(target, sign, value):
            line.expr(target)
            line.add(f" {sign} ")
            if sign == "=":
                line.split()
            line.expr(value)
        case Do(expr):
            line.expr(expr)
        case Return(value):
            line.add("return ")
            line.expr(value)
        case Jump(word):
            line.add(word)
        case _:
            raise TypeError(f"no text for {type(statement).__name__}")
    return line


def _loop_head(statement: For | ForEach | While) -> Line:
    line = Line()
    match statement:
        case For(type_, variable, first, test, step):
            line.add(f"for ({type_} {variable} = ")
            line.split()
            line.expr(first)
            line.add("; ")
            line.expr(test)
            line.add("; ")
            line.add("".join(_simple(step).pieces))
        case ForEach(type_, variable, array):
            line.add(f"for ({type_} {variable} : ")
            line.expr(array)
        case While(test):
            line.add("while (")
            line.expr(test)
    line.add(")")
    return line


def _if(statement: If, indent: str, depth: int) -> Iterator[str]:
    (condition, then), *more = statement.branches
    head = Line()
    head.add("if (")
    head.expr(condition)
    head.add(")")
    alone = not more and not statement.otherwise
    if alone:
        yield from _short(statement.short, head, then, indent, depth)
        return
    head.add(" {")
    yield from wrapped(head, indent)
    yield from statements(then, depth + 1)
    for condition, block in more:
        head = Line()
        head.add("} else if (")
        head.expr(condition)
        head.add(") {")
        yield from wrapped(head, indent)
        yield from statements(block, depth + 1)
    if statement.otherwise:
        yield f"{indent}}} else {{"
        yield from statements(statement.otherwise, depth + 1)
    yield f"{indent}}}"


def _short(short: bool, head: Line, body: Block, indent: str, depth: int) -> Iterator[str]:
    """Yield a head and its block, in one line if that is asked for and fits."""
    if short and len(body) == 1 and _may_follow(body[0]):
        heads = wrapped(head, indent)
        lines = list(_statement(body[0], "  " * (depth + 1), depth + 1))
        if len(heads) == len(lines) == 1 and len(heads[0]) + len(lines[0].strip()) < LINE_LENGTH - 2:
            yield f"{heads[0]} {lines[0].strip()}"
            return
    head.add(" {")
    yield from wrapped(head, indent)
    yield from statements(body, depth + 1)
    yield f"{indent}}}"


def _may_follow(statement: Statement) -> bool:
    """Return whether a statement may stand behind the head that it belongs to, in the same line."""
    if isinstance(statement, Declare):
        return not statement.type.startswith("const ")
    return not isinstance(statement, If | For | ForEach | Comment)


def head_of(function: Function) -> list[str]:
    """Return the lines before the body. Arguments that the body does not use stay without a name."""
    used, line = names_in(function.body), Line()
    line.add(" ".join(filter(None, (function.mark, function.result, f"{function.name}("))))
    for n, (kind, name) in enumerate(function.arguments):
        if n:
            line.add(", ")
            line.split()
        line.add(f"{kind} {name}" if name in used else kind)
    line.add(") {")
    template = [f"template <{', '.join(function.template)}>"] if function.template else []
    return [*template, *wrapped(line, "")]
