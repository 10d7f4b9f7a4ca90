# SPDX-License-Identifier: Apache-2.0
"""``hypgen compile --library``: what it exports, and that it plans as the solver does."""

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.embedding import Embedded

from hypgen.runtime.builder import tools

pytestmark = pytest.mark.cxx
ROOT = Path(__file__).parent.parent.parent
ROCKS = str(ROOT / "examples" / "rock_sample.pomdp")
HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]
SETTINGS = {"mode": "despot", "trials": 60, "scenarios": 100, "particles": 500, "memory": 64, "seed": 3}


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
def embedded(package: Path) -> Iterator[Embedded]:
    settings = " ".join(f"{name}={value}" for name, value in SETTINGS.items())
    found = Embedded(package / "lib" / "librock_sample.so", settings)
    yield found
    found.close()


def test_the_package_has_what_its_users_need(package: Path) -> None:
    names = {p.relative_to(package).as_posix() for p in package.rglob("*") if p.is_file()}
    headers = {"include/hypgen.h", "include/rock_sample.h"}
    pages = {"README.md", "LICENSE.hypgen", "NOTICE.hypgen", "LICENSE.nlohmann-json"}
    config = "lib/cmake/rock_sample/rock_sample-config.cmake"
    assert names >= {*headers, *pages, config, "lib/librock_sample.so"}


def test_the_library_exports_the_interface_alone(package: Path) -> None:
    library = package / "lib" / "librock_sample.so"
    if shutil.which("nm") is None or shutil.which("readelf") is None:
        pytest.skip("needs nm and readelf")
    listed = subprocess.run(
        ["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=True
    )
    exported = {line.split()[-1] for line in listed.stdout.splitlines()}
    header = (package / "include" / "hypgen.h").read_text()
    declared = {word.split("(")[0] for word in header.split() if word.startswith("hypgen_") and "(" in word}
    assert exported == declared | {"hypgen_model_rock_sample"}
    dynamic = subprocess.run(["readelf", "-d", library], capture_output=True, text=True, check=True).stdout
    assert "RPATH" not in dynamic and "RUNPATH" not in dynamic and "hypgen" not in dynamic


def test_the_library_decides_as_the_solver_does(embedded: Embedded, tmp_path: Path) -> None:
    lines = tmp_path / "lines.jsonl"
    options = [f"--{name}={value}" for name, value in SETTINGS.items()]
    done = hypgen(
        "run", ROCKS, "--target", "cpu", "--", *options, "--runs=2", "--steps=6", f"--json={lines}", "--quiet"
    )
    assert done.returncode == 0, done.stderr
    steps = [s for s in map(json.loads, lines.read_text().splitlines()) if s["type"] == "step"]
    for step in steps:
        if step["step"] == 0:
            embedded.reset(episode=step["episode"])
        decision = embedded.plan()
        found = (decision.action, decision.lower, decision.upper, decision.trials)
        assert found == (step["action"], step["lower"], step["upper"], step["trials"])
        assert embedded.status_name(decision.status) == step["status"]
        if not step["terminal"]:
            assert embedded.decode([step["observation_key"]]) == {"reading": step["observation"]}
            assert embedded.update_key(decision.action, [step["observation_key"]]) == 0
    assert len(steps) > 6


def test_the_model_is_described(embedded: Embedded) -> None:
    model = embedded.json("describe", embedded.model, planner=False)
    assert model["model"] == "RockSample" and model["actions"][5] == "check(0)"
    [reading] = model["seen"]
    assert reading["values"] == ["nothing", "looks_good", "looks_bad"]
    assert [(v["name"], v["low"], v["high"], v["drawn"]) for v in model["visible"]] == [
        ("rover.x", 0, 7, False),
        ("rover.y", 0, 6, False),
    ]
    embedded.reset({"rover.x": 2})
    belief = embedded.json("belief")
    assert len(belief) == 8 and belief[3]["variable"] == "rock.good[3]"


def test_mistakes_are_refused(embedded: Embedded, package: Path) -> None:
    with pytest.raises(ValueError, match="wrong_argument: no episode has begun"):
        embedded.plan()
    with pytest.raises(ValueError, match="rover.x: expected an integer from 0 to 7, found -5"):
        embedded.reset({"rover.x": -5})
    embedded.reset()
    with pytest.raises(ValueError, match="wrong_argument: seconds"):
        embedded.plan(float("nan"))
    with pytest.raises(ValueError, match="reading: expected a name such as"):
        embedded.update(5, {"reading": "looks"})
    with pytest.raises(ValueError, match="wrong_argument: key"):
        embedded.update_key(5, [99])
    with pytest.raises(ValueError, match="wrong_argument: action"):
        embedded.update_key(99, [0])
    library = package / "lib" / "librock_sample.so"
    with pytest.raises(ValueError, match="no setting is named scenario; the settings are: mode"):
        Embedded(library, "scenario=3")
    with pytest.raises(ValueError, match="sure.: expected probability from 0 to 1, found 7"):
        Embedded(library, "", '{"sure": 7}')


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


def test_the_header_is_one_of_cxx_too(package: Path) -> None:
    compiler = str(tools.find_tools().compiler.path)
    text = '#include "rock_sample.h"\nstatic_assert(ROCK_SAMPLE_READING_LOOKS_BAD == 2, "");\n'
    flags = ["-std=c++17", "-Wall", "-Wextra", "-pedantic", "-Werror", "-fsyntax-only"]
    command = [compiler, *flags, f"-I{package / 'include'}", "-x", "c++", "-"]
    done = subprocess.run(command, input=text, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_library_has_no_project_to_emit() -> None:
    done = hypgen("compile", ROCKS, "--library", "--emit-only", "-o", "nowhere")
    assert done.returncode == 2 and "leave out --library" in done.stderr
