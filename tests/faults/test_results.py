# SPDX-License-Identifier: Apache-2.0
"""Results are kept, and exit codes tell the truth, where runs are ended and nothing more can be written."""

from __future__ import annotations

import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from subprocess import PIPE
from typing import Any

import pytest
from support.paths import ROOT

from hypgen.cli.exit_codes import Exit

pytestmark = pytest.mark.cxx
TIGER = str(ROOT / "examples" / "tiger.pomdp")
HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]
FULL = "No space left on device"
ENDLESS = ["--mode", "despot", "--trials", "3", "--runs", "1000000", "--steps", "5", "--threads", "1"]
QUICK = ["--mode", "default", "--runs", "2"]
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def hypgen(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*HYPGEN, *arguments], text=True, **{"stderr": PIPE, **options})


@pytest.fixture(scope="module")
def solver() -> str:
    return hypgen("compile", TIGER, stdout=PIPE, check=True).stdout.strip()


@pytest.fixture
def small(tmp_path: Path) -> Iterator[Path]:
    """Return a folder that holds 64 KiB."""
    folder = tmp_path / "small"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(folder)]
    if subprocess.run(mount, capture_output=True).returncode != 0:
        pytest.skip("needs the right to mount a tmpfs")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.parametrize(
    "arguments",
    [
        ["check", TIGER],
        ["fmt", "--diff", "-"],
        ["sim", TIGER, "--policy", "default"],
        ["run", TIGER, *QUICK],
        ["compare", TIGER, "--runs", "1", "--modes", "default"],
        ["solve", TIGER, "--json"],
        ["--help"],
    ],
    ids=" ".join,
)
def test_a_full_standard_output_is_told(solver: str, arguments: list[str]) -> None:
    with open("/dev/full", "w") as full:
        done = hypgen(*arguments, stdout=full, input="model  M\n")
    assert done.returncode in (Exit.DIFFERENT, Exit.MISTAKE)
    assert re.search(f"standard output:? cannot be written: {FULL}\n$", done.stderr), done.stderr
    assert "bug" not in done.stderr


def test_a_full_standard_error_ends_nothing() -> None:
    with open("/dev/full", "w") as full:
        done = hypgen("fmt", "--check", TIGER, stdout=PIPE, stderr=full)
    assert done.returncode == Exit.OK


def test_a_line_that_does_not_fit_ends_the_run(solver: str) -> None:
    done = subprocess.run([solver, *ENDLESS, "--json", "/dev/full"], capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.endswith(f"Tiger: /dev/full: cannot be written: {FULL}\n")


def test_what_fits_on_a_small_disk_is_whole(solver: str, small: Path) -> None:
    lines = small / "lines.jsonl"
    done = subprocess.run([solver, *ENDLESS, "--json", str(lines)], capture_output=True, text=True)
    assert done.returncode == 1
    assert f"{lines}: cannot be written: {FULL}" in done.stderr
    told = finished(done.stdout)
    assert told == sum(line["type"] == "episode" for line in whole_lines(lines)) > 0


def test_a_small_disk_keeps_what_was_there(small: Path, tmp_path: Path) -> None:
    text = Path(TIGER).read_text().replace("observe", "observe ", 1)
    model = small / "model.pomdp"
    model.write_text(text)
    filler = small / "filler"
    with open(filler, "wb", buffering=0) as stream, pytest.raises(OSError, match=FULL):
        while True:
            stream.write(bytes(4096))
    for arguments in (["fmt", str(model)], ["import", cassandra(tmp_path), "-o", str(model), "--force"]):
        done = hypgen(*arguments, stdout=PIPE)
        assert done.returncode == Exit.MISTAKE
        assert f"{model} cannot be written: {FULL}" in done.stderr
        assert model.read_text() == text
    policy = small / "policy"
    done = hypgen("solve", TIGER, "--policy", str(policy), stdout=PIPE)
    assert done.returncode == 1 and f"{policy}: cannot be written: {FULL}" in done.stderr
    assert "Tiger: 2 states" in done.stdout
    done = hypgen("compile", TIGER, "--emit", "project", "-o", str(small / "out"), stdout=PIPE)
    assert done.returncode == Exit.MISTAKE and FULL in done.stderr
    assert sorted(os.listdir(small)) == ["filler", "model.pomdp"]


@pytest.mark.faults
def test_a_full_disk_ends_a_suite_that_goes_on_once_there_is_room(small: Path, tmp_path: Path) -> None:
    suite, out = tmp_path / "suite.toml", small / "out"
    suite.write_text(
        f'[tasks.tiger]\nmodel = "{TIGER}"\n[[study]]\nname = "s"\nruns = 4\nplay = ["default"]\nsteps = 3\n'
        "beside = false\n"
    )
    filler = small / "filler"
    with open(filler, "wb", buffering=0) as stream, pytest.raises(OSError, match=FULL):
        while True:
            stream.write(bytes(4096))
    done = hypgen("bench", str(suite), "-o", str(out), stdout=PIPE)
    assert done.returncode == Exit.MISTAKE and FULL in done.stderr and "bug" not in done.stderr
    filler.unlink()
    done = hypgen("bench", str(suite), "-o", str(out), stdout=PIPE)
    assert done.returncode == Exit.OK and "| default | 4 |" in done.stdout, done.stderr
    assert not list(out.glob(".*")), "nothing half written is left"


def cassandra(folder: Path) -> str:
    path = folder / "one.POMDP"
    head = "discount: 0.9\nvalues: reward\nstates: 1\nactions: a\nobservations: o\n"
    path.write_text(f"{head}T: a\nuniform\nO: a\nuniform\nR: * : * : * : * 1\n")
    return str(path)


@pytest.mark.parametrize(
    "command", ["{solver} --json - {endless}", "{hypgen} run {tiger} --json - {endless}", "{hypgen} --help"]
)
def test_a_reader_that_goes_away_ends_a_command_quietly(solver: str, command: str) -> None:
    hypgen_ = f'{sys.executable} -c "from hypgen.cli.main import main; main()"'
    words = command.format(solver=solver, hypgen=hypgen_, tiger=TIGER, endless=" ".join(ENDLESS))
    script = f"{words} | head -c 1 > /dev/null; echo ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", f"{{ {script}; }} 2>&1"], stdout=PIPE, text=True)
    lines = [line for line in done.stdout.splitlines() if "cached" not in line and "note:" not in line]
    assert lines in (["141"], ["0"] if "--help" in command else ["141"])  # a short text may fit in the pipe


