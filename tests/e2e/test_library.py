# SPDX-License-Identifier: Apache-2.0
"""``hypgen compile --library``: what it exports, and that it plans as the solver does."""

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from support.native import c_names_of, exported_by

from hypgen.api import Planner, PlannerError, Solver
from hypgen.api.programs import files
from hypgen.dsl.load import load
from hypgen.runtime.builder import tools
from hypgen.runtime.builder.solver import build_solver

pytestmark = pytest.mark.cxx
ROOT = Path(__file__).parent.parent.parent
ROCKS = str(ROOT / "examples" / "rock_sample.pomdp")
HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]
SETTINGS: dict[str, Any] = {
    "mode": "despot",
    "trials": 60,
    "scenarios": 100,
    "particles": 500,
    "memory": 64,
    "seed": 3,
}


def hypgen(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*HYPGEN, *arguments], capture_output=True, text=True)


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the library of RockSample."""
    folder = tmp_path_factory.mktemp("library") / "rocks"
    done = hypgen("compile", ROCKS, "--library", "--target", "cpu", "-o", str(folder))
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"{folder / 'lib' / 'librock_sample.so'}\n"
    return folder


@pytest.fixture
def solver(package: Path) -> Solver:
    return Solver(package / "lib" / "librock_sample.so")


@pytest.fixture
def planner(solver: Solver) -> Iterator[Planner]:
    with solver.planner(**SETTINGS) as found:
        yield found


def test_the_package_has_what_its_users_need(package: Path) -> None:
    names = {p.relative_to(package).as_posix() for p in package.rglob("*") if p.is_file()}
    headers = {"include/hypgen.h", "include/hypgen.hpp", "include/rock_sample.h"}
    pages = {"README.md", "LICENSE.hypgen", "NOTICE.hypgen", "LICENSE.nlohmann-json"}
    config = "lib/cmake/rock_sample/rock_sample-config.cmake"
    assert names >= {*headers, *pages, config, "lib/librock_sample.so", "lib/librock_sample.a"}
    assert len([name for name in names if re.fullmatch(r"lib/libhypgen_runtime-[0-9a-f]{12}[.]a", name)]) == 1


def test_the_library_exports_the_interface_alone(package: Path) -> None:
    exported, dynamic = exported_by(package / "lib" / "librock_sample.so")
    header = (package / "include" / "hypgen.h").read_text()
    declared = {word.split("(")[0] for word in header.split() if word.startswith("hypgen_") and "(" in word}
    hash = Solver(package / "lib" / "librock_sample.so").description["hash"]
    assert exported == declared | {f"hypgen_model_rock_sample_{hash[:16]}"}
    assert "RPATH" not in dynamic and "RUNPATH" not in dynamic and "hypgen" not in dynamic


def test_no_other_name_could_meet_one_of_the_users(package: Path) -> None:
    """As a program has one set of names with C linkage, those of static libraries too."""
    program = build_solver(files(load(ROCKS), "solver"), ROCKS, lambda step: None)
    for built in (program, *(package / "lib").glob("*.a")):
        names = c_names_of(built)
        assert names and all(name.startswith("hypgen_") for name in names), built


def test_the_library_decides_as_the_solver_does(planner: Planner, tmp_path: Path) -> None:
    lines = tmp_path / "lines.jsonl"
    options = [f"--{name}={value}" for name, value in SETTINGS.items()]
    done = hypgen(
        "run", ROCKS, "--target", "cpu", "--", *options, "--runs=2", "--steps=6", f"--json={lines}", "--quiet"
    )
    assert done.returncode == 0, done.stderr
    steps = [s for s in map(json.loads, lines.read_text().splitlines()) if s["type"] == "step"]
    for step in steps:
        if step["step"] == 0:
            planner.reset(episode=step["episode"])
        found = planner.plan()
        decision = (found.action, found.lower, found.upper, found.trials, found.status)
        assert decision == tuple(step[name] for name in ("action", "lower", "upper", "trials", "status"))
        if not step["terminal"]:
            assert planner.seen(step["observation_key"]) == {"reading": step["observation"]}
            assert planner.update(found.action, step["observation_key"]) == "ok"
    assert len(steps) > 6


def test_the_model_is_described(solver: Solver, planner: Planner) -> None:
    model = solver.description
    assert model["model"] == "RockSample" and model["actions"][5] == "check(0)"
    [reading] = model["seen"]
    assert reading["values"] == ["nothing", "looks_good", "looks_bad"]
    assert [(v["name"], v["low"], v["high"], v["drawn"]) for v in model["visible"]] == [
        ("rover.x", 0, 7, False),
        ("rover.y", 0, 6, False),
    ]
    planner.reset({"rover.x": 2})
    assert list(planner.belief)[3] == "rock.good[3]" and len(planner.belief) == 8


def test_mistakes_are_refused(solver: Solver, planner: Planner) -> None:
    with pytest.raises(PlannerError, match="no episode has begun"):
        planner.plan()
    with pytest.raises(PlannerError, match="rover.x: expected an integer from 0 to 7, found -5"):
        planner.reset({"rover.x": -5})
    planner.reset()
    with pytest.raises(PlannerError, match="seconds: expected"):
        planner.plan(float("nan"))
    with pytest.raises(PlannerError, match="reading: expected one of nothing, looks_good, looks_bad, found"):
        planner.update(5, {"reading": "looks"})
    with pytest.raises(PlannerError, match="key: no observation of the model has it"):
        planner.update(5, 99)
    with pytest.raises(PlannerError, match="action: expected an integer from 0 to 12, found 99"):
        planner.update(99, 0)
    with pytest.raises(PlannerError, match="no setting is named scenario; the settings are: mode"):
        solver.planner(scenario=3)
    with pytest.raises(PlannerError, match="sure.: expected probability from 0 to 1, found 7"):
        solver.planner(params={"sure": 7})


def test_the_c_example_plans(package: Path, tmp_path: Path) -> None:
    source = ROOT / "examples" / "embed_c" / "robot.c"
    lib = package / "lib"
    compiler = str(tools.find_tools().compiler.path)
    flags = ["-std=c11", "-Wall", "-Wextra", "-pedantic", "-Werror"]
    where = [f"-I{package / 'include'}", f"-L{lib}", f"-Wl,-rpath,{lib}"]
    robot = tmp_path / "robot"
    build = [
        compiler,
        "-x",
        "c",
        *flags,
        str(source),
        "-x",
        "none",
        *where,
        "-lrock_sample",
        "-o",
        str(robot),
    ]
    done = subprocess.run(build, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    done = subprocess.run([robot], input="bad\nbad\n", capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    *decisions, last = done.stdout.splitlines()
    assert len(decisions) == 3 and last.startswith("rock 0 is good with probability 0.")


def test_the_header_of_cxx_has_all_calls(package: Path, tmp_path: Path) -> None:
    source, program = ROOT / "tests" / "support" / "every_call.cpp", tmp_path / "calls"
    lib = package / "lib"
    flags = ["-std=c++17", "-Wall", "-Wextra", "-pedantic", "-Wconversion", "-Werror"]
    where = [f"-I{package / 'include'}", f"-L{lib}", f"-Wl,-rpath,{lib}", "-lrock_sample"]
    build = [str(tools.find_tools().compiler.path), *flags, str(source), *where, "-o", str(program)]
    done = subprocess.run(build, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    done = subprocess.run([program], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    functions = set(re.findall(r"\b(hypgen_\w+)\(", (package / "include" / "hypgen.h").read_text()))
    called = set(re.findall(r"\bhypgen_\w+", (package / "include" / "hypgen.hpp").read_text()))
    assert functions - called == {"hypgen_library_model", "hypgen_now"}


def test_the_header_is_one_of_cxx_too(package: Path) -> None:
    compiler = str(tools.find_tools().compiler.path)
    page = (ROOT / "docs" / "guide" / "embedding.md").read_text()
    [(includes, body)] = re.findall(r"```cpp\n(.*?)\n\n(.*?)```", page, re.DOTALL)
    check = 'static_assert(ROCK_SAMPLE_READING_LOOKS_BAD == 2, "");'
    text = f"{includes}\n{check}\nvoid guide() {{\n{body}}}\n"
    flags = ["-std=c++17", "-Wall", "-Wextra", "-pedantic", "-Werror", "-fsyntax-only"]
    command = [compiler, *flags, f"-I{package / 'include'}", "-x", "c++", "-"]
    done = subprocess.run(command, input=text, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_library_has_no_project_to_emit() -> None:
    done = hypgen("compile", ROCKS, "--library", "--emit-only", "-o", "nowhere")
    assert done.returncode == 2 and "leave out --library" in done.stderr
