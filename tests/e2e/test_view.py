# SPDX-License-Identifier: Apache-2.0
"""``hypgen view`` as a person types it."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from hypgen.cli.main import run

EXAMPLES = Path(__file__).parent.parent.parent / "examples"
ROCKS = str(EXAMPLES / "rock_sample.pomdp")  # other tests build the same library
QUICK = ("--mode", "despot", "--trials", "20", "--scenarios=50", "--seed", "7")


def data_of(page: Path) -> dict[str, Any]:
    data = re.search(r'<script type="application/json" id="data">(.*?)</script>', page.read_text(), re.DOTALL)
    assert data is not None
    view: dict[str, Any] = json.loads(data[1])
    return view


@pytest.mark.cxx
@pytest.mark.parametrize("mode", ["default", "rollout", "pomcp"])
def test_each_mode_has_a_page(mode: str, tmp_path: Path) -> None:
    page = tmp_path / "rocks.html"
    assert run(["view", ROCKS, "--mode", mode, "--trials", "20", "--steps", "2", "-o", str(page)]) == 0
    step = data_of(page)["steps"][0]
    assert (step["tree"] is None) == (mode != "pomcp")
    if mode == "default":
        assert step["lower"] is None
        assert step["why"].startswith(f"{step['action']} is what the default policy does.")
    if mode == "pomcp":
        assert "mean return" in step["why"]


@pytest.mark.cxx
def test_an_episode_becomes_a_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    page = tmp_path / "rocks.html"
    addresses: list[str] = []
    monkeypatch.setattr(
        "webbrowser.open", lambda address: addresses.append(address)
    )  # gives None: no browser
    assert (
        run(
            [
                "view",
                ROCKS,
                *QUICK,
                "--steps",
                "3",
                "--episode",
                "2",
                "--step",
                "1",
                "--open",
                "-o",
                str(page),
            ]
        )
        == 0
    )
    said = capsys.readouterr().err
    assert f"page: {page}" in said and "no browser was found" in said and addresses == [page.as_uri()]
    view = data_of(page)
    assert view["version"] == 1 and view["episode"] == 2 and view["first"] == 1
    assert [one["step"] for one in view["steps"]] == [0, 1, 2]
    for step in view["steps"]:
        assert step["reward"] == pytest.approx(sum(step["terms"].values()))
        assert step["action"] in {one["name"] for one in step["tree"]["actions"]}
        assert {one["variable"] for one in step["marginals"]} >= {f"rock.good[{i}]" for i in range(8)}
        assert all("true" in one for one in step["marginals"])
    assert "rover.x" in view["end"]["state"]


@pytest.mark.cxx
@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--nonsense", "3"), "nonsense"),
        (("--step", "9", "--steps", "2", *QUICK), "--step 9: the episode has the steps 0 to 1"),
        (("-o", "/nowhere/page.html", "--steps", "1", *QUICK), "/nowhere/page.html cannot be written"),
    ],
)
def test_what_cannot_be_shown_is_refused_in_words(
    options: tuple[str, ...], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = () if "-o" in options else ("-o", str(tmp_path / "page.html"))
    assert run(["view", ROCKS, *options, *page]) == 2
    assert said in capsys.readouterr().err


def test_an_option_without_dashes_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["view", ROCKS, "despot"]) == 2
    assert "unknown option despot" in capsys.readouterr().err
