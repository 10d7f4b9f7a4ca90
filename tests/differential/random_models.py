"""Random models of a fixed shape: whatever operators and distributions a printer may have to nest.

Every expression is well typed, with true intervals, so that a model is one that lowering could have made.
"""

from __future__ import annotations

import random

from ir_samples import const, span

from hypgen.dsl import ir
from hypgen.dsl.types import BOOL, FLOAT, PROB, Bool, Enum, Float, Int, Record, Type, Variant, low_of, size_of

SMALL = Int(-2, 3)
INDEX = Int(1, 3)
ACT = Enum("Act", (Variant("wait"), Variant("move", SMALL), Variant("look", INDEX), Variant("stop")))
MODE = Enum("Mode", (Variant("idle"), Variant("busy", BOOL), Variant("far", SMALL)))
POS = Record("Pos", (("row", INDEX), ("col", SMALL), ("lit", BOOL)))
FINITE: tuple[Type, ...] = (BOOL, SMALL, INDEX, MODE, POS)
OBSERVED: tuple[tuple[str, Type], ...] = (("mode", MODE), ("number", SMALL))
LIMIT = 100_000


def hull(*types: Type) -> Int:
    """Return the smallest interval around int types."""
    ints = [t for t in types if isinstance(t, Int)]
    return Int(min(t.low for t in ints), max(t.high for t in ints))


