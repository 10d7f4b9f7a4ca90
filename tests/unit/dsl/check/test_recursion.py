# SPDX-License-Identifier: Apache-2.0
"""Recursive functions, unrolled for the ints that are constant."""

from hypgen.dsl import ir
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.parse import parse

TEXT = """model M
type Cell = 0 .. 9
enum Act { go }
action act: Act
discount 0.9
fn power(x: Cell, n: 0 .. 4): int = if n == 0 then 1 else x * power(x, n - 1)
fn fib(n: 0 .. 20): int = if n < 2 then n else fib(n - 1) + fib(n - 2)
fn even(n: int): bool = n == 0 or odd(n - 1)
fn odd(n: int): bool = n != 0 and even(n - 1)
fn scaled(x: int, n: int): int = if n == 0 then x else scaled(2 * x, n - 1)
element robot { hidden x: Cell  init x = 0  x' = x }
"""


def load(text: str) -> ir.Model:
    source = Source("m.pomdp", TEXT + text)
    file = parse(source)
    assert isinstance(file, ast.ModelFile)
    return lower(file, {}, source)


def names(model: ir.Model) -> list[str]:
    return [f.name for f in model.functions]


def test_a_call_becomes_a_call_of_a_copy_without_the_constant() -> None:
    model = load("reward r = power(robot.x, 3)")
    assert names(model) == ["power_n0", "power_n1", "power_n2", "power_n3"]
    assert all([b.name for b in f.formals] == ["x"] for f in model.functions)
    (reward,) = model.rewards
    assert isinstance(reward.value, ir.Call) and reward.value.function == "power_n3"
    assert str(reward.value.type) == "0 .. 729"


def test_copies_are_shared() -> None:
    assert len(names(load("reward r = fib(12) + fib(10)"))) == 13


def test_functions_may_call_each_other() -> None:
    model = load("reward r = if even(3) then 1 else 0")
    assert names(model) == ["odd_n0", "even_n1", "odd_n2", "even_n3"]


def test_constants_take_the_values_of_recursive_functions() -> None:
    model = load(
        "const t: int[Cell] = [c in Cell: fib(c)]\nconst f: int = fib(10)\nreward r = t[robot.x] + f"
    )
    assert model.tables[0].values == (0, 1, 1, 2, 3, 5, 8, 13, 21, 34)


def test_the_ranges_of_ints_are_proven_for_each_call() -> None:
    (reward,) = load("reward r = scaled(robot.x, 4)").rewards
    assert str(reward.value.type) == "0 .. 144"


def test_a_recursive_function_that_nothing_calls_is_left_out() -> None:
    assert names(load("")) == []


def test_reads_of_state_go_through_copies() -> None:
    model = load(
        "fn here(n: 0 .. 3): Cell = if n == 0 then robot.x else here(n - 1)\nterminal when here(2)' == 9"
    )
    assert model.terminal != model.legal
    assert "here_n0" in names(model)