def whole_lines(path: Path) -> list[dict[str, Any]]:
    """Return the JSON lines of a file that must end with a whole one."""
    text = path.read_text() if path.exists() else ""
    assert text == "" or text.endswith("\n")
    return [json.loads(line) for line in text.splitlines()]


def finished(table: str) -> int:
    """Return how many episodes a table counts."""
    found = re.search(r"^episodes +([\d,]+)", table, re.MULTILINE)
    return int(found[1].replace(",", "")) if found else 0


def end_later(solver: str, lines: Path, number: int, wait: float, begun: bool) -> str:
    """Start a run, end it by a signal some time later, or so long after its first line if it has ``begun``.

    Returns how it ended, once all is checked.
    """
    lines.unlink(missing_ok=True)
    command = [solver, *ENDLESS, "--json", str(lines)]
    with subprocess.Popen(command, stdout=PIPE, stderr=PIPE, text=True) as run:
        if begun:
            wait_for(lines, 1)
        time.sleep(wait)
        run.send_signal(number)
        table, complaint = run.communicate(timeout=100)
    code, written = run.returncode, whole_lines(lines)
    episodes = [line for line in written if line["type"] == "episode"]
    whole = [line["episode"] for line in episodes if line["status"] != "interrupted"]
    assert whole == list(range(len(whole)))
    steps = Counter(line["episode"] for line in written if line["type"] == "step")
    assert all(steps[line["episode"]] == line["steps"] for line in episodes)
    if code == -number:  # by SIGKILL, or before there was anything to keep
        assert number == signal.SIGKILL or not written or written[-1]["type"] == "run"
        return "before its first line" if not written else "in mid-run"
    assert code == 128 + number, complaint
    assert written[-1]["type"] == "summary" and written[-1]["episodes"] == len(whole)
    assert finished(table) == len(whole)
    return "with table and summary"


def end_many(solver: str, folder: Path, runs: int) -> Counter[tuple[str, str]]:
    """Return how often runs ended in which way, by signal."""
    draw, ended = random.Random(runs), Counter[tuple[str, str]]()
    for i in range(runs):
        number = (*SIGNALS, signal.SIGKILL)[i % 4]
        begun = draw.random() < 0.8
        wait = draw.random() * (0.3 if begun else 0.03)
        ended[number.name, end_later(solver, folder / "lines.jsonl", number, wait, begun)] += 1
    return ended


def test_runs_that_are_ended_keep_what_they_have_played(solver: str, tmp_path: Path) -> None:
    assert end_many(solver, tmp_path, 8).total() == 8


@pytest.mark.faults
def test_200_runs_that_are_ended_keep_what_they_have_played(solver: str, tmp_path: Path) -> None:
    ended = end_many(solver, tmp_path, 200)
    print("\n", *(f"{count:4} {name} {how}\n" for (name, how), count in sorted(ended.items())))
    assert ended.total() == 200


def start(*arguments: str, before: tuple[str, ...] = ()) -> subprocess.Popen[str]:
    return subprocess.Popen([*before, *HYPGEN, *arguments], stdout=PIPE, stderr=PIPE, text=True)


