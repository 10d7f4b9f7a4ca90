# SPDX-License-Identifier: Apache-2.0
"""The cache under kills, planted files and other users. Short forms: tests/unit/builder/test_cache.py.

``pytest -n 0 -s -m faults tests/faults/test_cache.py`` prints the figures of docs/results/faults.md.
"""

import contextlib
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from collections import Counter
from pathlib import Path

import pytest

from hypgen.runtime.builder import cache
from hypgen.runtime.builder.errors import ToolchainError

pytestmark = [pytest.mark.faults, pytest.mark.cxx]
ROOT = Path(__file__).parents[2]
HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]
NOBODY = 65534
COMPILES, COMPILES_A_CACHE = 200, 10
SIGNALS = (signal.SIGTERM, signal.SIGHUP, signal.SIGINT, signal.SIGKILL)
MARK = "HYPGEN_FAULT_TEST"  # in the environment of all that a compile starts

# A runtime and a model that compile in about a second, with CMake, Ninja and two threads of compilers.
RUNTIME = {
    "CMakeLists.txt": "cmake_minimum_required(VERSION 3.20)\nproject(tiny CXX)\n"
    "add_library(hypgen_runtime STATIC src/tiny.cpp src/more.cpp)\n"
    "target_compile_features(hypgen_runtime PUBLIC cxx_std_17)\n"
    "target_include_directories(hypgen_runtime PUBLIC include)\n"
    "install(TARGETS hypgen_runtime DESTINATION lib COMPONENT hypgen_runtime)\n",
    "include/tiny.hpp": "#pragma once\nint tiny(int x);\n",
    "src/tiny.cpp": "#include <algorithm>\n#include <tiny.hpp>\n"
    "int tiny(int x) { return std::max(x + 4, 0); }\n",
    "src/more.cpp": "#include <map>\nint more() { return std::map<int, int>{{1, 2}}[1]; }\n",
}
COMPILE = """
import sys
from pathlib import Path
from hypgen.runtime.builder import solver
solver.RUNTIME_FOLDER = Path(sys.argv[1])
files = {
    "src/toy.hpp": f"#pragma once\\n// {sys.argv[2]}\\ninline int toy() {{ return 3; }}\\n",
    "src/main.cpp": '#include <map>\\n#include <tiny.hpp>\\n#include "toy.hpp"\\n'
    "int main() { return std::map<int, int>{{1, tiny(toy())}}[1]; }\\n",
    "src/other.cpp": "#include <algorithm>\\nint other(int x) { return std::max(x, 0); }\\n",
}
print(solver.build_solver(files, "toy.pomdp", lambda step: None))
"""


def start(runtime: Path, model: str, folder: Path, mark: str) -> subprocess.Popen[str]:
    environment = {**os.environ, MARK: mark, "HYPGEN_CACHE_DIR": str(folder), "CXXFLAGS": "-O0"}
    command = [sys.executable, "-c", COMPILE, str(runtime), model]
    null = subprocess.DEVNULL
    return subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=null, text=True, preexec_fn=heed_signals
    )


def heed_signals() -> None:
    """Undo what ``nohup`` and shells do to what runs in the background: they ignore signals."""
    for number in SIGNALS[:-1]:
        signal.signal(number, signal.SIG_DFL)


def seconds(runtime: Path, model: str, folder: Path) -> float:
    """Return how long a compile takes."""
    begin = time.monotonic()
    with start(runtime, model, folder, "measured") as process:
        assert process.wait() == 0
    return time.monotonic() - begin


def marked(mark: str) -> list[int]:
    """Return the processes that have the mark."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if f"{MARK}={mark}\0".encode() in (path / "environ").read_bytes():
                found.append(int(path.name))
    return found


def orphans(mark: str) -> list[int]:
    """Return what still runs five seconds after its parent's end."""
    end = time.monotonic() + 5
    while (found := marked(mark)) and time.monotonic() < end:
        time.sleep(0.05)
    return found


