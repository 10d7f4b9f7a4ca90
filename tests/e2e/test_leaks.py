# SPDX-License-Identifier: Apache-2.0
"""Programs that embed a library leak nothing, and the sanitizers have nothing to say of either."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from support.paths import EXAMPLES, ROOT

from hypgen.runtime.builder import tools

pytestmark = [pytest.mark.cxx, pytest.mark.slow]
HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]
SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=undefined", "-g1"]
SETTINGS = {"ASAN_OPTIONS": "detect_leaks=1", "UBSAN_OPTIONS": "print_stacktrace=1"}


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with RockSample's library, compiled with the sanitizers."""
    folder = tmp_path_factory.mktemp("leaks") / "rocks"
    flags = {"CXXFLAGS": " ".join(["-O1", *SANITIZE]), "LDFLAGS": " ".join(SANITIZE)}
    model = str(EXAMPLES / "rock_sample.pomdp")
    done = subprocess.run(
        [*HYPGEN, "compile", model, "--library", "--target", "cpu", "-o", str(folder)],
        env=os.environ | flags,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return folder


def run(package: Path, source: Path, archives: bool, tmp_path: Path, said: str = "") -> str:
    """Compile a program with the library or its archives, run it, and return what it prints."""
    language = ["-x", "c++", "-std=c++17"] if source.suffix == ".cpp" else ["-x", "c", "-std=c11"]
    lib = package / "lib"
    [runtime] = lib.glob("libhypgen_runtime-*.a")
    archived = [str(lib / "librock_sample.a"), str(runtime), "-pthread", "-lstdc++", "-lm"]
    linked = archived if archives else [f"-L{lib}", f"-Wl,-rpath,{lib}", "-lrock_sample"]
    program = str(tmp_path / source.stem)
    command = [str(tools.find_compiler().path), *SANITIZE, f"-I{package / 'include'}", *language, str(source)]
    done = subprocess.run([*command, "-x", "none", *linked, "-o", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    done = subprocess.run([program], input=said, env=os.environ | SETTINGS, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-8000:]
    assert "Sanitizer" not in done.stderr and "runtime error" not in done.stderr
    return done.stdout


@pytest.mark.parametrize("archives", [False, True], ids=["shared", "static"])
@pytest.mark.parametrize("source", ["embed_c/robot.c", "embed_cpp/robot.cpp"])
def test_the_examples_leak_nothing(package: Path, source: str, archives: bool, tmp_path: Path) -> None:
    out = run(package, ROOT / "examples" / source, archives, tmp_path, "bad\nbad\n")
    assert len(out.splitlines()) == 4


@pytest.mark.parametrize("archives", [False, True], ids=["shared", "static"])
def test_every_call_leaks_nothing(package: Path, archives: bool, tmp_path: Path) -> None:
    support = ROOT / "tests" / "support"
    assert run(package, support / "every_call.c", archives, tmp_path) == "57 refused\n"
    said = "all calls are as hypgen.h says\n"
    assert run(package, support / "every_call.cpp", archives, tmp_path) == said
