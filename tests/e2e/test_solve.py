# SPDX-License-Identifier: Apache-2.0
"""``hypgen solve``: from a model file to a proven interval. One build serves all tests."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from hypgen.cli.exit_codes import Exit
from hypgen.dsl.foreign import reader

pytestmark = pytest.mark.cxx
ROOT = Path(__file__).parent.parent.parent
HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()", "solve"]
TIGER = str(ROOT / "examples" / "tiger.pomdp")


def solve(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*HYPGEN, *arguments], capture_output=True, text=True)


def test_tiger_is_bounded_from_both_sides(tmp_path: Path) -> None:
    policy = tmp_path / "tiger.policy"
    done = solve(TIGER, "--json", "--gap", "1e-4", "--policy", str(policy))
    assert done.returncode == Exit.OK, done.stderr
    result = json.loads(done.stdout)
    assert result["lower"] <= 19.3714 <= result["upper"] < result["lower"] + 0.002
    assert (result["states"], result["actions"], result["observations"], result["outcomes"]) == (2, 3, 2, 20)
    bounds = result["bounds"]
    assert bounds["blind"] <= result["lower"] and result["upper"] <= bounds["fib"] <= bounds["qmdp"]
    assert result["status"] == "converged" and policy.read_text()
    [first] = result["first"]
    assert result["best_action"] == first["best_action"] == "listen" and first["regret"] == 0
    assert [a["action"] for a in first["actions"]] == ["listen", "open_left", "open_right"]
    assert first["actions"][0]["lower"] == pytest.approx(result["lower"])
    assert all(-26.7 < a["lower"] <= a["upper"] < -26.5 for a in first["actions"][1:])
    table = solve(TIGER).stdout
    assert "Tiger: 2 states, 3 actions" in table and "the gap that was asked for is reached" in table
    assert "first action    listen; no other is better" in table and "\n  open_right    -26." in table


def test_a_policy_is_shown_as_a_graph(tmp_path: Path) -> None:
    shown = solve(TIGER, "--graph", "3").stdout
    assert "graph           3 nodes\n  start (1) -> 1\n  1 listen\n    left (0.5) -> 2\n" in shown
    assert "    left (0.745) -> ...\n" in shown
    assert "  ... 2 nodes are left out; --graph 5 has room for all\n" in shown
    file = tmp_path / "graph.json"
    done = solve(TIGER, "--graph-file", str(file), "--json")
    graph = json.loads(file.read_text())
    assert graph == json.loads(done.stdout)["graph"]
    assert [node["action"] for node in graph["nodes"]][:3] == ["listen", "listen", "listen"]
    assert {node["action"] for node in graph["nodes"][3:]} == {"open_left", "open_right"}
    assert all(sum(e["probability"] for e in n["edges"]) == pytest.approx(1) for n in graph["nodes"])
    assert solve(TIGER, "--graph-file", str(tmp_path / "no" / "graph.json")).returncode == Exit.DIFFERENT


def test_a_policy_is_drawn(tmp_path: Path) -> None:
    pytest.importorskip("networkx")
    pytest.importorskip("matplotlib")
    file = tmp_path / "graph.svg"
    done = solve(TIGER, "--graph-file", str(file), "--json")
    assert done.returncode == Exit.OK, done.stderr
    assert json.loads(done.stdout)["best_action"] == "listen"
    assert "open_left" in file.read_text()
    done = solve(TIGER, "--graph-file", str(tmp_path / "no" / "graph.svg"))
    assert done.returncode == Exit.MISTAKE and "No such file" in done.stderr
    assert solve(TIGER, "--max-states", "1", "--graph-file", str(file)).returncode == Exit.DIFFERENT


RARE = """discount: 0.99
values: cost
states: fine broken
actions: go stop
observations: nothing
start: fine
T: go
0.9999999999 0.0000000001
0 1
T: stop
identity
O: *
1
1
R: go : broken : * : * 10000000
R: stop : broken : * : * 10000000
R: stop : fine : * : * 0.05
"""


def test_a_rare_accident_counts(tmp_path: Path) -> None:
    """It comes once in 10^10 steps and costs 10^9: more than to stop, which costs 5."""
    model = tmp_path / "rare.pomdp"
    model.write_text(reader.import_text("rare.POMDP", RARE.encode(), None, None).text)
    done = solve(str(model), "--json")
    assert done.returncode == Exit.OK, done.stderr
    result = json.loads(done.stdout)
    assert -5.2 < result["lower"] <= -5 <= result["upper"] < -4.9


def test_limits_say_what_was_found() -> None:
    done = solve(TIGER, "--max-states", "1")
    assert done.returncode == Exit.DIFFERENT
    assert "more than 1 state (2 states found, 1 of them expanded, 10 outcomes)" in done.stderr
    assert "raise --max-states" in done.stderr


def test_no_time_is_spent_where_nothing_is_left_to_gain() -> None:
    done = solve(TIGER, "--gap", "0", "--time", "1000")
    assert done.returncode == Exit.OK, done.stderr
    assert "no trial changes a bound any more; what is left of the gap is rounding" in done.stdout


def test_an_interrupt_prints_what_is_proven(tmp_path: Path) -> None:
    patient = tmp_path / "patient.pomdp"  # whose sweeps take long
    patient.write_text(Path(TIGER).read_text().replace("discount 0.95", "discount 0.9999999"))
    terminal, theirs = os.openpty()  # on a terminal it says how far it is
    command = [*HYPGEN, str(patient), "--gap", "0", "--time", "600"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=theirs, text=True) as started:
        os.close(theirs)
        shown = b""
        while b" trials" not in shown and started.poll() is None:
            shown += os.read(terminal, 1024)
        started.send_signal(signal.SIGINT)
        printed, _ = started.communicate(timeout=300)
    os.close(terminal)
    assert started.returncode == Exit.INTERRUPTED, shown
    assert "Tiger: 2 states" in printed and "interrupted" in printed


def test_a_continuous_draw_is_refused_before_anything_is_compiled() -> None:
    done = solve(str(ROOT / "examples" / "light_dark.pomdp"))
    assert done.returncode == Exit.MISTAKE
    assert "error[E0812]: 'robot.slip_y' is drawn from a continuous law" in done.stderr
    assert "compiling" not in done.stderr


def test_policies_of_the_solver_play_the_same_episodes_as_planners() -> None:
    options = ("--runs", "4", "--trials", "20", "--steps", "30", "--seed", "3", "--json")
    modes = ("--modes", "default,despot,alpha,qmdp,blind")
    done = subprocess.run([*HYPGEN[:-1], "compare", TIGER, *options, *modes], capture_output=True, text=True)
    assert done.returncode == Exit.OK, done.stderr
    found = json.loads(done.stdout)
    returns = {policy["name"]: policy["returns"] for policy in found["policies"]}
    assert [policy["problem"] for policy in found["policies"]] == [None] * 5
    assert all(len(one) == 4 for one in returns.values())
    assert returns["blind"] == pytest.approx(returns["default"])  # both only listen
    assert found["value"]["lower"] < 19.372 < found["value"]["upper"] + 0.02
    assert found["steps"] == 30 and found["left_out"] == pytest.approx(0.95**30)


LARGE = """discount: 0.9
values: cost
states: a b
actions: go
observations: x
start: a
T: go
uniform
O: go
uniform
R: go : a : * : * 2.5e7
"""
SMALL = """model Small
enum Act {{ a, b }}
discount 0.9
action act: Act
element coin {{
  hidden heads: bool
  init heads ~ bernoulli(0.5)
  heads' = heads
}}
observe side: bool ~ noisy(coin.heads', 0.7)
reward gain = match act {{ a => {most}  b => {least} }}
"""


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("large.POMDP", LARGE, -1.375e8),
        ("small.pomdp", SMALL.format(most="2e-8", least="0.00000001"), 2e-7),
        ("smaller.pomdp", SMALL.format(most="1.5e-30", least="1e-30"), 1.5e-29),
        ("some.pomdp", SMALL.format(most="0.00002", least="0.00001"), 2e-4),
    ],
)
def test_rewards_have_any_scale(name: str, text: str, value: float, tmp_path: Path) -> None:
    model = tmp_path / name
    model.write_text(text)
    done = solve(str(model), "--json")
    assert done.returncode == Exit.OK, done.stderr
    found = json.loads(done.stdout)
    assert found["lower"] == pytest.approx(value, rel=1e-3)
    assert found["upper"] == pytest.approx(value, rel=1e-3)


def test_a_param_far_beyond_its_declared_value_is_a_model_error(tmp_path: Path) -> None:
    model, params = tmp_path / "fees.pomdp", tmp_path / "fees.json"
    text = SMALL.format(most="fee", least="0.5").replace("discount", "param fee: float = 2.0\ndiscount")
    model.write_text(text + "bound upper = 1e9\nbound tail = 0.0\n")
    params.write_text('{"fee": 1e8}')
    done = solve(str(model), "--param", str(params))
    assert done.returncode == Exit.DIFFERENT
    assert "a reward is not a number, or beyond the range of rewards" in done.stderr


def test_a_reward_that_is_no_number_is_named_with_a_state(tmp_path: Path) -> None:
    model = tmp_path / "purse.pomdp"
    model.write_text(
        "model Purse\nenum Act { spend, wait }\ndiscount 0.9\naction act: Act\n"
        "element purse { hidden left: -2 .. 4  init left = 1\n"
        "  left' = if act == spend then clamp(left - 1) else left }\n"
        "reward joy = if act == spend then sqrt(purse.left) else 0\n"
        "bound upper = 30\nbound tail = 0\n"
    )
    done = solve(str(model))
    assert done.returncode == Exit.DIFFERENT
    assert "where spend is done in purse.left=-1\n" in done.stderr
    assert "what may be no number: reward 'joy' (purse.pomdp:7)" in done.stderr
