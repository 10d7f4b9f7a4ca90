# SPDX-License-Identifier: Apache-2.0
import csv
import io
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from support import synthetic_cells

from hypgen.cli.main import run
from hypgen.experiments.cells import Cell, cells_of
from hypgen.experiments.reports import Report, read_report
from hypgen.experiments.store import Failure
from hypgen.experiments.suite import read_suite
from hypgen.experiments.suite_values import SuiteError

SUITE = """
title = "Rocks & <robots>"
[tasks.rocks]
model = "rocks.pomdp"
[[study]]
name = "time"
runs = 10
play = ["despot", { mode = "parallel", threads = 4 }]
time = [0.1, 1.0]
against = ["default", "rollout"]
[[study.measure]]
name = "way, m"
visible = "robot.x"
times = 0.5
[[study.measure]]
name = "waits"
action = "wait"
[[study.measure]]
name = "failures"
failure = true
[[study.published]]
task = "rocks"
label = "DESPOT of others"
mode = "despot"
at = { time = 1.0 }
return = 20.93
interval = 0.3
success = 0.5
measured = { waits = 7 }
source = "Ye et al., table 1"
differs = "another layout </script>"
"""
VOID = {"meta", "path", "circle"}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return synthetic_cells.write_suite(tmp_path, SUITE)


@pytest.fixture
def whole(path: Path, tmp_path: Path) -> Report:
    synthetic_cells.play(path, tmp_path / "out")
    return read_report(tmp_path / "out")


