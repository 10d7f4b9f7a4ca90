# SPDX-License-Identifier: Apache-2.0
"""Simulated worlds from Python: in arrays, as environments of Gymnasium, and as records of episodes."""

import importlib.util
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypgen
from hypgen import EpisodeRecord, Observation, StepRecord

pytestmark = pytest.mark.cxx
ROOT = Path(__file__).parent.parent.parent
ROCKS = ROOT / "examples" / "rock_sample.pomdp"
HYPGEN = [sys.executable, "-c", "from hypgen.cli.main import main; main()"]
SETTINGS: dict[str, Any] = {
    "mode": "despot",
    "trials": 60,
    "scenarios": 100,
    "particles": 500,
    "memory": 64,
    "seed": 3,
}
EAST, SAMPLE, CHECK = 2, 4, 5
NEEDS_GYMNASIUM = pytest.mark.skipif(
    importlib.util.find_spec("gymnasium") is None, reason="needs gymnasium, of the extra [gym]"
)

# A visible float and an array, a horizon, and a state in which only some actions are legal.
CART = """\
model Cart

type Flag = 0 .. 2
enum Act { stay, go(0 .. 1) }
discount 0.9
horizon 4
action act: Act

element cart {
  visible at: float
  visible fixed flags: bool[Flag]
  hidden fixed good: bool
  init at ~ uniform(0.5, 1.5)
  init flags = [i in Flag: i == 1]
  init good ~ bernoulli(0.5)
  at' = match act { go(i) => at + 0.5 + i   else => at }
  reward moved = clamp(at' - at, 0.0, 2.0)
}

observe far: bool ~ bernoulli(if cart.good then 0.9 else 0.1)
observe level: 3 .. 5 ~ uniform(3, 5)
legal when act != stay or cart.at < 2.0
policy default { choose = go(0) }
"""


@pytest.fixture(scope="module")
def solver() -> hypgen.Solver:
    return hypgen.load(ROCKS).compile(target="cpu")


@pytest.fixture(scope="module")
def cart(tmp_path_factory: pytest.TempPathFactory) -> hypgen.Solver:
    path = tmp_path_factory.mktemp("worlds") / "cart.pomdp"
    path.write_text(CART)
    return hypgen.load(path).compile(target="cpu")


@pytest.fixture
def worlds(solver: hypgen.Solver) -> Iterator[hypgen.Worlds]:
    with solver.worlds(4, seed=5) as found:
        yield found


def test_worlds_move_together(worlds: hypgen.Worlds) -> None:
    worlds.reset()
    assert worlds.visible.tolist() == [[0, 3]] * 4
    assert worlds.legal[0].tolist() == [1, 1, 1, 1, 0] + [1] * 8
    worlds.step([EAST, CHECK, CHECK, 0])
    assert worlds.visible.tolist() == [[1, 3], [0, 3], [0, 3], [0, 4]]
    assert worlds.seen[0] == 0 and set(worlds.seen[1:3, 0].tolist()) <= {1, 2}
    assert worlds.keys[:, 0].tolist() == worlds.seen[:, 0].tolist()
    assert worlds.seen_by_name(0) == {"reading": "nothing"}
    assert worlds.visible_by_name(3) == {"rover.x": 0, "rover.y": 4}
    for _ in range(6):
        worlds.step(np.full(4, EAST))
    assert worlds.terminal.tolist() == [True, False, False, False]
    assert worlds.rewards.tolist() == [10, 0, 0, 0]
    assert not worlds.legal[0].any()
    worlds.reset(mask=worlds.terminal)
    assert worlds.visible[:2].tolist() == [[0, 3], [6, 3]] and not worlds.terminal.any()


def test_an_episode_is_that_of_its_number(solver: hypgen.Solver) -> None:
    with solver.worlds(3, seed=5) as many, solver.worlds(1, seed=5) as alone:
        many.reset()
        many.step([many.NEXT_EPISODE] * 3)  # the next episodes: 3, 4 and 5
        seen = []
        for rock in range(8):
            many.step([CHECK + rock] * 3)
            seen.append(many.seen[1, 0])
        alone.reset([4])
        for rock in range(8):
            alone.step([CHECK + rock])
            assert alone.seen[0, 0] == seen[rock]


