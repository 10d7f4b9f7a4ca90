# SPDX-License-Identifier: Apache-2.0
"""``hypgen view`` as a person types it."""

import json
import re
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path
from typing import Any

import pytest

from hypgen.cli.main import run

EXAMPLES = Path(__file__).parent.parent.parent / "examples"
ROCKS = str(EXAMPLES / "rock_sample.pomdp")  # other tests build the same solver
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
    if mode == "rollout":
        assert re.search(r"earned \S+ (more|less) .*than", step["why"])
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
        (("--nonsense", "3"), "unknown option --nonsense"),
        (("despot",), "unknown option despot"),
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


@pytest.mark.cxx
def test_a_run_is_watched_and_recorded(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "rocks.jsonl"
    assert run(["run", ROCKS, "--live", *QUICK, "--runs=1", "--steps=2", "--record", str(log)]) == 0
    said = capfd.readouterr()
    assert "live: http://127.0.0.1:" in said.err and "discounted return" in said.out
    kinds = [json.loads(line)["type"] for line in log.read_text().splitlines()]
    assert kinds == ["recording", "start", "step", "step", "episode"]


@pytest.mark.cxx
def test_a_run_becomes_a_log_for_robots(tmp_path: Path) -> None:
    pytest.importorskip("mcap", reason="logs in MCAP need the extra mcap")
    log = tmp_path / "rocks.mcap"
    assert run(["run", ROCKS, *QUICK, "--runs=1", "--steps=2", "--record", str(log)]) == 0
    assert log.read_bytes().startswith(b"\x89MCAP0") and list(tmp_path.iterdir()) == [log]


@pytest.mark.cxx
def test_ctrl_c_ends_a_run_that_is_watched() -> None:
    told = [sys.executable, "-c", "from hypgen.cli.main import main; main()", "run", ROCKS, "--live", *QUICK]
    with subprocess.Popen(
        [*told, "--runs=1000"], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True
    ) as watched:
        assert watched.stderr is not None
        address = next(line for line in watched.stderr if line.startswith("live: ")).split()[1]
        with urllib.request.urlopen(address, timeout=20) as page:
            assert page.status == 200
        watched.send_signal(signal.SIGINT)
        assert "Traceback" not in watched.stderr.read()
    assert watched.returncode == 130
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(address, timeout=20)


@pytest.mark.cxx
@pytest.mark.parametrize(
    ("options", "code", "said"),
    [
        (("--nonsense",), 2, "unknown option --nonsense"),
        (("--record", "-"), 2, "--record: expected a file"),
        (("--serve",), 2, "--serve plays no episodes that --live could show"),
        # As without --live: the solver failed.
        (("--record", "/nowhere/log.jsonl"), 1, "error: /nowhere/log.jsonl cannot be written: No such file"),
        (("--record", "/dev/full"), 1, "error: /dev/full cannot be written: No space left on device"),
    ],
)
def test_what_cannot_be_watched_is_refused_in_words(
    options: tuple[str, ...], code: int, said: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(["run", ROCKS, "--live", *QUICK, *options]) == code
    told = capfd.readouterr().err
    assert said in told and "Broken pipe" not in told
