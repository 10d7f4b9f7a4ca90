# SPDX-License-Identifier: Apache-2.0
"""Hostile input and machines that lack something: each is told, and none is called a bug of hypgen."""

from __future__ import annotations

import errno
import io
import json
import os
import random
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from support import hostile_input
from support.sanitized import BROKEN, ENVIRONMENT, sanitized_solver

from hypgen.cli import main
from hypgen.codegen.generate import generate
from hypgen.dsl.load import load
from hypgen.runtime.builder import preflight, tools
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.solver import build_solver

ROOT = Path(__file__).parents[2]
TIGER = ROOT / "examples" / "tiger.pomdp"
KNOBS = Path(__file__).parent / "knobs.pomdp"
MANY = 10_000
SHORT = 25
FEW = (*hostile_input.SMALL, *hostile_input.CAPS)
REQUIRE_GPU = b"--require-gpu"  # documented to end with 1 where there is none


def answered(solver: Path, arguments: list[bytes]) -> tuple[int, bytes]:
    """Return how a solver ends and what it says; of a broken model the table tells."""
    done = subprocess.run(
        [os.fsencode(solver), *arguments],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        env={**os.environ, **ENVIRONMENT},
        timeout=120,
    )
    return done.returncode, done.stderr or done.stdout


def wrong_with(arguments: list[bytes], code: int, said: bytes) -> str:
    """Return what an answer to hostile input lacks, nothing if it is as it has to be."""
    if code == 1 and REQUIRE_GPU in arguments and b"CUDA" in said:
        return ""
    if code not in (0, 2):
        return f"exit code {code}"
    if b"Sanitizer" in said or b"runtime error" in said:
        return "a sanitizer's report"
    if code == 0:
        return ""
    text = said.decode("utf-8", "replace")
    if not text.strip() or "\N{REPLACEMENT CHARACTER}" in text or "None" in text.replace('"None"', ""):
        return "no message, or one that is no text"
    if any(ord(c) < 32 for c in text.rstrip("\n").replace("\n", "")) or len(text) > 4000:
        return "a message that a terminal obeys, or a long one"
    return ""


def try_all(solver: Path, lines: Iterable[list[bytes]]) -> Counter[int]:
    """Return how often a solver ends with each exit code; an answer that is wrong ends the test."""

    def one(arguments: list[bytes]) -> int:
        code, said = answered(solver, arguments)
        problem = wrong_with(arguments, code, said)
        assert not problem, f"{problem}: {arguments!r}\n{said[-3000:].decode(errors='replace')}"
        return code

    with ThreadPoolExecutor(2) as pool:
        return Counter(pool.map(one, lines))


def files_of(contents: Iterable[bytes], folder: Path) -> Iterable[list[bytes]]:
    """Yield the arguments that give a solver each of the contents as a file."""
    for number, content in enumerate(contents):
        path = folder / f"{number}.json"
        path.write_bytes(content)
        yield [b"--param", os.fsencode(path), *(w.encode() for w in FEW)]


def random_lines(seed: int, count: int) -> list[list[bytes]]:
    """Return random lines of options."""
    generator = random.Random(seed)
    return [hostile_input.option_line(generator) for _ in range(count)]


def random_files(seed: int, count: int) -> list[bytes]:
    """Return random contents of params files."""
    generator = random.Random(seed)
    return [hostile_input.param_file(generator) for _ in range(count)]


@pytest.fixture(scope="module")
def solver() -> Path:
    """Return the solver that tests/e2e/test_serve.py builds too."""
    try:
        tools.find_tools()
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")
    return build_solver(generate(load(TIGER).model), "serve/tiger", lambda step: None)


