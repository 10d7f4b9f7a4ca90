# SPDX-License-Identifier: Apache-2.0
"""Libraries from CMake: exported projects in one build, what they install, and programs that find it."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from support.native import build_with_cmake, exported_by
from support.pinned import PINS, signatures

from hypgen.runtime.builder import tools

pytestmark = pytest.mark.cxx
ROOT = Path(__file__).parent.parent.parent
EXAMPLES = ROOT / "examples"
HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]
BOTH = """cmake_minimum_required(VERSION 3.20)
project(both LANGUAGES CXX)
add_subdirectory(rocks)
add_subdirectory(tiger)
"""
# A library that knows no model, and a program with two.
PLANS = """
#include <hypgen.hpp>
#include <cstdio>
void plan(const hypgen_model* model) {
  hypgen::api::Planner planner(model, "mode=despot trials=20 memory=64");
  planner.reset();
  std::puts(planner.plan().action_name);
}
"""
TWO_MODELS = """
#include <rock_sample.h>
#include <MORE.h>
void plan(const hypgen_model* model);
int main() {
  plan(hypgen_model_rock_sample());
  plan(hypgen_model_MORE());
}
"""
TWO_MODELS_PROJECT = """cmake_minimum_required(VERSION 3.20)
project(robot LANGUAGES CXX)
list(APPEND CMAKE_PREFIX_PATH PREFIXES)
find_package(hypgen_runtime 1 REQUIRED)
find_package(rock_sample 1 REQUIRED)
find_package(MORE 1 REQUIRED)
add_library(plans STATIC plans.cpp)
target_link_libraries(plans PUBLIC hypgen::runtime)
add_executable(robot robot.cpp)
target_link_libraries(robot PRIVATE plans rock_sample::static MORE::static)
"""


def compile_model(model: str, output: Path, *options: str) -> Path:
    """Return the folder that ``hypgen compile -o`` writes."""
    command = [*HYPGEN, "compile", str(EXAMPLES / model), "--target", "cpu", "-o", str(output), *options]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return output


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("installed")


@pytest.fixture(scope="module")
def package(folder: Path) -> Path:
    """Return what ``--library`` writes for RockSample."""
    return compile_model("rock_sample.pomdp", folder / "package", "--library")


@pytest.fixture(scope="module")
def runtime(package: Path) -> tuple[str, str]:
    """Return the settings by which a project takes the runtime that is built already."""
    return "-DHYPGEN_FIND_RUNTIME=ON", f"-DCMAKE_PREFIX_PATH={package}"


@pytest.fixture(scope="module")
def both(folder: Path) -> Path:
    """Return a CMake project with two exported ones."""
    compile_model("rock_sample.pomdp", folder / "both" / "rocks", "--emit-only")
    compile_model("tiger.pomdp", folder / "both" / "tiger", "--emit-only")
    (folder / "both" / "CMakeLists.txt").write_text(BOTH)
    return folder / "both"


@pytest.fixture(scope="module")
def installed(both: Path, runtime: tuple[str, str], folder: Path) -> Path:
    """Return the prefix that two projects of one build are installed to."""
    build = build_with_cmake(both, folder / "build", *runtime)
    prefix = folder / "prefix"
    cmake = str(tools.find_cmake().path)
    subprocess.run([cmake, "--install", build, "--prefix", prefix], check=True, capture_output=True)
    return prefix


def test_two_projects_of_one_build_install_solvers_and_libraries(installed: Path) -> None:
    names = {p.relative_to(installed).as_posix() for p in installed.rglob("*") if p.is_file()}
    for stem in ("rock_sample", "tiger"):
        config = {f"lib/cmake/{stem}/{stem}-config{end}.cmake" for end in ("", "-version")}
        assert names >= {f"lib/lib{stem}.so", f"lib/lib{stem}.a", *config}
        assert names >= {f"bin/{stem}", f"include/{stem}.h"}
        assert f"share/doc/{stem}/hypgen/LICENSE" in names
    assert names >= {"include/hypgen.h", "include/hypgen.hpp"}
    assert len([name for name in names if name.startswith("lib/libhypgen_runtime-")]) == 1
    run = [installed / "bin" / "tiger", "--mode=rollout", "--runs=1", "--steps=2", "--trials=8"]
    assert subprocess.run(run, capture_output=True).returncode == 0


@pytest.mark.parametrize("name", ["rock_sample", "tiger"])
def test_an_installed_solver_searches_the_pinned_trees(installed: Path, name: str) -> None:
    """A model's code that is as optimised as users have it, unlike in most tests."""
    assert signatures(installed / "bin" / name, name) == PINS[name]