class Elements(HTMLParser):
    """Checks that all elements are closed in order, and keeps their attributes."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += [(name, value or "") for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop() == tag


def test_the_page_is_one_well_formed_file_that_asks_for_no_other(whole: Report) -> None:
    page = whole.page()
    elements = Elements(page)
    assert elements.open == []
    links = [value for name, value in elements.attributes if name in ("href", "src")]
    assert links and all(link.startswith(("#", "data:")) for link in links)
    assert "url(" not in page and "@import" not in page and "http" not in page
    assert "Rocks &amp; &lt;robots&gt;" in page


def test_the_page_says_what_when_where_and_how(whole: Report) -> None:
    page = whole.page()
    assert "Played on 2026-11-30 10:00 UTC." in page
    assert "AMD EPYC 7763 64-Core Processor, 16 cores" in page and "g++ 13.2.0" in page
    assert "hypgen bench suite.toml --only time" in page
    assert 'class="warning"' not in page and "not played to the end" not in page
    for text in ("despot, time 0.1", "minus default", "70 of 70 episodes", "how searches ended"):
        assert text in page
    assert page.count('<svg class="panel"') == 4
    assert "DESPOT of others" in page and "Ye et al., table 1" in page
    assert "Differs: another layout &lt;/script&gt;" in page


def test_rows_have_the_colours_of_their_modes(whole: Report) -> None:
    found = re.findall(r'<i class="dot m-(\w+)"></i>(\w+)', whole.page())
    assert [mode for mode, label in found if mode == label] == [
        "default", "rollout", "rollout", "despot", "despot", "parallel", "parallel",
    ]  # fmt: skip
    assert len(found) == 8, "the last is published"


def test_the_data_are_within_the_page_and_as_csv(whole: Report) -> None:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', whole.page(), re.DOTALL)
    assert found is not None
    data = json.loads(found[1])
    assert data["title"] == "Rocks & <robots>"
    rows = {row["setting"]: row for row in data["rows"]}
    assert rows["default"]["episodes"] == 10 and rows["default"]["speed_up"] is None
    parallel = rows["parallel, time 1.0, threads 4"]
    assert parallel["minus_default_shown"] is True and parallel["minus_rollout_pairs"] == 10
    assert "minus_rollout" not in rows["rollout, time 1.0"], "it is compared with the modes before it"
    assert (parallel["way, m"], parallel["waits"]) == (0.5 * 4.5, 2.0)
    assert parallel["failures"] == pytest.approx(1.0 - parallel["success"])
    assert rows["DESPOT of others"]["waits"] == 7
    assert rows["parallel, time 1.0, threads 4"]["speed_up"] == pytest.approx(14, rel=0.2)
    assert rows["DESPOT of others"]["differs"] == "another layout </script>"
    table = list(csv.DictReader(io.StringIO(whole.csv())))
    assert [row["setting"] for row in table] == list(rows)
    assert float(table[0]["return"]) == pytest.approx(rows["default"]["return"])
    assert table[-1]["kind"] == "published" and table[-1]["return_high"] == "21.23"


def test_what_is_missing_failed_and_mixed_is_said(path: Path, tmp_path: Path) -> None:
    other = {**synthetic_cells.MACHINE, "processor": "Xeon 6", "cores": -1}

    def is_left_out(cell: Cell) -> bool:
        labels = dict(cell.setting.labels)
        return labels["mode"] == "despot" and (labels["time"] == 1.0 or cell.first == 5)

    store = synthetic_cells.play(
        path,
        tmp_path / "out",
        lambda cell: not is_left_out(cell),
        lambda cell: other if cell.setting.mode == "parallel" else synthetic_cells.MACHINE,
    )
    for cell in cells_of(read_suite(path).studies, {"rocks": "abc"}):
        if is_left_out(cell) and dict(cell.setting.labels)["time"] == 1.0:
            store.fail(Failure(cell, "the solver was ended by signal 11"))
    page = read_report(tmp_path / "out").page()
    assert Elements(page).open == []
    assert "1 failed" in page and "rocks: despot, time 1.0: the solver was ended by signal 11" in page
    assert "1 not played to the end" in page and "rocks: despot, time 0.1: 5 of 10 episodes" in page
    assert "Some tables mix machines, compilers or versions of hypgen: time, rocks" in page
    assert "processors AMD EPYC 7763 64-Core Processor and Xeon 6" in page
    assert "4 of 11 cells began on a machine with more to do than it has cores" in page
    assert ">M2<" in page and "Not all episodes are played" in page


def test_nothing_played_is_a_page_that_says_so(path: Path, tmp_path: Path) -> None:
    synthetic_cells.play(path, tmp_path / "out", lambda cell: False)
    page = read_report(tmp_path / "out").page()
    assert Elements(page).open == []
    assert "No episode is played yet." in page and "0 of 70 episodes" in page and "<table>" not in page


def test_a_file_that_is_no_cell_is_named(path: Path, tmp_path: Path) -> None:
    synthetic_cells.play(path, tmp_path / "out")
    cell = next((tmp_path / "out").glob("*.jsonl"))
    for text in ("not JSON\n", '{"type": "step"}\n', "[1]\n"):
        cell.write_text(text)
        with pytest.raises(SuiteError) as error:
            read_report(tmp_path / "out")
        assert str(cell) in str(error.value) and "delete it" in str(error.value)


def test_the_command_writes_the_page_and_its_data(
    path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    synthetic_cells.play(path, out, lambda cell: cell.first == 0)
    assert run(["report", str(out), "--csv", str(tmp_path / "t.csv")]) == 0
    assert "7 of 7 settings are not played to the end" in capsys.readouterr().err
    assert (out / "report.html").read_text().startswith("<!doctype html>")
    assert (tmp_path / "t.csv").read_text().startswith("study,task,kind,setting,mode")
    assert run(["report", str(out), "-o", str(tmp_path / "none" / "p.html")]) == 2
    assert "cannot be written: No such file or directory" in capsys.readouterr().err
    (tmp_path / "empty").mkdir()
    assert run(["report", str(tmp_path / "empty")]) == 2
    assert "is no folder of a suite" in capsys.readouterr().err


def test_parquet_without_polars_says_what_to_install(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import importlib.util

    real = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "polars" else real(name))
    assert run(["report", str(tmp_path), "--parquet", str(tmp_path / "e.parquet")]) == 2
    assert "Parquet needs polars: pip install 'hypgen[parquet]'" in capsys.readouterr().err


def test_parquet_has_a_row_for_each_episode(whole: Report, tmp_path: Path) -> None:
    polars = pytest.importorskip("polars")
    whole.write_parquet(tmp_path / "e.parquet")
    frame = polars.read_parquet(tmp_path / "e.parquet")
    assert len(frame) == 7 * 10
    assert frame["discounted_return"].dtype == polars.Float64
    assert frame["option.time"].dtype == polars.Float64
    assert frame["option.time"].null_count() == 10, "the default policy takes no time"
