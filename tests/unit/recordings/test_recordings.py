# SPDX-License-Identifier: Apache-2.0
import json
import tracemalloc
from pathlib import Path
from typing import Any

import pytest

from hypgen.dsl import ir
from hypgen.dsl.interpret.episode import Episode
from hypgen.dsl.load import load
from hypgen.recordings import End, RecordingError, Start, Step, open_recording, reward_terms

HEADER: dict[str, Any] = {
    "type": "recording", "version": 1, "kind": "episode", "model": "M", "hash": "abc", "file": "m.pomdp",
    "discount": 0.9, "horizon": None, "options": {"seed": 0}, "params": {}, "actions": ["a"],
    "variables": [{"name": "x", "type": "int", "dims": [], "visible": True}],
}  # fmt: skip


def step(episode: int, number: int, **more: Any) -> dict[str, Any]:
    return {
        "type": "step", "episode": episode, "step": number, "action": 0, "action_name": "a",
        "default_action": "a", "reward": 1.0, "terminal": False, "seen": {}, "state": {"x": 1},
        "sampled": {}, "particles_total": 10, "marginals": [], "tree": None, "tree_shown": 0,
        "tree_total": 0, "cycle_seconds": 0.25, **more,
    }  # fmt: skip


def episode(number: int, steps: int = 2) -> list[dict[str, Any]]:
    end = {"type": "episode", "episode": number, "steps": steps, "discounted_return": 1.9}
    return [
        {"type": "start", "episode": number, "visible": {"x": 1}},
        *(step(number, i) for i in range(steps)),
        {**end, "status": "step_limit", "terminal": False, "state": {"x": 2}},
    ]


def write(path: Path, lines: list[dict[str, Any]]) -> Path:
    path.write_text("".join(json.dumps(line, separators=(",", ":")) + "\n" for line in lines))
    return path


def test_an_episode_is_read_by_its_number(tmp_path: Path) -> None:
    recording = open_recording(write(tmp_path / "r", [HEADER, *episode(3), *episode(4, 1)]), model_hash="abc")
    assert recording.episodes == [3, 4] and not recording.cut_off
    start, only, end = recording.read(4)
    assert isinstance(start, Start) and isinstance(only, Step) and isinstance(end, End)
    assert (only.episode, only.state, end.state) == (4, {"x": 1}, {"x": 2})
    with pytest.raises(RecordingError, match="has no episode 5; it has 3, 4"):
        list(recording.read(5))


