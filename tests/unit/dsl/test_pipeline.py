# SPDX-License-Identifier: Apache-2.0
"""What lowering makes of expressions, draws and declarations."""

import math

import pytest

from hypgen.dsl import ir
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse, parse_expression
from hypgen.dsl.types import BOOL, FLOAT, Array, Enum, Float, Int, Record, size_of
from hypgen.dsl.types.intervals import float32

HEAD = """model M
const n: int = 4
type Cell = 0 .. n - 1
record Pos { row: Cell  col: Cell }
enum Dir { up, down }
enum Act { wait, go(Dir), to(Pos) }
const step: int[Dir] = [1, -1]
param w: float[Cell] = [i in Cell: 1 / (1 + i)]
param start: Pos = Pos(1, 2)
discount 0.9
action act: Act
element bot {
  visible pos: Pos
  visible k: Cell
  hidden fixed home: Cell
  init pos = start
  init k = 0
  init home ~ uniform(Cell)
  pos' = pos
  k' = k
}
bound upper = 0
bound tail = 0
"""


def model(text: str = "", **settings: str) -> ir.Model:
    overrides = {k: parse_expression(Source(f"--set {k}", v)) for k, v in settings.items()}
    source = Source("m.pomdp", HEAD + text)
    return lower(parse(source), overrides, source)


def reward(text: str) -> ir.Expr:
    return model(f"reward r = {text}").rewards[0].value


def codes(text: str = "", **settings: str) -> list[str]:
    with pytest.raises(ModelError) as caught:
        model(text, **settings)
    return [d.code for d in caught.value.diagnostics]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("7 // 2 - 7 % 4", 0),
        ("-7 // 2", -4),
        ("-7 % 4", 1),
        ("2 ** 10", 1024),
        ("2.0 ** -1", 0.5),
        ("1 / 4", 0.25),
        ("-2147483648", -(2**31)),
        ("abs(-3) + sign(-5) + max(1, 2, 3)", 5),
        ("floor(2.5) + ceil(2.5) + round(2.5)", 7),
        ("hypot(3, 4)", 5.0),
        ("0.1 + 0.2", float32(float32(0.1) + float32(0.2))),
        ("gamma", float32(0.9)),
        ("pi", float32(math.pi)),
        ("sin(pi / 6)", float32(math.sin(float32(float32(math.pi) / 6)))),
        ("cos(0) + tan(0) + asin(0) + acos(1)", 1.0),
        ("atan2(0, -1)", float32(math.pi)),
        ("clamp(7, 0, 5)", 5),
        ("step[down]", -1),
        ("index(Dir.down) + index(to(Pos(0, 1)))", 5),
        ("if n == 4 then 1 else step[down]", 1),
        ("let a = 3 in a * a", 9),
        ("match n { 4 => 1  else => 0 }", 1),
        ("match go(down) { go(d) => index(d)  else => 5 }", 1),
        ("Pos(2, 3).col", 3),
    ],
)
def test_constants_fold(text: str, value: float) -> None:
    e = reward(text)
    assert isinstance(e, ir.Const)
    assert e.value == value and type(e.value) is type(value)


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ("bot.k - 2", -2, 1),
        ("bot.k * (bot.k - 2)", -6, 3),
        ("(bot.k - 2) ** 2", 0, 4),
        ("abs(bot.k - 2)", 0, 2),
        ("(bot.k - 2) // 2", -1, 0),
        ("(bot.k - 2) % 3", 0, 2),
        ("min(bot.k, 2)", 0, 2),
        ("sum(c in Cell where c == bot.k: -2)", -8, 0),
        ("count(c in Cell where c == bot.k)", 0, 4),
        ("max(c in Cell: c - bot.k)", -3, 3),
        ("if bot.k < n - 1 then bot.k + 1 else bot.k", 1, 3),
        ("if bot.k != 0 and bot.k <= 2 then bot.k else 1", 1, 2),
        ("match bot.k { 0 => 1  else => bot.k }", 1, 3),
        ("step[if act == wait then up else down]", -1, 1),
        ("bot.pos.row + bot.pos'.col", 0, 6),
        ("floor(bot.k / 2)", 0, 1),
    ],
)
def test_intervals_of_ints_are_exact(text: str, low: int, high: int) -> None:
    assert reward(text).type == Int(low, high)


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ("gamma ** bot.k", 0.729, 1.0),
        ("2.0 ** bot.k", 1.0, 8.0),
        ("hypot(bot.k, 4)", 4.0, 5.0),
        ("-bot.k / 2", -1.5, 0.0),
        ("w[0]", -math.inf, math.inf),
        ("clamp(w[0], 0, 1)", 0.0, 1.0),
        ("sqrt(bot.k)", 0.0, 3**0.5),
        ("sin(bot.k)", -1.0, 1.0),
        ("cos(w[0])", -1.0, 1.0),
        ("tan(bot.k)", -math.inf, math.inf),
        ("asin(bot.k / 4)", 0.0, math.asin(0.75)),
        ("acos(bot.k / 4)", math.acos(0.75), math.acos(0.0)),
        ("acos(w[0])", 0.0, math.pi),
        ("atan2(bot.k, 1)", -math.pi, math.pi),
    ],
)
def test_intervals_of_floats_enclose(text: str, low: float, high: float) -> None:
    found = reward(text).type
    assert isinstance(found, Float)
    assert found.low == pytest.approx(low, rel=1e-5) and found.high == pytest.approx(high, rel=1e-5)


