# SPDX-License-Identifier: Apache-2.0
"""POMDPX: tables, decision diagrams, several variables; and what is refused."""

import numpy as np
import pytest
from support import large_files
from support.foreign_laws import laws_of_cassandra, laws_of_text, load
from support.paths import ROOT

from hypgen.dsl.foreign import reader
from hypgen.dsl.foreign.pomdpx import tables
from hypgen.dsl.foreign.tables import plan
from hypgen.dsl.interpret.evaluate.distributions import Evaluator
from hypgen.dsl.interpret.evaluate.values import Array, Frame
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.types import size_of

CORPUS = ROOT.parent / "shared" / "corpus"

HEAD = """<?xml version="1.0" encoding="ISO-8859-1"?>
<pomdpx version="1.0">
<Description>A rover that may take a rock.</Description>
<Discount>0.9</Discount>
<Variable>
  <StateVar vnamePrev="rover_0" vnameCurr="rover_1" fullyObs="true"><NumValues>3</NumValues></StateVar>
  <StateVar vnamePrev="rock_0" vnameCurr="rock_1"><ValueEnum>good bad</ValueEnum></StateVar>
  <ObsVar vname="sensor"><ValueEnum>ogood obad</ValueEnum></ObsVar>
  <ActionVar vname="act"><ValueEnum>east take check</ValueEnum></ActionVar>
  <RewardVar vname="gain"/><RewardVar vname="cost"/>
</Variable>
<InitialStateBelief>
  <CondProb><Var>rover_0</Var><Parent>null</Parent><Parameter type="TBL">
    <Entry><Instance>s0</Instance><ProbTable>1.0</ProbTable></Entry></Parameter></CondProb>
  <CondProb><Var>rock_0</Var><Parent>null</Parent><Parameter type="TBL">
    <Entry><Instance>-</Instance><ProbTable>uniform</ProbTable></Entry></Parameter></CondProb>
</InitialStateBelief>
<StateTransitionFunction>
  <CondProb><Var>rover_1</Var><Parent>act rover_0</Parent><Parameter type="TBL">
    <Entry><Instance>* - -</Instance><ProbTable>identity</ProbTable></Entry>
    <Entry><Instance>east - -</Instance><ProbTable>0.1 0.9 0  0 0.1 0.9  0 0 1</ProbTable></Entry>
  </Parameter></CondProb>
"""
TABLES = """  <CondProb><Var>rock_1</Var><Parent>act rover_0 rock_0</Parent><Parameter type="TBL">
    <Entry><Instance>* * - -</Instance><ProbTable>identity</ProbTable></Entry>
    <Entry><Instance>take s1 * good</Instance><ProbTable>0</ProbTable></Entry>
    <Entry><Instance>take s1 * bad</Instance><ProbTable>1</ProbTable></Entry>
  </Parameter></CondProb>
</StateTransitionFunction>
<ObsFunction><CondProb><Var>sensor</Var><Parent>act rover_1 rock_1</Parent><Parameter type="TBL">
    <Entry><Instance>* * * -</Instance><ProbTable>1 0</ProbTable></Entry>
    <Entry><Instance>check s0 - -</Instance><ProbTable>0.8 0.2 0.2 0.8</ProbTable></Entry>
    <Entry><Instance>check s1 - -</Instance><ProbTable>identity</ProbTable></Entry>
    <Entry><Instance>check s2 * -</Instance><ProbTable>uniform</ProbTable></Entry>
</Parameter></CondProb></ObsFunction>
"""
DIAGRAMS = """  <CondProb><Var>rock_1</Var><Parent>act rover_0 rock_0</Parent><Parameter type="DD"><DAG>
    <Node var="act">
      <Edge val="east"><SubDAG type="persistent" var="rock"/></Edge>
      <Edge val="take"><Node var="rover_0">
        <Edge val="s0"><SubDAG type="persistent" var="rock"/></Edge>
        <Edge val="s1"><SubDAG type="deterministic" var="rock_1" val="bad"/></Edge>
        <Edge val="s2"><SubDAG type="template" idref="kept"/></Edge></Node></Edge>
      <Edge val="check"><SubDAG type="template" idref="kept"/></Edge>
    </Node></DAG>
    <SubDAGTemplate id="kept"><Node var="rock_0">
      <Edge val="good"><Node var="rock_1"><Edge val="good"><Terminal>1</Terminal></Edge></Node></Edge>
      <Edge val="bad"><Node var="rock_1"><Edge val="good"><Terminal>0</Terminal></Edge>
        <Edge val="bad"><Terminal>1</Terminal></Edge></Node></Edge>
    </Node></SubDAGTemplate>
  </Parameter></CondProb>
</StateTransitionFunction>
<ObsFunction><CondProb><Var>sensor</Var><Parent>act rover_1 rock_1</Parent><Parameter type="DD"><DAG>
    <Node var="act">
      <Edge val="east"><SubDAG type="deterministic" var="sensor" val="ogood"/></Edge>
      <Edge val="take"><SubDAG type="deterministic" var="sensor" val="ogood"/></Edge>
      <Edge val="check"><Node var="rover_1">
        <Edge val="s2"><SubDAG type="uniform" var="sensor"/></Edge>
        <Edge val="s1"><Node var="rock_1">
          <Edge val="good"><SubDAG type="deterministic" var="sensor" val="ogood"/></Edge>
          <Edge val="bad"><SubDAG type="deterministic" var="sensor" val="obad"/></Edge></Node></Edge>
        <Edge val="s0"><Node var="rock_1">
          <Edge val="good"><Node var="sensor">
            <Edge val="ogood"><Terminal>0.8</Terminal></Edge><Edge val="obad"><Terminal>0.2</Terminal></Edge>
          </Node></Edge>
          <Edge val="bad"><Node var="sensor">
            <Edge val="ogood"><Terminal>0.2</Terminal></Edge><Edge val="obad"><Terminal>0.8</Terminal></Edge>
          </Node></Edge></Node></Edge></Node></Edge>
    </Node></DAG></Parameter></CondProb></ObsFunction>
"""
TAIL = """<RewardFunction>
  <Func><Var>gain</Var><Parent>act rover_0 rock_0</Parent><Parameter type="TBL">
    <Entry><Instance>take s1 -</Instance><ValueTable>10 -10</ValueTable></Entry>
    <Entry><Instance>take s2 *</Instance><ValueTable>-100</ValueTable></Entry></Parameter></Func>
  <Func><Var>cost</Var><Parent>act sensor</Parent><Parameter type="DD"><DAG><Node var="act">
    <Edge val="check"><Node var="sensor"><Edge val="obad"><Terminal>-2</Terminal></Edge></Node></Edge>
  </Node></DAG></Parameter></Func>
</RewardFunction>
</pomdpx>
"""
ROVER = HEAD + TABLES + TAIL