def whole_entries(folder: Path) -> set[tuple[str, str]]:
    pairs = ((kind, path.name) for kind in ("runtime", "solvers") for path in folder.glob(f"{kind}/*"))
    return {
        (kind, key) for kind, key in pairs if not key.startswith(("tmp-", "lock-")) and cache.entry(kind, key)
    }


def test_200_compiles_that_are_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runtime, choice = tmp_path / "runtime", random.Random(20)
    for name, text in RUNTIME.items():
        (runtime / name).parent.mkdir(parents=True, exist_ok=True)
        (runtime / name).write_text(text)
    (tmp_path / "temporary").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "temporary"))
    counts: Counter[str] = Counter()
    whole_time = model_time = 0.0  # seconds of a compile, with the runtime and without, as the machine is now
    for number in range(COMPILES):
        folder = tmp_path / f"cache-{number // COMPILES_A_CACHE}"
        monkeypatch.setenv("HYPGEN_CACHE_DIR", str(folder))
        if number % COMPILES_A_CACHE == 0:
            whole_time, model_time = (seconds(runtime, m, tmp_path / f"other-{number}") for m in ("a", "b"))
        before, mark = whole_entries(folder), uuid.uuid4().hex
        with start(runtime, f"model {number}", folder, mark) as process:
            has_runtime = any(kind == "runtime" for kind, _ in before)
            time.sleep(choice.uniform(0.0, model_time if has_runtime else whole_time))
            counts["kills with compilers under way"] += len(marked(mark)) > 1
            process.send_signal(choice.choice(SIGNALS))
            output, _ = process.communicate()
        left = orphans(mark)
        counts["orphans"] += len(left)
        for orphan in left:
            with contextlib.suppress(ProcessLookupError):
                os.kill(orphan, signal.SIGKILL)
        if process.returncode == 0:
            counts["compiles that were ready before"] += 1
            counts["exit 0 without a solver"] += subprocess.run([output.strip()]).returncode != 7
        counts["half-made folders"] += any(folder.glob("*/tmp-*"))
        cache.entry("solvers", "0")  # the next use
        counts["half-made folders at the next use"] += any(folder.glob("*/tmp-*"))
        after = whole_entries(folder)
        counts["lost entries"] += len(before - after)
        if number % COMPILES_A_CACHE == COMPILES_A_CACHE - 1:
            with start(runtime, f"model {number}", folder, mark) as process:
                output, _ = process.communicate()
            counts["compiles that failed afterwards"] += subprocess.run([output.strip()]).returncode != 7
            shutil.rmtree(folder)
    counts["temporary files of compilers"] = len(list((tmp_path / "temporary").iterdir()))
    print()
    for name, count in sorted(counts.items()):
        print(f"| {name} | {count} |")
    wrong = ("orphans", "exit 0 without a solver", "lost entries", "half-made folders at the next use")
    assert not any(counts[name] for name in (*wrong, "compiles that failed afterwards"))
    assert counts["kills with compilers under way"] > COMPILES / 4


@pytest.fixture(scope="module")
def compiled() -> Path:
    """The cache of all tests, with the compiled solver of one example."""
    done = hypgen("compile", "--target", "cpu")
    assert done.returncode == 0, done.stderr
    return cache.root()


