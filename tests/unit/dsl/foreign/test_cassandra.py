# SPDX-License-Identifier: Apache-2.0
"""Cassandra's format: every form of it, against arrays filled by another way; and its mistakes."""

import itertools
import random
import time
from pathlib import Path

import numpy as np
import pytest
from support.foreign_laws import laws_of_cassandra, laws_of_text
from support.paths import ROOT

from hypgen.dsl.foreign import files, reader
from hypgen.dsl.foreign.cassandra import tables
from hypgen.dsl.foreign.tables.numbers import shown
from hypgen.dsl.format.formatter import format_source
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.source import Source

CORPUS = ROOT.parent / "shared" / "corpus" / "cassandra"
FILES = sorted(CORPUS.glob("*.pomdp"))
HEAD = (
    "discount: 0.9\nvalues: reward\nstates: left middle right\nactions: stay go\nobservations: dark light\n"
)
TABLES = "T: stay identity\nT: go uniform\nO: * uniform\n"
ROBOT = HEAD + TABLES
PAID = "R: go : * : * : * 1\n"


def imported(text: str | bytes, horizon: int | None = None) -> str:
    content = text if isinstance(text, bytes) else text.encode()
    return reader.import_text("robot.pomdp", content, None, horizon).text


def told(text: str | bytes) -> list[str]:
    with pytest.raises(ModelError) as error:
        imported(text)
    return [f"{d.code} {d.span.line if d.span else 0}: {d.message}" for d in error.value.diagnostics]


@pytest.mark.parametrize(
    "text",
    [
        ROBOT,
        ROBOT + "R: go : * : * : * 1\n",
        ROBOT + "R: go : left : right : light 2.5\nR: * : middle : * : * -1e-1\n",
        ROBOT + "R: go : left : right\n1 2\nR: stay : left\n1 2 3 4 5 6\n",
        ROBOT + "R: * : * : right : * 7\n",
        ROBOT + "R: * : * : * : light 7\nR: go : * : * : light 3\n",
        ROBOT + "T: go : left\n0.1 0.2 0.7\nT: go : left : left 0.2\nT: go : left : right .6",
        ROBOT + "T: * : right\nuniform\nO: go : left\n0.25 0.75\nO: stay\n1 0\n0 1\n0.5 0.5\n",
        ROBOT + "T: * : * : * 0\nT:0:0:1 1.0\nT:0:1:2 1\nT: 0: right :left : 1\nT:1:*:0 1\n",
        HEAD + "start: 0.5 0.25 0.25\n" + TABLES,
        HEAD + "start: uniform\n" + TABLES,
        HEAD + "start: middle\n" + TABLES,
        HEAD + "start: 2\n" + TABLES,
        HEAD + "start include: left 2\n" + TABLES,
        HEAD + "start exclude: left\n" + TABLES,
        (ROBOT + "R: go : * : * : * 1\n").replace("reward", "cost"),
        ROBOT.replace("left middle right", "3") + "R: go : 2 : * : * 1",
        ROBOT.replace("left middle right", "T R O"),
        ROBOT.replace("stay go", "reward if").replace("T: stay", "T: reward").replace("go", "if"),
        ROBOT.replace("\n", "\n\n  # comment: T: 1\n"),
        ROBOT.replace("\n", " ").replace(":", " :\n").replace("identity", "\nidentity"),
    ],
)
def test_every_form_is_read(text: str) -> None:
    laws_of_text(imported(text)).assert_close(laws_of_cassandra(text))


def test_line_ends_and_encodings_of_old_files_change_nothing() -> None:
    plain = imported(ROBOT)
    assert imported(ROBOT.replace("\n", "\r\n").encode()) == plain
    assert imported(b"\xef\xbb\xbf" + ROBOT.encode().rstrip()) == plain
    assert imported(b"# caf\xe9 by Andr\xe9\n" + ROBOT.encode()) == plain


def test_words_of_the_format_may_be_in_capitals() -> None:
    other = ROBOT.replace("discount", "Discount").replace("uniform", "Uniform").replace("T: go", "T: GO")
    assert imported(other) == imported(ROBOT)


