# SPDX-License-Identifier: Apache-2.0
"""Warnings: what is told of models that are right and yet doubtful."""

import json
from pathlib import Path

import pytest

from hypgen.cli import main
from hypgen.dsl import load

BASE = """model M
enum Act { wait, go }
action act: Act
discount 0.9
type Cell = 0 .. 3
"""
ROOM = """
element room {
  hidden x: Cell
  let slip ~ bernoulli(0.5)
  init x ~ uniform(Cell)
  x' = if slip then x else clamp(x + 1)
  %s
}
observe seen: Cell ~ noisy(room.x', 0.9)
reward effort = if act == go then -1 else 0
%s
"""


def warned(tmp_path: Path, top: str = "", member: str = "", bottom: str = "", **files: str) -> list[str]:
    for name, text in files.items():
        (tmp_path / f"{name}.pomdp").write_text(text)
    path = tmp_path / "m.pomdp"
    path.write_text(BASE + top + ROOM % (member, bottom))
    return [f"{w.code} {w.message}" for w in load.load(path).warnings]


def test_a_model_without_doubts(tmp_path: Path) -> None:
    assert warned(tmp_path) == []


@pytest.mark.parametrize(
    ("top", "name"),
    [
        ("const n: int = 3", "'n' is a const that nothing uses"),
        ("param p: prob = 0.5", "'p' is a param that nothing reads"),
        ("type T = 0 .. 1", "'T' is a type that nothing uses"),
        ("enum Door { left, right }", "'Door' is an enum that nothing uses"),
        ("record Pos { row: Cell }", "'Pos' is a record that nothing uses"),
        ("fn f(unread: Cell): int = 1", "'f' is a function that nothing uses"),
    ],
)
def test_names_that_nothing_uses(top: str, name: str, tmp_path: Path) -> None:
    assert warned(tmp_path, top) == [f"W01 {name}"]


def test_variables_and_lets_that_nothing_reads(tmp_path: Path) -> None:
    member = "hidden y: Cell init y = 0 y' = y let unread = x visible clock: Cell init clock = 0 clock' = 0"
    assert warned(tmp_path, member=member) == [
        "W01 'room.y' is a variable that nothing reads",
        "W01 'room.unread' is a let that nothing reads",
    ]


def test_memory_and_lets_of_the_policy_that_nothing_reads(tmp_path: Path) -> None:
    members = "memory n: Cell = 0 memory last_n: Cell = 1 n' = clamp(n + 1) last_n' = n let odd = n % 2"
    policy = "policy default { %s choose = %s }"
    assert warned(tmp_path, bottom=policy % (members, "if n > 2 then go else wait")) == [
        "W01 'last_n' is memory that nothing reads",
        "W01 'odd' is a let that nothing reads",
    ]
    assert warned(tmp_path, bottom=policy % (members, "if odd == 1 and last_n == 0 then go else wait")) == []


def test_uses_of_every_kind_count(tmp_path: Path) -> None:
    top = """const n: int = 2
type Row = 0 .. n
enum Door { left, right }
enum Side { near, far }
record Pos { row: Row  side: Side }
fn here(p: Pos): bool = p.row == 0
"""
    bottom = """reward r = (match pick(room.x) { left => 1 right => 0 })
reward s = if here(Pos(0, far)) and act == go then 1 else 0
fn pick(c: Cell): Door = if c == 0 then Door.left else right
reward q = if room.z then 1 else 0
"""
    member = "hidden fixed z: bool init z = true"
    assert warned(tmp_path, top, member, bottom) == []


def test_a_librarys_names_may_be_unused(tmp_path: Path) -> None:
    assert warned(tmp_path, 'import "lib.pomdp"', lib="library L const n: int = 3") == []


def test_rewards_that_change_no_choice(tmp_path: Path) -> None:
    bottom = """fn worth(c: Cell): int = c * price
param price: 0 .. 9 = 2
reward step = -1
reward dear = worth(3)
reward here = worth(room.x)
"""
    assert warned(tmp_path, bottom=bottom) == [
        "W05 'step' is the same whatever is done, and nothing ends an episode early",
        "W05 'dear' is the same whatever is done, and nothing ends an episode early",
    ]
    assert warned(tmp_path, bottom=bottom + "terminal when room.x' == 3") == []


def test_floats_tested_for_equality(tmp_path: Path) -> None:
    bottom = "reward r = if act == go or p == 0.5 then 1 else 0"
    found = warned(tmp_path, "param p: float = 0.25", bottom=bottom)
    assert found == ["W02 floats are tested for equality, which rounding decides"]
    assert warned(tmp_path, "const p: float = 0.25", bottom=bottom) == []


@pytest.mark.parametrize(
    ("declared", "kept"),
    [
        ("param p: prob = 0.9999999999", ["1"]),
        ("fn q(c: Cell): prob = if c == 1 then 0.99999999999 else 0.5", ["1"]),
        ("const row: prob[Cell] = [c in Cell: if c == 1 then 0.9999999999 else 0.5]", ["1"]),
        ("fn d(): bool ~ { true: 1e-18, else false }", ["9.76e-19"]),
        ("fn d(): bool ~ bernoulli(0.9999999999)", []),
        ("const p: prob = 0.9999999999", []),
        ("param p: prob = 1e-15", []),
        ("param p: float = 0.9999999999", []),
    ],
)
def test_probabilities_that_rounding_loses(declared: str, kept: list[str], tmp_path: Path) -> None:
    found = [f for f in warned(tmp_path, declared) if f.startswith("W06")]
    assert [f.split("is kept as ")[1].split(",")[0] for f in found] == kept


