# SPDX-License-Identifier: Apache-2.0
"""Enumerated models in Cassandra's format: what the lines say, and that reading them back gives the same."""

import json
from pathlib import Path

import numpy as np
import pytest
from support.foreign_laws import laws_of_cassandra
from support.paths import ROOT

from hypgen.cli import main
from hypgen.dsl.foreign import reader
from hypgen.dsl.foreign.enumerated.dump import Enumerated, read
from hypgen.dsl.foreign.enumerated.write_cassandra import SeveralStartsError, export


def exported(model: Enumerated) -> str:
    return "\n".join(export(model, "model.pomdp")) + "\n"


def two_doors() -> Enumerated:
    """Return a model in which what is seen depends on the state before, which ends, and is partly illegal."""
    return Enumerated(
        name="Doors",
        discount=0.9,
        variables=["room.door", "room.open"],
        actions=["look", "take(3)"],
        observations=["dark", "Pos(1, -2)"],
        policy_hash=7,
        starts=[[(0, 0.25), (1, 0.75)]],
        values=[["left", "true"], ["left", "false"]],
        rows=[
            {0: (1.0, [(0, 0, 0.2), (0, 1, 0.4), (1, 0, 0.3), (1, 1, 0.1)]), 1: (5.0, [(0, 0, 0.5)])},
            {0: (1.0, [(0, 1, 1.0)])},
        ],
    )


def test_states_are_split_by_what_is_seen_on_arriving() -> None:
    text = exported(two_doors())
    assert "states: left-t left-f left-f-again1 ended\n" in text
    assert "actions: look take_3\nobservations: dark Pos_1_-2 ended\n" in text
    assert "start: 0.25 0.75 0 0\n" in text
    laws = laws_of_cassandra(text)
    np.testing.assert_allclose(laws.transitions.sum(axis=2), 1)
    np.testing.assert_allclose(laws.observations.sum(axis=2), 1)
    seen = np.einsum("ast,ato->asto", laws.transitions, laws.observations)
    np.testing.assert_allclose(seen[0, 0, 0, :2], [0.2, 0.3])
    np.testing.assert_allclose(seen[0, 0, 1:3, :2].sum(axis=0), [0.4, 0.1])
    for copy in (1, 2):  # both do what the state does
        np.testing.assert_allclose(seen[0, copy, 1:3, :2].sum(axis=0), [1, 0])
        np.testing.assert_allclose(seen[1, copy, 1:3].sum(axis=0), [1, 0, 0])  # taking is not legal: it looks
        np.testing.assert_allclose(laws.rewards[:, copy], 1)
    np.testing.assert_allclose(laws.transitions[1, 0], [0.5, 0, 0, 0.5])
    np.testing.assert_allclose(laws.rewards[:, 0], [1, 5])
    np.testing.assert_allclose(laws.transitions[:, 3, 3], 1)
    np.testing.assert_allclose(laws.rewards[:, 3], 0)


def test_what_is_written_can_be_imported() -> None:
    text = exported(two_doors())
    imported = reader.import_text("doors.POMDP", text.encode(), None, None)
    assert "terminal when system.state' == ended" in imported.text
    assert imported.model.states[0].size == 4


def test_names_are_those_of_the_format() -> None:
    model = two_doors()
    model.actions, model.observations = ["identity", "identity "], ["3", "*"]
    model.values, model.steps = [["T"], ["T"]], [0, 1]
    text = exported(model)
    assert "actions: identity_2 identity_3\nobservations: o3 o_2 ended\n" in text
    assert "states: T-at0 T-at1 T-at1-again1 ended\n" in text


def test_starts_that_can_be_told_apart_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    model = two_doors()
    model.starts = [[(0, 1.0)], [(1, 1.0)]]
    with pytest.raises(SeveralStartsError):
        exported(model)
    program = tmp_path / "program"
    program.write_text('#!/bin/sh\n: > "${1#--dump=}"\n')
    program.chmod(0o755)
    monkeypatch.setattr("hypgen.cli.commands.export.build", lambda *_: program)
    monkeypatch.setattr("hypgen.dsl.foreign.enumerated.dump.read", lambda _: model)
    assert main.run(["export", str(ROOT / "examples" / "tiger.pomdp")]) == 2
    assert "starts in 2 ways that the agent can tell apart" in capsys.readouterr().err
    model.starts = [[(0, 1.0)]]
    output = tmp_path / "doors.POMDP"
    assert main.run(["export", str(ROOT / "examples" / "tiger.pomdp"), "-o", str(output)]) == 0
    assert "2 states; written to" in capsys.readouterr().err and "start: left-t\n" in output.read_text()
    assert main.run(["export", str(ROOT / "examples" / "tiger.pomdp"), "-o", str(output)]) == 2


def test_the_exact_programs_lines_are_read() -> None:
    head = {"type": "model", "name": "M", "discount": 0.9, "variables": ["x"], "actions": ["a"]}
    lines = [
        head | {"observations": ["o"], "policy_hash": 7, "states": 1, "horizon": 2},
        {"type": "start", "probability": 1.0, "class": 0, "belief": [[0, 1.0]]},
        {"type": "state", "state": 0, "class": 0, "step": 0, "values": ["3"]},
        {"type": "row", "state": 0, "action": 0, "reward": 2.5, "outcomes": [[0, 0, 0.5]]},
        {"type": "end"},
    ]
    model = read(map(json.dumps, lines))
    assert model.rows == [{0: (2.5, [(0, 0, 0.5)])}]
    assert (model.starts, model.values, model.steps) == ([[(0, 1.0)]], [["3"]], [0])
    with pytest.raises(ValueError, match="incomplete"):
        read(map(json.dumps, lines[:-1]))