def test_large_tables_are_lists_of_successors() -> None:
    count, chance = 40, random.Random(1)
    rows = [f"discount: 0.9\nstates: {count}\nactions: 2\nobservations: 12"]
    for kind, size in (("T: {a}", count), ("O: {a}", 12)):
        for a, s in itertools.product(range(2), range(count)):
            length = chance.choice((1, 1, 2, 3, 5, size - 1, size))
            values = chance.sample(range(size), length)
            numbers = ["0"] * size
            for value in values:
                numbers[value] = f"{1 / length:.7f}"
            rows.append(f"{kind.format(a=a)} : {s} {' '.join(numbers)}")
    rows.append("T: 1 : 5 uniform")
    rows += [f"R: 1 : {s} : * : * {s}" for s in range(count)]
    text = "\n".join(rows)
    written = imported(text)
    assert "if r == 0 then uniform(State)" in written and "else if r < " in written
    assert "weighted(" in written and "const state_chance: prob[StateEntry] = [" in written
    laws_of_text(written).assert_close(laws_of_cassandra(text))
    assert format_source(Source("robot.pomdp", written)) == written


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (ROBOT + "T: go : lft : left 1", ["E0902 9: there is no state called 'lft'"]),
        (ROBOT + "T: go : 3 : left 1", ["E0902 9: there is no state 3: they are numbered 0 to 2"]),
        (ROBOT + "R: go : left :", ["E0901 9: a state is expected, but the file ends"]),
        (ROBOT + "T: go : left\n1 0", ["E0903 10: a row of T takes 3 numbers, but the file ends after 2"]),
        (ROBOT + "T: go : left\n1 0\nO: * uniform",
         ["E0903 10: a row of T takes 3 numbers, but the next specification starts after 2"]),
        (ROBOT + "T: go : left\n1 x 0", ["E0901 10: number 2 of a row of T is expected, but found 'x'"]),
        (ROBOT + "T: go : left\n1 0 0 0",
         ["E0903 10: here is a number too many: a row of T takes 3 numbers"]),
        (ROBOT + "T: go : left : left 0.5",
         ["E0904 9: the probabilities of row T : go : left sum to 1.16667"]),
        (ROBOT + "T: go : left : left nan", ["E0901 9: a probability is expected, but found 'nan'"]),
        (ROBOT + "T: go : left : left 1e999", ["E0901 9: a probability is expected, but found '1e999'"]),
        (ROBOT + "T: go : left : left -1", ["E0906 9: -1 is no probability"]),
        (HEAD + "T: stay identity\nT: go\nreset\nO: * uniform",
         ["E0901 8: 'reset' stands for a row, not for a whole matrix"]),
        (ROBOT + "T: go : left : * 0", ["E0904 9: the probabilities of row T : go : left sum to 0"]),
        (ROBOT + "T: go : * 0.5 0.5 0.5",
         ["E0904 9: the probabilities of row T : go : left sum to 1.5, "
          "and so do those of 2 more rows written here"]),
        (ROBOT + "O: go : * 0.9 0.0997\nT: stay : left 0.5 0.2 0.301",
         ["E0904 10: the probabilities of row T : stay : left sum to 1.001, "
          "and 3 more rows are off 1 by at most 0.01"]),
        (ROBOT.replace("discount: 0.9\n", "") + PAID,
         ["E0908 1: no discount is given, which counts as 1, and from some state no action ever leads to "
          "an end: values are sums without end"]),
        (HEAD + "T: stay identity\nO: * uniform",
         ["E0905 6: 3 rows have no probabilities: T : go : left, T : go : middle, T : go : right"]),
        (HEAD + "start: 0.5 0.5\n" + TABLES,
         ["E0903 6: 'start' takes 3 numbers, one for each state, but 2 are given"]),
        (HEAD + "start: 0.5 0.5 0.5\n" + TABLES, ["E0904 6: the probabilities of the start sum to 1.5"]),
        (ROBOT.replace("0.9", "1.5"), ["E0908 1: the discount is 1.5"]),
        (ROBOT.replace("0.9", "1") + PAID,
         ["E0908 1: the discount is 1, and from some state no action ever leads to an end: "
          "values are sums without end"]),
        (ROBOT.replace("states: left middle right", ""), ["E0907 6: the states are not declared"]),
        (ROBOT.replace("left middle", "left, middle"),
         ["E0901 3: a name of the states is expected, but found 'left,'"]),
        (ROBOT.replace("left middle", "left,middle"),
         ["E0901 3: a name of the states is expected, but found 'left,middle'"]),
        (ROBOT.replace("left middle", "left left"), ["E0907 3: the state 'left' is declared twice"]),
        (ROBOT.replace("left middle right", "200000"),
         ["E0912 3: there are 200000 states, and 1 to 100000 can be imported"]),
        (ROBOT + "T: go : lft : left 1\nO: * : * : grey 1\nR: fly : * : * : * 1",
         ["E0902 9: there is no state called 'lft'", "E0902 10: there is no observation called 'grey'",
          "E0902 11: there is no action called 'fly'"]),
    ],
)  # fmt: skip
def test_mistakes_are_told_where_they_are(text: str, expected: list[str]) -> None:
    assert told(text) == expected