@pytest.mark.parametrize(
    "shown", ["room.slip", "slipped()", "room.copy", "if act == go then room.slip else true"]
)
def test_observations_that_show_a_draw(shown: str, tmp_path: Path) -> None:
    bottom = f"""fn slipped(): bool = not room.slip
observe felt: bool = {shown}
reward r = if slipped() then 1 else 0"""
    found = warned(
        tmp_path, member="let copy = slip", bottom=f"{bottom}\nreward q = if room.copy then 1 else 0"
    )
    assert [f[:3] for f in found] == ["W03"]
    assert "'felt' shows the draw 'room.slip' as it is" in found[0]


@pytest.mark.parametrize(
    "shown", ["noisy(room.slip, 0.9)", "if room.slip then bernoulli(0.2) else bernoulli(0.5)"]
)
def test_noise_hides_a_draw(shown: str, tmp_path: Path) -> None:
    assert warned(tmp_path, bottom=f"observe felt: bool ~ {shown}") == []


def test_a_model_without_rewards(tmp_path: Path) -> None:
    path = tmp_path / "m.pomdp"
    path.write_text("# nothing yet\n" + BASE)
    (first, *_) = load.load(path).warnings
    assert (first.code, first.span and (first.span.line, first.span.end_column)) == ("W11", (2, 8))


def test_check_prints_warnings_and_counts_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    warned(tmp_path, "const n: int = 3\nconst k: int = 4\n")
    path = str(tmp_path / "m.pomdp")
    assert main.run(["check", path]) == 0
    printed = capsys.readouterr()
    assert printed.out.endswith("; 2 warnings\n")
    assert f"warning[W01]: 'n' is a const that nothing uses\n --> {path}:6:1" in printed.err
    assert main.run(["check", path, "--strict"]) == 1
    capsys.readouterr()
    assert main.run(["check", path, "--json"]) == 0
    assert [d["severity"] for d in json.loads(capsys.readouterr().out)["diagnostics"]] == ["warning"] * 2


def test_compile_prints_a_line_for_each(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    warned(tmp_path, "const n: int = 3\n")
    path = str(tmp_path / "m.pomdp")
    assert main.run(["compile", path, "--emit-only", "-o", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().err == f"{path}:6:1: warning[W01]: 'n' is a const that nothing uses\n"


MOVES = """hidden at: Cell
  init at ~ uniform(Cell)
  at' = %s"""


@pytest.mark.parametrize(
    ("moves", "shown", "is_told"),
    [
        ("wrap(at + 1)", "noisy(room.at, 0.9)", True),
        ("wrap(at + 1)", "noisy(if act == go then room.at' else room.at, 0.9)", False),
        ("wrap(at + 1)", "noisy(ahead(), 0.9)", True),
        ("if act == go then 0 else at", "noisy(room.at, 0.9)", False),  # what act == go spoils is seen before
        ("wrap(at + 1)", "noisy(room.before, 0.9)", False),  # a let is of the state before on purpose
    ],
)
def test_observations_of_the_state_before_the_step(
    moves: str, shown: str, is_told: bool, tmp_path: Path
) -> None:
    bottom = f"""fn ahead(): Cell = if room.at == 3 then 0 else room.at
observe felt: Cell ~ {shown}
reward r = ahead() + room.before"""
    found = warned(tmp_path, member=MOVES % moves + "\n  let before = at", bottom=bottom)
    told = "W07 'felt' shows the state before the step: it reads 'room.at', which the step changes"
    assert found == [told] * is_told


@pytest.mark.parametrize(
    ("bound", "why"),
    [
        ("log(p - p)", "'log' of 0 is not finite"),
        ("1e38 * (1e3 * p)", "'*' of 1e+38 and 250 is not finite"),
        ("sqrt(p - 1)", "'sqrt' of -0.75 is not finite"),
        ("2 + (if p > 1 then 1 else 1 / (p - p))", "'/' of 1 and 0 is not finite"),
        ("if room.x == 0 then log(p - 1) else 1", ""),
        ("log(p) / room.x", ""),
    ],
)
def test_bounds_that_are_never_finite(bound: str, why: str, tmp_path: Path) -> None:
    found = warned(
        tmp_path,
        "param p: float = 0.25\n",
        bottom=f"bound upper = {bound}\nreward r = if room.x == 0 and p > 0 then 1 else 0",
    )
    assert found == ([f"W08 bound upper is no finite number: {why}"] if why else [])


@pytest.mark.parametrize(
    ("part", "why"),
    [
        ("log(p - p)", "'log' of 0 is not finite"),
        ("(if act == wait then sqrt(p - 1) else 1)", "'sqrt' of -0.75 is not finite"),
        ("(if p > 1 then log(p - 1) else 1)", ""),
        ("log(p)", ""),
    ],
)
def test_rewards_without_a_value_at_the_defaults(part: str, why: str, tmp_path: Path) -> None:
    bottom = f"bound upper = 1\nbound tail = 0\nreward r = if room.x == 0 then {part} else 0"
    found = warned(tmp_path, "param p: float = 0.25\n", bottom=bottom)
    told = f"W08 reward 'r' is no finite number with the defaults of params: {why}"
    assert found == [told] * bool(why)