def imported(text: str) -> str:
    return reader.import_text("rover.pomdpx", text.encode(), None, None).text


def told(text: str) -> list[str]:
    with pytest.raises(ModelError) as error:
        imported(text)
    return [f"{d.code}: {d.message}" for d in error.value.diagnostics]


def test_every_variable_is_an_element() -> None:
    text = imported(ROVER)
    assert "element rover {\n  visible state: Rover\n" in text
    assert "element rock {\n  hidden state: Rock\n" in text
    assert "observe seen: Observation ~ match act {" in text
    model = load(text)
    assert [v.name for v in model.variables] == ["rover.state", "rock.state"]
    assert model.factors, "the rock's posterior is exact"


def test_diagrams_say_what_tables_say() -> None:
    assert imported(HEAD + DIAGRAMS + TAIL) == imported(ROVER)


def test_rewards_on_observations_are_expected() -> None:
    text = imported(ROVER)
    assert "# Rewards on observations are replaced by their expectation" in text
    assert "rover.state'" in text.partition("reward cost")[2]


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("0.8 0.2 0.2 0.8", "0.8 0.1 0.2 0.8",
         "E0904: the probabilities of 'sensor' given act = check, rover_1 = s0, rock_1 = good sum to 0.9"),
        ("0.8 0.2 0.2 0.8", "0.8 0.2 0.2", "E0903: <ProbTable> has 3 numbers and takes 4"),
        ("take s1 * good", "take s1 * god", "E0902: 'rock_1' has no value 'god'"),
        ("take s1 * good", "take s1 good", "E0903: <Instance> names 3 values, and there are 4 variables"),
        ("<Var>sensor", "<Var>senser", "E0902: there is no variable 'senser'"),
        ("good bad<", "good good<", "E0911: <ValueEnum> names a value twice"),
        ("<NumValues>3", "<NumValues>x",
         "E0911: <StateVar> says not how many values there are, or says 'x'"),
        ("<Discount>0.9", "<Discount>2", "E0908: the discount is '2'"),
        ("</pomdpx>", "", "E0909: this is no well-formed XML: no element found"),
        ("</Variable>", "", "E0909: this is no well-formed XML: mismatched tag"),
        ("<pomdpx version", '<!DOCTYPE a SYSTEM "http://localhost/a.dtd">\n<pomdpx version',
         "E0910: a document type or an entity is declared, which is refused: "
         "entities can grow without limit"),
        ("<Description>", "<a>" * 300, "E0910: elements are nested more than 200 levels deep"),
        ("rover_0 rock_0</Parent><Parameter type", "rover_0 rover_0 rover_0</Parent><Parameter type",
         "E0911: 'rover_0' is a parent twice"),
        ("act rover_0 rock_0</Parent><Parameter type=\"TBL\">\n    <Entry><Instance>* *",
         "act rover_0 sensor</Parent><Parameter type=\"TBL\">\n    <Entry><Instance>* *",
         "E0911: 'rock_1' cannot depend on 'sensor' here"),
    ],
)  # fmt: skip
def test_mistakes_are_told(old: str, new: str, expected: str) -> None:
    assert old in ROVER
    assert expected in told(ROVER.replace(old, new))


