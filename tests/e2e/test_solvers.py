# SPDX-License-Identifier: Apache-2.0
"""From a model file to a running solver: the cache, exported projects, options and signals."""

import json
import os
import re
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from hypgen.codegen.generate import generate_verify
from hypgen.dsl.load import load
from hypgen.runtime.builder import tools
from hypgen.runtime.builder.solver import build_solver

pytestmark = pytest.mark.cxx
ROOT = Path(__file__).parent.parent.parent
TIGER = str(ROOT / "examples" / "tiger.pomdp")
HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]
QUICK = ("--mode", "despot", "--runs", "2", "--trials", "20", "--scenarios", "50", "--steps", "5")


def hypgen(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*HYPGEN, *arguments], capture_output=True, text=True)


def test_a_model_is_compiled_once() -> None:
    forced = hypgen("compile", TIGER, "--force")
    assert forced.returncode == 0, forced.stderr
    assert "tiger: compiling (as asked for)\n" in forced.stderr
    again = hypgen("compile", TIGER)
    assert again.stdout == forced.stdout and Path(again.stdout.strip()).is_file()
    assert again.stderr == "tiger: cached\n"


def test_a_changed_model_is_compiled_again(tmp_path: Path) -> None:
    path = tmp_path / "tiger.pomdp"
    path.write_text(Path(TIGER).read_text())
    assert hypgen("compile", str(path)).returncode == 0
    path.write_text(path.read_text().replace("-100", f"-{int(time.time()) % 10**6}"))
    assert hypgen("compile", str(path)).stderr == "tiger: compiling (the model or its settings changed)\n"


def test_compiling_takes_seconds_once_the_runtime_is_built() -> None:
    def seconds() -> float:  # of the CPU, which other processes do not prolong
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    hypgen("compile", TIGER)
    before = seconds()
    assert hypgen("compile", str(ROOT / "examples" / "rock_sample.pomdp"), "--force").returncode == 0
    assert seconds() - before < 20, "6 s on a machine that does nothing else"


def test_run_hands_its_options_to_the_solver(tmp_path: Path) -> None:
    lines = tmp_path / "lines.jsonl"
    done = hypgen("run", TIGER, *QUICK, "--seed", "7", "--json", str(lines))
    assert done.returncode == 0, done.stderr
    rows = [json.loads(line) for line in lines.read_text().splitlines()]
    assert [row["type"] for row in rows].count("episode") == 2
    assert rows[-1]["type"] == "summary"
    assert (rows[0]["type"], rows[0]["version"], rows[0]["seed"]) == ("run", 1, 7)


def test_the_details_of_a_step_have_the_names_of_the_model(tmp_path: Path) -> None:
    lines = tmp_path / "lines.jsonl"
    hypgen("run", TIGER, *QUICK, "--json", str(lines), "--details")
    step = json.loads(lines.read_text().splitlines()[1])
    [marginal] = step["marginals"]
    assert marginal["variable"] == "room.tiger"
    assert {e["value"]: e["probability"] for e in marginal["values"]} == {"left": 0.5, "right": 0.5}
    assert {action["action"] for action in step["root"]} == {"listen", "open_left", "open_right"}


def test_a_run_can_be_split(tmp_path: Path) -> None:
    def episodes(*options: str) -> list[tuple[object, ...]]:
        lines = tmp_path / "lines.jsonl"
        hypgen("run", TIGER, *QUICK, *options, "--json", str(lines))
        rows = [json.loads(line) for line in lines.read_text().splitlines()]
        names = ("type", "episode", "step", "action", "observation", "lower", "upper", "discounted_return")
        return [tuple(map(row.get, names)) for row in rows if "episode" in row]

    whole = episodes("--runs", "3")
    assert [row for row in whole if row[1] != 0] == episodes("--runs", "2", "--first-run", "1")


def test_a_period_holds_update_and_plan(tmp_path: Path) -> None:
    lines = tmp_path / "lines.jsonl"
    done = hypgen("run", TIGER, "--period", "0.05", "--runs", "1", "--steps", "5", "--json", str(lines))
    assert done.returncode == 0, done.stderr
    assert "over the period of 0.05 by 1 ms or more: " in done.stdout
    rows = [json.loads(line) for line in lines.read_text().splitlines()]
    assert (rows[0]["period"], rows[0]["time"]) == (0.05, 0.05)
    steps = [row for row in rows if row["type"] == "step"]
    for before, step in zip(steps, steps[1:], strict=False):
        assert abs(step["cycle_seconds"] - before["update_seconds"] - step["search_seconds"]) < 1e-9


