# SPDX-License-Identifier: Apache-2.0
"""Recordings become what pages and pictures show; what cannot be shown is refused in words."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from support import recorded_episodes as recorded

from hypgen.cli.main import run
from hypgen.dsl.load import load
from hypgen.recordings import open_recording
from hypgen.views import page_of, view_of_recording

Lines = list[dict[str, Any]]


def view(
    folder: Path, hints: str = recorded.HINTS, lines: Lines | None = None, **more: Any
) -> dict[str, Any]:
    model = recorded.model_file(folder, hints)
    log = recorded.write(folder / "log.jsonl", recorded.lines_of(model) if lines is None else lines)
    return view_of_recording(open_recording(log), load(model).model, **({"episode": 3} | more))


def test_a_recorded_episode_has_scenes_terms_and_curves(tmp_path: Path) -> None:
    found = view(tmp_path, first=1)
    assert found["episode"] == 3 and found["first"] == 1 and found["ended"] == "step_limit"
    assert found["options"] == {"mode": "despot", "seed": 5}
    assert found["scene"]["extent"] == {"cells": True, "x": [0, 1], "y": [0, 0]}
    assert [one["name"] for one in found["scene"]["static"]] == ["door", "door", "note"]
    step = found["steps"][1]
    assert step["action"] == "open_left" and step["terms"] == {"outcome": step["reward"]}
    assert step["truth"][0]["x"] == recorded.DOORS.index(step["state"]["room.tiger"])
    assert {one["x"]: one["p"] for one in step["belief"]} == {0: 0.75, 1: 0.25}
    assert step["nodes"] == 11 and step["effective"] == 90.0 and step["believed"]["mean"] == 0.5
    assert "sampled" not in step
    assert found["end"]["truth"][0]["name"] == "tiger"


def test_a_model_without_hints_has_no_scene(tmp_path: Path) -> None:
    found = view(tmp_path, "")
    assert found["scene"] is None and "no draw declarations" in " ".join(found["notes"])


def test_a_recording_that_is_cut_off_says_what_is_missing(tmp_path: Path) -> None:
    lines = recorded.lines_of(recorded.model_file(tmp_path), episodes=(3,))[:-1]
    found = view(tmp_path, lines=lines)
    assert found["end"] is None and found["ended"] is None
    assert [step["earned"] for step in found["steps"]] == [None] * 3
    assert "The recording ends after step 2" in found["notes"][0]


def test_terms_that_do_not_fit_are_left_out_and_said(tmp_path: Path) -> None:
    lines = recorded.lines_of(recorded.model_file(tmp_path))
    lines[3]["reward"] += 1.0
    found = view(tmp_path, lines=lines)
    assert ["terms" in step for step in found["steps"]] == [True, False, False]
    assert found["notes"][0].startswith("Rewards by term are missing from step 1 on")


def test_no_name_ends_the_script(tmp_path: Path) -> None:
    page = page_of(view(tmp_path))
    data = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    assert data is not None
    read = json.loads(data[1])
    assert read["model"]["name"].startswith("Tiger </script>")
    assert [one["text"] for one in read["scene"]["static"]][-1] == "</script>"


def changed(**more: Any) -> Callable[[Lines], Lines]:
    return lambda lines: [lines[0] | more, *lines[1:]]


@pytest.mark.parametrize(
    ("change", "options", "said"),
    [
        (changed(version=2), (), "is of version 2, and this hypgen reads version 1"),
        (changed(hash="0123"), (), "was recorded with another model"),
        (changed(kind="belief"), (), "is of kind 'belief'"),
        (changed(params={}), (), "does not tell the param hearing"),
        (lambda lines: lines[:0], (), "is empty or ends within its first line"),
        (lambda lines: lines[:1], (), "has no episode"),
        (lambda lines: lines[:2], (), "episode 3 has no whole step"),
        (lambda lines: [{"type": "run"}], (), "has the lines of --json; record the run with --record FILE"),
        (changed(), ("--episode", "7"), "has no episode 7; it has 3, 4"),
        (changed(), ("--step", "3"), "--step 3: the episode has the steps 0 to 2"),
        (changed(), ("--mode", "despot"), "leave out --steps and all options of a solver"),
        (changed(), ("--steps", "2"), "leave out --steps and all options of a solver"),
        (changed(), ("--target", "cpu"), "leave out --steps and all options of a solver"),
    ],
)
def test_a_log_that_cannot_be_shown_is_refused_in_words(
    change: Callable[[Lines], Lines],
    options: tuple[str, ...],
    said: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    model = recorded.model_file(tmp_path)
    log = recorded.write(tmp_path / "log.jsonl", change(recorded.lines_of(model)))
    page = tmp_path / "page.html"
    assert run(["view", str(model), "--log", str(log), *options, "-o", str(page)]) == 2
    assert said in " ".join(capsys.readouterr().err.split())
    assert not page.exists()


def test_no_log_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = recorded.model_file(tmp_path)
    assert run(["view", str(model), "--log", str(tmp_path / "none.jsonl")]) == 2
    assert "none.jsonl cannot be read: No such file or directory" in capsys.readouterr().err


def test_a_last_line_that_is_cut_off_is_left_out_and_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = recorded.model_file(tmp_path)
    log = recorded.write(tmp_path / "log.jsonl", recorded.lines_of(model))
    log.write_bytes(log.read_bytes()[:-9])
    page = tmp_path / "page.html"
    told = ["view", str(model), "--log", str(log), "--episode", "4", "-o", str(page)]
    assert run(told) == 0
    assert "log.jsonl is cut off: its last line is not read" in capsys.readouterr().err
    assert "The recording ends after step 2" in page.read_text()


@pytest.mark.parametrize(
    ("hint", "said"),
    [
        ("draw a = cell { x = nowhere, y = 0, colour = blue }\n", "nowhere"),
        ("draw a = cell { x = 0, y = 0, colour = pink }\n", "pink"),
    ],
)
def test_hints_that_do_not_fit_are_shown_with_their_place(
    hint: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = recorded.model_file(tmp_path, hint)
    assert run(["view", str(model), "--log", "none.jsonl"]) == 2
    found = capsys.readouterr().err
    line = len(model.read_text().splitlines())
    assert f"tiger.pomdp:{line}:" in found and said in found


def test_pictures_of_a_log(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib", reason="pictures need the extra draw")
    monkeypatch.chdir(tmp_path)
    model = recorded.model_file(tmp_path)
    log = recorded.write(tmp_path / "log.jsonl", recorded.lines_of(model, count=1))
    assert run(["view", str(model), "--log", str(log), "--gif", "a.gif", "--png", "a.png"]) == 0
    assert (tmp_path / "a.gif").read_bytes()[:3] == b"GIF"
    assert (tmp_path / "a.png").read_bytes()[1:4] == b"PNG"
    assert not (tmp_path / "tiger.html").exists(), "pictures come instead of the page"
    assert capsys.readouterr().err == "picture: a.gif\npicture: a.png\n"


def test_pictures_without_their_packages_say_how_to_get_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert run(["view", str(recorded.model_file(tmp_path)), "--png", "a.png"]) == 2
    assert "pip install 'hypgen[draw]'" in capsys.readouterr().err


def test_the_episode_that_earned_least_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = recorded.model_file(tmp_path)
    lines = recorded.lines_of(model, episodes=(3, 4, 5))
    for line, earned in zip(
        [one for one in lines if one["type"] == "episode"], (2.0, -7.5, 1.0), strict=True
    ):
        line["discounted_return"] = earned
    log = recorded.write(tmp_path / "log.jsonl", lines)
    told = ["view", str(model), "--log", str(log), "-o", str(tmp_path / "page.html")]
    assert run(told) == 0
    note = "log.jsonl has 3 episodes; the lowest return, -7.5, is that of --episode 4"
    assert note in capsys.readouterr().err
    assert run([*told, "--episode", "5"]) == 0
    assert "lowest" not in capsys.readouterr().err
