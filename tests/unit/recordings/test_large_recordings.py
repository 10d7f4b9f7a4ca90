# SPDX-License-Identifier: Apache-2.0
"""A recording of 1 GB: an episode of it is found and shown in the memory of that episode's page."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from pathlib import Path

import pytest
from support import recorded_episodes as recorded
from support import seen_episodes

BYTES = 1 << 30
STEPS = 40
MEGABYTES = 300

READS = """
import sys
from pathlib import Path
from hypgen.recordings import open_recording
recording = open_recording(Path(sys.argv[1]))
print(sum(1 for _ in recording.read(recording.episodes[-1])))
"""
VIEWS = "import sys; from hypgen.cli.main import run; sys.exit(run(sys.argv[1:]))"


def write_large(path: Path, model: Path) -> int:
    """Write a recording whose steps have trees of 5,000 nodes; return the number of its last episode."""
    tree = json.dumps(seen_episodes.tree(5000))
    header, *episode = recorded.lines_of(model, episodes=(0,), count=STEPS)
    number, none = 0, '"tree":null'
    with path.open("w") as file:
        file.write(json.dumps(header) + "\n")
        while file.tell() < BYTES:
            for line in episode:
                text = json.dumps(line | {"episode": number}, separators=(",", ":"))
                file.write(text.replace(none, f'"tree":{tree}') + "\n")
            number += 1
    return number - 1


def peak_megabytes(script: str, *words: str) -> tuple[str, float]:
    """Return what a script prints, and the most memory that it or an earlier one has taken."""
    run = subprocess.run(
        [sys.executable, "-c", script, *words], capture_output=True, text=True, timeout=600, check=False
    )
    assert run.returncode == 0, run.stderr
    return run.stdout, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024


@pytest.mark.slow
def test_an_episode_of_a_large_recording_is_shown_in_little_memory(tmp_path: Path) -> None:
    model, log, page = recorded.model_file(tmp_path), tmp_path / "log.jsonl", tmp_path / "page.html"
    last = write_large(log, model)
    parts, read = peak_megabytes(READS, str(log))
    assert int(parts) == STEPS + 2 and read < 150
    told = ["view", str(model), "--log", str(log), "--episode", str(last), "-o", str(page)]
    _, viewed = peak_megabytes(VIEWS, *told)
    assert viewed < MEGABYTES
    assert f'"episode":{last}' in page.read_text()
    with log.open("rb+") as file:
        file.truncate(log.stat().st_size - 100)
    peak_megabytes(VIEWS, *told)
    assert f"The recording ends after step {STEPS - 1}" in page.read_text()
    print(
        f"{log.stat().st_size / 1e9:.2f} GB, {last + 1} episodes: read {read:.0f} MB, viewed {viewed:.0f} MB"
    )