def test_the_world_may_differ_from_the_model(tmp_path: Path) -> None:
    def mean_return(hearing: float | None) -> float:
        lines, values = tmp_path / "lines.jsonl", tmp_path / "world.json"
        values.write_text(json.dumps({"hearing": hearing}))
        world = [] if hearing is None else ["--world-param", str(values)]
        options = ["--mode", "despot", "--trials", "20", "--runs", "40", "--steps", "20", "--quiet"]
        done = hypgen("run", TIGER, *options, *world, "--json", str(lines))
        assert done.returncode == 0, done.stderr
        return float(json.loads(lines.read_text().splitlines()[-1])["discounted_return"])

    assert mean_return(None) == mean_return(0.85)
    assert mean_return(0.5) < mean_return(0.85) - 50  # what it hears says nothing
    wrong = hypgen("run", TIGER, "--world-param", "/no/such/file")
    assert wrong.returncode == 2
    assert "--world-param" in wrong.stderr
    idle = hypgen("run", TIGER, "--world-param", "x.json", "--serve")
    assert (idle.returncode, "there are none to play" in idle.stderr) == (2, True)


def test_verify_says_what_was_compared_and_what_was_left_out() -> None:
    done = hypgen("verify", TIGER, "--target", "cpu", "--lanes", "30", "--steps", "10", "--json")
    assert done.returncode == 0, done.stderr
    checks = [json.loads(line) for line in done.stdout.splitlines()]
    assert [(c["check"], c["variant"], c["steps"]) for c in checks[:2]] == [
        ("schedule", "2 warps", 300),
        ("schedule", "3 warps", 300),
    ]
    assert all(c["differing"] == 0 for c in checks)
    assert (checks[-1]["check"], checks[-1]["steps"]) == ("device", 0)
    assert checks[-1]["remark"] == "this program was built without CUDA"
    timed = hypgen("verify", TIGER, "--target", "cpu", "--seconds", "0.1")
    assert "left out: this program was built without CUDA" in timed.stdout
    assert hypgen("verify", TIGER, "--target", "cpu", "--param", "/no/such/file").returncode == 2


def test_the_documentation_has_every_option_and_field_of_the_solver(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "guide" / "solver.md").read_text()
    listed = set(re.findall(r"^  (--[a-z-]+)", hypgen("run", TIGER, "--", "--help").stdout, re.MULTILINE))
    assert listed == set(re.findall(r"`(--[a-z-]+)[^`]*`", page.split("## JSON lines")[0]))
    lines = tmp_path / "lines.jsonl"
    hypgen("run", TIGER, *QUICK, "--json", str(lines), "--details")
    for line in lines.read_text().splitlines():
        assert not [
            field for field in json.loads(line) if f"`{field}`" not in page and f'`"{field}"`' not in page
        ]


def test_the_solver_plans_and_the_other_program_checks() -> None:
    page = (ROOT / "docs" / "internals" / "contracts.md").read_text()
    program = build_solver(generate_verify(load(TIGER).model), TIGER, lambda step: None)
    printed = subprocess.run([program, "--help"], capture_output=True, text=True, check=True).stdout
    listed = set(re.findall(r"^  (--[a-z-]+)", printed, re.MULTILINE))
    section = page.split("## The program that checks")[1].split("\n## ")[0]
    rows = [line.split(" | ")[0] for line in section.splitlines() if line.startswith("| `--")]
    assert listed == set(re.findall(r"`(--[a-z-]+)[^`]*`", " ".join(rows)))
    checks = {"--trace", "--lanes", "--warps", "--check-bounds", "--check-beliefs"}
    assert checks < listed and program.name == "tiger_verify"
    for option in checks - {"--lanes"}:  # a solver's own says how rollouts are played
        done = hypgen("run", TIGER, f"{option}=1")
        assert (done.returncode, f"unknown option {option}" in done.stderr) == (2, True)


def test_bounds_are_sampled(tmp_path: Path) -> None:
    done = hypgen("check", TIGER, "--bounds", "500", "--json")
    assert done.returncode == 0, done.stderr
    compared = json.loads(done.stdout)["bounds"]["compared"]
    assert [(b["name"], b["beliefs"], b["violations"]) for b in compared] == [
        ("upper", 500, 0),
        ("declared upper", 500, 0),
        ("lower", 500, 0),
        ("tail", 500, 0),
    ]
    wrong = tmp_path / "tiger.pomdp"
    wrong.write_text(re.sub(r"(?m)^bound upper .*$", "bound upper = -1000", Path(TIGER).read_text()))
    done = hypgen("check", str(wrong), "--bounds", "100")
    assert (done.returncode, "error[C0204]: bound upper is below" in done.stderr) == (2, True), done.stderr


def test_ranks_in_the_belief_depend_on_no_thread() -> None:
    program = build_solver(generate_verify(load(TIGER).model), TIGER, lambda step: None)
    runs = [
        subprocess.run(
            [program, "--check-beliefs=40", f"--threads={threads}"], capture_output=True, text=True
        )
        for threads in (1, 3)
    ]
    (head, *lines), (_, *others) = (list(map(json.loads, done.stdout.splitlines())) for done in runs)
    assert head["variables"] == ["room.tiger"]
    assert lines == sorted(others, key=lambda line: int(line["episode"]))
    assert [line["episode"] for line in lines] == list(range(40))
    assert all(0.0 <= rank <= 1.0 for line in lines for rank in line["ranks"])
    assert len({line["step"] for line in lines}) > 10


