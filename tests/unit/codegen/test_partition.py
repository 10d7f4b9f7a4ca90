# SPDX-License-Identifier: Apache-2.0
"""How warps share a step: no two write one word, everything is done once, and the text says so."""

from __future__ import annotations

import itertools

import pytest

from hypgen.codegen.generate import generate
from hypgen.codegen.layout.state_layout import pack
from hypgen.codegen.passes.partition import Share, most_warps, partition, run_count, shares, written_words
from hypgen.dsl import ir
from hypgen.dsl.messages.source import Source
from hypgen.dsl.pipeline import lower
from hypgen.dsl.syntax.parse import parse

HEAD = """model Shared
discount 0.9
type Row = 0 .. {last}
action act: -2 .. 2
param worth: float[Row]
"""
TAIL = """
policy default = 0
bound upper = 10
bound tail = 0
"""


def model(text: str, last: int = 9) -> ir.Model:
    source = Source("shared.pomdp", HEAD.format(last=last) + text + TAIL)
    return lower(parse(source), {}, source)


def family(*fields: str, last: int = 9) -> ir.Model:
    """Return a family whose members each have these variables, all of which move."""
    lines = []
    for number, field in enumerate(fields):
        kind, _, type_ = field.partition(" ")
        start = "false" if type_ == "bool" else "0"
        moved = f"not x{number}" if type_ == "bool" else f"wrap(x{number} + 1)"
        lines.append(f"  {kind} x{number}: {type_}\n  init x{number} = {start}\n")
        lines.append(f"  x{number}' = {'x' + str(number) + ' + 1.0' if type_ == 'float' else moved}\n")
    return model("element e[i in Row] {\n" + "".join(lines) + "}\n", last)


def only_stage(model_: ir.Model) -> tuple[Share, ...]:
    (stage,) = partition(model_)
    return shares(stage, pack(model_).state)