def test_a_misspelt_part_is_named_in_the_remedy() -> None:
    with pytest.raises(ModelError) as error:
        imported(ROVER.replace("ObsFunction", "ObsFunktion"))
    (mistake,) = error.value.diagnostics
    assert mistake.message == "<pomdpx> lacks <ObsFunction>"
    assert mistake.remedy == "did you mean <ObsFunction> where <ObsFunktion> stands?"


def test_a_row_that_no_entry_gives_is_told() -> None:
    entry = "    <Entry><Instance>* * * -</Instance><ProbTable>1 0</ProbTable></Entry>\n"
    row = "there are no probabilities of 'sensor' given act = east, rover_1 = s0, rock_1 = good"
    assert f"E0905: {row} and 11 more rows" in told(ROVER.replace(entry, ""))


def test_a_row_that_is_given_as_zeros_sums_to_0() -> None:
    row = "the probabilities of 'sensor' given act = check, rover_1 = s0, rock_1 = good sum to 0"
    assert f"E0904: {row}" in told(ROVER.replace("0.8 0.2 0.2 0.8", "0 0 0.2 0.8"))
    start = "<Entry><Instance>-</Instance><ProbTable>uniform"
    assert "E0904: the probabilities of 'rock_0' sum to 0" in told(
        ROVER.replace(start, start.replace("uniform", "0.0 0.0"))
    )


def test_a_word_that_is_no_probability_has_the_caret() -> None:
    with pytest.raises(ModelError) as error:
        imported(ROVER.replace("0.8 0.2 0.2 0.8", "0.8 0.2 <!-- -0.1 -->\n1.1 -0.1"))
    (mistake,) = error.value.diagnostics
    assert mistake.message == "'1.1' is no probability" and mistake.span is not None
    assert (mistake.span.column, mistake.span.end_column) == (1, 4)


def test_a_caret_is_at_the_text_of_an_element() -> None:
    with pytest.raises(ModelError) as error:
        imported(ROVER.replace("<Discount>0.9", "<Discount>\n  7 "))
    (mistake,) = error.value.diagnostics
    assert mistake.span is not None and (mistake.span.line, mistake.span.column) == (5, 3)


def test_rounded_rows_are_scaled_when_told_to() -> None:
    text = ROVER.replace("0.8 0.2 0.2 0.8", "0.8 0.199 0.2 0.8")
    row = "'sensor' given act = check, rover_1 = s0, rock_1 = good"
    assert told(text) == [f"E0904: the probabilities of {row} sum to 0.999"]
    scaled = reader.import_text("rover.pomdpx", text.encode(), None, None, 0.01)
    assert "1 row is scaled to sum to 1." in scaled.model.notes