def test_ints_become_floats_by_a_node() -> None:
    e = reward("bot.k + 0.5")
    assert isinstance(e, ir.Binary) and isinstance(e.left, ir.ToFloat)
    assert e.right == ir.Const(Float(0.5, 0.5), 0.5)


def test_variants_resolve_by_the_expected_type() -> None:
    m = model("enum Side { up, left }\nfn f(s: Side): bool = s == up\nfn g(d: Dir): bool = up == d")
    operands = [f.body.right if f.name == "f" else f.body.left for f in m.functions]  # type: ignore[attr-defined]
    assert [str(o.type) for o in operands] == ["Side", "Dir"]


def test_a_prime_reaches_every_state_read_and_calls_but_not_fixed_state() -> None:
    e = reward("(bot.k + f(bot.k) + bot.home)'\nfn f(c: Cell): int = c + bot.k")
    reads = [x for x in walk(e) if isinstance(x, ir.StateRead)]
    assert {(r.variable, r.primed) for r in reads} == {("bot.k", True), ("bot.home", False)}
    assert [x.primed for x in walk(e) if isinstance(x, ir.Call)] == [True]


def walk(node: object) -> list[object]:
    if isinstance(node, tuple):
        return [x for part in node for x in walk(part)]
    if isinstance(node, ir.Expr | ir.Dist):
        return [node, *(x for part in vars(node).values() for x in walk(part))]
    return []


def test_match_binds_arguments_and_scrutinees_that_are_no_plain_reads() -> None:
    e = reward("match act { to(p) => p.row  go(d) => step[d]  wait => 0 }")
    assert isinstance(e, ir.If) and isinstance(e.condition, ir.IsVariant) and isinstance(e.then, ir.LetIn)
    assert e.then.name == "p" and isinstance(e.then.value, ir.VariantArgument)
    named = reward("match bot.k + 1 { 1 => 5  else => bot.k }")
    assert isinstance(named, ir.LetIn) and isinstance(named.body, ir.If)


def test_what_an_arm_does_not_read_is_not_bound() -> None:
    e = reward("match act { to(p) => bot.k  else => 0 }")
    assert isinstance(e, ir.If) and isinstance(e.then, ir.StateRead)


def draw(text: str) -> ir.Dist:
    return model(f"element e {{ hidden v: Cell init v = 0 v' {text} }}").updates[-1].dist


