# SPDX-License-Identifier: Apache-2.0
"""From a key to the diagnostics on the screen: ``hypgen lsp`` over its pipes, as an editor runs it.

``PYTHONPATH=tests python benchmarks/keystrokes.py [KEYS]`` prints docs/results/editor.md's table. Letters are
typed at random places and taken away again, so that each second text has no mistake. Bursts are ten
letters, 30 ms apart: the time counts from the last.
"""

from __future__ import annotations

import asyncio
import random
import sys
import time
from pathlib import Path

from machine import machine
from support.editor_session import Editor, over_pipes

ROOT = Path(__file__).resolve().parent.parent
MODELS = ("two_robot_rock_sample", "pocman")
COMMAND = (sys.executable, "-c", "from hypgen.cli.main import main; main()", "lsp")


async def answer(editor: Editor, path: Path, text: str) -> float:
    """Return how long the server takes to say something of a text, in milliseconds."""
    start = time.perf_counter()
    await editor.change(path, text)
    return 1e3 * (time.perf_counter() - start)


async def measure(model: str, keys: int) -> dict[str, list[float]]:
    """Return the times of a model by the kind of text."""
    path = ROOT / "examples" / f"{model}.pomdp"
    text, rng = path.read_text(), random.Random(model)
    times: dict[str, list[float]] = {"no mistake": [], "one letter typed": [], "ten letters in a burst": []}
    async with over_pipes(*COMMAND) as editor:
        await editor.open(path, text)
        for _ in range(keys):
            at = rng.randrange(len(text))
            times["one letter typed"].append(await answer(editor, path, f"{text[:at]}x{text[at:]}"))
            times["no mistake"].append(await answer(editor, path, text))
            for number in range(1, 10):
                editor.send(path, f"{text[:at]}{'x' * number}{text[at:]}")
                await asyncio.sleep(0.03)
            last = f"{text[:at]}{'x' * 10}{text[at:]}"
            times["ten letters in a burst"].append(await answer(editor, path, last))
    return times


def main() -> None:
    """Print the table."""
    keys = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    print(f"{machine()}; {keys} of each\n")
    print("| model | text | p50 | p95 |\n|---|---|---|---|")
    for model in MODELS:
        for kind, found in asyncio.run(measure(model, keys)).items():
            found.sort()
            p50, p95 = (found[min(len(found) - 1, int(share * len(found)))] for share in (0.5, 0.95))
            print(f"| `{model}` | {kind} | {p50:.0f} ms | {p95:.0f} ms |")


if __name__ == "__main__":
    main()