def test_wrong_calls_move_no_world(worlds: hypgen.Worlds) -> None:
    def refused(text: str, actions: Any) -> None:
        with pytest.raises(hypgen.PlannerError, match=text):
            worlds.step(actions)

    refused("world 0: no action is legal: its episode has ended, or none has begun", [EAST] * 4)
    worlds.reset()
    refused("world 3: action sample is not legal now", [EAST, EAST, EAST, SAMPLE])
    refused("world 1: expected an action from 0 to 12, or HYPGEN_NEXT_EPISODE, found 13", [0, 13, 0, 0])
    refused("actions: expected 4 integers, found shape \\(1,\\)", [EAST])
    refused("actions: expected 4 integers, found shape \\(4,\\) of float64", [0.5] * 4)
    assert worlds.visible.tolist() == [[0, 3]] * 4
    with pytest.raises(hypgen.PlannerError, match="episodes: expected 4 numbers, found 1"):
        worlds.reset([1])
    with pytest.raises(hypgen.PlannerError, match="episode: expected an integer from 0"):
        worlds.reset([-1] * 4)
    worlds.close()
    worlds.close()
    with pytest.raises(hypgen.PlannerError, match="the worlds are closed"):
        worlds.reset()


def test_wrong_worlds_are_refused(solver: hypgen.Solver) -> None:
    with pytest.raises(hypgen.PlannerError, match="count: expected an integer from 1 to 16777216, found 0"):
        solver.worlds(0)
    with pytest.raises(hypgen.PlannerError, match="unknown param"):
        solver.worlds(params={"no": 1})
    with pytest.raises(hypgen.PlannerError, match="device: expected cpu, cuda or cuda:N, found gpu"):
        solver.worlds(device="gpu")
    with pytest.raises(hypgen.PlannerError, match="this solver was built without CUDA") as caught:
        solver.worlds(device="cuda:1")
    assert caught.value.status == "no_gpu"
    with solver.worlds(params={"start_row": 1}) as found:
        found.reset()
        assert found.visible_by_name() == {"rover.x": 0, "rover.y": 1}