@pytest.mark.parametrize(
    ("old", "new", "remedy"),
    [
        ("values: reward", "values: profit", "write `values: reward` or `values: cost`"),
        ("discount: 0.9", "discount: 90%", "write a number from 0 to 1, such as 0.95"),
        ("T: stay identity", "T: stay identiy", "did you mean 'identity'?"),
        ("T: stay identity", "T: stay\n1 0 0\n0 one 0", "write a number, such as 0.25"),
        ("T: stay identity", "R: stay : left 1\nT: stay identity",
         "give the numbers that are missing; one reward is written "
         "`R : action : state : next state : observation number`"),
        ("T: stay identity", "T: stay identity 1", 
         "a specification starts with T, O, R or a word as `discount:`, a comment with #"),
    ],
)  # fmt: skip
def test_remedies_fit_the_place(old: str, new: str, remedy: str) -> None:
    with pytest.raises(ModelError) as error:
        imported(ROBOT.replace(old, new))
    assert error.value.diagnostics[0].remedy == remedy


def places(text: str) -> list[tuple[str, int, int]]:
    with pytest.raises(ModelError) as error:
        imported(text)
    return [(d.message, d.span.line, d.span.column) for d in error.value.diagnostics if d.span]


def test_carets_are_at_the_numbers_that_are_wrong() -> None:
    assert places(ROBOT + "T: go : left\n1.2 0 -0.2") == [
        ("1.2 is no probability", 10, 1),
        ("-0.2 is no probability", 10, 7),
    ]
    assert places(HEAD + "start: 0.5 -0.5 1\n" + TABLES) == [("a probability of the start is -0.5", 6, 12)]
    text = "# the discount is 1\n" + ROBOT.replace("0.9", "1") + PAID
    assert [(line, column) for _, line, column in places(text)] == [(2, 11)]


def test_a_reward_on_observations_needs_observations() -> None:
    text = "discount: 0.9\nstates: a b\nactions: go\nT: go uniform\nR: go : a : b : {} 1\n"
    message = "R takes an action, a state and a next state here, as the file declares no observations"
    for observation in ("*", "0", "seen"):
        assert places(text.format(observation)) == [(message, 5, 17)]
    imported(text.replace("{} 1", "1"))


def test_rounded_rows_are_told_once_and_scaled_when_told_to() -> None:
    rounded = " ".join(["0.0769"] * 13)
    head = HEAD.replace("observations: dark light", "observations: 13")
    text = f"{head}T: stay identity\nT: go uniform\nO: * : *\n{rounded}\nR: go : left : * : * 1\n"
    with pytest.raises(ModelError) as error:
        imported(text)
    (mistake,) = error.value.diagnostics
    assert "`hypgen import robot.pomdp --normalise` scales them" in mistake.remedy
    scaled = reader.import_text("robot.pomdp", text.encode(), None, None, 0.001)
    assert scaled.model.notes == ("6 rows are scaled to sum to 1.",)
    assert "observe seen: Observation ~ uniform(Observation)" in scaled.text


