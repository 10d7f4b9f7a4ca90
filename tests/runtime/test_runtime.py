"""Builds the C++ tests of the runtime with CMake and runs each as a case of its own."""

import os
import subprocess
from pathlib import Path

import pytest

from hypgen.runtime import toolchain

HERE = Path(__file__).parent


def configure(build: Path) -> None:
    """Configure the tests, or skip where GoogleTest is not installed."""
    tools = toolchain.find_tools()
    generator = ["-G", "Ninja", f"-DCMAKE_MAKE_PROGRAM={tools.ninja.path}"] if tools.ninja else []
    definitions = [
        f"-DCMAKE_CXX_COMPILER={tools.compiler.path}",
        f"-DHYPGEN_JSON_INCLUDE_DIR={tools.json_include}",
        "-DCMAKE_BUILD_TYPE=Release",
        "-DHYPGEN_WERROR=ON",
    ]
    command = [str(tools.cmake.path), "-S", str(HERE), "-B", str(build), *generator, *definitions]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode and "GTest" in done.stderr:
        pytest.skip("GoogleTest is not installed (Debian: libgtest-dev)")
    assert done.returncode == 0, done.stdout + done.stderr


def test_runtime(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> None:
    # Kept between runs, where pytest keeps its own cache: a change then recompiles only what it touches.
    build = (
        Path(str(request.config.cache.mkdir("runtime-tests")))
        if request.config.cache
        else tmp_path_factory.mktemp("b")
    )
    configure(build)
    cmake = str(toolchain.find_cmake().path)
    done = subprocess.run([cmake, "--build", str(build)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-20000:] + done.stderr[-5000:]
    ctest = [str(Path(cmake).with_name("ctest")), "--test-dir", str(build), "--output-on-failure"]
    done = subprocess.run([*ctest, "-j", str(os.cpu_count() or 1)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-20000:]
    assert "No tests were found" not in done.stdout + done.stderr