def test_the_installed_library_exports_the_interface_alone(installed: Path) -> None:
    exported, dynamic = exported_by(installed / "lib" / "librock_sample.so")
    header = (installed / "include" / "hypgen.h").read_text()
    declared = {word.split("(")[0] for word in header.split() if word.startswith("hypgen_") and "(" in word}
    [model] = exported - declared
    assert declared <= exported and re.fullmatch(r"hypgen_model_rock_sample_[0-9a-f]{16}", model)
    assert "RPATH" not in dynamic and "RUNPATH" not in dynamic and "hypgen" not in dynamic


@pytest.mark.parametrize("found", ["installed", "package"])
@pytest.mark.parametrize("example", ["embed_c", "embed_cpp"])
def test_examples_find_the_package(
    example: str, found: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    prefix = request.getfixturevalue(found)
    source = shutil.copytree(EXAMPLES / example, tmp_path / example)
    flags = "-Wall -Wextra -pedantic -Werror"
    settings = [f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_C_FLAGS={flags}", f"-DCMAKE_CXX_FLAGS={flags}"]
    robot = build_with_cmake(source, tmp_path / "build", *settings) / "robot"
    done = subprocess.run([robot], input="bad\nbad\n", capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    *decisions, last = done.stdout.splitlines()
    assert len(decisions) == 3 and last.startswith("rock 0 is good with probability 0.")


def two_models(folder: Path, other: str, prefixes: list[Path]) -> Path:
    """Return a project of a program that links RockSample and another model, both static."""
    folder.mkdir()
    texts = {"plans.cpp": PLANS, "robot.cpp": TWO_MODELS, "CMakeLists.txt": TWO_MODELS_PROJECT}
    paths = " ".join(f'"{prefix}"' for prefix in prefixes)
    for name, text in texts.items():
        (folder / name).write_text(text.replace("MORE", other).replace("PREFIXES", paths))
    return folder


def test_two_models_link_into_one_program(installed: Path, package: Path, tmp_path: Path) -> None:
    """Also where the folder is another one than that which they were installed to."""
    moved = shutil.copytree(installed, tmp_path / "moved")
    project = two_models(tmp_path / "two", "tiger", [moved, package])
    done = subprocess.run([build_with_cmake(project, tmp_path / "build") / "robot"], capture_output=True)
    assert done.returncode == 0 and len(done.stdout.split()) == 2


def test_two_settings_of_a_model_link_into_one_program_under_two_names(package: Path, tmp_path: Path) -> None:
    options = ("--library", "--name", "SmallRocks", "--set", "start_row=1")
    other = compile_model("rock_sample.pomdp", tmp_path / "small", *options)
    project = two_models(tmp_path / "two", "small_rocks", [package, other])
    done = subprocess.run([build_with_cmake(project, tmp_path / "build") / "robot"], capture_output=True)
    assert done.returncode == 0 and len(done.stdout.split()) == 2


def test_two_settings_of_a_model_under_one_name_are_refused(package: Path, tmp_path: Path) -> None:
    other = compile_model("rock_sample.pomdp", tmp_path / "other", "--library", "--set", "start_row=1")
    compiler = str(tools.find_tools().compiler.path)
    objects = []
    for number, prefix in enumerate((package, other)):
        text = '#include <rock_sample.h>\nextern "C" const void* f() { return hypgen_model_rock_sample(); }\n'
        source = tmp_path / f"part{number}.cpp"
        source.write_text(text.replace(" f()", f" f{number}()"))
        objects.append(str(source.with_suffix(".o")))
        compiled = [compiler, "-c", str(source), f"-I{prefix / 'include'}", "-o", objects[-1]]
        subprocess.run(compiled, check=True)
    main = tmp_path / "main.cpp"
    one = tmp_path / "one"
    main.write_text('extern "C" const void* f0();\nint main() { return f0() == nullptr; }\n')
    link = [compiler, str(main), objects[0], f"-L{package / 'lib'}", "-lrock_sample", "-o", str(one)]
    subprocess.run(link, check=True)
    for prefix, starts in ((package, True), (other, False)):
        path = {**os.environ, "LD_LIBRARY_PATH": str(prefix / "lib")}
        done = subprocess.run([one], env=path, capture_output=True, text=True)
        assert (done.returncode == 0) == starts
        assert starts or "undefined symbol: hypgen_model_rock_sample_" in done.stderr
    main.write_text('extern "C" const void *f0(), *f1();\nint main() { return f0() == f1(); }\n')
    archives = [*(package / "lib").glob("*.a"), *(other / "lib").glob("*.a")]
    link = [compiler, str(main), *objects, *map(str, sorted(archives, reverse=True)), "-pthread"]
    done = subprocess.run([*link, "-o", str(tmp_path / "main")], capture_output=True, text=True)
    assert done.returncode != 0
    assert re.search(r"multiple definition of .*hypgen::embedded_model_RockSample", done.stderr), done.stderr


def refused(source: Path, build: Path, *settings: str) -> str:
    """Return what CMake says of a project that it must refuse, as one line."""
    command = [str(tools.find_cmake().path), "-S", str(source), "-B", str(build), *settings]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode != 0
    return " ".join(done.stderr.split())


def test_two_projects_of_other_versions_are_refused(
    both: Path, runtime: tuple[str, str], tmp_path: Path
) -> None:
    changed = shutil.copytree(both, tmp_path / "changed")
    with open(changed / "tiger" / "hypgen" / "src" / "core" / "status.cpp", "a") as file:
        file.write("// changed\n")
    message = refused(changed, tmp_path / "build", *runtime)
    assert "The project tiger has another version of hypgen's runtime" in message
    assert "with one version of hypgen." in message


def test_two_projects_of_one_name_are_refused(both: Path, runtime: tuple[str, str], tmp_path: Path) -> None:
    shutil.copytree(both / "tiger", tmp_path / "twice" / "tiger")
    shutil.copytree(both / "tiger", tmp_path / "twice" / "rocks")
    shutil.copy(both / "CMakeLists.txt", tmp_path / "twice")
    message = refused(tmp_path / "twice", tmp_path / "build", *runtime)
    assert "Two projects in this build are called tiger." in message and "--name NAME" in message


@pytest.mark.parametrize("name", ["hypgen_runtime", "rock_sample"])
def test_another_version_of_the_interface_is_refused(name: str, package: Path, tmp_path: Path) -> None:
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.20)\nproject(robot LANGUAGES NONE)\n"
        f'find_package({name} 2 REQUIRED PATHS "{package}")\n'
    )
    message = refused(tmp_path, tmp_path / "build")
    assert 'compatible with requested version "2"' in message and "version: 1" in message


@pytest.mark.parametrize("source", ["tree", "project"])
def test_the_runtime_is_a_package_of_its_own(source: str, both: Path, package: Path, tmp_path: Path) -> None:
    """Its archive is compiled already: what CMake installs is what is in its place."""
    folder = ROOT / "runtime" if source == "tree" else both / "tiger" / "hypgen"
    build, prefix, cmake = tmp_path / "build", tmp_path / "prefix", str(tools.find_cmake().path)
    found = [f"-DHYPGEN_JSON_INCLUDE_DIR={tools.find_json()}"] if source == "tree" else []
    command = [cmake, "-S", folder, "-B", build, "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", *found]
    subprocess.run(command, check=True, capture_output=True)
    [archive] = (package / "lib").glob("libhypgen_runtime-*.a")
    shutil.copy(archive, build)
    subprocess.run([cmake, "--install", build, "--prefix", prefix], check=True, capture_output=True)
    names = {p.relative_to(prefix).as_posix() for p in prefix.rglob("*") if p.is_file()}
    config = {p.relative_to(package).as_posix() for p in (package / "lib/cmake/hypgen_runtime").iterdir()}
    assert len(config) == 4 and {n for n in names if n.endswith(".cmake")} == config
    assert names >= {"include/hypgen.h", "include/hypgen.hpp", f"lib/{archive.name}"}
    licence = prefix / "share" / "doc" / "hypgen_runtime" / "hypgen" / "LICENSE"
    assert licence.is_file() and not licence.is_symlink()
    texts = [(prefix / name).read_text() for name in config]
    assert not [text for text in texts if str(tmp_path) in text or str(ROOT) in text]
    commands = json.loads((build / "compile_commands.json").read_text())
    named = [command["file"] for command in commands if "RUNTIME_ID" in command["command"]]
    assert [Path(name).name for name in named] == ["c_worlds.cpp"], "others are compiled again for nothing"


def test_a_program_of_static_models_has_one_runtime(installed: Path, package: Path, tmp_path: Path) -> None:
    changed = shutil.copytree(installed, tmp_path / "changed")
    config = changed / "lib" / "cmake" / "tiger" / "tiger-config.cmake"
    config.write_text(re.sub(r'HYPGEN_RUNTIME "\w+"', 'HYPGEN_RUNTIME "0123456789ab"', config.read_text()))
    shutil.rmtree(changed / "lib" / "cmake" / "rock_sample")
    project = two_models(tmp_path / "two", "tiger", [package, changed])
    message = refused(project, tmp_path / "build")
    assert 'INTERFACE_HYPGEN_RUNTIME property of "tiger::static" does not agree' in message


def test_a_model_does_not_link_with_another_runtime(package: Path, tmp_path: Path) -> None:
    compiler = str(tools.find_tools().compiler.path)
    main = tmp_path / "main.cpp"
    main.write_text(
        "#include <rock_sample.h>\nint main() { return hypgen_model_rock_sample() == nullptr; }\n"
        "namespace hypgen { inline namespace runtime_0123456789ab { void this_runtime() {} } }\n"
    )
    archive = package / "lib" / "librock_sample.a"
    link = [compiler, str(main), f"-I{package / 'include'}", str(archive), "-pthread"]
    done = subprocess.run([*link, "-o", str(tmp_path / "main")], capture_output=True, text=True)
    assert done.returncode != 0
    [library] = (package / "lib").glob("libhypgen_runtime-*.a")
    name = f"hypgen::runtime_{library.stem.partition('-')[2]}::this_runtime"
    assert re.search(rf"undefined reference to .{name}", done.stderr), done.stderr


def test_two_runtimes_do_not_link(package: Path) -> None:
    """As a model takes the whole unit that has its runtime's version, and functions of hypgen.h."""
    [library] = (package / "lib").glob("libhypgen_runtime-*.a")
    done = subprocess.run(["nm", "-A", "-C", "--defined-only", library], capture_output=True, text=True)
    rows = [line.split(":", 2) for line in done.stdout.splitlines()]
    shared = re.compile(r"::this_runtime\(\)| hypgen_worlds_create$")
    units = {unit for _, unit, symbol in rows if shared.search(symbol)}
    assert units == {"c_worlds.cpp.o"}


def test_a_name_has_to_be_one(tmp_path: Path) -> None:
    for name in ("2rocks", "small-rocks", ""):
        command = [*HYPGEN, "compile", str(EXAMPLES / "tiger.pomdp"), "--name", name]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 2 and "expected a name such as LargeRocks" in done.stderr
