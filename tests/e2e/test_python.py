# SPDX-License-Identifier: Apache-2.0
"""``import hypgen``: from a model's file to decisions in this process."""

import json
import re
import shutil
import subprocess
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypgen
from hypgen.api.c_interface import CLibrary
from hypgen.runtime.builder.solver import Step
from hypgen.runtime.builder.tools import find_compiler

pytestmark = pytest.mark.cxx
ROOT = Path(__file__).parent.parent.parent
ROCKS = ROOT / "examples" / "rock_sample.pomdp"


@pytest.fixture(scope="module")
def solver() -> hypgen.Solver:
    return hypgen.load(ROCKS).compile(target="cpu")


@pytest.fixture
def planner(solver: hypgen.Solver) -> Iterator[hypgen.Planner]:
    with solver.planner(mode="despot", trials=60, scenarios=100, particles=500, memory=64) as found:
        yield found


def test_a_planner_plans_and_learns(planner: hypgen.Planner) -> None:
    assert planner.reset() == "ok"
    decision = planner.plan()
    assert decision.status == "trial_limit" and decision.name and decision.lower <= decision.upper
    for _ in range(3):
        assert planner.update("check(1)", {"reading": "looks_good"}) == "ok"
    assert planner.update(planner.action("check(1)"), 1) == "ok"
    assert planner.seen(1) == {"reading": "looks_good"}
    good = planner.probability("rock.good[1]", True)
    assert good > 0.9
    marginal = planner.belief["rock.good[1]"]
    assert isinstance(marginal, dict) and marginal["true"] == pytest.approx(good)
    assert planner.info["mode"] == "despot" and planner.info["step"] == 4
    assert planner.plan(seconds=0.01).seconds < 5


def test_the_tree_says_what_it_has_seen(planner: hypgen.Planner) -> None:
    with pytest.raises(hypgen.PlannerError, match="has left no tree"):
        planner.tree()
    planner.reset()
    decision = planner.plan()
    tree = planner.tree(depth=3, top=30)
    assert tree["scenarios"] == decision.scenarios == 100 and tree["visits"] >= decision.trials
    assert (tree["lower"], tree["upper"]) == (decision.lower, decision.upper)
    best = max(tree["actions"], key=lambda action: action["lower"])
    assert best["name"] == decision.name and best["lower"] == pytest.approx(tree["lower"])
    checks = [a for a in tree["actions"] if a["name"].startswith("check") and "groups" in a]
    assert checks and {g["seen"]["reading"] for a in checks for g in a["groups"]} == {
        "looks_good",
        "looks_bad",
    }

    def agrees(node: dict[str, Any]) -> int:
        """Check that shares add up, and count the nodes below that have actions."""
        found = 0
        for action in node.get("actions", ()):
            if "groups" in action:
                assert sum(group["share"] for group in action["groups"]) == pytest.approx(1.0)
                assert all(group["lower"] <= group["upper"] + 1e-9 for group in action["groups"])
                assert all("seen" in group or group["terminal"] for group in action["groups"])
                found += sum(agrees(group) + ("actions" in group) for group in action["groups"])
        return found

    assert agrees(tree) > 3
    assert "actions" not in planner.tree(depth=0)
    assert planner.tree(top=2)["actions_left_out"] == len(tree["actions"]) - 2
    assert planner.tree(nodes=1)["actions_left_out"] == len(tree["actions"])

    def count(node: dict[str, Any]) -> int:
        return 1 + sum(count(one) for kind in ("actions", "groups") for one in node.get(kind, ()))

    assert 50 < count(planner.tree(depth=9, top=30, nodes=100)) <= 100 < count(tree)


def test_the_belief_has_columns(planner: hypgen.Planner) -> None:
    planner.reset()
    for _ in range(3):
        planner.update("check(1)", {"reading": "looks_good"})
    columns = planner.sample_belief(4000, seed=3)
    assert list(columns) == ["rock.good"] and columns["rock.good"].shape == (4000, 8)
    assert columns["rock.good"].dtype == bool
    assert columns["rock.good"][:, 1].mean() == pytest.approx(
        planner.probability("rock.good[1]", True), abs=0.04
    )
    assert (planner.sample_belief(4000, seed=3)["rock.good"] == columns["rock.good"]).all()
    with pytest.raises(hypgen.PlannerError, match="count: expected"):
        planner.sample_belief(0)
    with pytest.raises(hypgen.PlannerError, match="expected true or false, found perhaps"):
        planner.probability("rock.good[1]", "perhaps")


