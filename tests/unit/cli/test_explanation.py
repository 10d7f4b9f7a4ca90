# SPDX-License-Identifier: Apache-2.0
"""The facts that ``hypgen explain`` tells, and their text."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import pytest
from click.testing import CliRunner
from support import ir_samples
from support.paths import EXAMPLES, ROOT

from hypgen.cli.commands.explain import STAGES, SUMMARIES, command
from hypgen.cli.show.explanation import describe
from hypgen.codegen.generate import generate
from hypgen.codegen.model_report import explain
from hypgen.dsl import ir
from hypgen.dsl.load import load
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.source import Span
from hypgen.dsl.types import Float, Int


def text(model: ir.Model) -> str:
    blocks = describe(explain(model))
    return "".join(f"{heading}\n" + "".join(f"  {line}\n" for line in lines) for heading, lines in blocks)


def test_layout_and_stages() -> None:
    shown = text(ir_samples.wanderer())
    assert (
        "State, fixed: 4 bytes, stored once a scenario\n"
        "  variable                  type  word  bits\n"
        "  map.wall[1 .. 5]  hidden  bool  0     0 .. 4, 5 x 1\n"
        "State, dynamic: 8 bytes, copied by every step\n"
        "  variable                   type    word  bits\n"
        "  bot.at[0 .. 1]    hidden   1 .. 5  0     0 .. 7, 2 x 4\n"
        "  bot.seen[0 .. 1]  visible  1 .. 5  1     0 .. 7, 2 x 4\n"
    ) in shown
    assert (
        "Stage 1: 1 task\n"
        "  element  writes  reads primed  words  runs\n"
        "  bot x 2  seen'   bot.at'       1      1 of 2  taken from what was seen by the filter\n"
    ) in shown


def test_what_is_drawn() -> None:
    shown = text(load(EXAMPLES / "rock_sample.pomdp").model)
    picture = shown[shown.index("Picture: ") :].splitlines()
    assert picture[1].split() == ["drawing", "shape", "reads", "shows"]
    rows = [line.split("  ") for line in picture[2:]]
    assert any("truth and belief" in row and any("rock.good" in part for part in row) for row in rows)
    assert any("nothing: it is static" in row for row in rows)
    assert "Picture" not in text(load(EXAMPLES / "tiger.pomdp").model)


def test_facts_are_plain_data() -> None:
    for model in (ir_samples.tiger(), ir_samples.rocks(), ir_samples.wanderer()):
        facts = explain(model)
        assert json.loads(json.dumps(facts, allow_nan=False)) == facts


def test_whether_a_model_can_be_solved_exactly() -> None:
    tiger = load(EXAMPLES / "tiger.pomdp").model
    assert "Exact solution: `hypgen solve` applies, there are at most 2^1 states\n" in text(tiger)
    late = dataclasses.replace(tiger, horizon=1_000_000)
    assert "`hypgen solve` applies if at most a million of 2^21 states can be reached\n" in text(late)
    drifting = load(EXAMPLES / "light_dark.pomdp").model
    assert "Exact solution: none, as 'robot.at.x' is drawn from a continuous law in line " in text(drifting)
    assert explain(tiger)["exact"] == {"obstacles": [], "most_states_log2": 1}
    assert explain(drifting)["exact"]["obstacles"][0]["line"] > 0


def test_what_each_warp_takes() -> None:
    facts = explain(ir_samples.rocks())
    family = next(task for stage in facts["stages"] for task in stage if task["members"] > 1)
    assert (family["runs"], family["grain"], family["words"]) == (1, family["members"], [1])
    assert facts["warps"]["most"] == 1
    assert "Warps that share a step: 1 at most\n" in text(ir_samples.rocks())
    crowd = load(EXAMPLES / "crowd_driving.pomdp").model
    warps = explain(crowd)["warps"]
    assert warps["most"] == 16
    assert warps["shares"][1] == {"warps": 2, "runs": [[11, 10], [1, 0]]}
    assert (
        "Warps that share a step: 16 at most\n"
        "  warps  runs of stage 0 for each  runs of stage 1 for each\n"
        "  1      21                        1\n"
        "  2      11 10                     1 0\n"
        "  4      6 5 5 5                   1 0 0 0\n"
    ) in text(crowd)


def test_rewards_add_up_over_members() -> None:
    model = ir_samples.tiger()
    term = dataclasses.replace(model.rewards[0], value=ir.Const(Int(-3, 4), 1))
    family = dataclasses.replace(term, name="more", binder=ir.Binder("i", Int(0, 9)))
    rewards = explain(dataclasses.replace(model, rewards=(term, family)))["rewards"]
    assert (rewards["low"], rewards["high"]) == (-33, 44)
    endless = dataclasses.replace(term, value=ir.Const(Float(-1, math.inf), 1.0))
    rewards = explain(dataclasses.replace(model, rewards=(endless,)))["rewards"]
    assert (rewards["low"], rewards["high"]) == (-1, None)
    assert "Reward of a step: -1 .. inf" in text(dataclasses.replace(model, rewards=(endless,)))


def test_what_forbids_a_factor_is_named() -> None:
    obstacle = ir.Obstacle("room", Span("m.pomdp", 7, 3, 7, 9), "two members are read at once")
    shown = text(dataclasses.replace(ir_samples.tiger(), factors=(), obstacles=(obstacle,)))
    assert (
        "Belief: particles of the whole state\n"
        "  room is no factor: two members are read at once (m.pomdp:7:3)\n" in shown
    )


@pytest.mark.parametrize(
    ("lower", "words"), [(None, "what the default policy earns, looked up"), (-7.5, "-7.5")]
)
def test_bounds(lower: float | None, words: str) -> None:
    value = None if lower is None else ir.Const(Float(lower, lower), lower)
    shown = text(dataclasses.replace(ir_samples.tiger(), lower=value))
    row = next(line for line in shown.splitlines() if line.startswith("  lower"))
    assert words in row


def test_what_the_policy_keeps_is_laid_out() -> None:
    template = ROOT / "cli" / "templates" / "memory.pomdp"
    model = load(template).model
    assert "it knows visible state and 4 bytes of history\n" in text(model)
    kept = explain(model)["policy"]["history"]["variables"]
    assert [v["name"] for v in kept] == ["memory:score", "last:signal", "last_action", "started"]


def test_what_is_drawn_when_read_is_named() -> None:
    model = load(ROOT / "tests" / "differential" / "models" / "corridor.pomdp").model
    assert explain(model)["belief"]["drawn_when_read"] == ["floor.wet"]
    assert "; copies draw anew what they have not read of floor.wet\n" in text(model)


def test_what_moves_value_by_value_is_named() -> None:
    model = load(EXAMPLES / "classics" / "battleship.pomdp").model
    assert explain(model)["belief"]["moved"] == ["ship.place"]
    assert "; moves change single values of ship.place\n" in text(model)


def test_what_is_seen_at_the_start_is_named() -> None:
    model = load(ROOT / "tests" / "golden" / "first_look.pomdp").model
    assert explain(model)["belief"]["seen_first"] == ["bell.rings", "chest.glint"]
    assert "; the first one is given what is seen of bell.rings, chest.glint\n" in text(model)


def test_what_the_policy_knows_of_floats_is_named() -> None:
    model = load(ROOT / "benchmarks" / "beliefs" / "floats" / "cart.pomdp").model
    assert [f["moments"] for f in explain(model)["belief"]["factors"]] == [True]
    assert "particles: 'cart.x' is a float; the policy knows mean and deviation\n" in text(model)


def test_too_many_values_are_not_drawn_when_read(tmp_path: Path) -> None:
    text = (ROOT / "tests" / "differential" / "models" / "corridor.pomdp").read_text()
    large = tmp_path / "large.pomdp"
    large.write_text(text.replace("0 .. 9", "0 .. 4096"))
    assert explain(load(large).model)["belief"]["drawn_when_read"] == []


def stage(name: str, model: Path = EXAMPLES / "tiger.pomdp") -> str:
    """Return what ``hypgen explain --stage`` prints."""
    result = CliRunner().invoke(command, [str(model), "--stage", name], standalone_mode=False)
    if result.exception is not None:
        raise result.exception
    return result.stdout


def test_the_stages_are_the_compilers_passes_in_order() -> None:
    seen: list[str] = []
    loaded = load(EXAMPLES / "tiger.pomdp", watch=lambda name, _: seen.append(name))
    generate(loaded.model, lambda name, _: seen.append(name))
    assert seen == list(STAGES)


@pytest.mark.parametrize("name", [*STAGES, *SUMMARIES])
def test_every_stage_prints_something(name: str) -> None:
    assert stage(name).strip()
    assert stage(name) == stage(name)


def test_a_stage_prints_what_its_pass_made() -> None:
    light_dark = EXAMPLES / "light_dark.pomdp"
    assert "  hearing: a param\n" in stage("collect-symbols")
    assert "TypeName(Vec)" in stage("resolve-imports", light_dark)
    assert "at.x" not in stage("resolve-imports", light_dark)
    assert "Variable(at.x, TypeName(float, m))" in stage("flatten-records", light_dark)
    assert stage("flatten-records") == "This pass changes nothing here.\n"
    assert stage("check-visibility") == "This pass changes nothing here.\n"
    assert stage("collect-sites").startswith("sites: [[init:room.tiger, 15:3], [room.tiger, 16:3]")
    assert stage("make-key") == "key: [KeyField{Door}(heard, observed)]\n"
    assert stage("find-factors").startswith("factors:\n  Factor\n    element: room\n")


def test_names_of_larger_pieces_stand_for_stages() -> None:
    assert stage("ast") == stage("resolve-imports")
    assert stage("ir").startswith("Model\n  name: Tiger\n")
    assert stage("cpp").startswith("// src/")
    assert stage("cpp") in stage("print") and len(stage("cpp")) < len(stage("print"))


def test_a_stage_before_a_mistake_is_printed(tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.pomdp"
    wrong.write_text((EXAMPLES / "tiger.pomdp").read_text().replace("uniform(Door)", "uniform(Dor)"))
    result = CliRunner().invoke(command, [str(wrong), "--stage", "collect-symbols"], standalone_mode=False)
    assert "  room.tiger: a variable\n" in result.stdout
    assert isinstance(result.exception, ModelError)


def test_help_lists_the_stages_and_the_nearest_is_named() -> None:
    text = CliRunner().invoke(command, ["--help"]).output
    assert all(f"\n    {name} " in text for name in (*STAGES, *SUMMARIES))
    wrong = CliRunner().invoke(command, ["m.pomdp", "--stage", "chek-parts"])
    assert wrong.exit_code == 2
    assert "there is no stage 'chek-parts'. Did you mean 'check-parts'?" in wrong.output