@pytest.mark.parametrize(
    ("fields", "last", "grain"),
    [
        (("hidden float",), 9, 1),
        (("hidden bool",), 9, 10),
        (("hidden bool",), 99, 32),
        (("hidden 0 .. 200",), 9, 4),
        (("hidden 0 .. 200", "hidden 0 .. 3"), 99, 16),
        (("hidden 0 .. 200", "visible 0 .. 200"), 99, 4),
        (("hidden bool", "visible float"), 9, 1),
        (("hidden bool", "hidden float", "visible 0 .. 2000000000", "hidden 0 .. 200"), 9, 1),
        (("hidden float", "visible float"), 19, 1),
    ],
)
def test_runs_are_as_short_as_words_allow(fields: tuple[str, ...], last: int, grain: int) -> None:
    stage = only_stage(family(*fields, last=last))
    assert {share.grain for share in stage} == {grain}
    assert {share.runs for share in stage} == {-(-(last + 1) // grain)}
    assert {share.first for share in stage} == {0}


TWO_STAGES = """
element a { hidden x: bool  hidden y: bool
  init x = false  init y = false
  x' = not x
  y' = x' and b.z
}
element b { hidden z: bool  hidden w: bool
  init z = true  init w = true
  z' = not z
  w' = a.x' or z'
}
element c[i in Row] { hidden on: bool
  init on = false
  on' = a.x' and not on
}
"""


def test_narrow_variables_share_words_for_each_member_where_a_wide_one_has_them_too() -> None:
    built = family("hidden bool", "hidden float", "hidden 0 .. 200", "hidden 0 .. 40000000", last=9)
    fields = {field.variable: field for field in pack(built).state.fields}
    assert [
        (f.word, f.shift, f.width, f.spread) for f in map(fields.get, ("e.x1", "e.x0", "e.x2", "e.x3")) if f
    ] == [
        (0, 0, 32, False),
        (20, 0, 1, True),
        (20, 1, 8, True),
        (10, 0, 32, False),
    ]
    assert pack(built).state.words == 30
    assert fields["e.x2"].words(3, 2) == range(23, 25)


def test_a_stage_reads_primed_no_word_that_another_element_writes() -> None:
    built = model(TWO_STAGES)
    state = pack(built).state
    words = {field.variable: set(field.words(0, field.length)) for field in state.fields}
    for stage in partition(built)[1:]:
        for writer, reader in itertools.permutations(stage, 2):
            read = {name for assign in reader.assigns for name in assign.reads}
            written = frozenset[int]().union(*written_words(writer, state))
            assert not written & set().union(*(words[name] for name in read))


def test_a_stage_of_one_scalar_element_takes_no_word_of_its_own() -> None:
    alone = (
        "element a { hidden x: bool  hidden y: bool\n  init x = false  init y = false  x' = not x  y' = x' }"
    )
    assert pack(model(alone)).state.words == 1
    assert pack(model(TWO_STAGES)).state.words == 5


@pytest.mark.parametrize("text", [TWO_STAGES, ""])
@pytest.mark.parametrize("warps", [1, 2, 3, 8])
def test_warps_write_different_words_and_all_members(text: str, warps: int) -> None:
    built = model(text) if text else family("hidden 0 .. 200", "visible bool", "hidden float", last=70)
    state = pack(built).state
    for stage in partition(built):
        takers: dict[int, int] = {}
        done = 0
        for share in shares(stage, state):
            for member, words in enumerate(written_words(share.update, state)):
                warp = (share.first + member // share.grain) % warps
                done += 1
                for word in words:
                    assert takers.setdefault(word, warp) == warp
        assert done == sum(update.members for update in stage)


def test_as_many_warps_as_the_largest_stage_feeds() -> None:
    state_of = {last: family("hidden float", last=last) for last in (0, 2, 3, 7, 15, 99)}
    found = {}
    for last, built in state_of.items():
        stages = [shares(stage, pack(built).state) for stage in partition(built)]
        assert run_count(stages[0]) == last + 1
        found[last] = most_warps(stages)
    assert found == {0: 1, 2: 1, 3: 4, 7: 8, 15: 16, 99: 16}
    assert most_warps([]) == 1


def text_of(built: ir.Model, function: str) -> str:
    header = generate(built)["src/shared.hpp"]
    start = header.index(f" {function}(")
    return header[start : header.index("\n  }\n", start)]


def test_the_text_of_runs() -> None:
    whole = text_of(family("hidden bool", last=4), "step_stage")
    assert "if (part.takes(0)) {\n      for (std::int32_t i = 0; i <= 4; ++i) update_e(" in whole
    single = text_of(family("hidden float", last=4), "step_stage")
    assert "for (std::int32_t i = part.first(0); i <= 4; i += part.count) update_e(" in single
    several = text_of(family("hidden 0 .. 200", last=9), "step_stage")
    assert "for (int run = part.first(0); run < 3; run += part.count) {" in several
    assert "const std::int32_t last = math::min(run * 4 + 3, 9);" in several
    assert "for (std::int32_t i = run * 4; i <= last; ++i) update_e(" in several


def test_guards_and_stages_are_those_of_the_step() -> None:
    guarded = model("""
element e[i in Row] { hidden x: float
  init x = 0.0
  x' = if act == 1 then x + worth[i] else x
  reward paid = if act == 2 then worth[i] else 0.0
}
""")
    stage = text_of(guarded, "step_stage")
    assert stage.index("if (act == 1) {") < stage.index("part.first(0)")
    assert "stage ==" not in stage
    rewards = text_of(guarded, "step_rewards")
    assert rewards.index("if (act == 2) {") < rewards.index("part.first(0)")
    assert "error |= math::is_nan(earned);" in rewards
    stages = text_of(model(TWO_STAGES), "step_stage")
    assert stages.index("if (stage == 0) {") < stages.index("if (stage == 1) {")