@pytest.fixture
def folder(compiled: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache with a copy of that solver alone."""
    monkeypatch.setenv("HYPGEN_CACHE_DIR", str(compiled))
    solver = Path(hypgen("compile", "--target", "cpu").stdout.strip()).parent.parent
    folder = tmp_path / "cache"
    for kind in ("runtime", "records"):
        shutil.copytree(compiled / kind, folder / kind)
    shutil.copytree(solver, folder / "solvers" / solver.name)
    for path in (folder, folder / "solvers"):
        path.chmod(0o700)
    monkeypatch.setenv("HYPGEN_CACHE_DIR", str(folder))
    return folder


def hypgen(command: str, *options: str, before: tuple[str, ...] = ()) -> subprocess.CompletedProcess[str]:
    model = str(ROOT / "examples" / "tiger.pomdp")
    return subprocess.run([*before, *HYPGEN, command, model, *options], capture_output=True, text=True)


def plant(folder: Path, tmp_path: Path) -> Path:
    """Put a program in the place of the solver; return the file that it would write."""
    [solver] = folder.glob(f"solvers/*/{cache.FILES}/tiger")
    solver.write_text(f"#!/bin/sh\ntouch {tmp_path / 'ran'}\n")
    return tmp_path / "ran"


RUN = ("--target", "cpu", "--runs", "1", "--trials", "20")


def test_a_planted_solver_is_not_run(folder: Path, tmp_path: Path) -> None:
    ran = plant(folder, tmp_path)
    done = hypgen("run", *RUN)
    assert done.returncode == 0 and "no longer whole in the cache" in done.stderr
    assert not ran.exists()
    assert "cached" in hypgen("run", *RUN).stderr


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give files away")
@pytest.mark.parametrize("what", ["cache", "cache/solvers", "entry"])
def test_a_planted_solver_of_another_user_is_refused(what: str, folder: Path, tmp_path: Path) -> None:
    ran = plant(folder, tmp_path)
    path = next(folder.glob("solvers/[!l]*")) if what == "entry" else tmp_path / what
    os.chown(path, NOBODY, NOBODY)
    for command, options in (("compile", ("--target", "cpu")), ("run", RUN)):
        done = hypgen(command, *options)
        assert done.returncode == 2
        assert f"error: '{path}' belongs to" in done.stderr and "help: remove it, or let" in done.stderr
    assert hypgen("check").returncode == 0
    assert not ran.exists()


def test_a_planted_pickle_is_not_read(folder: Path, tmp_path: Path) -> None:
    (folder / "grammar.lark-tables").write_bytes(
        b"cos\nsystem\n(S'touch " + bytes(tmp_path / "ran") + b"'\ntR."
    )
    assert hypgen("check").returncode == 0
    assert not (tmp_path / "ran").exists()


@pytest.mark.skipif(os.geteuid() != 0 or not shutil.which("setpriv"), reason="needs root and setpriv")
def test_the_second_user_of_a_teams_cache_is_refused(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/usr/bin:/bin")  # tools of this Python may be out of the other user's reach
    other = ("setpriv", "--reuid", str(NOBODY), "--regid", str(NOBODY), "--clear-groups", "--")
    with tempfile.TemporaryDirectory() as name:  # pytest's own folders are closed to others
        team, own = Path(name) / "team", Path(name) / "own"
        shutil.copytree(folder, team)
        own.mkdir()
        os.chown(own, NOBODY, NOBODY)
        for path in (Path(name), *Path(name).rglob("*")):
            path.chmod(0o755)
        mine = {**os.environ, "HYPGEN_CACHE_DIR": str(own)}
        if subprocess.run([*other, *HYPGEN, "doctor"], env=mine, capture_output=True).returncode != 0:
            pytest.skip("the other user cannot start hypgen here")
        ran = plant(team, own)
        monkeypatch.setenv("HYPGEN_CACHE_DIR", str(team))
        for command, options in (("compile", ("--target", "cpu")), ("run", RUN)):
            done = hypgen(command, *options, before=other)
            assert done.returncode == 2
            assert f"error: '{team}' belongs to root, and hypgen runs as" in done.stderr
        assert not ran.exists()


def test_random_damage_is_noticed(folder: Path) -> None:
    choice = random.Random(20)
    [path] = (p for p in folder.glob("solvers/*") if not p.name.startswith("lock-"))
    contents = {p: p.read_bytes() for p in path.rglob("*") if p.is_file()}
    for _ in range(1000):
        file, data = choice.choice(list(contents.items()))
        damaged = bytearray(data)
        match choice.randrange(3):
            case 0:
                damaged[choice.randrange(len(data))] ^= 1 << choice.randrange(8)
            case 1:
                del damaged[choice.randrange(len(data)) :]
            case 2:
                damaged += bytes([choice.randrange(256)])
        file.write_bytes(damaged)
        with contextlib.suppress(ToolchainError):
            found = cache.entry("solvers", path.name)
            # A manifest may differ in its spaces.
            assert found is None or file.name == cache.MANIFEST
        file.write_bytes(data)
    assert cache.entry("solvers", path.name) is not None
