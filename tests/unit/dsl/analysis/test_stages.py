# SPDX-License-Identifier: Apache-2.0
"""Stages, the order of inits, the observation key, and which visible variables are determined or copied."""

import pytest

from hypgen.dsl import ir
from hypgen.dsl.analysis.stages import check_sites, find_cycle
from hypgen.dsl.messages.report import Report
from hypgen.dsl.messages.source import Source, Span
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse


def model(members: str, more: str = "") -> ir.Model:
    text = (
        "model M\ntype C = 0 .. 2\nenum A { stay, go }\ndiscount 0.9\naction act: A\n"
        f"bound upper = 0\nbound tail = 0\nelement e {{\n{members}\n}}\n{more}\n"
    )
    source = Source("m.pomdp", text)
    return lower(parse(source), {}, source)


def flags(m: ir.Model) -> dict[str, str]:
    return {
        v.name.removeprefix("e."): "determined" if v.determined else "copied" if v.copied else "weighed"
        for v in m.variables
        if v.visible
    }


CHAIN = """
  visible a, b, c, d: C
  init a = b
  init b = c
  init c = 1
  init d = 0
  a' = f()
  b' = if act == go then c' else d'
  c' = c
  d' = next'
  let next = c
"""


def test_stages_are_longest_paths_through_functions_and_lets() -> None:
    m = model(CHAIN, "fn f(): C = e.b'")
    assert {u.variable: u.stage for u in m.updates} == {"e.a": 3, "e.b": 2, "e.c": 0, "e.d": 1}
    assert {u.variable: u.reads for u in m.updates}["e.d"] == {"e.c"}
    assert [[u.variable for u in stage] for stage in m.stages()] == [["e.c"], ["e.d"], ["e.b"], ["e.a"]]


def test_a_primed_call_orders_by_what_the_function_reads() -> None:
    m = model("visible a, b: C\ninit a = 0\ninit b = 0\na' = g()'\nb' = b", "fn g(): C = e.b")
    assert {u.variable: u.stage for u in m.updates} == {"e.a": 1, "e.b": 0}


def test_inits_run_visible_first_and_after_what_they_read() -> None:
    m = model(CHAIN + "  hidden h: C\n  init h = a\n  h' = h\n", "fn f(): C = e.b'")
    assert [i.variable for i in m.inits] == ["e.c", "e.b", "e.a", "e.d", "e.h"]


@pytest.mark.parametrize(
    ("update", "expected"),
    [
        ("if act == go then a else 0", "determined"),
        ("b'", "determined"),
        ("r'", "copied"),
        ("noisy(a, 0.5)", "copied"),
        ("if own then a else 0", "copied"),
        ("h", "weighed"),
        ("h'", "weighed"),
        ("noisy(h, 0.9)", "weighed"),
        ("if tied then a else 0", "weighed"),
        ("if told then a else 0", "weighed"),
    ],
)
def test_how_the_filter_takes_a_visible_variable(update: str, expected: str) -> None:
    m = model(
        f"""
  visible a, b, r: C
  hidden h: C
  visible fixed f: C
  init a = 0  init b = 0  init r = 0  init h ~ uniform(C)  init f = 1
  let own ~ bernoulli(0.5)
  let tied ~ bernoulli(0.5)
  let told ~ bernoulli(0.5)
  a' ~ {update}
  b' = if b == f then 0 else 1
  r' ~ uniform(C)
  h' = if tied then h else 0
  observe o: bool = told
"""
    )
    found = flags(m)
    assert found["a"] == expected
    assert (found["b"], found["r"], found["f"]) == ("determined", "copied", "determined")


def test_a_draw_shared_with_a_weighed_variable_ties_the_copied_one() -> None:
    m = model(
        """
  visible a, b: bool
  hidden h: bool
  init a = false  init b = false  init h = false
  let coin ~ bernoulli(0.5)
  a' = coin
  b' = coin != h
  h' = h
"""
    )
    assert flags(m) == {"a": "weighed", "b": "weighed"}


def test_the_key_has_observations_then_visible_variables_that_are_not_determined() -> None:
    m = model(
        "visible a: C\nvisible b: bool[C]\ninit a = 0\ninit b = [i in C: false]\na' = a\n"
        "b' ~ [i in C: bernoulli(0.5)]\nobserve o: C[A] ~ [x in A: uniform(C)]"
    )
    assert [(f.name, f.observed, f.length) for f in m.key] == [("e.o", True, 2), ("e.b", False, 3)]


def test_cycles_are_found_wherever_they_are() -> None:
    assert find_cycle({"a": ["b"], "b": ["c"], "c": []}) == []
    assert find_cycle({"a": ["b"], "b": ["c", "d"], "c": [], "d": ["b"]}) == ["b", "d"]
    assert find_cycle({"a": ["a"]}) == ["a"]


def test_draws_with_the_same_id_are_refused() -> None:
    class Colliding(ir.Site):
        id = 7

    span, report = Span("m", 1, 1, 1, 2), Report()
    check_sites([(Colliding("a"), span), (Colliding("b"), span)], report)
    assert [d.code for d in report.found] == ["E0807"]