def test_draws() -> None:
    assert draw("~ uniform(Cell)") == ir.Uniform(Int(0, 3))
    assert isinstance(draw("~ noisy(v, 0.5)"), ir.Noisy)
    assert isinstance(draw("~ 2"), ir.Certain)
    assert isinstance(draw("~ if act == wait then v else 0"), ir.Certain)
    assert isinstance(draw("~ if act == wait then v else uniform(Cell)"), ir.IfDist)
    table = draw("~ { v: 0.5, 0: 0.25, else 3 }")
    assert isinstance(table, ir.Table) and len(table.entries) == 2
    assert isinstance(draw("~ uniform(c in Cell where c > v: c else 0)"), ir.UniformSet)
    assert isinstance(draw("~ let k = v // 2 in noisy(k, 0.5)"), ir.LetDist)
    assert isinstance(draw("~ match act { go(d) => uniform(Cell)  else => v }"), ir.IfDist)


def test_a_uniform_draw_of_a_part_of_the_target_lists_its_values() -> None:
    m = model("type Two = 1 .. 2\nelement e { hidden v: Cell init v ~ uniform(Two) v' = v }")
    dist = m.inits[-1].dist
    assert isinstance(dist, ir.UniformSet) and dist.type == Int(0, 3)
    assert dist.binders[0].type == Int(1, 2)


def test_families_and_arrays_bind_in_order() -> None:
    m = model(
        "element e[i in Cell] { hidden v: bool[Dir] init v ~ [d in Dir: bernoulli(w[i])]\n"
        "v' = [d in Dir: v[d] and not e[i].v[up]]  reward r = if v[up] then i else 0\n"
        "observe o: bool ~ noisy(v[up], 0.8) }"
    )
    update = m.updates[-1]
    assert [b.name for b in update.binders] == ["i", "d"]
    assert m.variable("e.v").indices == tuple(b.type for b in update.binders)
    assert m.rewards[0].binder == ir.Binder("i", Int(0, 3)) and m.rewards[0].name == "e.r"
    assert [b.name for b in m.observations[0].binders] == ["i"]
    assert update.site.path == "e.v" and m.inits[-1].site.path == "init:e.v"


def test_product_actions_are_read_and_chosen_by_component() -> None:
    text = HEAD.replace("action act: Act", "action act: Act[Dir]")
    source = Source(
        "m", text + "policy default = [d in Dir: go(d)]\nreward r = if act[up] == wait then 1 else 0"
    )
    m = lower(parse(source), {}, source)
    assert m.action.count == 19**2
    assert m.policy is not None and m.policy.binders[0].name == "d"
    assert any(isinstance(x, ir.ActionRead) and len(x.indices) == 1 for x in walk(m.rewards[0].value))


def test_a_table_of_many_entries_is_computed() -> None:
    large = "type Large = 0 .. 9999\nfn f(i: int): float = exp(-i / 100.0) + i % 7\n"
    m = model(large + "const t: float[Large] = [i in Large: f(i)]\nreward r = sum(i in Large: t[i])")
    assert len(m.tables[-1].values) == 10_000


def test_params_and_tables_hold_their_entries_row_major() -> None:
    m = model("const t: int[Cell, Dir] = [i in Cell: [i, sum(j in Cell where j < i: j)]]")
    assert m.tables[-1].values == (0, 0, 1, 0, 2, 1, 3, 3)
    assert m.params[0].default == (1.0, 0.5, float32(1 / 3), 0.25)
    assert m.params[1].default == (6,)


def test_functions_keep_the_interval_that_they_reach() -> None:
    m = model("fn f(c: Cell): int = 2 * c\nfn p(c: Cell): prob = c / 3\nfn g(): int = f(3) + f(0)")
    assert [f.type for f in m.functions] == [Int(0, 6), Float(0, 1, prob=True), Int(0, 12)]


def test_several_conditions_join() -> None:
    m = model(
        "legal when act != wait\nlegal when bot.k < 3\nterminal when bot.k == 1\nterminal when bot.k == 2"
    )
    assert isinstance(m.legal, ir.Binary) and m.legal.op == "and"
    assert isinstance(m.terminal, ir.Binary) and m.terminal.op == "or"
    assert m.success is None and model("success when bot.k' == 1").success is not None


def test_settings_size_types_and_replace_defaults() -> None:
    small = model(n="2", start="Pos(1, 1)", w="[0.5, 0.25]")
    assert small.variable("bot.k").type == Int(0, 1)
    assert [p.default for p in small.params] == [(0.5, 0.25), (3,)]
    assert small.source_hash != model().source_hash == model().source_hash


