# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

import pytest

from hypgen.experiments.cells import cells_of
from hypgen.experiments.store import Failure, Store
from hypgen.experiments.suite import Suite, read_suite
from hypgen.experiments.suite_values import SuiteError

HEAD = 'title = "T"\n[tasks.tiger]\nmodel = "tiger.pomdp"\n'
STUDY = '[[study]]\nname = "modes"\nruns = 7\n'


def suite(folder: Path, text: str) -> Suite:
    (folder / "tiger.pomdp").write_text("model Tiger\n")
    path = folder / "suite.toml"
    path.write_text(text)
    return read_suite(path)


def test_lists_play_all_combinations_beside_the_simple_policies(tmp_path: Path) -> None:
    [study] = suite(tmp_path, HEAD + STUDY + 'play = ["despot"]\ntime = [0.1, 1]\nxi = [0.9, 0.95]\n').studies
    shown = [str(setting) for setting in study.settings]
    assert shown == [
        f"tiger, {mode} time {time} xi {xi}"
        for mode in ("default", "rollout", "despot")
        for time in (0.1, 1)
        for xi in (0.9, 0.95)
    ]
    assert study.settings[-1].arguments() == ["--time=1", "--xi=0.95", "--mode=despot", "--seed=1"]
    assert study.settings[0].arguments() == ["--mode=default", "--seed=1"], "it has no search"


def test_cells_come_in_waves_and_equal_settings_are_played_once(tmp_path: Path) -> None:
    text = HEAD + STUDY + 'play = ["despot"]\ntrials = [5, 9]\nbeside = true\n'
    cells = cells_of(suite(tmp_path, text).studies, {"tiger": "abc"})
    assert [(cell.setting.mode, cell.first, cell.runs) for cell in cells] == [
        (mode, first, runs)
        for first, runs in ((0, 5), (5, 2))
        for mode in ("default", "rollout", "rollout", "despot", "despot")
    ]
    assert len({cell.key for cell in cells}) == len(cells)
    assert {cell.key for cell in cells}.isdisjoint(
        cell.key for cell in cells_of(suite(tmp_path, text).studies, {"tiger": "other code"})
    )


def test_a_param_file_is_part_of_a_cells_name(tmp_path: Path) -> None:
    text = HEAD + 'param = "values.json"\n' + STUDY + 'play = ["default"]\n'
    keys = []
    for values in ("{}", "{} ", "{}"):
        (tmp_path / "values.json").write_text(values)
        keys.append(cells_of(suite(tmp_path, text + "beside = false\n").studies, {"tiger": "abc"})[0].key)
    assert keys[0] == keys[2] != keys[1]


def test_cells_take_a_list_of_params_in_turn(tmp_path: Path) -> None:
    text = HEAD + 'param = "values.json"\n' + STUDY + "trials = 9\nepisodes_a_cell = 2\n"
    (tmp_path / "values.json").write_text('[{"x": 1}, {"x": 2}, {"x": 3}]')
    cells = cells_of(suite(tmp_path, text).studies, {"tiger": "abc"})
    assert {(cell.first, cell.param) for cell in cells} == {
        (0, '{"x": 1}'), (2, '{"x": 2}'), (4, '{"x": 3}'), (6, '{"x": 1}'),
    }  # fmt: skip
    assert len({cell.key for cell in cells}) == len(cells) == 3 * 4


@pytest.mark.parametrize("params", ["", "[]", "[1]", "7"])
def test_what_is_wrong_with_params_is_said(tmp_path: Path, params: str) -> None:
    (tmp_path / "values.json").write_text(params)
    with pytest.raises(SuiteError, match=r"task tiger: `param` names '.*values.json'"):
        suite(tmp_path, HEAD + 'param = "values.json"\n' + STUDY + "trials = 9\n")


def test_threads_tell_settings_of_threaded_modes_apart(tmp_path: Path) -> None:
    text = HEAD + STUDY + 'play = ["despot", "parallel"]\nbeside = false\nagainst = "despot"\n'
    [study] = suite(tmp_path, text + "threads = [1, 2]\ntime = 1\n").studies
    assert [str(setting) for setting in dict.fromkeys(study.settings)] == [
        "tiger, despot time 1", "tiger, parallel threads 1 time 1", "tiger, parallel threads 2 time 1",
    ]  # fmt: skip


PUBLISHED = HEAD + STUDY + "time = 1\n[[study.published]]\n"
WHOLE = 'task = "tiger"\nlabel = "X"\nsource = "a paper"\ndiffers = "the machine"\nreturn = 5\n'