@pytest.fixture(scope="module")
def sanitized(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a solver with params of all kinds; HYPGEN_SANITIZED names a folder to keep it in."""
    kept = os.environ.get("HYPGEN_SANITIZED")
    return sanitized_solver(KNOBS, Path(kept) if kept else tmp_path_factory.mktemp("sanitized"))


def report(name: str, codes: Counter[int], start: float) -> None:
    """Print the figures of docs/results/faults.md."""
    print(
        f"{name}: {sum(codes.values())} tried, exit codes {dict(sorted(codes.items()))}",
        end="",
        file=sys.stderr,
    )
    print(f", {time.monotonic() - start:.0f} s", file=sys.stderr)


@pytest.mark.cxx
def test_a_solver_answers_any_options(solver: Path) -> None:
    codes = try_all(solver, random_lines(1, SHORT))
    assert codes[0] > 0 and codes[2] > 0


@pytest.mark.cxx
def test_a_solver_answers_any_params(solver: Path, tmp_path: Path) -> None:
    codes = try_all(solver, files_of([*random_files(2, SHORT), b'{"hearing": 0.7}'], tmp_path))
    assert codes[0] > 0 and codes[2] > 0


@pytest.mark.faults
@pytest.mark.cxx
def test_options_under_sanitizers(sanitized: Path) -> None:
    start = time.monotonic()
    codes = try_all(sanitized, random_lines(3, MANY))
    report("options", codes, start)
    assert codes[0] > MANY / 5 and codes[2] > MANY / 5


@pytest.mark.faults
@pytest.mark.cxx
def test_params_under_sanitizers(sanitized: Path, tmp_path: Path) -> None:
    start = time.monotonic()
    codes = try_all(sanitized, files_of(random_files(4, MANY), tmp_path))
    report("params", codes, start)
    assert codes[0] > MANY / 5 and codes[2] > MANY / 5


@pytest.mark.cxx
@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"[" * 100_000, "nested deeper than 100 levels"),
        (b'{"hearing": ' + b"[" * 100_000 + b"]" * 100_000 + b"}", "nested deeper than 100 levels"),
        (b'{"hearing": 0.5, "hearing": 0.6}', '"hearing" is given twice'),
        (b'{"hearing": NaN}', "not valid JSON"),
        (b'{"hearing": 1e999}', "not valid JSON: number overflow"),
        (b'{"hear\xff": 1}', "not valid JSON"),
        (b"\x7fELF\0\0", "is a binary file"),
        (b" " * 16_000_001, "is larger than 16 MB"),
        (b"", "is empty"),
    ],
)
def test_hostile_params_are_named(solver: Path, tmp_path: Path, content: bytes, message: str) -> None:
    arguments = next(iter(files_of([content], tmp_path)))
    code, said = answered(solver, arguments)
    assert (code, wrong_with(arguments, code, said)) == (2, "")
    assert message in said.decode()


@pytest.mark.cxx
@pytest.mark.parametrize(
    ("file", "message"),
    [
        ("/dev/zero", "is a binary file"),
        ("/", "Is a directory"),
        ("/nowhere", "No such file or directory"),
        ("/dev/stdin", "is larger than 16 MB"),
    ],
)
def test_files_without_an_end_are_named(solver: Path, file: str, message: str) -> None:
    """Standard input is here a program that does not stop to write."""
    with subprocess.Popen(["yes"], stdout=subprocess.PIPE) as endless:
        done = subprocess.run(
            [solver, "--param", file], stdin=endless.stdout, capture_output=True, text=True, timeout=60
        )
        endless.kill()
    assert done.returncode == 2 and message in done.stderr


@pytest.mark.cxx
def test_a_request_without_an_end_ends_the_agent(solver: Path) -> None:
    with subprocess.Popen(["cat", "/dev/zero"], stdout=subprocess.PIPE) as endless:
        command = [solver, "--serve", "--scenarios", "10", "--memory", "8"]
        done = subprocess.run(command, stdin=endless.stdout, capture_output=True, text=True, timeout=60)
        endless.kill()
    assert (done.returncode, done.stdout) == (2, "")
    assert "a request is larger than 16 MB" in done.stderr


@pytest.mark.cxx
@pytest.mark.parametrize(
    ("line", "message"),
    [
        (
            '{"do": "update", "action": 5000000000, "seen": {"heard": "left"}}',
            "from 0 to 2, found 5000000000",
        ),
        ('{"do": "update", "action": -7, "seen": {"heard": "left"}}', "from 0 to 2, found -7"),
        ('{"do": "plan", "do": "quit"}', '"do" is given twice'),
        ("[" * 100_000, "nested deeper than 100 levels"),
        ('{"do": "reset", "visible": ' + '{"a":' * 90_000, "nested deeper"),
        ('{"do": "\x1b[2J"}', "not valid JSON"),
    ],
)
def test_hostile_requests_are_named(solver: Path, line: str, message: str) -> None:
    command = [solver, "--serve", "--scenarios", "10", "--memory", "8"]
    text = '{"do": "reset"}\n' + line + '\n{"do": "quit"}\n'
    done = subprocess.run(command, input=text, capture_output=True, text=True, timeout=60)
    answers = [json.loads(answer) for answer in done.stdout.splitlines()]
    assert [answer["status"] for answer in answers] == ["ok", "wrong_argument", "ok"]
    assert message in answers[1]["error"]


def endless_pipe(folder: Path) -> str:
    os.mkfifo(folder / "pipe")
    return str(folder / "pipe")


@pytest.mark.parametrize("command", ["check", "fmt", "import"])
@pytest.mark.parametrize(
    ("file", "message"),
    [
        (lambda folder: "/dev/zero", "is a binary file"),
        (lambda folder: "/dev/null", "is empty"),
        (lambda folder: str(folder), "is a folder"),
        (lambda folder: "a" * 5000, "File name too long"),
        (endless_pipe, "is empty"),
    ],
)
def test_files_that_are_no_models_are_named(
    command: str,
    file: Callable[[Path], str],
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("hypgen.dsl.messages.input_file.PIPE_SECONDS", 0.01)
    assert main.run([command, file(tmp_path)]) == 2
    text = capsys.readouterr().err
    assert message in text and "help: " in text and "None" not in text and "bug of hypgen" not in text


def refuse(*arguments: Any, **named: Any) -> Any:
    raise OSError(errno.ENOSPC, "No space left on device", "/full/model.o")


MACHINES: list[tuple[Exception, str]] = [
    (OSError(errno.ENOSPC, "No space left on device", "/full"), "error: '/full': No space left on device"),
    (PermissionError(errno.EACCES, "Permission denied", "/x"), "error: '/x': Permission denied"),
    (OSError(errno.EMFILE, "Too many open files"), "error: Too many open files\nhelp: raise the limit"),
    (OSError(), "error: OSError"),
    (FileNotFoundError(errno.ENOENT, "No usable temporary directory found in []"), "No usable temporary"),
    (MemoryError(), "error: not enough memory"),
    (ImportError("libx.so: failed to map segment from shared object"), "error: not enough memory"),
    (RuntimeError("can't start new thread"), "error: the system gives no more threads"),
    (
        ModuleNotFoundError("No module named 'lark'", name="lark"),
        "error: the Python package 'lark' is missing",
    ),
    (
        UnicodeEncodeError("ascii", "ü", 0, 1, "ordinal not in range"),
        "error: standard output takes ascii alone",
    ),
    (UnicodeEncodeError("utf-8", "\udcff", 0, 1, "surrogates not allowed"), "is not UTF-8"),
]


@pytest.mark.parametrize(("error", "message"), MACHINES, ids=lambda value: type(value).__name__)
def test_what_a_machine_lacks_is_no_bug(
    error: Exception, message: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*arguments: Any, **named: Any) -> Any:
        raise error

    monkeypatch.setattr("hypgen.dsl.load.load_any", fail)
    monkeypatch.delenv("HYPGEN_DEBUG", raising=False)
    assert main.run(["check", str(TIGER)]) == 2
    text = capsys.readouterr().err
    assert message in text and "\nhelp: " in text and "bug" not in text and "None" not in text


@pytest.mark.parametrize(
    "error",
    [ValueError("x"), RuntimeError("x"), ImportError("x"), ModuleNotFoundError("x", name="hypgen.dsl.x")],
)
def test_bugs_stay_bugs(
    error: Exception, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*arguments: Any, **named: Any) -> Any:
        raise error

    monkeypatch.setattr("hypgen.dsl.load.load_any", fail)
    monkeypatch.delenv("HYPGEN_DEBUG", raising=False)
    assert main.run(["check", str(TIGER)]) == 70
    assert "bug of hypgen" in capsys.readouterr().err


def homeless(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    def nobody(uid: int) -> Any:
        raise KeyError(uid)

    monkeypatch.setattr("pwd.getpwuid", nobody)
    for name in ("HOME", "XDG_CACHE_HOME", "HYPGEN_CACHE_DIR"):
        monkeypatch.delenv(name, raising=False)


def full(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    monkeypatch.setattr(preflight, "free_megabytes", lambda folder: 3)


def without_inodes(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    monkeypatch.setattr("tempfile.TemporaryFile", refuse)


def without_temporary(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    def none() -> str:
        raise FileNotFoundError(errno.ENOENT, "No usable temporary directory found in []")

    monkeypatch.setattr("tempfile.gettempdir", none)


def unwritable(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    (folder / "file").touch()
    monkeypatch.setenv("HYPGEN_CACHE_DIR", str(folder / "file" / "cache"))


def open_quote(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    monkeypatch.setenv("CXXFLAGS", "-DNAME='")


def gone(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    (folder / "gone").mkdir()
    monkeypatch.chdir(folder / "gone")
    (folder / "gone").rmdir()


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (homeless, "this user has no home folder"),
        (full, "has 3 MB free, and compiling takes up to"),
        (without_inodes, "cannot be written: No space left on device"),
        (without_temporary, "no folder for temporary files"),
        (unwritable, "cannot be written"),
        (open_quote, "CXXFLAGS has no closing quotation"),
        (gone, "the current folder is gone"),
    ],
)
@pytest.mark.cxx
def test_a_machine_that_cannot_compile_is_told_before(
    spoil: Callable[[pytest.MonkeyPatch, Path], None],
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("HYPGEN_CACHE_DIR", str(tmp_path / "cache"))
    spoil(monkeypatch, tmp_path)
    try:
        assert main.run(["compile", str(TIGER)]) == 2
    finally:
        os.chdir(ROOT)
    text = capsys.readouterr().err
    assert f"{message}" in text and "\nhelp: " in text
    assert "compiling (" not in text and "bug" not in text and "None" not in text


def test_a_solver_that_may_not_start_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "tiger").write_bytes(b"no program")
    monkeypatch.setattr("hypgen.cli.commands.run.build", lambda *arguments: tmp_path / "tiger")
    assert main.run(["run", str(TIGER), "--target", "cpu"]) == 2
    text = capsys.readouterr().err
    assert f"error: '{tmp_path / 'tiger'}': Permission denied\nhelp: check who owns" in text


def test_commands_do_without_standard_input(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", None)
    assert main.run(["fmt", "-"]) == 2
    assert "is empty" in capsys.readouterr().err
    monkeypatch.setattr("sys.stdin", None)
    assert main.run(["sim", str(TIGER), "--steps", "1"]) in (0, 130)
    assert "bug" not in capsys.readouterr().err


def test_standard_input_without_an_end_is_refused(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    class Endless(io.RawIOBase):
        def readable(self) -> bool:
            return True

        def readinto(self, buffer: Any) -> int:
            buffer[:] = b"#" * len(buffer)
            return len(buffer)

    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BufferedReader(Endless())))
    assert main.run(["fmt", "-"]) == 2
    assert "is larger than 16 MB" in capsys.readouterr().err


@pytest.mark.faults
@pytest.mark.cxx
def test_a_pipe_without_a_writer_is_empty(solver: Path, tmp_path: Path) -> None:
    code, said = answered(solver, [b"--param", os.fsencode(endless_pipe(tmp_path))])
    assert code == 2 and b"is empty" in said


LIMITS = ("-v 4000000", "-v 400000", "-v 150000", "-v 60000", "-n 30", "-n 12", "-n 7", "-f 10")


@pytest.mark.faults
@pytest.mark.parametrize(
    ("command", "limit"),
    [
        *(("check", limit) for limit in LIMITS),
        *(("doctor", limit) for limit in LIMITS),
        *(("compile", limit) for limit in LIMITS[2:]),  # with more it works, after minutes
    ],
)
def test_limits_are_named(command: str, limit: str, tmp_path: Path) -> None:
    """Under ``ulimit`` a command works or says what it lacks, once Python has come as far as hypgen."""
    started = "import sys; from hypgen.cli.main import main; print('started', file=sys.stderr); main()"
    files = [] if command == "doctor" else [str(TIGER)]
    done = subprocess.run(
        ["bash", "-c", f'ulimit {limit}; exec "$@"', "bash", sys.executable, "-c", started, command, *files],
        capture_output=True,
        text=True,
        env={**os.environ, "HYPGEN_CACHE_DIR": str(tmp_path), "PYTHONDONTWRITEBYTECODE": "1"},
        timeout=600,
    )
    if not done.stderr.startswith("started") or "OpenBLAS error" in done.stderr:
        return  # what NumPy loads ends the process itself
    assert done.returncode in (0, 2), done.stderr[-2000:]
    assert "bug of hypgen" not in done.stderr and "None" not in done.stderr
    assert done.returncode == 0 or "help: " in done.stderr + done.stdout, done.stderr[-2000:]


def test_a_sanitizer_would_be_noticed() -> None:
    assert wrong_with([], BROKEN, b"") and wrong_with([], -11, b"") and wrong_with([], 2, b"")
    assert wrong_with([], 0, b"ERROR: AddressSanitizer: heap-buffer-overflow") and wrong_with([], 1, b"no")