def test_a_belief_of_too_few_particles_is_found() -> None:
    fine = hypgen("check", TIGER, "--beliefs", "300", "--strict")
    assert fine.returncode == 0 and "nothing wrong" in fine.stdout, fine.stdout + fine.stderr
    few = ("--belief", "particle", "--particles", "2")
    done = hypgen("check", TIGER, "--beliefs", "300", *few)
    assert done.returncode == 2
    assert "error[C0501]: the belief of 'room.tiger' is too sure" in done.stderr
    assert "--particles 8" in done.stderr


def test_a_check_of_beliefs_ends_in_time() -> None:
    done = hypgen("check", TIGER, "--beliefs", "1000000", "--time", "0.5")
    assert done.returncode == 0 and " of 1,000,000 episodes" in done.stdout, done.stderr


def test_run_gives_the_solvers_exit_code_and_help() -> None:
    done = hypgen("run", TIGER, "--no-such-option")
    assert done.returncode == 2 and "--no-such-option" in done.stderr
    done = hypgen("run", TIGER, "--", "--help")
    assert done.returncode == 0 and "--scenarios" in done.stdout


def test_an_interrupt_reaches_the_solver(tmp_path: Path) -> None:
    hypgen("compile", TIGER)
    lines = tmp_path / "lines.jsonl"
    command = [*HYPGEN, "run", TIGER, "--runs", "1000", "--time", "0.05", "--json", str(lines)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 300
    while not (lines.is_file() and lines.read_text().count("\n") > 3):
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=300)
    assert process.returncode == 130
    assert "return" in output
    assert json.loads(lines.read_text().splitlines()[-1])["type"] == "summary"


@pytest.fixture
def project(tmp_path: Path) -> Iterator[Path]:
    yield tmp_path / "project"


def test_a_project_builds_with_plain_cmake_and_nothing_of_hypgen(project: Path) -> None:
    done = hypgen("compile", TIGER, "-o", str(project), "--emit-only")
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"{project}\n"
    cmake = str(tools.find_cmake().path)
    bare = {"PATH": f"{Path(cmake).parent}:/usr/bin:/bin", "HOME": str(project)}
    if compiler := os.environ.get("CXX"):
        bare["CXX"] = compiler
    kinds = []
    for arguments in (
        ["-B", "build"],
        ["-B", "build", "-DCMAKE_BUILD_TYPE=Debug"],  # compiles sooner, and must plan the same
        ["--build", "build", "--parallel", "2"],
    ):
        done = subprocess.run([cmake, *arguments], cwd=project, capture_output=True, text=True, env=bare)
        assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-5000:]
        kinds += re.findall("CMAKE_BUILD_TYPE:STRING=(.*)", (project / "build/CMakeCache.txt").read_text())
    assert kinds == ["Release", "Debug", "Debug"]
    built = next(p for p in (project / "build").rglob("tiger") if p.is_file())
    own = hypgen("run", TIGER, *QUICK, "--seed", "3", "--signature", "--quiet").stdout
    assert (
        subprocess.run(
            [built, *QUICK, "--seed", "3", "--signature", "--quiet"], capture_output=True, text=True
        ).stdout
        == own
    )


def test_output_holds_project_and_solver(project: Path) -> None:
    done = hypgen("compile", TIGER, "-o", str(project))
    assert done.stdout == f"{project / 'bin' / 'tiger'}\n"
    assert subprocess.run([project / "bin" / "tiger", "--version"]).returncode == 0
    assert (project / "src" / "tiger.hpp").is_file()


def test_a_folder_of_someone_elses_is_left_alone(project: Path) -> None:
    project.mkdir()
    (project / "thesis.tex").write_text("years of work")
    done = hypgen("compile", TIGER, "-o", str(project))
    assert done.returncode == 2 and "was not written by hypgen" in done.stderr
    assert [p.name for p in project.iterdir()] == ["thesis.tex"]


def test_a_policy_that_remembers_makes_better_rollouts(tmp_path: Path) -> None:
    values = {}
    for name in ("tiger", "tiger_memory"):
        lines = tmp_path / f"{name}.jsonl"
        model = str(ROOT / "examples" / f"{name}.pomdp")
        options = ("--mode", "rollout", "--runs", "1", "--steps", "1", "--trials", "2", "--scenarios", "500")
        done = hypgen("run", model, *options, "--json", str(lines))
        assert done.returncode == 0, done.stderr
        (step,) = [row for row in map(json.loads, lines.read_text().splitlines()) if row["type"] == "step"]
        values[name] = step["lower"]
    assert values["tiger"] < -19, "listening for ever"
    assert values["tiger_memory"] > 10
