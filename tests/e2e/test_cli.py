# SPDX-License-Identifier: Apache-2.0
"""The command line as a user meets it: output, exit codes, and what is never shown."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from hypgen import __version__
from hypgen.cli import main
from hypgen.cli.exit_codes import Exit
from hypgen.runtime.builder.errors import BuildError

ROOT = Path(__file__).parent.parent.parent
TIGER = str(ROOT / "examples" / "tiger.pomdp")
ROCKS = str(ROOT / "examples" / "rock_sample.pomdp")
SLOW_IMPORTS = ("jinja2", "numpy", "rich", "hypgen.codegen.generate", "hypgen.runtime.builder.solver")


def hypgen(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run hypgen in a process of its own."""
    command = [sys.executable, "-c", "from hypgen.cli.main import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, env={**os.environ, **environment})


def test_version() -> None:
    assert hypgen("--version").stdout == f"hypgen, version {__version__}\n"


@pytest.mark.parametrize("name", main.COMMANDS)
def test_every_command_explains_itself(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run([name, "--help"]) == 0
    text = capsys.readouterr().out
    assert "Examples:\n    hypgen" in text or f"hypgen {name}" in text
    assert "Exit codes:" in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["chek", TIGER], "No such command 'chek'. Did you mean 'check'?"),
        (["check", TIGER.removesuffix(".pomdp")], "help: did you mean 'tiger.pomdp'?"),
        (["check", TIGER.replace("tiger", "tigre")], "help: did you mean 'tiger.pomdp'?"),
        (["check"], "Missing argument 'MODEL'"),
        (["check", TIGER, "--jason"], "No such option"),
        (["check", "/no/such.pomdp"], "error[E0001]: there is no file '/no/such.pomdp'"),
        (["check", TIGER, "--set", "hearing"], "error[E0011]"),
        (["compile", TIGER, "--emit-only"], "add -o DIR"),
        (["explain", TIGER, "--stage", "soul"], "'soul' is not one of"),
        (["explain", TIGER, "--stage", "ir", "--json"], "leave out --stage"),
        (["run", "--runs", "3", TIGER], "The model comes first"),
    ],
)
def test_a_users_mistake_ends_with_2(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.run(arguments) == 2
    output = capsys.readouterr()
    assert message in output.err and output.out == ""


def test_mistakes_of_a_model_are_shown_with_their_place(tmp_path: Path) -> None:
    path = tmp_path / "broken.pomdp"
    path.write_text(Path(TIGER).read_text().replace("room.tiger'", "room.tigre'"))
    done = hypgen("check", str(path))
    assert done.returncode == 2 and done.stdout == ""
    assert f"{path}:" in done.stderr and "^" in done.stderr and "help:" in done.stderr
    assert "\x1b" not in done.stderr, "colour belongs to terminals"
    data = json.loads(hypgen("check", str(path), "--json").stdout)
    assert not data["ok"]
    assert data["diagnostics"][0]["span"]["file"] == str(path)


def test_check_says_how_large_a_model_is() -> None:
    done = hypgen("check", TIGER)
    assert (done.returncode, done.stderr) == (0, "")
    expected = "Tiger: 1 bit of state (1 hidden), 3 actions, 2 observations, 1 stage of updates"
    assert done.stdout == f"{TIGER}: OK: {expected}\n"
    assert json.loads(hypgen("check", TIGER, "--json").stdout) == {
        "ok": True,
        "diagnostics": [],
        "model": "Tiger",
        "state_bits": 1,
        "hidden_bits": 1,
        "actions": 3,
        "observations": 2,
        "observation_bits": 1,
        "stages": 1,
    }


def test_check_imports_nothing_that_it_does_not_need() -> None:
    code = f"import sys; from hypgen.cli.main import run; run(['check', {TIGER!r}]); print(*sys.modules)"
    modules = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert not set(SLOW_IMPORTS) & set(modules)


@pytest.mark.parametrize("stage", ["ast", "ir", "cpp"])
def test_stages_are_deterministic_and_have_no_machine_paths(stage: str) -> None:
    first, second = (hypgen("explain", ROCKS, "--stage", stage, PYTHONHASHSEED=seed) for seed in "12")
    assert first.returncode == 0, first.stderr
    assert first.stdout == second.stdout
    assert "rock" in first.stdout
    assert stage in ("ast", "ir") or str(ROOT) not in first.stdout


def test_doctor_finds_what_compiling_takes() -> None:
    done = hypgen("doctor")
    assert done.returncode == 0, done.stdout
    for name in ("C++ compiler", "CMake", "Ninja", "nlohmann-json", "Eigen", "cache", "CUDA", "GPU"):
        assert f"\n{name} " in done.stdout
    done = hypgen("doctor", CXX="no-such-compiler")
    assert done.returncode == 2 and "help: unset CXX" in done.stdout


def test_without_a_compiler_the_user_is_told_what_to_do() -> None:
    done = hypgen("compile", TIGER, CXX="no-such-compiler")
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr == (
        "error: CXX names 'no-such-compiler', which does not run\n"
        "help: unset CXX or let it name one C++17 compiler, without options\n"
    )


def fail(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> int:
    def load(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("hypgen.cli.commands.explain.load", load)
    return main.run(["explain", TIGER])


def test_a_bug_says_so_without_a_traceback(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("HYPGEN_DEBUG", raising=False)
    assert fail(monkeypatch, KeyError("x")) == 70
    text = capsys.readouterr().err
    assert "a bug of hypgen" in text and "HYPGEN_DEBUG=1" in text and "Traceback" not in text
    monkeypatch.setenv("HYPGEN_DEBUG", "1")
    with pytest.raises(KeyError):
        fail(monkeypatch, KeyError("x"))


def test_cpp_errors_are_a_bug_and_stay_in_the_log(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert fail(monkeypatch, BuildError("the model", tmp_path / "gcc.log")) == 70
    text = capsys.readouterr().err
    assert "a bug of hypgen, not of your model" in text and str(tmp_path / "gcc.log") in text


def test_an_interrupt_ends_with_130(monkeypatch: pytest.MonkeyPatch) -> None:
    assert fail(monkeypatch, KeyboardInterrupt()) == Exit.INTERRUPTED == 130


def test_a_reader_that_goes_away_is_no_bug() -> None:
    command = (
        f"{sys.executable} -c 'from hypgen.cli.main import main; main()' explain {ROCKS} --stage ir | head -1"
    )
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True)
    assert done.stderr == "" and done.stdout.count("\n") == 1


def test_sampling_names_what_it_finds_and_the_state(tmp_path: Path) -> None:
    path = tmp_path / "tiger.pomdp"
    odd = "reward odd = 1.0 / (if room.tiger == left then 0.0 else 2.0)\n"
    path.write_text(f"{Path(TIGER).read_text()}\n{odd}")
    done = hypgen("check", str(path), "--samples", "500", "--seed", "3", "--time", "600")
    assert done.returncode == 2
    assert "error[C0104]: the reward 'odd' is inf" in done.stderr
    assert "in this state, the first of" in done.stderr and "room.tiger = left" in done.stderr
    assert "500 states in" in done.stdout and "1 mistake" in done.stdout
    data = json.loads(
        hypgen("check", str(path), "--samples", "500", "--seed", "3", "--time", "600", "--json").stdout
    )
    assert not data["ok"] and data["samples"]["states"] == 500 and data["actions"] == 3
    assert data["diagnostics"][0]["severity"] == "error"
    assert data["diagnostics"][0]["state"]["room.tiger"] == "left"


def test_sampling_a_right_model_ends_with_0() -> None:
    done = hypgen("check", TIGER, "--samples", "500", "--time", "600")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.endswith("500 states in 64 episodes, seed 0: nothing wrong\n")


def test_sampling_ends_in_time_and_keeps_what_it_found(tmp_path: Path) -> None:
    path = tmp_path / "tiger.pomdp"
    odd = "reward odd = 1.0 / (if room.tiger == left then 0.0 else 2.0)\n"
    path.write_text(f"{Path(TIGER).read_text()}\n{odd}")
    done = hypgen("check", str(path), "--samples", "1000000", "--time", "0")
    assert done.returncode == 2 and "error[C0104]: the reward 'odd' is inf" in done.stderr
    assert "note: 0 s are over: the walk ended after" in done.stderr and "--time gives it more" in done.stderr
    refused = hypgen("check", TIGER, "--time", "5")
    assert refused.returncode == 2 and "add one of them" in refused.stderr


def test_values_for_all_params_are_asked_for_at_once(tmp_path: Path) -> None:
    path = tmp_path / "tiger.pomdp"
    path.write_text(re.sub(r"(param \w+: \w+) = [^\n#]*", r"\1", Path(TIGER).read_text()))
    for command in (["check", str(path), "--samples", "500"], ["run", str(path)], ["verify", str(path)]):
        done = hypgen(*command)
        assert done.returncode == 2 and "has no value" in done.stderr
        assert "compiling" not in done.stderr  # said before time is spent
