# SPDX-License-Identifier: Apache-2.0
"""Whatever a file holds, the answer is a model or diagnostics: random files, and some nasty ones.

1,000 files are random; ``pytest -m property tests/fuzz`` tries 10,000.

A failure names the seed and shows the text;
``PYTHONPATH=tests python tests/fuzz/long_run.py --seed N --cases 1`` repeats it.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, note, settings
from hypothesis import strategies as st
from support.fuzz_cases import Failure, case, check, small_case

SEEDS = st.integers(0, 2**64 - 1)
FAST = settings(
    derandomize=True,  # the same cases in every run, so that a failure is a change's own
    database=None,
    deadline=None,  # `check` measures the CPU's time, which other processes do not prolong
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


def answer(content: bytes, folder: Path) -> None:
    note(content.decode("utf-8", "replace"))
    check(content, folder)


FEW, MANY = 100, 1000


@pytest.fixture(params=[FEW, pytest.param(MANY, marks=pytest.mark.property)])
def count(request: pytest.FixtureRequest) -> int:
    """How often a test of this name is repeated; files that were valid once come four times as often."""
    number: int = request.param
    return number


def test_files_that_were_valid_once(tmp_path: Path, count: int) -> None:
    @settings(FAST, max_examples=4 * count)
    @given(SEEDS)
    def run(seed: int) -> None:
        answer(case(seed), tmp_path)

    run()


def test_short_files(tmp_path: Path, count: int) -> None:
    @settings(FAST, max_examples=4 * count)
    @given(SEEDS)
    def run(seed: int) -> None:
        answer(small_case(seed), tmp_path)

    run()


def test_bytes(tmp_path: Path, count: int) -> None:
    @settings(FAST, max_examples=count)
    @given(st.binary(max_size=300))
    def run(content: bytes) -> None:
        answer(content, tmp_path)

    run()


def test_text_after_a_good_start(tmp_path: Path, count: int) -> None:
    @settings(FAST, max_examples=count)
    @given(st.text(max_size=200))
    def run(text: str) -> None:
        answer(f"model M\ndiscount 0.9\nenum A {{ a, b }}\naction act: A\n{text}".encode(), tmp_path)

    run()


HEAD = "model M\ndiscount 0.9\nenum A { a, b }\naction act: A\n"
NASTY = {
    "parentheses": HEAD + "const x: int = " + "(" * 50_000 + "1" + ")" * 50_000,
    "open parentheses": HEAD + "const x: int = " + "(" * 50_000,
    "minus signs": HEAD + "const x: int = " + "-" * 50_000 + "1",
    "a long sum": HEAD + "const x: int = " + " + ".join(["1"] * 20_000),
    "powers": HEAD + "const x: int = 9 ** 9 ** 9 ** 9",
    "a float too large": HEAD + "const x: float = 1e400 * 1e400 - 1e400",
    "a number of many digits": HEAD + f"const x: int = {'9' * 100_000}",
    "a long name": HEAD + f"const {'x' * 1_000_000}: int = 1",
    "a long line": HEAD + "# " + "x" * 1_000_000 + "\nconst x: bool = 3",
    "nested ifs": HEAD + "const x: int = " + "if true then 1 else " * 5000 + "2",
    "types of types": HEAD
    + "record R0 { a: bool }\n"
    + "".join(f"record R{i + 1} {{ a: R{i}  b: R{i} }}\n" for i in range(60)),
    "a type of itself": HEAD + "record R { a: R }\nenum E { e(E) }\ntype T = T\n",
    "a function of itself": HEAD + "fn f(x: int): int = f(f(x))\nconst c: int = f(3)\n",
    "a chain of functions": HEAD
    + "".join(f"fn f{i + 1}(x: float): float = f{i}(x) + f{i}(x)\n" for i in range(40))
    + "fn f0(x: float): float = x\nconst c: float = f40(1.0)\n",
    "a huge array": HEAD + "type T = 0 .. 99999\nconst c: int[T, T] = [i in T, j in T: i]\n",
    "a huge type": HEAD + "type T = 0 .. 2147483646\nelement e { visible x: T  init x = 0  x' = x }\n",
    "a huge family": HEAD
    + "type T = 0 .. 1999999999\nelement e[t in T] { hidden x: T[T]  init x = [i in T: 0]  x' = x }\n",
    "many elements": HEAD
    + "".join(f"element e{i} {{ visible x: bool  init x = true  x' = not x }}\n" for i in range(300)),
    "many mistakes": HEAD + "".join(f"const c{i}: int = d{i}\n" for i in range(3000)),
}


# What the long runs found.
FOUND = {
    "an index of a record's field": HEAD
    + "record R { x: bool }\nelement e { visible r: R  init r = R(true)  r' = R(r.x[1]) }\n",
    "an index of a param's field": HEAD + "record R { x: bool }\nparam p: R = R(true)\nreward r = p.x[1]\n",
}


@pytest.mark.parametrize("name", FOUND)
def test_what_failed_once(name: str, tmp_path: Path) -> None:
    assert check(FOUND[name].encode(), tmp_path) == "E0303"


@pytest.mark.parametrize("name", NASTY)
def test_what_is_large_or_deep_is_refused_or_read(name: str, tmp_path: Path) -> None:
    check(NASTY[name].encode(), tmp_path)


def test_ten_megabytes(tmp_path: Path) -> None:
    text = HEAD + "const x: int = 1 # " + "y" * 100 + "\n"
    assert check(text.encode() * (10_000_000 // len(text)), tmp_path) != "fine"


def test_a_slow_or_wordless_answer_is_a_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("support.fuzz_cases.SECONDS", -1.0)
    with pytest.raises(Failure, match="s of CPU"):
        check(b"model M", tmp_path)