def test_published_values_have_a_source_and_what_differs(tmp_path: Path) -> None:
    text = PUBLISHED + WHOLE + "interval = 0.5\nsuccess = 0.25\nat = { time = 1 }\n"
    [one] = suite(tmp_path, text).studies[0].published
    assert (one.task, one.interval, one.at) == ("tiger", (4.5, 5.5), (("time", 1),))
    assert dict(one.values) == {"return": 5, "success": 0.25}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "`task` is missing"),
        ('task = "lion"\n', "the study plays no task 'lion'; it plays tiger"),
        (WHOLE.replace('label = "X"\n', ""), "`label` is missing"),
        (WHOLE.replace('differs = "the machine"\n', ""), "`differs` is missing"),
        (WHOLE.replace("return = 5", "reward = 5"), "unknown key `reward`"),
        (WHOLE.replace("return = 5\n", ""), "expected at least one of return, success"),
        (WHOLE.replace("return = 5", 'return = "5"'), "`return` is a number"),
        (WHOLE + "success = 97\n", "`success` is a share from 0 to 1"),
        (WHOLE + "measured = { waits = 3 }\n", "the study has no measure 'waits'"),
        (WHOLE + 'mode = "fast"\n', "there is no mode 'fast'"),
        (WHOLE + "interval = [6, 4]\n", "`interval` is the half width"),
        (WHOLE + "at = { time = true }\n", "`time` is a number"),
    ],
)
def test_what_is_wrong_with_published_values_is_said(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(SuiteError) as error:
        suite(tmp_path, PUBLISHED + text)
    assert says in str(error.value) and "study 1 (modes), published 1" in str(error.value)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("tasks = 1\n", "`tasks` is a table"),
        (HEAD, "expected at least one [[study]]"),
        ("title = \n", "is not TOML"),
        (HEAD + "[[studies]]\n", "unknown key `studies`: did you mean 'study'?"),
        (HEAD + "speed = 1\n" + STUDY, "task tiger: unknown key `speed`"),
        (HEAD + '[tasks.lion]\nmodel = "lion.pomdp"\n' + STUDY, "lion.pomdp', which is no file"),
        (HEAD + "[tasks.lion]\n" + STUDY, "task lion: `model` is missing"),
        (HEAD + '[[study]]\nname = "a"\n', "study 1 (a): `runs` is missing"),
        (HEAD + '[[study]]\nname = "a"\nruns = 0\n', "`runs` is a whole number from 1"),
        (HEAD + STUDY + 'tasks = ["tigre"]\n', "there is no task 'tigre'. did you mean 'tiger'?"),
        (HEAD + STUDY + 'play = ["depot"]\ntime = 1\n', "there is no mode 'depot'"),
        (HEAD + STUDY, "mode 'rollout' needs a budget: `time`, `period` or `trials`"),
        (HEAD + STUDY + 'play = ["parallel"]\ntime = 1\n', "mode 'parallel' needs a number of `threads`"),
        (HEAD + STUDY + "time = []\n", "`time` is a value of a solver's option, or a list of them"),
        (HEAD + STUDY + "time = 1\nfirst_run = 3\n", "`first_run` is no option of a setting"),
        (HEAD + STUDY + 'time = 1\nagainst = "hyp"\n', "`against` names the mode 'hyp', which does not play"),
        (HEAD + STUDY + "time = 1\nagainst = []\n", "`against` is a list of texts"),
        (HEAD + STUDY + "time = 1\nmeasure = 3\n", "`measure` is written as [[study.measure]]"),
        (HEAD + STUDY + "time = 1\npublished = [3]\n", "values are written as [[study.published]]"),
        (
            HEAD + STUDY + 'time = 1\n[[study.measure]]\nname = "a"\n',
            "measure 1: expected one of `visible`, `action` and `failure = true`",
        ),
        (
            HEAD + STUDY + 'time = 1\n[[study.measure]]\nname = "a"\nfailure = false\n',
            "measure 1: `failure` is true",
        ),
        (
            HEAD + STUDY + "time = 1\n" + '[[study.measure]]\nname = "a"\naction = "b"\n' * 2,
            "two measures have the name 'a'",
        ),
        (
            HEAD + '[tasks.b]\nmodel = "tiger.pomdp"\nname = "tiger"\n' + STUDY,
            "two tasks have the name 'tiger'",
        ),
        (HEAD + (STUDY + "time = 1\n") * 2, "two studies have the name 'modes'"),
    ],
)
def test_what_is_wrong_with_a_suite_is_said(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(SuiteError) as error:
        suite(tmp_path, text)
    assert says in str(error.value)


def test_a_folder_belongs_to_one_suite(tmp_path: Path) -> None:
    store = Store(tmp_path / "out")
    store.open("T")
    store.open("T")
    with pytest.raises(SuiteError, match="has the cells of the suite 'T'"):
        store.open("another")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years of work")
    with pytest.raises(SuiteError, match="files that are no suite's"):
        Store(tmp_path / "mine").open("T")
    with pytest.raises(SuiteError, match="cannot be used"):
        Store(tmp_path / "mine" / "thesis.tex").open("T")


def test_a_cell_is_kept_whole_and_a_failure_with_its_reason(tmp_path: Path) -> None:
    [cell, *_] = cells_of(suite(tmp_path, HEAD + STUDY + "trials = 3\n").studies, {"tiger": "abc"})
    store = Store(tmp_path / "out")
    store.open("T")
    assert not store.has(cell)
    store.fail(Failure(cell, "it hung"))
    assert store.failure(cell) == "it hung" and not store.has(cell)
    store.put(cell, {"machine": {}}, '{"type": "run"}\n')
    assert store.has(cell) and store.failure(cell) == ""
    assert [line["type"] for line in store.lines(cell)] == ["cell", "run"]
    assert sorted(path.suffix for path in store.folder.iterdir()) == [".json", ".jsonl"]