def test_settings_that_do_not_fit() -> None:
    assert codes(m="2") == ["E0808"]
    assert codes(act="wait") == ["E0809"]
    assert codes(w="[1, 2]") == ["E0309"]
    assert codes(w="0.5") == ["E0309"]
    assert codes(start="Pos(1, 4)") == ["E0601"]
    assert codes(n="2.5") == ["E0301"]


def test_a_setting_may_make_a_branch_dead_but_not_wrong() -> None:
    text = "const two: int[Cell] = [i in Cell: i]\nreward r = if n > 2 then two[1] else 0"
    assert model(text, n="1", start="Pos(0, 0)").rewards[0].value == ir.Const(Int(0, 0), 0)
    assert codes(text.replace("two[1] else", "three[1] else"), n="1", start="Pos(0, 0)") == ["E0201"]


def test_bounds_follow_from_the_rewards() -> None:
    text = HEAD.replace("bound upper = 0\nbound tail = 0\n", "")

    def bounds(more: str, head: str = text) -> tuple[float, float]:
        source = Source("m", head + more)
        m = lower(parse(source), {}, source)
        assert isinstance(m.upper, ir.Const) and isinstance(m.tail, ir.Const)
        return float(m.upper.value), float(m.tail.value)

    plain = "reward r = if act == wait then -1 else bot.k - 5\n"
    assert bounds(plain) == pytest.approx((-10, -50))
    assert bounds(plain + "terminal when bot.k' == 3\n") == pytest.approx((0, -50))
    assert bounds(plain + "policy default = wait\n") == pytest.approx((-10, -10))
    assert bounds(plain + "policy default = wait\nlegal when act != wait\n") == pytest.approx((-10, -50))
    finite = text.replace("discount 0.9", "discount 1.0\nhorizon 20")
    assert bounds("reward r = bot.k\n", finite) == (60, 0)
    called = "fn cost(): int = if act == wait then 0 else -7\nreward r = cost()\npolicy default = wait\n"
    assert bounds(called) == (0, 0)


def test_locals_do_not_shadow_and_siblings_may_share_a_name() -> None:
    assert codes("reward r = sum(i in Cell: sum(i in Dir: 1))") == ["E0202"]
    assert reward("sum(i in Cell: i) + sum(i in Cell: i)").type == Int(0, 24)


def test_a_model_keeps_where_its_nameless_parts_stand() -> None:
    spans = model("terminal when bot.k' == 3").spans
    assert spans["terminal"].line == HEAD.count("\n") + 1 and spans["discount"].line == 10


def test_codes_of_types() -> None:
    m = model()
    act = m.action.type
    assert isinstance(act, Enum) and act.offsets == {"wait": 0, "go": 1, "to": 3} and size_of(act) == 19
    assert isinstance(m.records[0], Record) and m.records[0].stride("row") == 4
    assert size_of(Array(BOOL, (Int(0, 1),))) == 4 and FLOAT.high == math.inf


def test_ranges_of_an_int_formal_are_proven_where_the_function_is_called() -> None:
    text = """
      model M
      type R = 0 .. 9
      const t: bool[R] = [r in R: r > 4]
      discount 0.9
      action act: R
      fn inside(n: int): bool = n >= 0 and n <= 9
      fn far(n: int): bool = at(t, n * 3 + 1, false)
      fn near(n: int): bool = if inside(n) then t[clamp(n)] else false
      element e { hidden x: R  init x = 0  x' = if far(x + act) or near(x - act) then 1 else 0 }
      policy default = 0
    """
    source = Source("m.pomdp", text)
    assert lower(parse(source), {}, source).name == "M"


def test_a_discount_of_1_without_a_horizon_needs_declared_bounds() -> None:
    text = (
        "model M\nenum Act { go }\naction act: Act\ndiscount 1\nbound upper = 3\nbound tail = 0\n"
        "element e { visible x: bool init x = true x' = x }\nterminal when e.x'\nreward r = 1\n"
    )
    source = Source("m.pomdp", text)
    model = lower(parse(source), {}, source)  # type: ignore[arg-type]  # it is a model
    assert model.discount == 1 and model.horizon is None
