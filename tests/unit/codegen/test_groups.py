# SPDX-License-Identifier: Apache-2.0
"""Groups of reward terms: what each depends on, how they grow, and what forbids them."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.paths import EXAMPLES

from hypgen.codegen.bounds.groups import Relaxation, grow, strides
from hypgen.codegen.bounds.relaxation import relax
from hypgen.codegen.layout import limits
from hypgen.codegen.passes.read_sets import Reader, alike
from hypgen.dsl import ir
from hypgen.dsl.load import load

HEAD = """model M
type R = 1 .. 6
enum Act { stay, take(R), look }
discount 0.9
action act: Act
"""


def example(name: str) -> ir.Model:
    return load(EXAMPLES / f"{name}.pomdp").model


def written(text: str, tmp_path: Path) -> ir.Model:
    (tmp_path / "m.pomdp").write_text(HEAD + text)
    return load(tmp_path / "m.pomdp").model


def known(relaxation: Relaxation) -> list[list[tuple[str, tuple[int, ...]]]]:
    return [[(part.variable.name, part.members) for part in group.parts] for group in relaxation.groups]


def test_a_whole_state_that_fits_is_one_group() -> None:
    found = relax(example("rs_11_11"))
    assert known(found) == [[("rock.good", ()), ("rover.x", ()), ("rover.y", ())]]
    assert (found.groups[0].states, found.exact) == (12 * 11 * 2**11, True)


def test_a_table_holds_a_declared_bound_that_is_less() -> None:
    assert relax(example("tag")).declared
    assert not relax(example("rock_sample")).declared  # there is none


def test_what_a_policy_without_a_history_earns_is_known(tmp_path: Path) -> None:
    assert relax(example("tiger")).earned
    assert not relax(example("tiger_memory")).earned
    assert not relax(example("tag")).earned  # it draws by what it remembers
    assert relax(written(FLAGS, tmp_path)).earned
    assert not relax(written(FLAGS + "bound lower = 0\n", tmp_path)).earned
    assert not relax(
        written(
            FLAGS.replace("default = stay", "default = if wind.calm then stay else look")
            + """
