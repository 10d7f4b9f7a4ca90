# SPDX-License-Identifier: Apache-2.0
"""A suite: tasks, the settings that play them, and how many episodes. docs/guide/bench.md has its form."""

from __future__ import annotations

import itertools
import json
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hypgen.dsl.messages.diagnostic import did_you_mean
from hypgen.experiments.measures import Measure, measure_of
from hypgen.experiments.published import Published, publication_of
from hypgen.experiments.suite_values import (
    BESIDE,
    MODES,
    ON_GPU,
    THREADED,
    SuiteError,
    check_keys,
    number_of,
    numbers_of,
    strings_of,
    table_of,
    text_of,
)

_SUITE = ("title", "tasks", "study")
_TASK = ("model", "instance", "set", "param", "name", "at")
_STUDY = (
    "name", "tasks", "play", "runs", "seed", "against", "beside", "episodes_a_cell", "measure", "published",
)  # fmt: skip
_OURS = ("runs", "first_run", "json", "quiet", "param", "settings", "seed", "help", "version")  # bench's own
_BUDGETS = ("time", "period", "trials")
# What the default policy does not take up: it plays once, whatever the searches beside it are told.
_OF_SEARCHES = (
    *_BUDGETS, "scenarios", "threads", "depth", "xi", "pruning", "rollouts", "in_flight", "observation_loss",
    "exploration", "memory", "device_memory", "patience",
)  # fmt: skip

FIRST = "first"  # in place of a mode: what others are compared with is the first setting of the task

Value = bool | int | float | str


@dataclass(frozen=True)
class Task:
    """A model with its instance and values. ``settings`` are texts "NAME=VALUE".

    ``param`` is a JSON file of params, or of a list of them, which the cells of a study take in turn.
    ``at`` places the task on the axes of figures over several tasks.
    """

    name: str
    model: Path
    instance: Path | None = None
    settings: tuple[str, ...] = ()
    param: Path | None = None
    at: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Setting:
    """A task and the solver's options. ``labels`` tell it from the study's other settings."""

    task: Task
    labels: tuple[tuple[str, Value], ...]
    options: tuple[tuple[str, Value], ...]
    seed: int

    @property
    def mode(self) -> str:
        """How it plans."""
        return str(dict(self.options)["mode"])

    @property
    def threads(self) -> int:
        """How many cores its process takes."""
        return int(dict(self.options).get("threads", 1))

    @property
    def seconds(self) -> float:
        """About how long a decision takes; 0 where trials limit it."""
        return float(next((value for name, value in self.options if name in ("time", "period")), 0.0))

    @property
    def wants_gpu(self) -> bool:
        """Whether its process has a GPU to itself."""
        return self.mode in ON_GPU

    @property
    def group(self) -> tuple[tuple[str, Value], ...]:
        """The labels but for the mode: settings of one group are compared with each other."""
        return tuple((name, value) for name, value in self.labels if name != "mode")

    def arguments(self) -> list[str]:
        """Return the options as the solver takes them."""
        given = [*self.options, ("seed", self.seed)]
        return [word for name, value in given for word in _words(name, value)]

    def __str__(self) -> str:
        return f"{self.task.name}, {' '.join(_label(name, value) for name, value in self.labels)}"


@dataclass(frozen=True)
class Study:
    """Settings that play the same episodes of each task, each compared with those of the modes ``against``.

    One of a mode of ``against`` is compared with those of the modes before. ``FIRST`` is the first setting.
    """

    name: str
    settings: tuple[Setting, ...]
    runs: int
    against: tuple[str, ...]
    episodes_a_cell: int
    published: tuple[Published, ...] = ()
    measures: tuple[Measure, ...] = ()


@dataclass(frozen=True)
class Suite:
    """All studies of a file."""

    title: str
    path: Path
    studies: tuple[Study, ...]


