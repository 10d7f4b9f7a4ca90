# SPDX-License-Identifier: Apache-2.0
"""A recording as an MCAP file with JSON messages, for Foxglove and users of ROS."""

from __future__ import annotations

import json
import os
import secrets
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mcap.writer import Writer

from hypgen.recordings.reader import Recording
from hypgen.recordings.recording import End, Start, Step

_NANOSECONDS = 1e9
# Members of a step that have topics of their own.
_BELIEF = ("marginals", "sampled", "particles_total")
_TREE = ("tree", "tree_shown", "tree_total")
_TOPICS = ("/start", "/step", "/state", "/belief", "/tree", "/end")


def write_mcap(recording: Recording, path: Path) -> None:
    """Write all episodes of a recording, one after the other.

    The clock of the messages starts at 0 and counts the time of updates and plans. An ``OSError`` leaves no
    new file.
    """
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        with temporary.open("wb") as stream:
            _write(recording, Writer(stream))
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def _write(recording: Recording, writer: Writer) -> None:
    writer.start(profile="", library="hypgen")
    writer.add_metadata("recording", {k: json.dumps(v) for k, v in recording.header.line.items()})
    channels = {topic: _channel(writer, topic, recording) for topic in _TOPICS}
    seconds = 0.0

    def put(topic: str, episode: int, data: Mapping[str, Any]) -> None:
        time = int(seconds * _NANOSECONDS)
        message = json.dumps({"episode": episode, **data}).encode()
        writer.add_message(channels[topic], log_time=time, publish_time=time, data=message)

    for number in recording.episodes:
        for part in recording.read(number):
            if isinstance(part, Start):
                put("/start", number, {"visible": part.visible})
            elif isinstance(part, End):
                put("/state", number, {"step": part.steps, **part.state})
                put("/end", number, {k: v for k, v in part.line.items() if k not in ("type", "state")})
            else:
                seconds += part.line["cycle_seconds"]
                apart = ("type", "state", *_BELIEF, *_TREE)
                put("/state", number, {"step": part.step, **part.state})
                put("/step", number, {k: v for k, v in part.line.items() if k not in apart})
                put("/belief", number, _members(part, _BELIEF))
                put("/tree", number, _members(part, _TREE))
    writer.finish()  # type: ignore[no-untyped-call] # the package leaves its type out


def _members(step: Step, names: tuple[str, ...]) -> dict[str, Any]:
    return {"step": step.step, **{name: step.line[name] for name in names}}


def _channel(writer: Writer, topic: str, recording: Recording) -> int:
    properties: dict[str, Any] = {"episode": {"type": "integer"}, "step": {"type": "integer"}}
    if topic == "/state":
        types = {"bool": "boolean", "int": "integer", "float": "number", "named": "string"}
        for v in recording.header.variables:
            one = {"type": types[v.type]}
            properties[v.name] = {"type": "array", "items": one} if v.dims else one
    schema = {"type": "object", "properties": properties}
    name = f"hypgen.{topic[1:]}"
    return writer.register_channel(
        topic, "json", writer.register_schema(name, "jsonschema", json.dumps(schema).encode())
    )
