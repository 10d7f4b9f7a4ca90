# SPDX-License-Identifier: Apache-2.0
"""The interval of ``hypgen solve`` holds the value of the text in exact rational arithmetic.

One program solves many models, as each takes seconds to compile. ``pytest -m slow tests/e2e/test_proven.py``
tries 500.
"""

from __future__ import annotations

import json
import subprocess
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import pytest
from support.exact_pomdps import SmallModel, small_model

from hypgen.cli.main import run
from hypgen.codegen.generate import generate_exact
from hypgen.dsl.load import load
from hypgen.runtime.builder.solver import build_solver

pytestmark = pytest.mark.cxx
BATCH = 50


def exact_files(name: str, model: SmallModel, folder: Path) -> dict[str, str]:
    """Return the generated files of a model that is written in Cassandra's format and imported."""
    written, imported = folder / f"{name}.POMDP", folder / f"{name}.pomdp"
    written.write_text(model.text())
    assert run(["import", str(written), "--horizon", str(model.horizon), "-o", str(imported)]) == 0
    return generate_exact(load(str(imported)).model, precise=True)


def program_of(models: dict[str, SmallModel], folder: Path) -> Path:
    """Return a program that solves the model that its first argument names."""
    files: dict[str, str] = {}
    includes: set[str] = set()
    spaces, calls = [], []
    for name, model in models.items():
        found = exact_files(name, model, folder)
        lines = found.pop("src/exact.cpp").splitlines()
        includes |= {line for line in lines if line.startswith("#include")}
        body = "\n".join(line for line in lines if not line.startswith("#include"))
        spaces.append(f"namespace of_{name} {{\n{body}\n}}")
        calls.append(f'  if (name == "{name}") return of_{name}::main(argc - 1, argv + 1);')
        files |= {path: text for path, text in found.items() if path.endswith(".hpp")}
    head = "int main(int argc, char** argv) {\n  const std::string name = argv[1];"
    main_file = [*sorted(includes), *spaces, head, *calls, "  return 1;\n}\n"]
    return build_solver({**files, "src/exact.cpp": "\n".join(main_file)}, str(folder), lambda step: None)


def misses(seeds: Sequence[int], folder: Path) -> list[str]:
    """Return what is wrong with the intervals of some models."""
    models = {f"m{seed}": small_model(seed) for seed in seeds}
    program, wrong = program_of(models, folder), []
    for name, model in models.items():
        command = [str(program), name, "--json=-", "--quiet", "--time=10"]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        found, value = json.loads(done.stdout), model.value()
        if not Fraction(found["lower"]) <= value <= Fraction(found["upper"]):
            wrong.append(f"{name}: {float(value)!r} is not in {found['lower']!r} .. {found['upper']!r}")
    return wrong


def test_intervals_of_random_models_hold_their_exact_values(tmp_path: Path) -> None:
    assert not misses(range(6), tmp_path)


@pytest.mark.slow
def test_intervals_of_many_random_models_hold_their_exact_values(tmp_path: Path) -> None:
    assert not [
        text for first in range(0, 500, BATCH) for text in misses(range(first, first + BATCH), tmp_path)
    ]
