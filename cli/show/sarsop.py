"""The row of ``hypgen compare`` that another program gives: scikit-decide's SARSOP."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from hypgen.play.played_programs import Comparison, Policy, lines_of

GAP = 1e-3  # at which it stops, relative to a value above 1, like `hypgen solve`
MISSING = (
    "The mode 'sarsop' needs scikit-decide: pip install 'hypgen[sarsop]' "
    "(in a clone: pip install '.[sarsop]')."
)
SECONDS_BESIDE = 120  # to read the model and write vectors


def is_installed() -> bool:
    """Return whether scikit-decide is here."""
    return importlib.util.find_spec("skdecide") is not None


def play_sarsop(
    program: Path,
    seconds: float,
    params: Sequence[str],
    episodes: Sequence[str],
    show: Callable[[Policy], None],
    comparison: Comparison,
) -> None:
    """Solve a model with SARSOP, then let its alpha vectors play on the exact belief."""
    policy = comparison.add("sarsop")
    try:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            _run([str(program), f"--dump={folder / 'model.jsonl'}", "--quiet", *params], None)
            _solve(folder, seconds, comparison)
            play = [f"--load-policy={folder / 'policy'}", *params, *episodes, "--json", "-", "--quiet"]
            for line in lines_of([str(program), *play]):
                policy.take(line)
                show(policy)
    except RuntimeError as error:
        policy.problem = str(error)


def _solve(folder: Path, seconds: float, comparison: Comparison) -> None:
    value = comparison.solved
    size = max(1.0, abs(value["lower"]), abs(value["upper"])) if value else 1.0
    child = [
        sys.executable,
        "-P",
        "-m",
        "hypgen.cli.show.sarsop_child",
        str(folder),
        repr(seconds),
        repr(GAP * size),
    ]
    _run(child, 2 * seconds + SECONDS_BESIDE)
    comparison.sarsop = json.loads((folder / "bounds.json").read_text())


def _run(command: Sequence[str], most_seconds: float | None) -> None:
    """Run a program to its end; raises RuntimeError with the last line that it said if it fails."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=most_seconds)
    except subprocess.TimeoutExpired:
        raise RuntimeError(f"SARSOP was stopped after {most_seconds:.0f} s") from None
    if done.returncode != 0:
        said = (done.stderr.strip() or done.stdout.strip()).splitlines()
        raise RuntimeError(said[-1] if said else f"exit code {done.returncode}")