def wait_for(path: Path, count: int) -> None:
    """Wait until a file has so many lines."""
    deadline = time.monotonic() + 100
    while not path.exists() or path.read_text().count("\n") < count:
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_two_signals_at_once_are_one_and_a_later_one_ends_a_run(solver: str, tmp_path: Path) -> None:
    lines = tmp_path / "lines.jsonl"
    slow = [
        "--mode",
        "despot",
        "--runs",
        "9",
        "--time",
        "1000",
        "--trials",
        "100000000",
        "--json",
        str(lines),
    ]
    with subprocess.Popen([solver, *slow], stdout=PIPE, stderr=PIPE) as run:
        wait_for(lines, 1)
        time.sleep(0.1)
        run.send_signal(signal.SIGTERM)
        run.send_signal(signal.SIGTERM)
        time.sleep(0.2)
        assert run.poll() is None, "it ends after its step"
        run.send_signal(signal.SIGINT)
        assert run.wait(100) == -signal.SIGINT
    lines.unlink()
    with start("run", TIGER, *ENDLESS, "--json", str(lines)) as run:
        wait_for(lines, 20)
        run.send_signal(signal.SIGTERM)
        run.send_signal(signal.SIGTERM)
        table, complaint = run.communicate(timeout=100)
    assert run.returncode == 128 + signal.SIGTERM and finished(table) > 0, complaint


def test_nohup_keeps_a_run_from_ending(solver: str, tmp_path: Path) -> None:
    lines = tmp_path / "lines.jsonl"
    with start("run", TIGER, *ENDLESS, "--json", str(lines), before=("nohup",)) as run:
        wait_for(lines, 3)
        run.send_signal(signal.SIGHUP)
        wait_for(lines, lines.read_text().count("\n") + 100)
        run.send_signal(signal.SIGTERM)
        table, _ = run.communicate(timeout=100)
    assert run.returncode == 128 + signal.SIGTERM and finished(table) > 0


def test_a_comparison_that_is_ended_prints_what_is_known(solver: str) -> None:
    options = ["--modes", "default,despot", "--runs", "30", "--time", "0.2", "--steps", "10"]
    with start("compare", TIGER, *options) as run:
        assert run.stderr is not None
        while not run.stderr.readline().startswith("default:"):
            assert run.poll() is None
        run.send_signal(signal.SIGHUP)
        table, _ = run.communicate(timeout=100)
    assert run.returncode == 128 + signal.SIGHUP
    assert re.search(r"(?m)^default +(30 )? ", table)


def test_an_episode_that_is_ended_is_summed_up() -> None:
    with start("sim", TIGER, "--policy", "default", "--steps", "100000000") as run:
        assert run.stdout is not None
        run.stdout.readline()
        run.send_signal(signal.SIGTERM)
        text, _ = run.communicate(timeout=100)
    assert run.returncode == 128 + signal.SIGTERM
    assert "return" in text.splitlines()[-1]


def files_of(folder: Path) -> dict[Path, bytes]:
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def remove_stages(folder: Path) -> None:
    """Remove what killed processes have not moved."""
    for stage in folder.glob(".hypgen-*/"):
        shutil.rmtree(stage)


def kill_while_moving(arguments: tuple[str, ...], folder: Path, wait: float) -> None:
    """Kill a command some time after it has begun to write to a folder."""
    remove_stages(folder)
    with start(*arguments) as run:
        while run.poll() is None and not list(folder.glob(".hypgen-*/project/third_party")):
            time.sleep(0.005)
        time.sleep(wait)
        run.kill()


@pytest.mark.faults
def test_50_kills_of_compile_leave_each_file_old_or_new(tmp_path: Path) -> None:
    draw, model, marker = random.Random(50), tmp_path / "model.pomdp", ".hypgen-project"
    texts = [Path(TIGER).read_text().replace("0.95", discount, 1) for discount in ("0.95", "0.9")]
    wanted = []
    for i, text in enumerate(texts):
        model.write_text(text)
        done = hypgen("compile", str(model), "--emit-only", "-o", str(tmp_path / f"whole-{i}"), stdout=PIPE)
        assert done.returncode == Exit.OK
        wanted.append(files_of(tmp_path / f"whole-{i}"))
    folder, moving = tmp_path / "whole-1", 0
    arguments = ("compile", str(model), "--emit-only", "-o", str(folder))
    for i in range(50):
        model.write_text(texts[i % 2])
        kill_while_moving(arguments, folder, 0.3 * draw.random())
        moving += "before" in json.loads((folder / marker).read_text())
        for name in wanted[0].keys() - {Path(marker)}:
            assert (folder / name).read_bytes() in (wanted[0][name], wanted[1][name])
    print(f"\n{moving} of 50 kills came while files were moved")
    remove_stages(folder)
    done = hypgen(*arguments, stdout=PIPE)
    assert done.returncode == Exit.OK and "note" not in done.stderr
    assert files_of(folder) == wanted[1]