element wind {
  visible calm: bool
  init calm = true
  calm' ~ noisy(calm, 0.9)
}
""",
            tmp_path,
        )
    ).earned  # it reads what no reward depends on


def test_only_what_matters_is_known() -> None:
    assert known(relax(example("tag"))) == [[("robot.cell", ()), ("opponent.cell", ())]]


def test_actions_that_do_alike_are_one() -> None:
    found = relax(example("rock_sample")).groups[0]
    assert found.actions == (0, 1, 2, 3, 4, 5)  # any check stands for all


def test_joint_actions_that_do_alike_are_one(monkeypatch: pytest.MonkeyPatch) -> None:
    two_robots = example("two_robot_rock_sample")
    assert "would take more than" in grow(two_robots).reason
    monkeypatch.setattr(limits, "MAX_UNDECLARED_WORK", 1 << 28)
    found = grow(two_robots)
    assert [len(group.actions) for group in found.groups] == [36] * 20
    assert known(found)[3] == [("bot.x", ()), ("bot.y", ()), ("rock.good", (3,))]


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("crowd_driving", "the reward 'car.slow' depends on 'ped.y', whose values are not finitely many"),
        ("light_dark", "the reward 'outcome' depends on 'robot.at.y', whose values are not finitely many"),
        ("navigation", "the reward 'step' depends on more than 524288 joint values of the state"),
    ],
)
def test_what_forbids_groups(name: str, reason: str) -> None:
    assert relax(example(name)) == Relaxation(reason=reason)


FLAGS = """
element flag[r in R] {
  hidden on: bool
  init on ~ bernoulli(0.5)
  on' = on and act != take(r)
  reward taken = if act == take(r) and on then 1 else 0
}
observe seen: bool ~ noisy(flag[2].on, 0.8)
policy default = stay
"""


def test_groups_grow_while_their_tables_fit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model = written(FLAGS, tmp_path)
    assert known(relax(model)) == [[("flag.on", ())]]
    monkeypatch.setattr(limits, "MAX_GROUP_ENTRIES", 16)
    found = relax(model)
    assert known(found) == [[("flag.on", (0, 1, 2, 3))], [("flag.on", (4, 5))]]
    assert [group.states for group in found.groups] == [16, 4]
    assert found.groups[1].actions == (0, 5, 6)  # all other flags are as good as staying


def test_a_read_through_an_unknown_index_is_of_every_member(tmp_path: Path) -> None:
    text = FLAGS.replace("act != take(r)", "(match act { take(q) => not flag[q].on  else => true })")
    reads = Reader(written(text, tmp_path))
    update = next(u for u in reads.model.updates if u.variable == "flag.on")
    assert reads.of(update.dist, {"r": 3}).entries == {("flag.on", m) for m in range(6)}


def test_draws_and_continuous_laws(tmp_path: Path) -> None:
    text = FLAGS.replace("on' = on and", "let noise ~ normal(0.0, 1.0)\n  on' = noise > 0.0 and on and")
    assert relax(written(text, tmp_path)).reason == (
        "a member's reward 'flag.taken' depends on a draw from a continuous law"
    )


def test_actions_are_told_apart_by_what_is_asked(tmp_path: Path) -> None:
    action = written(FLAGS, tmp_path).action
    assert alike(action, set()) == (0,)
    assert alike(action, {("is", "", 7)}) == (0, 7)
    assert alike(action, {("variant", "take", 0)}) == (0, 1)
    assert alike(action, {("argument", "take", 0)}) == (0, 1, 2, 3, 4, 5, 6)
    assert alike(action, {("argument is", "take", 3)}) == (0, 1, 3)
    assert len(alike(action, {("any", "", 0)})) == 8


# Agents that act apart -------------------------------------------------------------------------------

TEAM = """model M
type Bot = 0 .. 1
type R = 0 .. 3
enum Act { grab, left, right, kick }
discount 0.9
action act: Act[Bot]
fn takes(b: Bot, r: R): bool = act[b] == grab and bot[b].x == r
fn finds(b: Bot, r: R): bool = tok[r].on and not any(c in Bot where c < b: takes(c, r))
element bot[b in Bot] {
  visible x: R
  init x = 3 * b
  x' = match act[b] { left => clamp(x - 1)  right => clamp(x + 1)  else => x }
  reward moved = if x' != x then -1 else 0
}
element tok[r in R] {
  hidden on: bool
  init on ~ bernoulli(0.5)
  on' = on and not any(b in Bot: takes(b, r))
  reward gain = sum(b in Bot where takes(b, r): if finds(b, r) then 5 else -1)
}
observe seen: bool ~ noisy(tok[0].on, 0.8)
policy default = [b in Bot: left]
"""


def team(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *changes: str) -> Relaxation:
    """Return what bounds the model above with texts of it replaced, too large for one table of all."""
    monkeypatch.setattr(limits, "MAX_GROUP_ENTRIES", 64)
    text = TEAM
    for old, new in zip(changes[::2], changes[1::2], strict=True):
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "m.pomdp").write_text(text)
    return relax(load(tmp_path / "m.pomdp").model)


def test_agents_apart_share_tokens_dealt_one_by_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = team(tmp_path, monkeypatch)
    assert known(found) == [[("tok.on", ()), ("bot.x", (b,))] for b in (0, 1)]
    assert found.team is not None
    assert found.team.idle == 1  # left: an agent that moves takes nothing
    assert [group.actions for group in found.groups] == [(1, 5, 9, 13), (4, 5, 6, 7)]
    monkeypatch.setattr(limits, "MAX_SHARED_TOKENS", 2)
    found = relax(load(tmp_path / "m.pomdp").model)
    assert known(found) == [[("tok.on", t), ("bot.x", (b,))] for t in ((0, 2), (1, 3)) for b in (0, 1)]
    assert [len(group.terms) for group in found.groups] == [2, 2, 3, 3]  # each moves for its own once


GAIN = "sum(b in Bot where takes(b, r): if finds(b, r) then 5 else -1)"
UPDATE = "on and not any(b in Bot: takes(b, r))"


@pytest.mark.parametrize(
    "changes",
    [
        (GAIN, "if on and not on' then 5 else 0"),
        (GAIN, "if on then -1 else 0"),
        (UPDATE, "on and all(b in Bot: not takes(b, r))"),
        ("policy", "legal when bot[0].x != bot[1].x\npolicy"),
        ("policy", "terminal when any(b in Bot: bot[b].x' == 2)\npolicy"),
    ],
)
def test_agents_that_act_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changes: list[str]) -> None:
    assert team(tmp_path, monkeypatch, *changes).team is not None


NOT_AS_MUCH = "'tok.on' is not as much to the agents apart as to all together"


DRAWS = "'tok.on' depends on draws or on more than agents and itself"
OTHERS = "the reward 'tok.gain' depends on more than an agent or a token"  # that the others disturb


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        # Both are paid for one token; it takes both; a token that is spent costs all together once.
        (("if finds(b, r)", "if on"), NOT_AS_MUCH),
        ((GAIN, "if on and all(b in Bot: takes(b, r)) then 5 else 0"), NOT_AS_MUCH),
        ((GAIN, "if on then 0 else -1"), NOT_AS_MUCH),
        # What is neither a condition on one agent nor the token is not decided.
        ((GAIN, "if on and takes(0, r) and bot[0].x != bot[1].x then 5 else 0"), NOT_AS_MUCH),
        ((UPDATE, "on or any(b in Bot: act[b] == kick and bot[b].x == r)"), NOT_AS_MUCH),  # it comes back
        ((UPDATE, "on and not any(b in Bot: bot[b].x == r)"), NOT_AS_MUCH),  # nobody can leave it alone
        ((UPDATE, "on and tok[0].on"), DRAWS),
        (("  on' = " + UPDATE, "  on' ~ bernoulli(0.5)"), DRAWS),
        (("hidden on: bool", "hidden on: R", "init on ~ bernoulli(0.5)", "init on = 1",
          UPDATE, "if takes(0, r) then 0 else on", GAIN, "on", "tok[0].on", "true", "tok[r].on", "true"),
         "'tok.on' is no single entry of two values"),
        (("policy", "reward both = if tok[0].on and tok[1].on then 1 else 0\npolicy"),
         "the reward 'both' depends on more than an agent or a token"),
        # One agent pushes the other; moves at random.
        (("right => clamp(x + 1)", "right => clamp(x + bot[1 - b].x)"),
         OTHERS),
        (("x' = match act[b] {", "x' ~ if act[b] == kick then uniform(R) else match act[b] {"),
         OTHERS),
        (("type Bot = 0 .. 1", "type Bot = 0 .. 2", "init x = 3 * b", "init x = b"),
         "there are not two agents"),
        (("  reward moved = if x' != x",
          "  hidden far: float\n  init far = 0.0\n  far' = far + 0.5\n  reward moved = if far > 3.0"),
         "an agent depends on 'bot.far', whose values are not finitely many"),
    ],
)  # fmt: skip
def test_what_forbids_taking_agents_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changes: list[str], reason: str
) -> None:
    found = team(tmp_path, monkeypatch, *changes)
    assert (found.team, found.together) == (None, reason)


def test_positions_with_gaps() -> None:
    assert strides((0, 2, 4)) == [range(0, 5, 2)]
    assert strides((3,)) == [range(3, 4)]
    assert strides((0, 1, 4, 5)) == [range(2), range(4, 6)]