def test_a_plan_ends_at_a_time_or_when_cancelled(solver: hypgen.Solver) -> None:
    with solver.planner(mode="despot", time=60, scenarios=500, memory=256) as planner:
        assert planner.warm_up(0.01) in ("deadline", "converged", "deadline_default")
        with pytest.raises(hypgen.PlannerError, match="reset comes first"):
            planner.plan()
        planner.reset()
        assert planner.plan(deadline=time.monotonic() - 1).status == "deadline_default"
        assert planner.plan(deadline=time.monotonic() + 0.05).seconds < 5
        is_over = threading.Event()

        def cancel() -> None:
            while not is_over.wait(0.02):
                planner.cancel()

        other = threading.Thread(target=cancel)
        other.start()
        decision = planner.plan()
        is_over.set()
        other.join()
        assert decision.status in ("deadline", "converged", "deadline_default") and decision.seconds < 30
        with pytest.raises(hypgen.PlannerError, match="deadline: expected a number, found nan"):
            planner.plan(deadline=float("nan"))
    planner.cancel()  # of a planner that is closed: nothing


def test_equal_settings_give_equal_decisions(solver: hypgen.Solver) -> None:
    settings: dict[str, str | int] = {"mode": "despot", "trials": 60, "memory": 64, "seed": 5}
    first, second = solver.planner(**settings), solver.planner(**settings)
    for planner in (first, second):
        planner.reset({"rover.x": 2, "rover.y": 0})
    assert (first.plan().lower, first.plan().action) == (second.plan().lower, second.plan().action)


def test_a_solver_describes_its_model(solver: hypgen.Solver) -> None:
    assert solver.description["actions"][:5] == ["north", "south", "east", "west", "sample"]


def test_a_model_is_compiled_once(solver: hypgen.Solver) -> None:
    steps: list[Step] = []
    again = hypgen.load(str(ROCKS)).compile(target="cpu", progress=steps.append)
    assert again.path == solver.path
    assert [(step.what, step.reason) for step in steps] == [("librock_sample.so", "")]


def test_values_reach_the_model() -> None:
    model = hypgen.load(ROCKS, start_row=1, rock_x=[1, 0, 3, 6, 2, 3, 5, 1])
    params = {p.name: p.default for p in model.loaded.model.params}
    assert params["start_row"] == (1,) and params["rock_x"] == (1, 0, 3, 6, 2, 3, 5, 1)


def test_the_readmes_example_runs(solver: hypgen.Solver, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    [text] = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    names: dict[str, Any] = {}
    exec(text, names)
    assert names["decision"].name in solver.description["actions"]


def test_a_target_has_a_known_name() -> None:
    with pytest.raises(ValueError, match="target: expected auto, cpu, cuda, both, found 'gpu'"):
        hypgen.load(ROCKS).compile(target="gpu")


def test_mistakes_of_a_model_are_raised(tmp_path: Path) -> None:
    path = tmp_path / "wrong.pomdp"
    path.write_text("model Wrong\ndiscount 2\n")
    with pytest.raises(hypgen.ModelError) as caught:
        hypgen.load(path)
    assert caught.value.diagnostics[0].code


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        ({"scenarios": 0}, "--scenarios: bad value"),
        ({"time": float("nan")}, "--time: bad value"),
        ({"on_depletion": "stop"}, "no setting is named on-depletion"),
        ({"mode": "gpu", "require_gpu": True}, "CUDA"),
    ],
)
def test_wrong_settings_are_raised(solver: hypgen.Solver, settings: dict[str, str | int], text: str) -> None:
    with pytest.raises(hypgen.PlannerError, match=text):
        solver.planner(**settings)


def test_wrong_calls_are_raised(planner: hypgen.Planner) -> None:
    with pytest.raises(hypgen.PlannerError, match="reset comes first"):
        planner.plan()
    planner.reset()
    wrong = "expected an integer from"
    for call in (
        lambda: planner.update(2**40, 0),
        lambda: planner.update(5, -1),
        lambda: planner.reset(episode=-1),
    ):
        with pytest.raises(hypgen.PlannerError, match=wrong):
            call()
    with pytest.raises(hypgen.PlannerError, match="no action is named fly; the actions are: north, south"):
        planner.update("fly", 0)
    with pytest.raises(hypgen.PlannerError, match="no hidden variable is named good; the names are: rock.go"):
        planner.probability("good", True)
    with pytest.raises(hypgen.PlannerError, match="seen: expected values by name, or a key, found None"):
        planner.update(5, None)  # type: ignore[arg-type]
    assert planner.update(np.int64(5), {"reading": np.int32(1)}) == "ok"
    with pytest.raises(hypgen.PlannerError, match="no value is named smell; the names are: reading"):
        planner.update(5, {"smell": 1})
    with pytest.raises(hypgen.PlannerError, match="words: expected 1, found 2"):
        planner.update(5, [0, 0])
    planner.close()
    planner.close()
    with pytest.raises(hypgen.PlannerError, match="the planner is closed"):
        planner.plan()


def test_a_name_does_not_end_early(solver: hypgen.Solver) -> None:
    with solver.planner(mode="despot", memory=256) as planner:
        with pytest.raises(hypgen.PlannerError, match="action: has a NUL"):
            planner.action("north\0junk")
        with pytest.raises(hypgen.PlannerError, match=r"2\^44"):
            planner.reset(episode=2**44)
    with pytest.raises(hypgen.PlannerError, match="settings: has a NUL"):
        solver.planner(mode="despot\0 oops=1")