def test_a_template_that_leads_to_itself_is_refused() -> None:
    inner = '<Edge val="good"><Node var="rock_1">'
    circle = DIAGRAMS.replace(inner, inner.replace("<Node", '<SubDAG type="template" idref="kept"/><Node'))
    assert "E0910: the diagram is nested too deep" in told(HEAD + circle + TAIL)


def test_tables_too_large_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "MAX_ROWS", 17)
    assert "E0912: a table of 3 x 3 x 2 rows has more than 17 to write down" in told(ROVER)
    monkeypatch.setattr(tables, "MAX_PARTS", 20)
    assert "E0912: a table of 3 x 3 x 2 rows has more than 17 to write down" in told(ROVER)
    monkeypatch.setattr(tables, "MAX_WRITTEN", 20)
    assert "E0912: entries are written again and again, millions of them" in told(ROVER)


def test_an_axis_may_be_long_where_tables_say_little() -> None:
    numbers = "east - -</Instance><ProbTable>0.1 0.9 0  0 0.1 0.9  0 0 1"
    assert numbers in ROVER
    large = ROVER.replace("<NumValues>3", "<NumValues>9999").replace(
        numbers, "east s0 -</Instance><ProbTable>uniform"
    )
    assert "type Rover = 0 .. 9998\n" in imported(large)


def flat(rock_sample: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the text that has every large table as one list."""
    with monkeypatch.context() as patch:
        patch.setattr(plan, "_SMALL", 10**9)
        return imported(rock_sample)


def test_large_tables_are_matches_of_small_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    file = "\n".join(large_files.rock_sample(4, 4))
    text, listed = imported(file), flat(file, monkeypatch)
    assert "  ac0 => seen_by(seen_ac0_row[robot.state', rock0.state'])\n" in text
    assert "seen_by(seen_row[act, robot.state', rock0.state', rock1.state'," in listed
    assert len(text) < 0.75 * len(listed)
    model, other = load(text), load(listed)
    chance, lanes = np.random.default_rng(5), 5000

    def drawn() -> dict[str, Array]:
        return {v.name: chance.integers(0, size_of(v.type), lanes).astype(np.int32) for v in model.variables}

    action = chance.integers(0, model.action.count, lanes).astype(np.int32)
    frame = Frame(np.arange(lanes), drawn(), drawn(), action)
    ours, theirs = Evaluator(model, {}), Evaluator(other, {})
    for one, same in zip(model.rewards, other.rewards, strict=True):
        np.testing.assert_array_equal(ours.value(one.value, frame), theirs.value(same.value, frame))
    for value in np.int32([0, 1]):
        seen = ours.density(model.observations[0].dist, frame, value)
        np.testing.assert_array_equal(seen, theirs.density(other.observations[0].dist, frame, value))


def test_rock_sample_of_11_has_tables_of_4_million_rows() -> None:
    text = imported("\n".join(large_files.rock_sample(11, 11)))
    assert len(text) < 50_000
    model = load(text)
    assert len(model.variables) == 12 and len(model.factors) == 11, "the rocks' posterior is exact"


@pytest.mark.skipif(not CORPUS.exists(), reason="the corpus is not beside the checkout")
def test_files_of_others_say_what_the_same_in_cassandras_format_says() -> None:
    for name, other, rewards_too in (("Tiger", "tiger.95", True), ("Hallway", "hallway", False)):
        path = CORPUS / "pomdpx" / f"{name}.pomdpx"
        ours = laws_of_text(reader.import_text(str(path), path.read_bytes(), None, None).text)
        theirs = laws_of_cassandra((CORPUS / "cassandra" / f"{other}.pomdp").read_text(encoding="latin-1"))
        np.testing.assert_allclose(ours.transitions, theirs.transitions, atol=2e-5)
        np.testing.assert_allclose(ours.observations, theirs.observations, atol=2e-5)
        if rewards_too:  # Hallway's are given on the state before the goal in one file
            ours.assert_close(theirs, tolerance=2e-5)