def test_simulations_are_those_of_the_command_line(solver: hypgen.Solver, tmp_path: Path) -> None:
    lines = tmp_path / "lines.jsonl"
    options = [f"--{name}={value}" for name, value in SETTINGS.items()]
    range_ = ["--runs=3", "--first-run=2", "--steps=30"]
    command = [*HYPGEN, "run", str(ROCKS), "--target", "cpu", "--", *options, *range_, f"--json={lines}"]
    done = subprocess.run([*command, "--quiet"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    told = [json.loads(line) for line in lines.read_text().splitlines()]
    with solver.planner(**SETTINGS) as planner:
        found = list(solver.simulate(planner, runs=3, first_run=2, steps=30))
    steps = [line for line in told if line["type"] == "step"]
    records = [record for record in found if isinstance(record, StepRecord)]
    assert len(steps) == len(records) > 30
    for line, record in zip(steps, records, strict=True):
        assert record.decision is not None
        same = ("episode", "step", "action", "reward", "terminal")
        assert [line[name] for name in same] == [getattr(record, name) for name in same]
        assert (line["lower"], line["upper"]) == (record.decision.lower, record.decision.upper)
        assert record.terminal or record.seen == {"reading": line["observation"]}
    ends = [line for line in told if line["type"] == "episode"]
    episodes = [record for record in found if isinstance(record, EpisodeRecord)]
    assert [line["discounted_return"] for line in ends] == [e.discounted_return for e in episodes]
    assert [line["status"] for line in ends] == [e.status for e in episodes]
    assert [e.episode for e in episodes] == [2, 3, 4]


def test_a_policy_is_a_function(solver: hypgen.Solver) -> None:
    known: list[Observation] = []

    def policy(observation: Observation) -> int | str:
        known.append(observation)
        return "check(0)" if observation.step == 0 else EAST

    *steps, episode = solver.simulate(policy, runs=1, seed=4)
    assert isinstance(episode, EpisodeRecord) and (episode.steps, episode.status) == (8, "terminal")
    assert episode.undiscounted_return == 10
    assert episode.discounted_return == pytest.approx(10 * 0.95**7)
    assert known[0].seen == {} and known[1].seen["reading"] in ("looks_good", "looks_bad")
    assert known[1].visible == {"rover.x": 0, "rover.y": 3} and SAMPLE not in known[1].legal
    assert isinstance(steps[0], StepRecord) and (steps[0].name, steps[0].decision) == ("check(0)", None)
    with pytest.raises(hypgen.PlannerError, match="no action is named fly"):
        list(solver.simulate(lambda _: "fly", runs=1))


def test_wrong_simulations_are_refused_at_once(solver: hypgen.Solver, cart: hypgen.Solver) -> None:
    wrong: list[tuple[Any, dict[str, Any], str]] = [
        (lambda _: EAST, {"runs": 0}, "runs: expected an integer from 1 to 1000000, found 0"),
        (lambda _: EAST, {"runs": "3"}, "runs: expected an integer from 1 to 1000000, found '3'"),
        (lambda _: EAST, {"runs": 1, "steps": 0}, "steps: expected an integer from 1"),
        (solver, {"runs": 1}, "planner: expected a planner or a policy, found"),
    ]
    for planner, arguments, text in wrong:
        with pytest.raises(hypgen.PlannerError, match=text):
            solver.simulate(planner, **arguments)
    with (
        cart.planner(mode="default", memory=64) as of_another,
        pytest.raises(hypgen.PlannerError, match="planner: its model has other actions"),
    ):
        solver.simulate(of_another, runs=1)


def test_values_have_the_types_of_the_model(cart: hypgen.Solver) -> None:
    with cart.worlds(2, seed=1) as worlds:
        worlds.reset()
        visible = worlds.visible_by_name()
        assert 0.5 <= visible["cart.at"] <= 1.5 and visible["cart.flags"] == [False, True, False]
        assert worlds.seen.tolist() == [[0, 3], [0, 3]]  # the least of each: nothing was seen
        worlds.step([1, 0])
        assert worlds.rewards.tolist() == pytest.approx([0.5, 0.0])
        assert worlds.visible_by_name()["cart.at"] == pytest.approx(visible["cart.at"] + 0.5)
        seen = worlds.seen_by_name()
        assert isinstance(seen["far"], bool) and 3 <= seen["level"] <= 5


def test_no_gymnasium_is_told(solver: hypgen.Solver, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    for make in (solver.env, lambda: solver.vector_env(2)):
        with pytest.raises(ModuleNotFoundError, match=r"pip install 'hypgen\[gym\]'"):
            make()


@NEEDS_GYMNASIUM
def test_gymnasium_takes_the_environment(solver: hypgen.Solver, cart: hypgen.Solver) -> None:
    from gymnasium.utils.env_checker import check_env

    env = solver.env()
    # The checker samples actions without the mask, and one of them is not legal: it is left out.
    space = env.action_space
    monkey = type(space).sample
    space.sample = lambda *args, **kwargs: monkey(space, mask=np.eye(13, dtype=np.int8)[EAST])
    check_env(env, skip_render_check=True)
    observation, info = env.reset(seed=2)
    assert observation.tolist() == [0, 3, 0] and observation.dtype == np.int32
    assert env.names == ["rover.x", "rover.y", "reading"] and env.actions[EAST] == "east"
    assert info["action_mask"].tolist() == [1, 1, 1, 1, 0] + [1] * 8
    observation, reward, terminated, truncated, info = env.step(CHECK)
    assert (reward, terminated, truncated) == (0.0, False, False) and observation[2] in (1, 2)
    assert env.visible == {"rover.x": 0, "rover.y": 3} and env.seen["reading"].startswith("looks_")
    with pytest.raises(hypgen.PlannerError, match="action sample is not legal now"):
        env.step(SAMPLE)
    with pytest.raises(hypgen.PlannerError, match="action: expected an integer from 0 to 12, found -1"):
        env.step(-1)
    with pytest.raises(ValueError, match="options: expected episode, found speed"):
        env.reset(options={"speed": 1})
    with pytest.raises(ValueError, match="steps: expected at least 1, found 0"):
        solver.env(steps=0)
    floats = cart.env()
    observation, _ = floats.reset(seed=1)
    assert observation.dtype == np.float64 and observation[1:].tolist() == [0, 1, 0, 0, 3]
    assert floats.names == ["cart.at", "cart.flags[0]", "cart.flags[1]", "cart.flags[2]", "far", "level"]
    assert observation in floats.observation_space


@NEEDS_GYMNASIUM
def test_episodes_are_truncated_at_the_horizon(cart: hypgen.Solver) -> None:
    for steps, last in ((None, 4), (2, 2), (9, 4)):
        env = cart.env(steps=steps)
        env.reset(seed=1)
        assert [env.step(1)[3] for _ in range(last)] == [False] * (last - 1) + [True]


@NEEDS_GYMNASIUM
def test_an_environment_plays_an_episode_by_number(solver: hypgen.Solver) -> None:
    env = solver.env(seed=3)
    with solver.planner(**SETTINGS) as planner:
        [*steps, _] = solver.simulate(planner, runs=1, first_run=7, steps=10)
    env.reset(options={"episode": 7})
    for step in steps:
        assert isinstance(step, StepRecord)
        assert env.step(step.action)[1] == step.reward and env.seen == step.seen


@NEEDS_GYMNASIUM
def test_a_vector_steps_as_its_worlds_do_alone(solver: hypgen.Solver, cart: hypgen.Solver) -> None:
    from gymnasium.vector import AutoresetMode, VectorEnv

    for model in (solver, cart):
        envs, alone = model.vector_env(5, steps=20), [model.env(steps=20) for _ in range(5)]
        assert isinstance(envs, VectorEnv)
        assert envs.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
        observations, info = envs.reset(seed=9)
        assert observations in envs.observation_space
        numbers, over = list(range(5)), [False] * 5
        for i, env in enumerate(alone):
            first, _ = env.reset(seed=9, options={"episode": i})
            assert first.tolist() == observations[i].tolist()
        random = np.random.default_rng(1)
        for _ in range(60):
            mask = info["action_mask"]
            actions = (random.random(mask.shape) * mask).argmax(axis=1)
            observations, rewards, terminated, truncated, info = envs.step(actions)
            assert observations in envs.observation_space
            for i, env in enumerate(alone):
                if over[i]:
                    numbers[i] += 5
                    observation, own = env.reset(options={"episode": numbers[i]})
                    expected = (observation, 0.0, False, False, own)
                else:
                    expected = env.step(actions[i])
                assert observations[i].tolist() == expected[0].tolist()
                assert (rewards[i], terminated[i], truncated[i]) == expected[1:4]
                assert info["action_mask"][i].tolist() == expected[4]["action_mask"].tolist()
                over[i] = expected[2] or expected[3]
        assert max(numbers) > 5


@NEEDS_GYMNASIUM
def test_wrong_calls_of_a_vector_are_refused(solver: hypgen.Solver) -> None:
    envs = solver.vector_env(2)
    envs.reset(seed=1)
    with pytest.raises(hypgen.PlannerError, match="world 1: action sample is not legal now"):
        envs.step(np.array([EAST, SAMPLE]))
    with pytest.raises(hypgen.PlannerError, match="world 1: expected an action from 0 to 12, .* found -1"):
        envs.step(np.array([EAST, -1]))
    with pytest.raises(hypgen.PlannerError, match="an environment starts episodes itself"):
        envs.step(np.array([EAST, hypgen.Worlds.NEXT_EPISODE]))
    with pytest.raises(hypgen.PlannerError, match=r"actions: expected 2 integers, found shape \(1,\)"):
        envs.step(np.array([EAST]))
    with pytest.raises(ValueError, match="seed: expected one integer for all worlds"):
        envs.reset(seed=[1, 2])
    envs.close()


@pytest.mark.parametrize(
    ("script", "package", "last"),
    [
        ("gymnasium_loop", "gymnasium", "a thousand random policies: "),
        ("pomdps_jl_like_loop", "numpy", "heading east: mean return 7.35 of 3 episodes"),
        ("pomdp_py_adapter", "pomdp_py", "reward "),
    ],
)
def test_the_examples_run(solver: hypgen.Solver, script: str, package: str, last: str) -> None:
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"needs {package}")
    path = ROOT / "examples" / "python" / f"{script}.py"
    done = subprocess.run([sys.executable, str(path)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1].startswith(last)


def test_worlds_keep_their_arrays_and_their_numbers(solver: hypgen.Solver) -> None:
    worlds = solver.worlds(2)
    worlds.reset()
    worlds.rewards = worlds.rewards.copy()  # C goes on to write to its own
    worlds.step([2, 2])
    for wrong in ([2**32 + 2, 2], np.array([2**32 - 1, 2], np.uint32)):
        with pytest.raises(hypgen.PlannerError, match="no number of an action"):
            worlds.step(wrong)
    worlds.reset([2**32 - 1, 0])
    with pytest.raises(hypgen.PlannerError, match="there is no next episode: their numbers end at 2\\^32"):
        worlds.reset()
    worlds.close()
    worlds.close()
    with pytest.raises(hypgen.PlannerError, match="closed"):
        worlds.step([2, 2])


def test_a_key_with_any_float_has_worlds() -> None:
    wide = ROOT / "tests" / "differential" / "models" / "wide_key.pomdp"
    with hypgen.load(wide).compile(target="cpu").worlds(3) as worlds:
        worlds.reset()
        worlds.step([0, 0, 0])
        assert worlds.seen.any()


GOOD = {"rock.good": [True, False] * 4, "rover.x": 1}


def test_a_start_is_that_of_the_command_line(solver: hypgen.Solver, tmp_path: Path) -> None:
    start = tmp_path / "start.json"
    start.write_text(json.dumps(GOOD))
    options = [f"--{name}={value}" for name, value in SETTINGS.items()]
    options += ["--runs=2", "--steps=6", f"--start={start}", "--json=-", "--quiet"]
    command = [*HYPGEN, "run", str(ROCKS), "--target", "cpu", "--", *options]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    told = [json.loads(line) for line in done.stdout.splitlines()]
    assert told[0]["start"] == str(start)
    with solver.planner(**SETTINGS) as planner:
        found = list(solver.simulate(planner, runs=2, steps=6, start=GOOD))
    records = [record for record in found if isinstance(record, StepRecord)]
    actions = [(line["action"], line["reward"]) for line in told if line["type"] == "step"]
    assert actions == [(record.action, record.reward) for record in records]


def test_episodes_start_where_they_are_told_to(solver: hypgen.Solver) -> None:
    with solver.worlds(3, seed=5, start=GOOD) as worlds:
        for _ in range(2):
            worlds.reset()
            assert worlds.visible.tolist() == [[1, 3]] * 3
        worlds.start({"rock.good[2]": False})
        worlds.reset()
        assert worlds.visible.tolist() == [[0, 3]] * 3
        for wrong, text in (
            ({"rock": 1}, "no variable is named rock; the variables are: rover.x, rover.y, rock.good"),
            ({"rock.good": 1}, "rock.good: expected an array of 8, found 1"),
            ({"rover.x": 8}, "rover.x: expected an integer from 0 to 7, found 8"),
        ):
            with pytest.raises(hypgen.PlannerError, match=text):
                worlds.start(wrong)
    ends = [list(solver.simulate(lambda _: EAST, runs=1, start={"rover.x": x}))[-1] for x in (0, 6)]
    assert [end.steps for end in ends if isinstance(end, EpisodeRecord)] == [7, 1]


def test_a_given_float_is_that_of_the_start(cart: hypgen.Solver) -> None:
    given = {"cart.at": 1.25, "cart.flags": [True, True, False], "cart.good": True}
    with cart.worlds(start=given) as worlds:
        worlds.reset()
        assert worlds.visible_by_name() == {"cart.at": 1.25, "cart.flags": [True, True, False]}
