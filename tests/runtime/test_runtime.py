# SPDX-License-Identifier: Apache-2.0
"""Builds the C++ tests of the runtime with CMake and runs them.

They are linked with the libraries of the solvers that other tests build, so that each is compiled once.
"""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from hypgen.runtime.builder import solver
from hypgen.runtime.builder import tools as toolchain

pytestmark = pytest.mark.cxx
HERE = Path(__file__).parent


def configure(build: Path, *settings: str) -> None:
    """Configure the tests, or skip where GoogleTest is not installed."""
    tools = toolchain.find_tools()
    generator = ["-G", "Ninja", f"-DCMAKE_MAKE_PROGRAM={tools.ninja.path}"] if tools.ninja else []
    definitions = [
        f"-DCMAKE_CXX_COMPILER={tools.compiler.path}",
        f"-DHYPGEN_JSON_INCLUDE_DIR={tools.json_include}",
        f"-DHYPGEN_EIGEN_INCLUDE_DIR={toolchain.find_eigen()}",
        "-DCMAKE_BUILD_TYPE=Quick",
        "-DCMAKE_CXX_FLAGS_QUICK=-O1 -DNDEBUG",
        "-DHYPGEN_WERROR=ON",
        *settings,
    ]
    command = [str(tools.cmake.path), "-S", str(HERE), "-B", str(build), *generator, *definitions]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode and "GTest" in done.stderr:
        pytest.skip("GoogleTest is not installed (Debian: libgtest-dev)")
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def archives() -> dict[str, Path]:
    """Return the archive of each library of the runtime, as solvers are linked with it."""
    tools = toolchain.find_tools()
    parts = solver._components(tools)
    libraries = {
        library.target: library
        for main in (solver.EXACT_MAIN, solver.VERIFY_MAIN)
        for library in solver._libraries({main: ""})
    }
    return {
        name: solver._archive(library, solver._library(library, tools, parts, lambda step: None))
        for name, library in libraries.items()
    }


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Path:
    """Return a folder for builds that is kept between runs: a change then recompiles only what it touches."""
    cache = getattr(request.config, "cache", None)  # not there with -p no:cacheprovider
    return Path(str(cache.mkdir("runtime-tests"))) if cache else tmp_path_factory.mktemp("b")


def compile_target(build: Path, target: str) -> None:
    command = [str(toolchain.find_cmake().path), "--build", str(build), "--target", target]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-20000:] + done.stderr[-5000:]


def test_runtime(archives: dict[str, Path], folder: Path) -> None:
    build, built = folder / "tests", ";".join(map(str, archives.values()))
    configure(build, f"-DHYPGEN_BUILT={built}", f"-DHYPGEN_RUNTIME_ID={solver.runtime_id()}")
    compile_target(build, "all")
    ctest = [
        str(toolchain.find_cmake().path.with_name("ctest")),
        "--test-dir",
        str(build),
        "--output-on-failure",
    ]
    done = subprocess.run([*ctest, "-j", str(os.cpu_count() or 1)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-20000:]
    assert "No tests were found" not in done.stdout + done.stderr


def test_tree_and_search_take_no_lock(archives: dict[str, Path]) -> None:
    names = shutil.which("nm")
    if names is None:
        pytest.skip("needs nm")
    command = [names, "-u", str(archives["hypgen_runtime"])]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    units = dict(part.split(".cpp.o:\n", 1) for part in listed.split("\n\n") if ".cpp.o:\n" in part)
    for unit in ("tree", "tree_bounds", "tree_choice", "tree_pomcp", "search_thread"):
        assert "pthread_mutex" not in units[unit]
        assert "pthread_cond" not in units[unit]


@pytest.mark.tsan
def test_threads_do_not_race(folder: Path) -> None:
    build = folder / "races"
    configure(build)
    compile_target(build, "race_tests")
    seconds = os.environ.get("HYPGEN_TEST_SECONDS", "8")  # for each of the searches in a loop
    settings = {"TSAN_OPTIONS": "halt_on_error=1", "HYPGEN_TEST_SECONDS": seconds}
    # Deadlines are not kept where everything takes ten times as long.
    command = [str(build / "race_tests"), "--gtest_brief=1", "--gtest_filter=-*Deadline*"]
    done = subprocess.run(command, env=os.environ | settings, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-10000:] + done.stderr[-10000:]


@pytest.mark.slow
def test_nothing_leaks(tmp_path: Path) -> None:
    """Nor reads or writes what it may not, nor does what C++ leaves undefined."""
    sanitize = "-fsanitize=address,undefined -fno-sanitize-recover=undefined -g1"
    configure(tmp_path, f"-DCMAKE_CXX_FLAGS={sanitize}", "-DHYPGEN_WERROR=OFF")
    compile_target(tmp_path, "runtime_tests")
    # Some tests ask for more memory than there is.
    settings = {"ASAN_OPTIONS": "detect_leaks=1:allocator_may_return_null=1"}
    # Deadlines are not kept where everything takes three times as long.
    command = [str(tmp_path / "runtime_tests"), "--gtest_brief=1", "--gtest_filter=-*Deadline*"]
    done = subprocess.run(command, env=os.environ | settings, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-10000:] + done.stderr[-10000:]
