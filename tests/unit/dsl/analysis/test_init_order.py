# SPDX-License-Identifier: Apache-2.0
"""The order in which variables get their first values."""

import pytest

from hypgen.dsl import ir
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax import ast
from hypgen.dsl.syntax.parse import parse

TEXT = """model M
type Ghost = 0 .. 3
enum Side { left, middle, right }
enum Act { go }
action act: Act
discount 0.9
fn side_taken(s: Side, below: Ghost): bool = any(i in Ghost where i < below: ghost[i].side == s)
element ghost[i in Ghost] {
  hidden fixed side: Side
  hidden fixed size: 0 .. 9
  hidden fixed last: 0 .. 9
"""


def load(inits: str) -> ir.Model:
    source = Source("m.pomdp", TEXT + inits + "\n}\n")
    file = parse(source)
    assert isinstance(file, ast.ModelFile)
    return lower(file, {}, source)


def groups(side: str = "left", size: str = "0", last: str = "0") -> list[list[str]]:
    model = load(f"init side ~ {side} init size ~ {size} init last ~ {last}")
    return [[i.variable.removeprefix("ghost.") for i in g] for g in model.init_groups(visible=False)]


@pytest.mark.parametrize(
    "side",
    [
        "uniform(s in Side where all(j in Ghost where j < i: ghost[j].side != s) else left)",
        "uniform(s in Side where not any(j in Ghost: i > j and ghost[j].side == s) else left)",
        "uniform(s in Side where all(j in Ghost: j >= i or ghost[j].side != s) else left)",
        "uniform(s in Side where all(j in Ghost where not i <= j: ghost[j].side != s) else left)",
        "uniform(s in Side where not side_taken(s, i) else left)",
        "uniform(j in Ghost where j < i: ghost[j].side else right)",
        "if i > 0 then noisy(ghost[i - 1].side, 0.5) else middle",
        "if i > 1 then ghost[i - 2].side else right",
        "if count(j in Ghost where j < i and ghost[j].side == left) > 1 then left else right",
        "let k = i in if any(j in Ghost where j < k: ghost[j].side == left) then right else left",
    ],
)
def test_members_may_read_lower_ones(side: str) -> None:
    assert groups(side=side) == [["side"], ["size"], ["last"]]


@pytest.mark.parametrize(
    "side",
    [
        "if any(j in Ghost: ghost[j].side == left) then right else left",
        "if any(j in Ghost where j > i: ghost[j].side == left) then right else left",
        "if any(j in Ghost where j <= i: ghost[j].side == left) then right else left",
        "if any(j in Ghost: j < i or ghost[j].side == left) then right else left",
        "if any(j in Ghost: if j < i then true else ghost[j].side == left) then right else left",
        "if i < 3 then ghost[i + 1].side else left",
        "ghost[0].side",
        "uniform(s in Side where not side_taken(s, 3) else left)",
        "uniform(j in Ghost where j < i and ghost[3].side == left: ghost[j].side else right)",
    ],
)
def test_reads_of_members_that_may_come_later_are_refused(side: str) -> None:
    with pytest.raises(ModelError) as caught:
        groups(side=side)
    assert [d.code for d in caught.value.diagnostics] == ["E0412"]


def test_variables_that_read_each_others_lower_members_go_member_by_member() -> None:
    side = "if i > 0 and ghost[i - 1].last > 3 then left else right"
    found = groups(side=side, last="if side == left then size else 9", size="{3: 0.5, else 5}")
    assert found == [["size"], ["side", "last"]]


def test_a_member_that_reads_itself_in_a_circle_is_refused() -> None:
    with pytest.raises(ModelError) as caught:
        groups(size="if i > 0 then ghost[i - 1].last else last", last="size")
    assert [d.code for d in caught.value.diagnostics] == ["E0406"]


def test_two_families_that_read_each_other_are_refused() -> None:
    other = "\n}\nelement rock[i in Ghost] {\nhidden fixed y: 0 .. 9\ninit y = ghost[i].size"
    with pytest.raises(ModelError) as caught:
        load(f"init side = left init size = if i > 0 then rock[i - 1].y else 0 init last = 0{other}")
    assert [d.code for d in caught.value.diagnostics] == ["E0406"]


def test_visible_variables_come_first_unless_they_tell_of_hidden_ones() -> None:
    model = load(
        "init side = left init size = shown init last = 0 visible fixed shown: 0 .. 9 init shown = 3"
    )
    assert [i.variable for i in model.inits][0] == "ghost.shown"
    assert [[i.variable for i in g] for g in model.init_groups(visible=True)] == [["ghost.shown"]]
    assert model.first_seen == ()
    model = load(
        "init side = left init size = 4 init last = 0 observe shown: 0 .. 9 at start ~ noisy(size, 0.5)"
    )
    order = [i.variable for i in model.inits]
    assert order.index("ghost.shown") > order.index("ghost.size")
    assert [g[0].variable for g in model.init_groups(visible=True)] == order
    assert "ghost.shown" not in [g[0].variable for g in model.init_groups(visible=False)]
    assert [i.variable for i in model.first_seen] == ["ghost.shown"]


def test_members_are_placed_with_what_is_seen_of_them() -> None:
    model = load(
        "init side ~ if i > 0 and ghost[i - 1].seen then middle else left init size = 0 init last = 0 "
        "observe seen: bool at start ~ noisy(side == left, 0.8)"
    )
    groups = [[i.variable for i in g] for g in model.init_groups(visible=True)]
    assert ["ghost.side", "ghost.seen"] in groups or ["ghost.seen", "ghost.side"] in groups
    assert ["ghost.side"] in [[i.variable for i in g] for g in model.init_groups(visible=False)]


def test_an_observation_at_the_start_is_short_for_a_variable() -> None:
    inits = "init side ~ uniform(Side) init size = 0 init last = 0 "
    short = load(inits + "observe seen: Side at start ~ noisy(side, 0.8)")
    long = load(inits + "visible fixed seen: Side init seen ~ noisy(side, 0.8)")
    for model in (short, long):
        seen = model.variable("ghost.seen")
        assert seen.visible and seen.fixed and seen.informative and seen.determined
    assert [i.dist for i in short.inits] == [i.dist for i in long.inits]
    assert short.observations == () and short.key == long.key
