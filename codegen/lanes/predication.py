# SPDX-License-Identifier: Apache-2.0
"""Functions in lanes: a mask in place of each branch.

Each lane has a scenario of its own, and lanes may take different ways through a function. So both ways of a
branch are taken, each by the lanes of a mask, and an assignment leaves the other lanes' values alone. A lane
that has returned, or has left a loop, is in no mask behind.

What C++ evaluates for some values only (``?:``, ``&&``) is evaluated in all lanes: most expressions change
nothing, and tables give an entry whatever the position.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from hypgen.codegen.lanes.lane_text import (
    CLASSES,
    MASK,
    RUNTIME,
    STRUCTS,
    NoLanes,
    lane_type,
    lanes_of,
    on_lanes,
)
from hypgen.codegen.tree.expr import (
    FALSE,
    Braces,
    Call,
    Choice,
    Expr,
    Index,
    Literal,
    Member,
    Name,
    Operand,
    Operation,
    Postfix,
    Prefix,
    number,
    of,
)
from hypgen.codegen.tree.statements import (
    BREAK,
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
    Return,
    Statement,
    const,
    var,
    walk,
    when,
)
from hypgen.codegen.tree.walks import nodes, root

_CHEAP = 4  # assignments that cost less than a branch around them


def predicated(functions: Sequence[Function]) -> list[Function]:
    """Return functions that call nothing but each other and the runtime, in lanes."""
    known = {f.name: f for f in functions}
    return [Predication(f, known).function() for f in functions]


def leaves(statement: Statement, in_loop: bool = False) -> bool:
    """Return whether a lane may leave, in a statement, the block that the statement stands in."""
    match statement:
        case Return():
            return True
        case Jump():
            return not in_loop
        case For(body=body) | ForEach(body=body):
            return any(leaves(s, in_loop=True) for s in body)
    return any(leaves(s, in_loop) for block in statement.blocks for s in block)


def _jumps(block: Block, word: str) -> bool:
    """Return whether a block of a loop has a jump of this loop."""
    for statement in block:
        if isinstance(statement, Jump) and statement.word == word:
            return True
        if not isinstance(statement, For | ForEach) and any(_jumps(b, word) for b in statement.blocks):
            return True
    return False


@dataclass
class Predication:
    """Puts one function into lanes."""

    source: Function
    known: Mapping[str, Function]
    uniform: set[str] = field(default_factory=set)  # loop variables: the same in all lanes
    loops: list[tuple[str, str]] = field(default_factory=list)  # masks: who skips, who has stopped

    def __post_init__(self) -> None:
        body = self.source.body
        self.taken = {n for s in walk(body) for n in s.names}
        self.taken |= {s.name for s in walk(body) if isinstance(s, Declare)}
        self.taken |= {name for _, name in self.source.arguments}
        self.early = any(isinstance(s, Return) and s is not body[-1] for s in walk(body))
        self.result = self._fresh("result") if self.early else ""
        self.done = self._fresh("done") if self.early else ""

    def function(self) -> Function:
        """Return the function in lanes; its first argument is the mask of the lanes that count."""
        source, mask = self.source, self._fresh("on")
        arguments, templates, preludes = [(f"lanes::{MASK}", mask)], list[str](), Block()
        changed = {root(s.target) for s in walk(source.body) if isinstance(s, Assign)}
        owned = set[str]()
        for kind, name in source.arguments:
            scalar = lane_type(kind)
            if kind == "D&":
                arguments.append(("lanes::Draws&", name))
            elif kind.endswith("Real*"):
                templates.append("class Real")
                arguments.append((kind.replace("Real", "lanes::Lanes<Real>"), name))
            elif scalar is None and kind.rstrip("&").removeprefix("const ") not in STRUCTS:
                raise NoLanes(f"{source.name} takes a {kind}")
            elif scalar is None:
                arguments.append((kind, name))
                if not kind.endswith("&"):
                    owned.add(name)
            elif name in changed:
                arguments.append((scalar, name))
                owned.add(name)
            else:
                templates.append(f"class T_{name}")
                arguments.append((f"const T_{name}&", name))
        result = source.result if source.result in ("void", "Joint") else lanes_of(source.result)
        if self.early:
            if result != "void":
                preludes.append(Declare(result, self.result))
            preludes.append(var(f"lanes::{MASK}", self.done, FALSE))
        body = [*preludes, *self.block(source.body, mask, owned)]
        if self.early and result != "void":
            body.append(Return(of(self.result)))
        return Function(
            result,
            source.name,
            arguments,
            body,
            source.comment,
            template=(*dict.fromkeys(templates),),
        )

    # Statements ----------------------------------------------------------------------------------

    def block(self, body: Block, mask: str, owned: set[str]) -> Block:
        """Return a block for the lanes of ``mask``; no other lane reads what is in ``owned``."""
        result = Block()
        for n, statement in enumerate(body):
            result += self.statement(statement, mask, owned)
            if isinstance(statement, Jump | Return):
                break
            if leaves(statement) and body[n + 1 :]:
                left = self._fresh("on")
                result.append(const(f"lanes::{MASK}", left, on_lanes("without", mask, self._gone())))
                result.append(when(on_lanes("any", left), *self.block(body[n + 1 :], left, owned)))
                break
        return result

    def _gone(self) -> Expr:
        """Return the mask of lanes that have left the block in work."""
        masks = [self.done] if self.early else []
        masks += [m for m in self.loops[-1] if m] if self.loops else []
        gone = of(masks[0])
        for name in masks[1:]:
            gone = on_lanes("either", gone, name)
        return gone

    def statement(self, statement: Statement, mask: str, owned: set[str]) -> Iterator[Statement] | Block:
        """Return what a statement becomes for the lanes of ``mask``."""
        match statement:
            case Comment():
                return [statement]
            case Declare():
                return [self._declared(statement, mask, owned)]
            case Assign(target, sign, value):
                return [self._assigned(target, sign, value, mask, owned)]
            case Do(Prefix(sign="++" | "--" as sign, operand=Name() as operand)):
                return [self._assigned(operand, f"{sign[0]}=", number(1), mask, owned)]
            case Do(Call() as call):
                return [Do(self._call(call, mask, changes=True))]
            case Return(value):
                return self._returned(value, mask)
            case Jump(word):
                skipped, stopped = self.loops[-1]
                name = skipped if word == "continue" else stopped
                return [Assign(of(name), "=", on_lanes("either", name, mask))]
            case If():
                return self._if(statement, mask)
            case For() | ForEach():
                return self._loop(statement, mask, owned)
        raise NoLanes(f"{self.source.name} has a {type(statement).__name__.lower()} loop")

    def _declared(self, declared: Declare, mask: str, owned: set[str]) -> Statement:
        kind, name = declared.type.removeprefix("const "), declared.name
        if kind.startswith("static constexpr "):
            return declared
        if declared.arguments:
            raise NoLanes(f"{self.source.name} uses {kind}")
        owned.add(name)
        value = declared.value
        empty = value is None or value == Braces("", ())
        if kind in STRUCTS or kind in CLASSES or kind == "StepResult":
            lanes = kind if kind in STRUCTS else CLASSES.get(kind, "lanes::StepLanes")
            prefix = "const " if declared.type.startswith("const ") else ""
            made = None if value is None or empty else self.expr(value, mask)
            return Declare(prefix + lanes, name, made, unused=declared.unused)
        scalar = lane_type(kind)
        if kind == "auto" and value is not None:
            return Declare("const auto", name, self.expr(value, mask), unused=declared.unused)
        if scalar is None or (declared.dimensions and not empty):
            raise NoLanes(f"{self.source.name} keeps a {kind}")
        if empty:
            return Declare(scalar, name, dimensions=declared.dimensions, unused=declared.unused)
        assert value is not None
        made = on_lanes(f"as<{kind}>", self.expr(value, mask))
        if declared.type.startswith("const "):
            return Declare("const auto", name, made, unused=declared.unused)
        return Declare(scalar, name, made, unused=declared.unused)

    def _assigned(self, target: Expr, sign: str, value: Expr, mask: str, owned: set[str]) -> Statement:
        new = self.expr(value, mask)
        if sign != "=":
            before = self.expr(target, mask)
            joined = {"&=": "both", "|=": "either"}.get(sign)
            new = on_lanes(joined, before, new) if joined else Operation(before, sign[:-1], new)
        match target:
            case Index(array, index):
                return Do(on_lanes("put_at", mask, self.expr(array, mask), self.expr(index, mask), new))
            case Name() | Member(owner=Name()):
                if root(target) in owned:
                    return Assign(target, "=", new)
                return Do(Call(Literal("assign"), (of(mask), target, new)))
        raise NoLanes(f"{self.source.name} assigns through a pointer")

    def _returned(self, value: Expr, mask: str) -> Block:
        void = self.source.result == "void"
        if not self.early:
            if void and isinstance(value, Call):
                return [Do(self._call(value, mask, changes=True))]
            return [Return(self.expr(value, mask))]
        if void:
            raise NoLanes(f"{self.source.name} returns from within")
        assigned = Do(Call(Literal("assign"), (of(mask), of(self.result), self.expr(value, mask))))
        return [assigned, Assign(of(self.done), "=", on_lanes("either", self.done, mask))]

    def _if(self, statement: If, mask: str) -> Block:
        result, left = Block(), mask
        branches: list[tuple[Expr | None, Block]] = [*statement.branches]
        branches += [(None, statement.otherwise)] if statement.otherwise else []
        while branches and not branches[-1][1]:
            branches.pop()
        for n, (condition, block) in enumerate(branches):
            if condition is None:
                own = left
            else:
                own = self._fresh("on")
                test = on_lanes("both", left, self.expr(condition, mask))
                result.append(const(f"lanes::{MASK}", own, test))
            if n + 1 < len(branches):
                before, left = left, self._fresh("on")
                result.append(const(f"lanes::{MASK}", left, on_lanes("without", before, own)))
            inner = self.block(block, own, set())
            if all(map(_is_cheap, inner)) and len(inner) <= _CHEAP:
                result += inner
            else:
                result.append(when(on_lanes("any", own), *inner))
        return result

    def _loop(self, loop: For | ForEach, mask: str, owned: set[str]) -> Block:
        if isinstance(loop, For):
            head = {n for e in (loop.first, loop.test) for n in e.names} - {loop.variable}
            if not head <= self.uniform:
                raise NoLanes(f"{self.source.name} has a loop whose length varies")
            self.uniform.add(loop.variable)
        if not any(leaves(s) for s in loop.body):
            return [self._with(loop, self.block(loop.body, mask, owned))]
        skipped = self._fresh("skipped") if _jumps(loop.body, "continue") else ""
        stopped = self._fresh("stopped") if _jumps(loop.body, "break") else ""
        self.loops.append((skipped, stopped))
        own = self._fresh("on")
        # Who skips the rest of a trip is there in the next one.
        self.loops[-1] = ("", stopped)
        out = (self.done if self.early else "", stopped)
        start: Expr = of(mask) if not any(out) else on_lanes("without", mask, self._gone())
        self.loops[-1] = (skipped, stopped)
        body: Block = [const(f"lanes::{MASK}", own, start)]
        body += [when(Prefix("!", on_lanes("any", own)), BREAK)] if any(out) else []
        body += [var(f"lanes::{MASK}", skipped, FALSE)] if skipped else []
        body += self.block(loop.body, own, set())
        self.loops.pop()
        before = [var(f"lanes::{MASK}", stopped, FALSE)] if stopped else []
        return [*before, self._with(loop, body)]

    def _with(self, loop: For | ForEach, body: Block) -> Statement:
        if isinstance(loop, ForEach):
            return ForEach("const auto&", loop.variable, loop.array, body)
        return For(loop.type, loop.variable, loop.first, loop.test, loop.step, body)

    # Expressions ---------------------------------------------------------------------------------

    def expr(self, expr: Expr, mask: Operand) -> Expr:
        """Return an expression in lanes."""
        match expr:
            case Name() | Literal():
                return expr
            case Operation(left, "&&", right):
                first = self.expr(left, mask)
                own = on_lanes("both", mask, first) if self._changes(right) else mask
                return on_lanes("both", first, self.expr(right, own))
            case Operation(left, "||", right):
                first = self.expr(left, mask)
                own = on_lanes("without", mask, first) if self._changes(right) else mask
                return on_lanes("either", first, self.expr(right, own))
            case Choice(_, then, otherwise) if self._changes(then) or self._changes(otherwise):
                raise NoLanes(f"{self.source.name} changes something in a choice")
            case Operation(left, sign, right):
                return Operation(self.expr(left, mask), sign, self.expr(right, mask))
            case Prefix(sign="!" | "-" as sign, operand=operand):
                return Prefix(sign, self.expr(operand, mask))
            case Postfix(Name() as operand, sign):
                return on_lanes("stepped", mask, operand, number(1 if sign == "++" else -1))
            case Choice(condition, then, otherwise):
                parts = (condition, then, otherwise)
                return on_lanes("select", *(self.expr(part, mask) for part in parts))
            case Member(owner, member):
                return Member(self.expr(owner, mask), member)
            case Index():
                return self._entry(expr, mask)
            case Braces(type_, values) if lane_type(type_) and all(isinstance(v, Literal) for v in values):
                return expr  # a number
            case Braces(type_, values):
                name = type_ if type_ in STRUCTS or not type_ else self._class(type_)
                return Braces(name, tuple(self.expr(v, mask) for v in values))
            case Call():
                return self._call(expr, mask)
        raise NoLanes(f"{self.source.name} has a {type(expr).__name__.lower()} expression")

    def _changes(self, expr: Expr) -> bool:
        """Return whether evaluating an expression changes anything: then only some lanes may evaluate it."""
        for node in nodes(expr):
            match node:
                case Postfix():
                    return True
                case Call(function=Name(text) | Literal(text)):
                    if RUNTIME.get(text.partition("<")[0]):
                        return True
                    kinds = [kind for kind, _ in self.known[text].arguments] if text in self.known else []
                    if any(k[-1] in "&*" and not k.startswith("const ") and k != "D&" for k in kinds):
                        return True
        return False

    def _entry(self, expr: Index, mask: Operand) -> Expr:
        indices: list[Expr] = []
        base: Expr = expr
        while isinstance(base, Index):
            indices.insert(0, self.expr(base.index, mask))
            base = base.array
        return on_lanes("at", self.expr(base, mask), *indices)

    def _class(self, name: str) -> str:
        if name not in CLASSES:
            raise NoLanes(f"{self.source.name} uses {name}")
        return CLASSES[name]

    def _call(self, call: Call, mask: Operand, changes: bool = False) -> Expr:
        arguments = tuple(self.expr(a, mask) for a in call.arguments)
        match call.function:
            case Member(owner, method):
                given = (of(mask), *arguments) if changes else arguments
                return Call(Member(self.expr(owner, mask), method), given)
            case Name(text) if text in self.known:
                return Call(call.function, (of(mask), *arguments))
            case Literal(text) if text.startswith("static_cast<"):
                return on_lanes(text.replace("static_cast", "as"), *arguments)
            case Name(text) | Literal(text):
                plain = text.partition("<")[0]
                if plain in CLASSES:
                    return Call(Literal(CLASSES[plain]), arguments)
                if "::" in plain and plain.split("::")[0] in ("math", "dist", "posteriors"):
                    if plain not in RUNTIME:
                        raise NoLanes(f"{self.source.name} calls {plain}")
                    given = (of(mask), *arguments) if RUNTIME[plain] else arguments
                    return Call(call.function, given)
                if "::" in plain and not plain.startswith(("std::", "hypgen::", "relaxation::", "moments::")):
                    return Call(call.function, arguments)  # of an enum or a record
        raise NoLanes(f"{self.source.name} calls what has no lanes")

    def _fresh(self, base: str) -> str:
        name, n = base, 2
        while name in self.taken:
            name, n = f"{base}_{n}", n + 1
        self.taken.add(name)
        return name


def _is_cheap(statement: Statement) -> bool:
    if isinstance(statement, Do) and isinstance(statement.expr, Call):
        target, new = statement.expr.function, statement.expr.arguments[2:]
        if target == Literal("assign"):
            return all(isinstance(n, Name | Literal | Operation | Member) for v in new for n in nodes(v))
    return isinstance(statement, Assign | Comment)
