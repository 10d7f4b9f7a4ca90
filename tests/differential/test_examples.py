# SPDX-License-Identifier: Apache-2.0
"""The generated code against the interpreter: every number of many random steps, bit for bit."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import pytest
from support import ir_samples, traces
from support.random_models import batches

from hypgen.codegen.generate import generate, generate_verify
from hypgen.dsl import ir
from hypgen.dsl.interpret.trace import columns, trace
from hypgen.dsl.load import load
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.solver import build_solver
from hypgen.runtime.builder.tools import find_tools

pytestmark = pytest.mark.cxx
FOLDER = Path(__file__).parent
EXAMPLES = sorted((FOLDER.parent.parent / "examples").glob("*.pomdp"))
CLASSICS = sorted((FOLDER.parent.parent / "examples" / "classics").glob("*.pomdp"))
MODELS = sorted((FOLDER / "models").glob("*.pomdp"))
SEED, SCENARIOS = 20261122, 6000
FEW, MANY = 300_000, 8_000_000  # numbers of a trace, at most
# Of a walk. The interpreter takes all walks a step at a time, so few steps of many walks take less.
FEW_STEPS, MANY_STEPS = 8, 20


@pytest.fixture(scope="module")
def _compiler(request: pytest.FixtureRequest) -> None:
    """Skip without a compiler; else build what this module needs (and later tests, too) on all cores."""
    try:
        find_tools()
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")
    mine = [item for item in request.session.items if item.fspath == request.path]
    values = [value for item in mine if hasattr(item, "callspec") for value in item.callspec.params.items()]
    programs = dict.fromkeys((name, value) for name, value in values if isinstance(value, Path))
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, path in programs:  # one that does not compile fails its own tests
            if name == "solved":
                pool.submit(build, path)
            else:
                pool.submit(build_verify, load(path).model)


@cache  # the code of some examples takes seconds to generate
def build(path: Path) -> Path:
    model = load(path).model
    return build_solver(generate(model), f"differential/{model.name}", lambda step: None)


def build_verify(model: ir.Model) -> Path:
    return build_solver(generate_verify(model), f"differential/{model.name}", lambda step: None)


def with_params(model: ir.Model, **values: tuple[float, ...]) -> ir.Model:
    """Return the model with defaults for the params that have none."""
    params = (dataclasses.replace(p, default=values.get(p.name, p.default)) for p in model.params)
    return dataclasses.replace(model, params=tuple(params))


HAND_BUILT = (ir_samples.tiger(), ir_samples.rocks(), with_params(ir_samples.wanderer(), slip=(0.1, 0.3)))


def traced_scenarios(model: ir.Model, numbers: int = FEW, steps: int = FEW_STEPS) -> int:
    """Return how many walks make a trace of so many numbers, or fewer where the interpreter is slow."""
    # It goes through all pairs of a factor's values, and through the points of a float.
    scenarios = SCENARIOS // 20 if any(f.size > 8 for f in model.factors) else SCENARIOS
    if any(f.moments is not None and f.element in model.history.beliefs for f in model.factors):
        scenarios //= 5
    return min(scenarios, numbers // (steps * len(columns(model))))


def assert_same_trace(model: ir.Model, folder: Path, numbers: int = FEW, steps: int = FEW_STEPS) -> None:
    program = build_verify(model)
    path = folder / "trace"
    scenarios = traced_scenarios(model, numbers, steps)
    size = ["--trace-scenarios", str(scenarios), "--trace-steps", str(steps), "--seed", str(SEED)]
    subprocess.run([program, "--trace", path, *size], check=True)
    actual = traces.read(path, model)
    path.unlink()  # tens of megabytes that would outlive the test
    expected = trace(model, SEED, scenarios, steps)
    assert (traces.difference(expected, actual, model, scenarios) or "equal") == "equal"
    shared = [program, "--lanes", "64", "--steps", "20", "--seed", str(SEED)]
    done = subprocess.run(shared, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


@pytest.mark.usefixtures("_compiler")
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example(path: Path, tmp_path: Path) -> None:
    assert_same_trace(load(path).model, tmp_path)


@pytest.mark.property
@pytest.mark.usefixtures("_compiler")
@pytest.mark.parametrize("path", [*EXAMPLES, *CLASSICS, *MODELS], ids=lambda path: path.stem)
def test_long_trace(path: Path, tmp_path: Path) -> None:
    assert_same_trace(load(path).model, tmp_path, MANY, MANY_STEPS)


@pytest.mark.property
@pytest.mark.usefixtures("_compiler")
@pytest.mark.parametrize("model", HAND_BUILT, ids=lambda model: model.name)
def test_long_trace_of_a_hand_built_model(model: ir.Model, tmp_path: Path) -> None:
    assert_same_trace(model, tmp_path, MANY, MANY_STEPS)


@pytest.mark.usefixtures("_compiler")
def test_models(tmp_path: Path) -> None:
    """Classics, those of ``models``, some built by hand: in one program, whose compiler optimises less."""
    models = [*(load(path).model for path in (*CLASSICS, *MODELS)), *HAND_BUILT]
    numbered = {i: batches.numbered(model, i) for i, model in enumerate(models)}
    found = batches.compare_models(
        numbered, tmp_path, lambda model: batches.Size(traced_scenarios(model), FEW_STEPS)
    )
    assert {m.name: found[i] for i, m in enumerate(models)} == {m.name: None for m in models}


SEARCH = ("--mode", "despot", "--runs", "1", "--steps", "5", "--trials", "3", "--scenarios", "20")


@pytest.mark.usefixtures("_compiler")
@pytest.mark.parametrize("solved", EXAMPLES, ids=lambda path: path.stem)
@pytest.mark.parametrize("options", [("--mode", "default", "--runs", "2"), SEARCH])
def test_episodes_end_well(solved: Path, options: tuple[str, ...], tmp_path: Path) -> None:
    solver = build(solved)
    lines = tmp_path / "lines.jsonl"
    subprocess.run([solver, *options, "--particles", "500", "--quiet", "--json", lines], check=True)
    summary = json.loads(lines.read_text().splitlines()[-1])
    assert set(summary["endings"]) <= {"terminal", "step_limit"}
    assert set(summary["searches"]) <= {"ok", "converged", "trial_limit"}


@pytest.mark.property
@pytest.mark.usefixtures("_compiler")
@pytest.mark.parametrize("solved", [*EXAMPLES, *CLASSICS], ids=lambda path: path.stem)
@pytest.mark.parametrize("options", [("--mode", "default", "--runs", "20"), SEARCH])
def test_many_episodes_end_well(solved: Path, options: tuple[str, ...], tmp_path: Path) -> None:
    test_episodes_end_well(solved, options, tmp_path)
