# SPDX-License-Identifier: Apache-2.0
"""The blocks of the guides: commands run in short, Python and data are what the package takes.

Numbers in commands become small, and models that no other test compiles become Tiger or RockSample.
"""

import ast
import inspect
import io
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click
import numpy
import pytest
from support.console import output

import hypgen
from hypgen.cli import main
from hypgen.codegen.generate import generate_library
from hypgen.dsl.load import load
from hypgen.experiments.suite import read_suite
from hypgen.runtime import builder
from hypgen.runtime.builder import tools

ROOT = Path(__file__).parents[2]
OTHER_TESTS_RUN = ("docs/guide/tutorial.md", "docs/guide/tools.md")  # those of their names
PAGES = [
    "README.md",
    *sorted(str(p.relative_to(ROOT)) for p in (ROOT / "docs" / "guide").glob("*.md")),
    "docs/reference/recording.md",
]
TIGER, ROCKS = "examples/tiger.pomdp", "examples/rock_sample.pomdp"
BLOCK = re.compile(r"^ *```(\S*)[^\n]*\n(.*?)^ *```", re.DOTALL | re.MULTILINE)
# What a reader gives seconds or minutes.
SMALL = {
    "--runs": "2",
    "--samples": "300",
    "--beliefs": "60",
    "--bounds": "50",
    "--particles": "200",
    "--seconds": "0.1",
    "--episode": "1",
    "--step": "0",
}
MORE = {
    "run": ["--runs=2", "--trials=5", "--steps=3", "--target=cpu"],
    "compare": ["--runs=2", "--trials=5", "--steps=3", "--modes=default,despot"],
    "view": ["--trials=5", "--steps=2"],
    "verify": ["--target=cpu", "--seconds=0.1"],
}
COMPILED = {"run", "compare", "view", "verify", "compile", "solve", "tune"}
# Commands that a test of their own runs, as they take seconds.
NOT_RUN = {
    "bench": "test_bench.py, test_bench_dask.py",
    "compile": "test_library.py, test_solvers.py, test_ros2.py",
    "doctor": "test_machine_checks.py",
    "tune": "test_tune.py",
    "lsp": "test_server.py",
}
# What is not hypgen's: a test looks at each where it can be had.
OTHER_PROGRAMS = re.compile("[.]|cd|cmake|code|colcon|dask|eval|npm|pip|pytest|python3|ros2")


def blocks(page: str, *kinds: str) -> list[str]:
    return [text for kind, text in BLOCK.findall((ROOT / page).read_text()) if kind in kinds]


def commands(page: str) -> Iterator[list[str]]:
    """Yield the commands of a page's shell blocks, as words."""
    for text in blocks(page, "sh"):
        for line in text.replace("\\\n", " ").splitlines():
            words = shlex.split(line.replace(".venv/bin/", ""), comments=True)
            while "&&" in words:
                yield words[: words.index("&&")]
                words = words[words.index("&&") + 1 :]
            if words:
                yield words


def mentioned(page: str) -> Iterator[list[str]]:
    """Yield the commands that a page's text has in backticks."""
    text = BLOCK.sub("", (ROOT / page).read_text())
    for code in re.findall(r"`(hypgen [a-z][^`]*)`", text.replace("\n", " ")):
        yield shlex.split(code)


def with_files(words: list[str], model: str = TIGER) -> list[str]:
    """Return a command whose model is one that there is."""
    return [model if word in ("MODEL", "MODEL.pomdp", "FILE.pomdp") else word for word in words]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a reader: the examples are there, and what pages read that nothing has written."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    return tmp_path


def solver_options() -> set[str]:
    guide = (ROOT / "docs" / "guide" / "solver.md").read_text()
    return set(re.findall(r"^\| `(--[a-z-]+)", guide, re.MULTILINE))


@pytest.mark.parametrize("page", PAGES)
def test_commands_have_their_options(page: str) -> None:
    for words in [*commands(page), *mentioned(page)]:
        if words[0] != "hypgen":
            assert OTHER_PROGRAMS.fullmatch(words[0]) or "/" in words[0], words
            continue
        command = main.group.get_command(click.Context(main.group), words[1])
        assert command is not None, words
        known = {"-h", "--help", *(name for option in command.params for name in option.opts)}
        if command.context_settings.get("ignore_unknown_options"):
            known |= solver_options()
        used = {word.partition("=")[0] for word in words[2:] if re.match(r"--?[a-z]", word)}
        assert used <= known, words