def test_numbers_are_the_shortest_that_stay_the_same() -> None:
    chance = random.Random(0)
    numbers = [chance.random() * 10.0 ** chance.randrange(-12, 12) for _ in range(5000)]
    for number in [*numbers, 0.0, -2.5, 1e-45, 3e38, 0.1 + 2**-29]:
        assert np.float32(numbers_text := shown(number)) == np.float32(number), numbers_text
    assert [shown(x) for x in (0.85, 1 / 3, 100.0, 1e-7, -0.5, 2e10)] == [
        "0.85", "0.33333334", "100", "1e-7", "-0.5", "2e10"
    ]  # fmt: skip


def test_a_discount_of_1_needs_a_horizon_and_one_of_0_is_one() -> None:
    assert "discount 1\nhorizon 20\n" in imported(ROBOT.replace("0.9", "1.0"), horizon=20)
    assert "discount 1\nhorizon 1\n" in imported(ROBOT.replace("0.9", "0"))


GOAL = """discount: 1
values: cost
states: far near goal
actions: slow fast
observations: dark light
start: far
T: slow
{slow}
0 0 1
T: fast
{fast}
0 0 1
O: * uniform
R: slow : far : * : * 1
R: slow : near : * : * {near}
R: fast : far : * : * 2
R: fast : near : * : * 2
"""


def test_a_goal_that_is_free_needs_no_horizon() -> None:
    text = imported(GOAL.format(slow="0.5 0.5 0\n0 0.5 0.5", fast="0.2 0.5 0.3\n0.3 0 0.7", near=1))
    assert "discount 1\naction" in text and "terminal when system.state' == goal" in text
    assert "bound upper = 4e-6\nbound tail = -4.000004\n" in text
    assert "the best from the start: -4.\npolicy default = slow" in text
    laws_of_text(text)


@pytest.mark.parametrize(
    ("slow", "fast", "near", "reason"),
    [
        ("0.5 0.5 0\n0 1 0", "0.2 0.5 0.3\n0.3 0 0.7", 0,
         "a policy that never ends costs nothing in the long run"),
        ("0.5 0.5 0\n0 1 0", "0 1 0\n1 0 0", 1, "from some state no action ever leads to an end"),
    ],
)  # fmt: skip
def test_a_discount_of_1_is_refused_with_the_reason(slow: str, fast: str, near: int, reason: str) -> None:
    told_ = told(GOAL.format(slow=slow, fast=fast, near=near))
    assert told_ == [f"E0908 1: the discount is 1, and {reason}: values are sums without end"]


def test_where_no_fixed_action_ends_the_default_policy_is_uniform() -> None:
    text = imported(GOAL.format(slow="0 1 0\n0 1 0", fast="1 0 0\n0 0 1", near=1))
    assert "bound tail = -6.000006" in text and "policy default" not in text


def test_discounts_near_1_stay_what_they_are() -> None:
    for discount in ("0.99999", "0.99999999", "0.9999999999"):
        assert f"\ndiscount {discount}\n" in imported(ROBOT.replace("0.9", discount))


def test_the_default_policy_is_the_best_at_a_discount_near_1() -> None:
    rows = "\n".join(" ".join("0.033333333" for _ in range(30)) for _ in range(30))
    head = "discount: {}\nvalues: cost\nstates: 30\nactions: hold stir\nobservations: 2\nstart: 0\n"
    text = f"{head}T: hold\nidentity\nT: stir\n{rows}\nO: * uniform\nR: hold : * : * : * {{}}\n"
    for discount, hold, best in (("0.99999", 1, "hold"), ("0.9999999", 1, "hold"), ("0.99999", 1.4, "stir")):
        filled = text.format(discount, hold) + "R: stir : * : * : * 1.2\n"
        assert f"policy default = {best}" in imported(filled)
        assert f"policy default = {best}" in imported(
            filled.replace(" 1.2", " 1.2e-7").replace(f" {hold}\nR", f" {hold}e-7\nR")
        )
    assert "from the start: -1e+05." in imported(text.format("0.99999", 1) + "R: stir : * : * : * 1.2\n")


