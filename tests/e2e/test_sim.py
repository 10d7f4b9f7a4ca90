# SPDX-License-Identifier: Apache-2.0
"""``hypgen sim``: an episode as a person and as a program see it."""

import io
import json
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest

from hypgen.cli import main

EXAMPLES = Path(__file__).parent.parent.parent / "examples"
NAMES = ("tiger", "rock_sample", "tag", "two_robot_rock_sample")
TIGER, ROCKS, TAG, TWO_ROBOTS = (str(EXAMPLES / f"{name}.pomdp") for name in NAMES)


@pytest.fixture
def play(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Any:
    def play(typed: str, *arguments: str, code: int = 0) -> tuple[str, str]:
        monkeypatch.setattr("sys.stdin", io.StringIO(typed))
        assert main.run(["sim", *arguments]) == code
        output = capsys.readouterr()
        return output.out, output.err

    return play


def rows(text: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in text.splitlines()]


def test_an_episode_in_words(play: Any) -> None:
    out, err = play("ch 3\n\nundo  # and look elsewhere\ne\nquit\n", ROCKS)
    assert err == ""
    assert out == (
        "RockSample: episode 0 of seed 0\n"
        "  rover.x = 0\n"
        "  rover.y = 3\n"
        "  rock.good = [true, false, true, true, false, false, false, false]  (hidden)\n"
        "  12 of 13 actions are legal: north, south, east, west, check(0), check(1), check(2), check(3),\n"
        "    check(4), check(5), check(6), check(7)\n"
        "step 0: check(3)\n"
        "  observed reading = looks_good\n"
        "  reward 0, so far 0, discounted 0\n"
        "back before step 0\n"
        "step 0: east\n"
        "  rover.x: 0 -> 1\n"
        "  observed reading = nothing\n"
        "  reward 0, so far 0, discounted 0\n"
        "stopped after 1 step: return 0, discounted 0\n"
    )


def test_hidden_variables_can_be_hidden(play: Any) -> None:
    out, _ = play("listen\nstate\nlegal\nhelp\n", TIGER, "--hide-hidden")
    assert "room.tiger" not in out and "observed heard = " in out and "print the legal actions" in out


def test_many_actions_are_not_all_listed(play: Any) -> None:
    out, _ = play("legal n 1\nlegal foo\nlegal all\n", TWO_ROBOTS)
    start, some, none, every = re.split(r"\n(?=  \d+ of)", out.split("(hidden)\n")[-1])
    assert start.endswith(
        "check(15)), (north, check(16)) and 509 more; `legal all` prints all, `legal WORDS` those with\n"
        "    the words"
    )
    assert some == "  1 of 529 legal actions have 'n 1': (north, check(1))"
    assert none == "  0 of 529 legal actions have 'foo': none"
    assert " more; " not in every and every.count("north") == 46
    out, _ = play("legal open\n", TIGER, "--json")
    assert rows(out)[1] == {"type": "legal", "step": 0, "actions": ["open_left", "open_right"]}


def test_an_episode_as_data(play: Any) -> None:
    out, _ = play("listen\nopen_l\nundo\nstate\nlegal\nopen_r\n", TIGER, "--json")
    lines = rows(out)
    assert [line["type"] for line in lines] == [
        "start",
        "step",
        "step",
        "undo",
        "state",
        "legal",
        "step",
        "end",
    ]
    first, second = lines[1], lines[2]
    assert (first["action_name"], first["reward"], first["rewards"]) == ("listen", -1.0, {"outcome": -1.0})
    assert first["observation"]["heard"] in ("left", "right")
    assert second["action"] == 1 and second["discounted_return"] == -1 + 0.95 * second["reward"]
    assert lines[3]["state"] == first["state"] == lines[4]["state"]
    assert lines[5]["actions"] == ["listen", "open_left", "open_right"]
    assert lines[-1]["steps"] == 2 and lines[-1]["success"] is None


def test_beliefs_and_memory(play: Any) -> None:
    out, _ = play("listen\nbelief\n", str(EXAMPLES / "tiger_memory.pomdp"))
    assert "  believed room.tiger: left 0.85; right 0.15\n" in out
    assert "  remembered lead = 0\n" in out
    out, _ = play("listen\nlisten\nbelief\n", TIGER, "--json")
    heard = [row["observation"]["heard"] for row in rows(out) if row["type"] == "step"]
    (believed,) = rows(out)[-2]["factors"]["room"]
    expected = 0.5 if heard[0] != heard[1] else 0.85**2 / (0.85**2 + 0.15**2)
    assert max(believed) == pytest.approx(expected)
    assert "opponent.cell: Cell(0, 0) 0.0345; Cell(0, 1)" in play("belief\n", TAG)[0]


def test_a_terminal_step_shows_no_observation(play: Any) -> None:
    *steps, end = rows(play("", ROCKS, "--policy", "default", "--json")[0])
    last = steps[-1]
    assert last["terminal"] and last["observation"] is None
    assert last["rewards"] == {"rover.exit": 10.0, "rock.sampled": 0.0}
    assert end["terminal"] and end["return"] == sum(sum(row.get("rewards", {}).values()) for row in steps)


def test_the_same_seed_gives_the_same_episode(play: Any) -> None:
    first, second, other = (play("", TAG, "--policy", "random", "--seed", s)[0] for s in ("4", "4", "5"))
    assert first == second != other


@pytest.mark.cxx
def test_the_solver_plays_the_same_episodes(play: Any, tmp_path: Path) -> None:
    from hypgen.codegen.generate import generate
    from hypgen.dsl.load import load
    from hypgen.runtime.builder.solver import build_solver

    loaded = load(TAG)
    solver = build_solver(generate(loaded.model), "tag", lambda step: None, model=loaded.model.source_hash)
    options = ["--mode", "default", "--runs", "3", "--seed", "3", "--quiet", "--json", "-"]
    done = subprocess.run([solver, *options], capture_output=True, text=True, check=True)
    episodes = [row for row in rows(done.stdout) if row["type"] == "episode"]
    for number, expected in enumerate(episodes):
        out, _ = play("", TAG, "--policy", "default", "--seed", "3", "--episode", str(number), "--json")
        end = rows(out)[-1]
        assert {k: end[k] for k in ("return", "steps", "success")} == {
            k: expected[k] for k in ("return", "steps", "success")
        }
        assert end["discounted_return"] == pytest.approx(expected["discounted_return"])


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        ("lisen\n", "line 1 of the script: there is no action 'lisen'; did you mean 'listen'?"),
        ("listen\nopen\n", "line 2 of the script: 'open' may mean open_left, open_right: write more of it"),
        ("!\n", "there is no action '!'"),
    ],
)
def test_a_script_stops_at_a_mistake(play: Any, typed: str, message: str) -> None:
    assert message in play(typed, TIGER, code=2)[1]


def test_an_illegal_action_is_not_taken(play: Any) -> None:
    assert "sample is not legal here" in play("sample\n", ROCKS, code=2)[1]


def test_scripts_steps_and_missing_params(play: Any, tmp_path: Path) -> None:
    script = tmp_path / "script"
    script.write_text("# look first\nlisten\nrandom\npolicy\n")
    out, _ = play("", TIGER, "--script", str(script), "--steps", "2", "--json")
    assert rows(out)[-1]["steps"] == 2
    assert "No such file" in play("", TIGER, "--script", str(tmp_path / "none"), code=2)[1]
    assert "one of them chooses" in play("", TIGER, "--script", "-", "--policy", "random", code=2)[1]
    model = tmp_path / "m.pomdp"
    model.write_text(
        "model M\nparam p: prob\ndiscount p\naction act: bool\n".replace("discount p", "discount 0.5")
    )
    assert "The param 'p' has no value: add --set p=.." in play("", str(model), code=2)[1]
    assert play("true\n", str(model), "--set", "p=0.1")[1] == ""