def test_a_second_thread_is_refused(solver: hypgen.Solver) -> None:
    planner = solver.planner(mode="despot", time=1.0, memory=256)
    planner.reset()
    thread = threading.Thread(target=planner.plan)
    thread.start()
    refused = None
    while thread.is_alive() and refused is None:
        try:
            planner.action("north")
        except hypgen.PlannerError as error:
            refused = error.status
    thread.join()
    assert refused == "busy"


def test_another_file_is_no_library(tmp_path: Path) -> None:
    path = tmp_path / "libnothing.so"
    path.write_bytes(b"nothing")
    with pytest.raises(hypgen.PlannerError, match="is no library of hypgen"):
        CLibrary(path)


@pytest.mark.parametrize(
    "version, text",
    [
        (99, "has version 99 of the C interface, and this package 1; compile the model again"),
        (1, "is no library of hypgen: .*undefined symbol: hypgen_status_name"),
    ],
    ids=["another version", "a missing function"],
)
def test_a_library_that_does_not_fit_is_refused(version: int, text: str, tmp_path: Path) -> None:
    path = tmp_path / "libmodel.so"
    source = f"unsigned hypgen_abi_version(void) {{ return {version}; }}\n"
    compiler = [str(find_compiler().path), "-x", "c", "-", "-shared", "-fPIC", "-o", str(path)]
    subprocess.run(compiler, input=source, text=True, check=True)
    with pytest.raises(hypgen.PlannerError, match=text) as error:
        hypgen.Solver(path)
    assert error.value.status == "wrong_argument"


def test_a_library_that_is_loaded_twice_knows_its_own(solver: hypgen.Solver, tmp_path: Path) -> None:
    """A file is one library, however often it is loaded; a copy is another one."""
    copy = hypgen.Solver(Path(shutil.copy(solver.path, tmp_path)))
    options: dict[str, Any] = {"mode": "despot", "trials": 20, "memory": 64}
    one, again, other = (s.planner(**options) for s in (solver, hypgen.Solver(solver.path), copy))
    for planner in (one, again, other):
        planner.reset()
    decisions = [(d.action, d.lower, d.upper) for d in (p.plan() for p in (one, again, other))]
    assert len(set(decisions)) == 1
    with pytest.raises(hypgen.PlannerError, match="another library has made it"):
        copy._library.json("info", one._handle)
    assert solver._library.json("info", again._handle)["step"] == 0
    with pytest.raises(hypgen.PlannerError, match="belongs to another library"):
        copy._library.json("describe", solver._library.model)


def test_planners_are_compared_and_a_small_model_is_solved() -> None:
    model = hypgen.load(ROOT / "examples" / "tiger.pomdp")
    seen: list[str] = []
    found = hypgen.compare(
        model,
        ["default", "despot", "alpha"],
        runs=4,
        trials=50,
        steps=20,
        cuda="cpu",
        show=lambda policy: seen.append(policy.name),
    )
    assert [policy.name for policy in found.policies] == ["default", "despot", "alpha"]
    assert seen == 4 * ["default"] + 4 * ["despot"] + 4 * ["alpha"]
    assert all(sorted(policy.returns) == [0, 1, 2, 3] for policy in found.policies)
    solution = hypgen.solve(model, gap=0.01)
    assert found.solved is not None and solution.lower <= found.solved["upper"]
    assert (solution.status, solution.best_action) == ("converged", "listen")
    assert 19 < solution.lower <= solution.upper < 19.6
    with pytest.raises(ValueError, match="there is no mode 'magic'"):
        hypgen.compare(model, ["magic"])
    with pytest.raises(hypgen.ModelError, match="continuous law"):
        hypgen.solve(hypgen.load(ROOT / "examples" / "light_dark.pomdp"))


def test_settings_come_from_a_file_or_a_mapping(solver: hypgen.Solver, tmp_path: Path) -> None:
    settings = {"options": {"mode": "despot", "memory": 64, "scenarios": 70}, "params": {"sure": 0.7}}
    file = tmp_path / "my settings.json"
    file.write_text(json.dumps(settings))
    for given in (file, str(file), settings):
        with solver.planner(settings=given, seed=5, mode="rollout") as planner:
            assert planner.info["mode"] == "rollout", "what is given goes first"
    for wrong, says in (
        ({"options": {"runs": 3}}, 'no setting is named "runs"'),
        ({"params": {"certain": 0.7}}, 'unknown param "certain"'),
        (tmp_path / "none.json", "none.json' cannot be read"),
    ):
        with pytest.raises(hypgen.PlannerError, match=says):
            solver.planner(settings=wrong)
    file.write_text("[]")
    with pytest.raises(hypgen.PlannerError, match="has no JSON object"):
        solver.planner(settings=file)