def test_a_file_without_observations_has_visible_states() -> None:
    text = imported("discount: 0.9\nstates: 2\nactions: 2\nT: * uniform\nR: 0 : 1 : * 2\n")
    assert "visible state: State" in text and "observe" not in text
    laws_of_text(text)


def test_an_end_without_rewards_is_terminal() -> None:
    text = imported(ROBOT + "T: * : right : * 0\nT: * : right : right 1\nR: * : left : * : * 1\n")
    assert "terminal when system.state' == right" in text
    laws_of_text(text)


def test_what_is_too_large_is_refused_before_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "large.pomdp"
    path.write_bytes(ROBOT.encode() + b" " * 100_000)
    with path.open("r+b") as stream:
        stream.truncate(100_000_000)
    start = time.process_time()
    with pytest.raises(ModelError, match="larger than 32 MB"):
        files.read(path)
    assert time.process_time() - start < 1


def test_very_many_names_become_numbers() -> None:
    names = " ".join(f"s{n}" for n in range(10_001))
    text = f"discount: 0.9\nstates: {names}\nactions: 1\nobservations: 1\nT: * identity\nO: * uniform\n"
    assert "type State = 0 .. 10000\n" in imported(text + "R: 0 : s7 : * : * 1\n")


def test_work_without_end_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "MAX_WRITTEN", 10_000)
    lines = "T: * : * : 1 0.5\n" * 50
    text = f"discount: 0.9\nstates: 500\nactions: 2\nobservations: 1\n{lines}"
    assert [t[:5] for t in told(text)] == ["E0912"]
    assert [t[:5] for t in told(text.replace("actions: 2", "actions: 20000"))] == ["E0912"]


def test_broken_files_give_diagnostics_and_nothing_else() -> None:
    chance = random.Random(0)
    words = [
        "T",
        ":",
        "*",
        "0",
        "1e9",
        "uniform",
        "identity",
        "reset",
        "start:",
        "include",
        "-",
        "#",
        "states: 2",
    ]
    text = ROBOT + "R: go : left : right : light 2.5\nT: go : left\n0.1 0.2 0.7\n"
    for _ in range(400):
        pieces = text.split(" ")
        for _ in range(chance.randrange(1, 4)):
            at = chance.randrange(len(pieces))
            pieces[at : at + chance.randrange(3)] = chance.sample(words, chance.randrange(3))
        broken = " ".join(pieces)[: chance.randrange(len(text) + 40)]
        try:
            imported("discount: 0.9\n" + broken)
        except ModelError as error:
            assert all(d.code.startswith("E09") for d in error.diagnostics)


@pytest.mark.skipif(not FILES, reason="the corpus is not beside the checkout")
@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_files_of_others_are_read(path: Path) -> None:
    horizon = 40 if path.stem == "test05" else None
    text = path.read_text(encoding="latin-1")
    laws_of_text(imported(text, horizon)).assert_close(laws_of_cassandra(text), tolerance=2e-5)


def test_rare_outcomes_keep_their_numbers() -> None:
    """What the others leave is the likeliest's, whatever the order of values."""
    text = imported(
        ROBOT + "T: go : left\n1e-15 0.3 0.699999999999999\nT: go : middle\n0.9999999999 0 1e-10\n"
    )
    assert "{ left: 1e-15, middle: 0.3, else right }" in text
    assert "{ right: 1e-10, else left }" in text
    states = " ".join(f"s{i}" for i in range(40))
    head = f"discount: 0.9\nvalues: reward\nstates: {states}\nactions: a\nobservations: o\nO: * uniform\n"
    rows = "".join(f"T: a : s{i} : s{i} 0.99999999999\nT: a : s{i} : s{39 - i} 1e-11\n" for i in range(40))
    table = imported(head + rows)
    assert "0.99999999999 1e-11 0.99999999999 1e-11" in table