@pytest.mark.cxx
@pytest.mark.parametrize("page", [page for page in PAGES if page not in OTHER_TESTS_RUN])
def test_commands_run(page: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def become(program: str, words: list[str]) -> None:
        raise click.exceptions.Exit(subprocess.run([program, *words[1:]]).returncode)

    monkeypatch.setattr(os, "execv", become)
    settings = [text for text in blocks(page, "json") if '"options"' in text]
    for words in commands(page):
        if words[0] != "hypgen" or words[1] in NOT_RUN or "--gif" in words:  # test_view.py draws
            continue
        if "tag.settings.json" in words:
            (folder / "tag.settings.json").write_text(settings[0].replace('{"sure": 0.78}', "{}"))
        short = shortened(words)
        assert main.run(short) == 0, short


def shortened(words: list[str]) -> list[str]:
    """Return a command's words that take less time than the page's."""
    name, rest = words[1], with_files(words[2:])
    if name in COMPILED or "--beliefs" in rest or "--bounds" in rest:
        rest = [TIGER if re.match(r"examples/(?!rock_sample)\w+\.pomdp", word) else word for word in rest]
    if name == "solve":
        rest = [TIGER if word == ROCKS else word for word in rest]
    for option, value in SMALL.items():
        if option in rest:
            rest[rest.index(option) + 1] = value
    if "--time" in rest:
        rest[rest.index("--time") + 1] = "0.3" if name == "check" else "0.01"
    if "--log" not in rest:
        rest += MORE.get(name, [])
    return [name, *(word for word in rest if word != "--open")]


@pytest.mark.parametrize("page", PAGES)
def test_data_are_taken(page: str, folder: Path) -> None:
    for text in blocks(page, "json"):
        json.loads(text)
    for text in blocks(page, "toml"):
        tomllib.loads(text)


def test_the_suite_is_one(tmp_path: Path) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    (tmp_path / "suites").mkdir()
    suite = tmp_path / "suites" / "suite.toml"
    first, *others = blocks("docs/guide/bench.md", "toml")
    for text in ("", *others):
        suite.write_text(first + text)
        (study,) = read_suite(suite).studies
        assert study.name == "time"


# For each page what its Python reads, before the first block, and what makes it short.
PYTHON: dict[str, tuple[str, dict[str, str]]] = {
    "README.md": ("", {"0.05": "0.01"}),
    "docs/guide/embedding.md": ("", {"start_row=1": "", "(1000)": "(10)"}),
    "docs/guide/worlds.md": (
        "actions = numpy.zeros(64, dtype=numpy.int32)",
        {"trials=100": "trials=5", "runs=10": "runs=1", "4096": "64"},
    ),
    "docs/guide/reading-results.md": ("", {}),
    "docs/reference/recording.md": ("", {}),
    "docs/guide/bench.md": ("", {}),
    "docs/guide/tune.md": ("", {}),
}


def test_all_pages_with_python_are_run() -> None:
    assert {page for page in PAGES if blocks(page, "python")} == set(PYTHON)


@pytest.mark.cxx
@pytest.mark.parametrize("page", PYTHON)
def test_python_runs(page: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before, shorter = PYTHON[page]
    for name in ("bench", "report", "tune"):  # minutes: test_bench and test_tune play
        monkeypatch.setattr(hypgen, name, only_bound(getattr(hypgen, name)), raising=False)
    if page in ("docs/guide/reading-results.md", "docs/reference/recording.md"):
        options = ["--runs=2", "--steps=3", "--trials=5", "--json=steps.jsonl", "--record=tiger.jsonl"]
        monkeypatch.setattr(os, "execv", lambda program, words: subprocess.run([program, *words[1:]]))
        assert main.run(["run", TIGER, "--target=cpu", "--mode=despot", "--quiet", *options]) == 0
    names: dict[str, Any] = {"hypgen": hypgen, "numpy": numpy}
    exec(before, names)
    for text in blocks(page, "python"):
        for long, short in shorter.items():
            text = text.replace(long, short)
        ast.parse(text)
        if "cuda" not in text and "SLURM" not in text:  # other machines
            exec(text, names)


def only_bound(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that takes what ``function`` takes, and does nothing."""
    signature = inspect.signature(function)

    class Nothing:
        settings = None

        def verdict(self) -> str:
            return ""

    def call(*values: Any, **named: Any) -> Any:
        signature.bind(*values, **named)
        return Nothing()

    return call


PATROL = """\
model Patrol
discount 0.9
record Place { x: 0 .. 3, y: 0 .. 2 }
action act: bool
element robot { hidden x: 0 .. 3  init x = 0  x' = x }
observe mark: Place = Place(robot.x', 0)
reward r = 0
policy default = false
"""


@pytest.mark.cxx
def test_c_fits_the_headers(tmp_path: Path) -> None:
    (tmp_path / "patrol.pomdp").write_text(PATROL)
    for model in (ROOT / ROCKS, tmp_path / "patrol.pomdp"):
        name = f"{model.stem}.h"
        (tmp_path / name).write_text(generate_library(load(model).model)[f"include/{name}"])
    loop, action, place = blocks("docs/guide/embedding.md", "c")
    text = f"""
#include <rock_sample.h>
#include <patrol.h>
#include <stddef.h>
void look_at(int32_t rock);
void loop(void);
void act(hypgen_decision decision);
void go(int32_t* seen);
void loop(void) {{ {loop} }}
void act(hypgen_decision decision) {{ {action} (void)action; }}
void go(int32_t* seen) {{ {place} }}
"""
    runtime = Path(builder.__file__).parent.parent
    command = [str(tools.find_tools().compiler.path), f"-I{runtime / 'include'}", f"-I{tmp_path}"]
    command += ["-std=c11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c", "-"]
    done = subprocess.run(command, input=text, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("program", "kind", "arguments"),
    [("luac", "lua", ["-p", "-"]), ("emacs", "elisp", ["--batch", "--eval", "(read (current-buffer))"])],
)
def test_editors_read_their_settings(program: str, kind: str, arguments: list[str]) -> None:
    if shutil.which(program) is None:
        pytest.skip(f"needs {program}")
    (text,) = blocks("docs/guide/editors.md", kind)
    done = subprocess.run([program, *arguments], input=text, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_what_import_says(tmp_path: Path) -> None:
    file = ROOT.parent / "shared" / "corpus" / "cassandra" / "tiger.95.pomdp"
    if not file.exists():
        pytest.skip("needs the corpus of foreign models")
    shutil.copy(file, tmp_path / "tiger.95.POMDP")
    first, *_ = blocks("docs/guide/import.md", "console")
    (played, said), (imported, printed) = (p.split("\n", 1) for p in first.removeprefix("$ ").split("\n$ "))
    assert output(imported, tmp_path) == printed
    note = said.splitlines()[0]  # what `run` says before it compiles, and `explain` as well
    assert played.endswith(" --runs 100")
    assert note in output("hypgen explain tiger.95.POMDP", tmp_path)