def read_suite(path: Path) -> Suite:
    """Return the suite of a file; raise ``SuiteError`` where it cannot be played."""
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise SuiteError(f"the suite '{path}' cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SuiteError(f"{path} is not TOML: {error}") from None
    check_keys(data, _SUITE, str(path))
    texts = table_of(data, "tasks", str(path))
    tasks = {name: _task(name, text, path) for name, text in texts.items()}
    shown = [task.name for task in tasks.values()]
    if doubled := next((name for name in shown if shown.count(name) > 1), None):
        raise SuiteError(f"{path}: two tasks have the name {doubled!r}")
    studies = tuple(
        _study(study, tasks, f"{path}, study {i}") for i, study in enumerate(_studies(data, path), 1)
    )
    names = [study.name for study in studies]
    if doubled := next((name for name in names if names.count(name) > 1), None):
        raise SuiteError(f"{path}: two studies have the name {doubled!r}")
    return Suite(text_of(data, "title", str(path), path.stem), path, studies)


def _studies(data: Mapping[str, Any], path: Path) -> list[dict[str, Any]]:
    found = data.get("study", [])
    if not isinstance(found, list) or not found or not all(isinstance(one, dict) for one in found):
        raise SuiteError(f"{path}: expected at least one [[study]]")
    return found


def _task(name: str, text: Any, path: Path) -> Task:
    where = f"{path}, task {name}"
    if not isinstance(text, dict):
        raise SuiteError(f"{where}: expected a table with `model`")
    check_keys(text, _TASK, where)
    files = {key: _file(text, key, where, path) for key in ("model", "instance", "param")}
    if files["model"] is None:
        raise SuiteError(f"{where}: `model` is missing")
    if files["param"] is not None:
        _check_params(files["param"], where)
    values = table_of(text, "set", where)
    settings = tuple(f"{key}={_as_model_text(value)}" for key, value in values.items())
    return Task(
        text_of(text, "name", where, name),
        files["model"],
        files["instance"],
        settings,
        files["param"],
        numbers_of(text, "at", where),
    )


def _file(text: Mapping[str, Any], key: str, where: str, suite: Path) -> Path | None:
    """Return a file that a suite names; its path is relative to the suite's."""
    if key not in text:
        return None
    file = suite.parent / text_of(text, key, where)
    if not file.is_file():
        raise SuiteError(f"{where}: `{key}` names '{file}', which is no file")
    return file


def _check_params(path: Path, where: str) -> None:
    """Refuse a file that is neither params nor a list of them; the solver checks their values."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise SuiteError(f"{where}: `param` names '{path}', which is no JSON: {error}") from None
    each = found if isinstance(found, list) else [found]
    if not each or not all(isinstance(one, dict) for one in each):
        raise SuiteError(f"{where}: `param` names '{path}': expected an object of params, or a list of them")


def _study(text: dict[str, Any], tasks: Mapping[str, Task], where: str) -> Study:
    name = text_of(text, "name", where)
    where = f"{where} ({name})"
    played = strings_of(text, "tasks", where, list(tasks))
    for task in played:
        if task not in tasks:
            raise SuiteError(
                f"{where}: there is no task {task!r}. {did_you_mean(task, tuple(tasks))}".strip()
            )
    runs = number_of(text, "runs", where, None, 1)
    axes = {key: value for key, value in text.items() if key not in _STUDY}
    searches = text.get("play", ["despot"])
    if not isinstance(searches, list) or not searches:
        raise SuiteError(f"{where}: `play` is a list of modes, or of tables with `mode` and options")
    beside = text.get("beside", True)
    if not isinstance(beside, bool):
        raise SuiteError(f"{where}: `beside` is true or false")
    known = [one.get("mode") if isinstance(one, dict) else one for one in searches]
    play = [*(mode for mode in BESIDE if beside and mode not in known), *searches]
    seed = number_of(text, "seed", where, 1, 0)
    settings = [
        Setting(tasks[task], *_labelled(options, where), seed)
        for task in played
        for one in play
        for options in _product({**axes, **_own(one, where)}, where)
    ]
    against = text.get("against", "default")
    against = [against] if isinstance(against, str) else strings_of(text, "against", where, [])
    for mode in against:
        if mode != FIRST and mode not in {setting.mode for setting in settings}:
            raise SuiteError(f"{where}: `against` names the mode {mode!r}, which does not play")
    measures = tuple(
        measure_of(one, f"{where}, measure {i}") for i, one in enumerate(_tables(text, "measure", where), 1)
    )
    shown = [measure.name for measure in measures]
    if doubled := next((one for one in shown if shown.count(one) > 1), None):
        raise SuiteError(f"{where}: two measures have the name {doubled!r}")
    return Study(
        name,
        tuple(settings),
        runs,
        tuple(against),
        number_of(text, "episodes_a_cell", where, 5, 1),
        tuple(
            publication_of(
                one,
                {key: tasks[key].name for key in played},
                tuple(measure.name for measure in measures),
                f"{where}, published {i}",
            )
            for i, one in enumerate(_tables(text, "published", where), 1)
        ),
        measures,
    )


def _tables(text: Mapping[str, Any], key: str, where: str) -> list[Any]:
    found = text.get(key, [])
    if not isinstance(found, list):
        raise SuiteError(f"{where}: `{key}` is written as [[study.{key}]]")
    return found


def _own(one: Any, where: str) -> dict[str, Any]:
    """Return an item of ``play`` as options."""
    own = {"mode": one} if isinstance(one, str) else one
    if not isinstance(own, dict) or "mode" not in own:
        raise SuiteError(f"{where}: an item of `play` is a mode, or a table with `mode` and options")
    return own


def _product(axes: Mapping[str, Any], where: str) -> Iterator[dict[str, Value]]:
    """Yield the options of each combination of values; a list has several."""
    lists = {name: value if isinstance(value, list) else [value] for name, value in axes.items()}
    for name, values in lists.items():
        if not values or not all(isinstance(one, Value) for one in values):
            raise SuiteError(f"{where}: `{name}` is a value of a solver's option, or a list of them")
        if name in _OURS:
            raise SuiteError(f"{where}: `{name}` is no option of a setting: `hypgen bench` chooses it")
    for combination in itertools.product(*lists.values()):
        yield dict(zip(lists, combination, strict=True))


def _labelled(
    options: dict[str, Value], where: str
) -> tuple[tuple[tuple[str, Value], ...], tuple[tuple[str, Value], ...]]:
    """Return the labels of a setting, and what its solver is told."""
    mode = options["mode"]
    if mode not in MODES:
        raise SuiteError(f"{where}: there is no mode {mode!r}; there are {', '.join(MODES)}")
    if mode != "default" and not any(budget in options for budget in _BUDGETS):
        raise SuiteError(f"{where}: mode {mode!r} needs a budget: `time`, `period` or `trials`")
    threads = options.get("threads", 1)
    if mode in THREADED and (
        "threads" not in options or isinstance(threads, bool) or not isinstance(threads, int)
    ):
        raise SuiteError(f"{where}: mode {mode!r} needs a number of `threads`")
    unused = _OF_SEARCHES if mode == "default" else () if mode in THREADED else ("threads",)
    told = {name: value for name, value in options.items() if name not in unused}
    unlabelled = ("mode",) if mode in THREADED else ("mode", "threads")
    labels = (("mode", mode), *((key, value) for key, value in options.items() if key not in unlabelled))
    return labels, (*told.items(), *((("require_gpu", True),) if mode in ON_GPU else ()))


def _words(name: str, value: Value) -> list[str]:
    option = f"--{name.replace('_', '-')}"
    if isinstance(value, bool):
        return [option] if value else []
    return [f"{option}={value}"]


def _label(name: str, value: Value) -> str:
    return str(value) if name == "mode" else f"{name} {value}"


def _as_model_text(value: Any) -> str:
    """Return a value as a model writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return f"[{', '.join(map(_as_model_text, value))}]"
    return str(value)