def test_a_line_that_is_cut_off_is_left_out(tmp_path: Path) -> None:
    path = write(tmp_path / "r", [HEADER, *episode(0)])
    path.write_bytes(path.read_bytes()[:-9])
    recording = open_recording(path)
    assert recording.cut_off
    assert [type(part) for part in recording.read(0)] == [Start, Step, Step]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty or ends within its first line"),
        ("nothing\n", "first line is not a header"),
        ("\x00\xff\n", "first line is not a header"),
        ("[1]\n", "first line is not a header"),
        ('{"type":"run","version":1}\n', "has the lines of --json"),
        (json.dumps({**HEADER, "version": 2}) + "\n", "is of version 2, and this hypgen reads version 1"),
        (json.dumps({**HEADER, "kind": "belief"}) + "\n", "is of kind 'belief'"),
        (json.dumps({"type": "recording", "version": 1, "kind": "episode"}) + "\n", "header is broken"),
        (json.dumps(HEADER) + "\n", "was recorded with another model"),
    ],
)
def test_what_is_no_recording_of_the_model_is_refused(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "r"
    path.write_text(text, encoding="latin-1")
    with pytest.raises(RecordingError, match=said):
        open_recording(path, model_hash="another")


def test_a_broken_line_is_named(tmp_path: Path) -> None:
    path = write(tmp_path / "r", [HEADER, *episode(0)])
    path.write_text(path.read_text().replace('"reward"', '"rewarded"', 1))
    with pytest.raises(RecordingError, match=":3: this line of the recording is broken"):
        list(open_recording(path).read(0))


def _peak_of_large_file(path: Path, episodes: int, filler: int) -> int:
    with path.open("w") as file:
        file.write(json.dumps(HEADER) + "\n")
        for number in range(episodes):
            for line in episode(number, 1):
                text = {**line, "filler": "x" * filler}
                file.write(json.dumps(text, separators=(",", ":")) + "\n")
    tracemalloc.start()
    assert len(list(open_recording(path).read(episodes - 1))) == 3
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def test_memory_is_that_of_a_line(tmp_path: Path) -> None:
    assert _peak_of_large_file(tmp_path / "r", 20, 100_000) < 2_000_000


@pytest.mark.slow
def test_a_gigabyte_takes_the_memory_of_a_line(tmp_path: Path) -> None:
    assert _peak_of_large_file(tmp_path / "r", 400, 1_000_000) < 10_000_000


TERMS = """
reward growl = if act == listen and room.tiger' == left then 0.25 else 0
"""


def _noisy_steps(folder: Path) -> tuple[ir.Model, Path]:
    """Play Tiger with a second term that reads what a step has drawn, and write what a solver records."""
    model_file = folder / "m.pomdp"
    model_file.write_text(Path("examples/tiger.pomdp").read_text().replace("\npolicy", TERMS + "\npolicy", 1))
    model = load(model_file).model
    world = Episode(model, seed=5, number=2)
    tiger = {"name": "room.tiger", "type": "named", "dims": [], "visible": False, "values": ["left", "right"]}
    lines: list[dict[str, Any]] = [
        {**HEADER, "options": {"seed": 5}, "params": {"hearing": 0.85}, "variables": [tiger]},
        episode(2, 0)[0],
    ]
    for number, action in enumerate([0, 1, 0, 2, 0, 0]):
        state = {"room.tiger": ["left", "right"][world.values()["room.tiger"][0]]}
        outcome = world.step(action)
        lines.append(
            step(2, number, action=action, state=state, reward=outcome.reward, expected=outcome.terms)
        )
    return model, write(folder / "r", lines)


def test_terms_are_those_of_the_world_that_was_played_in(tmp_path: Path) -> None:
    model, path = _noisy_steps(tmp_path)
    recording = open_recording(path)
    steps = [part for part in recording.read(2) if isinstance(part, Step)]
    found = [reward_terms(model, recording.header, part) for part in steps]
    assert found == [part.line["expected"] for part in steps]
    assert {terms["growl"] for terms in found} == {0.0, 0.25}


def test_terms_that_do_not_add_up_are_refused(tmp_path: Path) -> None:
    model, path = _noisy_steps(tmp_path)
    path.write_text(path.read_text().replace('"reward":-', '"reward":-9', 1))
    recording = open_recording(path)
    part = next(part for part in recording.read(2) if isinstance(part, Step))
    with pytest.raises(RecordingError, match="and with this model"):
        reward_terms(model, recording.header, part)


def test_a_log_for_robots_has_every_step(tmp_path: Path) -> None:
    mcap = pytest.importorskip("mcap.reader", reason="the extra mcap is not installed")
    from hypgen.recordings.mcap_file import write_mcap

    log = tmp_path / "log.mcap"
    write_mcap(open_recording(write(tmp_path / "r", [HEADER, *episode(0), *episode(1)])), log)
    with log.open("rb") as stream:
        messages = list(mcap.make_reader(stream).iter_messages())
    topics = [channel.topic for _, channel, _ in messages]
    counts = {topic: topics.count(topic) for topic in sorted(set(topics))}
    assert counts == {"/belief": 4, "/end": 2, "/start": 2, "/state": 6, "/step": 4, "/tree": 4}
    assert {(schema.encoding, channel.message_encoding) for schema, channel, _ in messages} == {
        ("jsonschema", "json")
    }
    assert max(message.log_time for *_, message in messages) == 1_000_000_000
    state = next(json.loads(m.data) for _, c, m in messages if c.topic == "/state")
    assert state == {"episode": 0, "step": 0, "x": 1}
