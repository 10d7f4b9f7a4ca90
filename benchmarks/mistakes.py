# SPDX-License-Identifier: Apache-2.0
"""Newcomers' mistakes: what ``hypgen check`` says of each, beside what stanc3 says of the same in Stan.

``python benchmarks/mistakes.py`` writes docs/results/mistakes.md from the corpus of wrong models
(cli/show/errors/cases, those of ``pipes.pomdp``) and mistakes/stan.toml. ``--stanc PATH`` runs
Stan's compiler first and keeps what it says in mistakes/stanc.json.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
import textwrap
import tomllib
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from hypgen.cli.show.error_index import cases

HERE = Path(__file__).parent / "mistakes"
BASE = "pipes.pomdp"
PAGE = Path(__file__).parent.parent / "docs" / "results" / "mistakes.md"
RECORD = HERE / "stanc.json"
MOST_LINES = 16  # of a message of stanc3 that are quoted


@dataclass(frozen=True)
class Mistake:
    """A mistake in the base model, what hypgen says of it, and the same in Stan if Stan has it."""

    what: str
    says: str
    stan_text: str | None
    better: str
    why: str


def mistakes() -> list[Mistake]:
    """Return every mistake in the base model, those that Stan has as well first."""
    ours = {case.what: case for case in cases() if case.name == BASE}
    base = (HERE / "base.stan").read_text()
    found = []
    for entry in tomllib.loads((HERE / "stan.toml").read_text())["mistake"]:
        says = ours.pop(entry["what"]).says
        assert entry["stan_old"] in base, entry
        stan = base.replace(entry["stan_old"], entry["stan_new"], 1)
        found.append(Mistake(entry["what"], says, stan, entry["better"], entry["why"]))
    return found + [Mistake(case.what, case.says, None, "", "") for case in ours.values()]


def run_stanc(stanc: str) -> None:
    """Keep what stanc3 says of every mistake that Stan has too, and its version."""
    said = {"version": subprocess.run([stanc, "--version"], capture_output=True, text=True).stdout.strip()}
    with tempfile.TemporaryDirectory() as folder:
        for mistake in (m for m in mistakes() if m.stan_text is not None):
            (Path(folder) / "model.stan").write_text(str(mistake.stan_text))
            done = subprocess.run([stanc, "model.stan"], cwd=folder, capture_output=True, text=True)
            said[mistake.what] = done.stdout + done.stderr if done.returncode else ""
    RECORD.write_text(json.dumps(said, indent=2) + "\n")


HEADING = """\
# What a newcomer's mistakes are answered

This page shows the message that `hypgen check` prints for {count} mistakes in a small model. A
message is good if its reader can mend the mistake with it. Each mistake is one edit of
`cli/show/errors/cases/pipes.pomdp`.

{shared} mistakes can be made in Stan as well. Beside them stands what {version} says of
the same mistake in `benchmarks/mistakes/base.stan`. Its messages are good, so they are the ones to
beat. The page cuts them after {most} lines.

- **Command**: `python benchmarks/mistakes.py` makes this page. A test runs every mistake.
- **Judgement**: each pair was judged by three questions. Is the place exact, is the cause named, is
  there a remedy that works? The judges are the authors of one of the two. Both messages are there
  to be read.
- A kind of mistake is only as comparable as two languages are. A few of stanc3's messages answer a
  near relative.

| better | pairs |
|---|---|
{tally}
"""


def page() -> str:
    """Return docs/results/mistakes.md."""
    said = json.loads(RECORD.read_text())
    found = mistakes()
    shared = [m for m in found if m.stan_text is not None]
    verdicts = Counter(m.better for m in shared)
    tally = "\n".join(f"| {name} | {verdicts[name]} |" for name in ("hypgen", "equal", "stanc3"))
    parts = [
        HEADING.format(
            count=len(found), shared=len(shared), version=said["version"], most=MOST_LINES, tally=tally
        ),
        "## Mistakes that Stan has too\n",
    ]
    for number, mistake in enumerate(found, 1):
        if number == len(shared) + 1:
            parts.append("## Mistakes of a POMDP's own\n")
        parts += [f"### {number}. {mistake.what}\n", block(mistake.says)]
        if mistake.stan_text is not None:
            parts += ["stanc3:\n", block(said[mistake.what] or "(no message: it compiles)")]
            verdict = "No difference" if mistake.better == "equal" else f"Better: {mistake.better}"
            parts.append(textwrap.fill(f"**{verdict}.** {mistake.why}", 100) + "\n")
    return "\n".join(parts)


def block(text: str) -> str:
    """Return a message as a block of Markdown, cut if it is long."""
    lines = text.rstrip().splitlines()
    if len(lines) > MOST_LINES:
        lines = [*lines[:MOST_LINES], f"({len(lines) - MOST_LINES} more lines)"]
    return "\n".join(["```", *lines, "```\n"])


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stanc", help="run this stanc first")
    arguments = parser.parse_args()
    if arguments.stanc:
        run_stanc(arguments.stanc)
    PAGE.write_text(page())


if __name__ == "__main__":
    main()