class Maker:
    """Makes random expressions over the variables that may be read."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.locals: list[tuple[str, Type]] = []
        self.names = 0
        self.reads: list[ir.Variable] = []
        self.primed: list[ir.Variable] = []
        self.action = False
        self.remembers = False

    def pick(self, *makers: str) -> str:
        return self.random.choice(makers)

    # Expressions of a given kind -----------------------------------------------------------------

    def of(self, t: Type, depth: int) -> ir.Expr:
        """Return an expression whose value lies within ``t``."""
        match t:
            case Bool():
                return self.truth(depth)
            case Float():
                return self.number(depth)
            case Int(low, high):
                e = self.integer(depth)
                inside = isinstance(e.type, Int) and low <= e.type.low and e.type.high <= high
                return e if inside else ir.Clamp(t, e, low, high)
        return self.code(t, depth)

    def leaf(self, t: Type) -> ir.Expr:
        """Return a read or constant of exactly this type."""
        found: list[ir.Expr] = [ir.Local(t, n) for n, local in self.locals if local == t]
        for primed, variables in ((False, self.reads), (True, self.primed)):
            same = [v for v in variables if v.type == t]
            found += [ir.StateRead(t, v.name, tuple(self.index() for _ in v.indices), primed) for v in same]
        if t == SMALL:
            found.append(ir.ParamRead(SMALL, "offset", (self.index(),)))
        if self.remembers:
            found += self.kept(t)
        if found and self.random.random() < 0.8:
            return self.random.choice(found)
        if isinstance(t, Float):
            return ir.Const(t, self.random.choice([0.0, 1.0, -0.5, 2.0, 0.125, 3.5]))
        value = self.random.randrange(size_of(t)) + low_of(t)
        return ir.Const(t, bool(value) if isinstance(t, Bool) else value)

    def kept(self, t: Type) -> list[ir.Expr]:
        """Return reads of the history of exactly this type."""
        reads: list[ir.Expr] = [ir.MemoryRead(SMALL, "count"), ir.MemoryRead(FLOAT, "mean")]
        reads.append(ir.MemoryRead(POS, "marked", (self.index(),)))
        for name, of in OBSERVED:
            reads.append(ir.LastObservation(of, name, (self.index(),), ir.Const(of, low_of(of))))
        return [r for r in reads if r.type == t]

    def index(self) -> ir.Expr:
        """Return an index that is cheap to read: a binder or a constant."""
        bound: list[ir.Expr] = [ir.Local(INDEX, n) for n, t in self.locals if t == INDEX]
        return self.random.choice([*bound, ir.Const(INDEX, self.random.randint(1, 3))])

    def integer(self, depth: int) -> ir.Expr:
        if depth <= 0:
            return self.leaf(self.random.choice([SMALL, INDEX]))
        kind = self.pick(
            "binary", "binary", "unary", "if", "let", "round", "count", "table", "field", "argument"
        )
        a = self.integer(depth - 1)
        at = hull(a.type)
        if kind == "binary":
            return self.arithmetic(a, self.integer(depth - 1))
        if kind == "unary":
            size = max(abs(at.low), abs(at.high))
            op, t = self.random.choice(
                [("neg", Int(-at.high, -at.low)), ("abs", Int(0, size)), ("sign", Int(-1, 1))]
            )
            return ir.Unary(t, op, a)
        if kind == "if":
            b = self.integer(depth - 1)
            return ir.If(hull(at, b.type), self.truth(depth - 1), a, b)
        if kind == "let":
            with_name = self.bind(at)
            body = self.arithmetic(ir.Local(at, with_name), self.integer(depth - 1))
            self.locals.pop()
            return ir.LetIn(body.type, with_name, a, body)
        if kind == "round":
            return ir.Unary(Int(-4, 9), self.pick("floor", "ceil", "round"), self.number(depth - 1))
        if kind == "count":
            return self.quantified(self.pick("sum", "count", "min", "max", "argmin", "argmax"), depth)
        if kind == "table":
            return ir.TableRead(Int(-7, 8), "worth", (self.index(), self.truth(0)))
        if kind == "field":
            name, t = self.random.choice(POS.fields[:2])
            return ir.FieldRead(t, POS, name, self.code(POS, depth - 1))
        mode = self.code(MODE, 0)
        far = ir.VariantArgument(SMALL, MODE, "far", mode)
        return ir.If(hull(at, SMALL), ir.IsVariant(BOOL, MODE, "far", mode), far, a)

    def arithmetic(self, a: ir.Expr, b: ir.Expr) -> ir.Expr:
        """Return an int operator of both, clamped where it could leave a comfortable range."""
        x, y = hull(a.type), hull(b.type)
        op = self.pick("add", "sub", "mul", "min", "max", "floordiv", "mod")
        corners = [x.low * y.low, x.low * y.high, x.high * y.low, x.high * y.high]
        divisor = max(abs(y.low), abs(y.high))
        t = {
            "add": Int(x.low + y.low, x.high + y.high),
            "sub": Int(x.low - y.high, x.high - y.low),
            "mul": Int(min(corners), max(corners)),
            "min": hull(x, y),
            "max": hull(x, y),
            "floordiv": hull(x, Int(-x.high, -x.low), Int(-1, 0)),
            "mod": Int(-divisor, divisor),
        }[op]
        e = ir.Binary(t, op, a, b)
        return e if t.low > -LIMIT and t.high < LIMIT else ir.Clamp(Int(-99, 99), e, -99, 99)

    def truth(self, depth: int) -> ir.Expr:
        if depth <= 0:
            return self.leaf(BOOL)
        kind = self.pick(
            "compare", "compare", "float", "and", "or", "not", "any", "all", "variant", "same", "if"
        )
        if kind in ("and", "or"):
            return ir.Binary(BOOL, kind, self.truth(depth - 1), self.truth(depth - 1))
        if kind == "not":
            return ir.Unary(BOOL, "not", self.truth(depth - 1))
        if kind in ("any", "all"):
            return self.quantified(kind, depth)
        if kind == "variant":
            enum = ACT if self.action or self.remembers else MODE
            variant = self.random.choice(enum.variants).name
            return ir.IsVariant(BOOL, enum, variant, self.code(enum, depth - 1))
        if kind == "same":
            t = self.random.choice(FINITE)
            return ir.Binary(BOOL, self.pick("eq", "ne"), self.of(t, depth - 1), self.of(t, depth - 1))
        if kind == "if":
            return ir.If(BOOL, self.truth(depth - 1), self.truth(depth - 1), self.truth(depth - 1))
        make = self.number if kind == "float" else self.integer
        return ir.Binary(BOOL, self.pick("lt", "le", "gt", "ge"), make(depth - 1), make(depth - 1))

    def number(self, depth: int) -> ir.Expr:
        if depth <= 0:
            return self.leaf(FLOAT)
        kind = self.pick("binary", "binary", "int", "unary", "if", "clamp", "power", "sum")
        a = self.number(depth - 1)
        if kind == "binary":
            op = self.pick("add", "sub", "mul", "div", "min", "max", "hypot")
            return ir.Binary(FLOAT, op, a, self.number(depth - 1))
        if kind == "int":
            return ir.ToFloat(FLOAT, self.integer(depth - 1))
        if kind == "unary":
            return ir.Unary(FLOAT, self.pick("neg", "abs", "sign", "sqrt", "exp", "log", "log2"), a)
        if kind == "if":
            return ir.If(FLOAT, self.truth(depth - 1), a, self.number(depth - 1))
        if kind == "clamp":
            return self.random.choice([ir.Clamp, ir.Checked])(FLOAT, a, -1.5, 2.0)
        if kind == "sum":
            return self.quantified("sum", depth, of_floats=True)
        return ir.Binary(FLOAT, "pow", a, ir.ToFloat(FLOAT, self.leaf(SMALL)))

    def code(self, t: Type, depth: int) -> ir.Expr:
        """Return an expression of an enum or record."""
        if t == ACT:
            first = ir.Const(ACT, self.random.randrange(size_of(ACT)))
            return ir.ActionRead(ACT) if self.action else ir.LastAction(ACT, (), first)
        if depth <= 0 or self.random.random() < 0.3:
            return self.leaf(t)
        if self.random.random() < 0.3:
            return ir.If(t, self.truth(depth - 1), self.code(t, depth - 1), self.code(t, depth - 1))
        if t == POS:
            return ir.MakeRecord(POS, POS, tuple(self.of(f, depth - 1) for _, f in POS.fields))
        return ir.MakeVariant(MODE, MODE, "far", self.of(SMALL, depth - 1))

    def bind(self, t: Type) -> str:
        self.names += 1
        self.locals.append((f"v{self.names}", t))
        return self.locals[-1][0]

    def quantified(self, kind: str, depth: int, of_floats: bool = False) -> ir.Expr:
        binder = ir.Binder(self.bind(INDEX), INDEX)
        condition = self.truth(depth - 1) if self.random.random() < 0.7 else None
        body: ir.Expr | None = None
        if kind in ("any", "all"):
            body = self.truth(depth - 1)
        elif kind != "count":
            body = self.number(depth - 1) if of_floats else self.of(SMALL, depth - 1)
        self.locals.pop()
        t: Type = {"any": BOOL, "all": BOOL, "count": Int(0, 3), "argmin": INDEX, "argmax": INDEX}.get(
            kind, SMALL
        )
        if kind == "sum":
            t = FLOAT if of_floats else Int(-6, 9)
        otherwise = None
        if kind in ("min", "max", "argmin", "argmax"):
            otherwise = self.leaf(t)
        return ir.Quantified(t, kind, (binder,), condition, body, otherwise)

    # Distributions -------------------------------------------------------------------------------

    def probability(self) -> ir.Expr:
        return ir.Const(PROB, self.random.choice([0.125, 0.25, 0.30000001192092896, 0.5]))

    def dist(self, t: Type, depth: int) -> ir.Dist:
        """Return a distribution over a finite type, or over floats."""
        nested = ("if", "let") if depth > 0 else ()
        finite = () if isinstance(t, Float) else ("uniform", "noisy")
        kind = self.pick("certain", *finite, "table", "rest", "set", *nested)
        if kind == "certain":
            return ir.Certain(t, self.of(t, depth))
        if kind == "uniform":
            return (
                ir.Bernoulli(BOOL, ir.Clamp(PROB, self.number(depth), 0.0, 1.0))
                if t == BOOL
                else ir.Uniform(t)
            )
        if kind == "noisy":
            return ir.Noisy(t, self.of(t, depth), ir.Clamp(PROB, self.number(1), 0.0, 1.0))
        if kind in ("table", "rest"):
            entries = tuple((self.of(t, depth), self.probability()) for _ in range(self.random.randint(1, 3)))
            return ir.Table(t, entries, self.of(t, depth) if kind == "rest" else None)
        if kind == "set":
            binder = ir.Binder(self.bind(SMALL), SMALL)
            condition, value = self.truth(depth), self.of(t, depth)
            self.locals.pop()
            otherwise = ir.Uniform(t) if finite and self.random.random() < 0.5 else None
            return ir.UniformSet(t, (binder,), condition, value, otherwise)
        if kind == "if":
            return ir.IfDist(t, self.truth(depth), self.dist(t, depth - 1), self.dist(t, depth - 1))
        value = self.integer(depth)
        name = self.bind(value.type)
        body = self.dist(t, depth - 1)
        self.locals.pop()
        return ir.LetDist(t, name, value, body)


def _variable(name: str, t: Type, visible: bool, fixed: bool = False, array: bool = False) -> ir.Variable:
    return ir.Variable(f"world.{name}", "world", t, (INDEX,) if array else (), visible, fixed, span(1))


class _Shape:
    """The declarations that all random models share."""

    secret = _variable("secret", POS, visible=False, fixed=True)
    level = _variable("level", SMALL, visible=True)
    flags = _variable("flags", BOOL, visible=False, array=True)
    mode = _variable("mode", MODE, visible=False)
    spots = _variable("spots", INDEX, visible=True, array=True)
    place = _variable("place", POS, visible=False)
    first = (level, flags, mode)
    speeds = _variable("speeds", FLOAT, visible=False, array=True)
    second = (spots, place, speeds)
    variables = (secret, *first, *second)


def model(seed: int, depth: int = 3) -> ir.Model:
    """Return a random model: two stages, arrays, a fixed variable, a function and all kinds of draws."""
    make = Maker(seed)

    def assign(v: ir.Variable, stage: int = 0) -> ir.Assign:
        binders = tuple(ir.Binder(make.bind(t), t) for t in v.indices)
        dist = make.dist(v.type, depth)
        for _ in binders:
            make.locals.pop()
        reads = frozenset(r.name for r in make.primed)
        return ir.Assign(v.name, binders, dist, ir.Site(v.name), span(2), stage, reads)

    inits = tuple(start(v) for v in _Shape.variables)

    visible = [v for v in _Shape.variables if v.visible]
    make.reads = visible
    binder = ir.Binder(make.bind(SMALL), SMALL)
    function = ir.Function("worth_of", (binder,), FLOAT, make.number(depth), span(3))
    make.locals.pop()
    bound = make.number(depth)
    make.action = True
    # Always something legal, and seldom terminal: a walk that ends at once shows little.
    moves = ir.IsVariant(BOOL, ACT, "move", ir.ActionRead(ACT))
    legal = ir.Binary(BOOL, "or", make.truth(depth), moves)
    make.reads = list(_Shape.variables)
    updates = [assign(v) for v in _Shape.first]
    make.primed = list(_Shape.first)
    updates += [assign(v, stage=1) for v in _Shape.second]
    make.primed = [*_Shape.first, *_Shape.second]
    registers, policy, lower = _remembering(seed, visible)
    observations = []
    for name, t in OBSERVED:
        looker = ir.Binder(make.bind(INDEX), INDEX)
        dist = make.dist(t, depth)
        make.locals.pop()
        observations.append(
            ir.Observation(name, None, t, (looker,), dist, ir.Site(f"observe:{name}"), span(5))
        )
    primed_call = ir.Call(FLOAT, "worth_of", (make.of(SMALL, 1),), primed=True)
    rewards: list[ir.Expr] = [primed_call, ir.Call(FLOAT, "worth_of", (make.leaf(SMALL),))]
    for _ in range(4):
        rewards += [make.integer(depth), make.number(depth)]
    terminal = ir.Binary(BOOL, "and", make.truth(depth), ir.Binary(BOOL, "eq", make.leaf(SMALL), const(3)))
    success = make.truth(depth)
    seen = [ir.KeyField(o.name, True, o.type, (INDEX,)) for o in observations]
    seen += [ir.KeyField(v.name, False, v.type, v.indices) for v in visible]
    return ir.Model(
        name=f"Random{seed}",
        file=f"random_{seed}.pomdp",
        source_hash=f"{seed:064x}",
        discount=0.949999988079071,
        horizon=None,
        enums=(ACT, MODE),
        records=(POS,),
        params=(ir.Param("offset", SMALL, (INDEX,), (3, -2, 0), span(6)),),
        tables=(ir.ConstantArray("worth", Int(-7, 8), (INDEX, BOOL), (5, -7, 0, 8, 1, 2), span(7)),),
        elements=(ir.Element("world", None, span(8)),),
        variables=_Shape.variables,
        lets=(),
        functions=(function,),
        action=ir.Action("act", ACT, (), span(9)),
        inits=inits,
        updates=tuple(updates),
        observations=tuple(observations),
        rewards=tuple(ir.Reward(f"term{i}", None, None, e, span(10)) for i, e in enumerate(rewards)),
        terminal=terminal,
        legal=legal,
        policy=policy,
        history=ir.History(registers, tuple(name for name, _ in OBSERVED), action=True),
        upper=bound,
        tail=const(-1.0),
        lower=lower,
        success=success,
        key=tuple(seen),
    )


def start(v: ir.Variable) -> ir.Assign:
    """Return an init that reaches every value."""
    binders = tuple(ir.Binder("i", t) for t in v.indices)
    dist: ir.Dist = ir.Bernoulli(BOOL, const(0.5)) if v.type == BOOL else ir.Uniform(v.type)
    if isinstance(v.type, Float):
        dist = ir.Table(FLOAT, ((const(-1.5), const(0.25)), (const(0.75), const(0.5))), const(2.0))
    return ir.Assign(v.name, binders, dist, ir.Site(f"init:{v.name}"), span(2))


def _remembering(seed: int, visible: list[ir.Variable]) -> tuple[tuple[ir.Register, ...], ir.Policy, ir.Expr]:
    """Return memory, a policy and a lower bound that read each other's past."""
    make = Maker(seed + 1_000_000)
    make.reads = visible

    def entries(t: Type, indices: tuple[Type, ...]) -> ir.Entries:
        binders = tuple(ir.Binder(make.bind(i), i) for i in indices)
        value = make.of(t, 2)
        for _ in binders:
            make.locals.pop()
        return ir.Entries(binders, value)

    shapes = (("count", SMALL, ()), ("mean", FLOAT, ()), ("marked", POS, (INDEX,)))
    firsts = [entries(t, indices) for _, t, indices in shapes]
    make.remembers = True
    registers = tuple(
        ir.Register(name, t, indices, first, entries(t, indices), span(4))
        for (name, t, indices), first in zip(shapes, firsts, strict=True)
    )
    lower = make.number(3)
    draws = ir.Let("policy.bold", "policy", None, make.dist(SMALL, 2), ir.Site("policy:bold"), span(4))
    value = make.of(SMALL, 2)
    plain = ir.Let("policy.plan", "policy", None, ir.Certain(SMALL, value), ir.Site("policy:plan"), span(4))
    named = ir.Binary(BOOL, "lt", ir.LetRead(SMALL, draws.name), ir.LetRead(SMALL, plain.name))
    move = ir.MakeVariant(ACT, ACT, "move", make.of(SMALL, 2))
    dist = ir.IfDist(
        ACT, named, ir.Uniform(ACT), ir.Certain(ACT, ir.If(ACT, make.truth(2), move, const(0, ACT)))
    )
    site = ir.Site("policy:default")
    return registers, ir.Policy((), dist, site, span(4), (draws, plain)), lower
