# SPDX-License-Identifier: Apache-2.0
from pathlib import Path
from xml.etree import ElementTree

import pytest
from support import synthetic_cells

from hypgen.experiments.reports import read_report
from hypgen.experiments.reports.figure_file import figure_style
from hypgen.experiments.reports.figures import Figure, axes_of, figures_of, task_axis
from hypgen.experiments.suite import Task
from hypgen.experiments.tables import Table

HEAD = """
title = "T"
[tasks.small]
model = "rocks.pomdp"
set = { size = 7, name = "a" }
[tasks.large]
model = "rocks.pomdp"
set = { size = 20, name = "b" }
"""


def tables(folder: Path, study: str) -> list[Table]:
    text = f'{HEAD}[[study]]\nname = "s"\nruns = 4\nepisodes_a_cell = 4\n{study}'
    path = synthetic_cells.write_suite(folder, text)
    synthetic_cells.play(path, folder / "out")
    return read_report(folder / "out").tables


def one(folder: Path, study: str) -> list[Figure]:
    return [figure for _, figure in figures_of(tables(folder, f'tasks = ["small"]\n{study}'))]


def test_modes_alone_give_dots_with_speed_ups(tmp_path: Path) -> None:
    [figure] = one(tmp_path, 'play = ["despot", { mode = "hyp", threads = 16 }]\ntime = 1.0\n')
    assert figure.axis == ""
    assert [panel.quantity for panel in figure.panels] == ["return", "success rate", "expansions a step"]
    assert [line.label for line in figure.panels[0].series] == [
        "default", "rollout", "despot", "hyp, threads 16",
    ]  # fmt: skip
    expansions = figure.panels[2]
    assert expansions.is_log and [line.mode for line in expansions.series] == ["despot", "hyp"]
    assert expansions.series[1].points[0].note.endswith("\u00d7 despot")


def test_an_option_with_numbers_is_an_axis_with_a_line_for_each_mode(tmp_path: Path) -> None:
    [figure] = one(tmp_path, 'play = ["despot", "pomcp"]\ntime = [0.1, 1.0, 1.5]\n')
    assert (figure.axis, figure.is_log) == ("time", True)
    assert [panel.quantity for panel in figure.panels] == [
        "return", "success rate", "tree size, nodes", "depth of the tree",
    ]  # fmt: skip
    by_mode = {line.mode: line for line in figure.panels[0].series}
    assert by_mode["default"].is_level and len(by_mode["default"].points) == 1
    assert [point.x for point in by_mode["pomcp"].points] == [0.1, 1.0, 1.5]
    assert list(by_mode) == ["default", "rollout", "despot", "pomcp"]
    assert [line.mode for line in figure.panels[2].series] == ["despot", "pomcp"], "others have no tree"


def test_values_within_a_factor_of_ten_have_a_linear_axis(tmp_path: Path) -> None:
    [figure] = one(tmp_path, "time = [0.1, 1.0]\n")
    assert not figure.is_log


def test_threads_are_an_axis_only_where_a_mode_plays_several(tmp_path: Path) -> None:
    study = 'play = ["despot", "parallel"]\nthreads = [1, 2, 4]\ntime = 0.1\n'
    [figure] = one(tmp_path, study)
    assert figure.axis == "threads"
    assert {line.mode: line.is_level for line in figure.panels[0].series} == {
        "default": True, "rollout": True, "despot": True, "parallel": False,
    }  # fmt: skip


def test_too_many_lines_are_divided_by_the_other_option(tmp_path: Path) -> None:
    study = 'play = ["despot", "pomcp"]\nbeside = false\nagainst = "despot"\n'
    study += "time = [0.1, 1.0]\nscenarios = [10, 20, 30, 40]\n"
    time, scenarios = one(tmp_path, study)
    assert (time.axis, scenarios.axis) == ("time", "scenarios")
    assert [(panel.quantity, panel.about) for panel in time.panels] == [
        (quantity, f"scenarios {count}")
        for quantity in ("return", "success rate")
        for count in (10, 20, 30, 40)
    ]
    assert all(len(panel.series) == 2 for panel in time.panels)
    assert {line.label for line in scenarios.panels[0].series} == {
        f"{mode}, time {value}" for mode in ("despot", "pomcp") for value in (0.1, 1.0)
    }
    assert [line.variant for line in scenarios.panels[0].series] == [0, 1, 0, 1]


def test_tasks_that_a_number_tells_apart_have_a_figure_over_them(tmp_path: Path) -> None:
    found = figures_of(tables(tmp_path, 'play = ["despot", { mode = "hyp", threads = 4 }]\ntime = 1.0\n'))
    assert [task for task, _ in found] == ["small", "large", ""]
    over = found[-1][1]
    assert over.axis == "size"
    assert [panel.quantity for panel in over.panels] == [
        "return", "success rate", "tree size, nodes", "speed-up against despot",
    ]  # fmt: skip
    assert [point.x for point in over.panels[0].series[0].points] == [7.0, 20.0]


def test_the_axis_of_tasks_is_what_they_say_or_their_only_number() -> None:
    def task(name: str, size: int, people: int, *at: tuple[str, float]) -> Task:
        return Task(name, Path("m.pomdp"), settings=(f"size={size}", f"people={people}", "kind=a"), at=at)

    assert task_axis([task("a", 1, 2)]) is None
    assert task_axis([task("a", 1, 2), task("b", 1, 2)]) is None
    assert task_axis([task("a", 1, 2), task("b", 3, 4)]) is None, "which of the two?"
    found = task_axis([task("a", 1, 2), task("b", 1, 5)])
    assert found is not None and found[0] == "people" and list(found[1].values()) == [2.0, 5.0]
    found = task_axis([task("a", 1, 2, ("actions", 256)), task("b", 3, 4, ("actions", 400))])
    assert found is not None and found[0] == "actions"


@pytest.mark.parametrize(("at", "places"), [("", []), ("at = { time = 0.5 }\n", [0.5])])
def test_published_values_stand_where_they_say(tmp_path: Path, at: str, places: list[float]) -> None:
    text = '[[study.published]]\ntask = "small"\nlabel = "X"\nreturn = 9\ninterval = [8, 11]\n'
    study = f'time = [0.1, 1.0]\n{text}{at}source = "p"\ndiffers = "d"\n'
    [figure] = one(tmp_path, study)
    assert [mark.point.x for mark in figure.panels[0].marks] == places
    assert all(mark.letter == "A" and mark.point.y.low == 8 for mark in figure.panels[0].marks)
    assert not figure.panels[1].marks, "no success is published"


def test_an_option_that_stands_for_all_is_no_axis(tmp_path: Path) -> None:
    rows = tables(tmp_path, "time = 1.0\nscenarios = 50\n")[0].rows
    assert axes_of(rows) == []


def test_figures_are_files_with_their_legends_and_their_style(tmp_path: Path) -> None:
    tables(tmp_path, 'tasks = ["small", "large"]\nplay = ["despot", "pomcp"]\ntime = [0.1, 1.0, 1.5]\n')
    figures = read_report(tmp_path / "out").figures()
    assert list(figures) == ["s-small", "s-large", "s"]
    for text in figures.values():
        root = ElementTree.fromstring(text)
        assert float(root.attrib["width"]) > 0 and float(root.attrib["height"]) > 0
        assert (root.findtext("{*}style") or "").strip() == figure_style().strip()
    assert ">pomcp</text>" in figures["s-small"]
