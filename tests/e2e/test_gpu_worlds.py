# SPDX-License-Identifier: Apache-2.0
"""Simulated worlds on a GPU do to the bit what those of the CPU do; without a GPU they say so."""

from pathlib import Path

import numpy as np
import pytest

import hypgen
from hypgen.runtime.builder import cuda_tools
from hypgen.runtime.builder.cuda_tools import CudaBuild
from hypgen.runtime.builder.errors import ToolchainError

pytestmark = [pytest.mark.cxx, pytest.mark.gpu]
EXAMPLES = Path(__file__).parent.parent.parent / "examples"
COUNT, STEPS = 3000, 200
HAS_GPU = bool(cuda_tools.find_gpus())


@pytest.fixture(scope="module", params=["tiger", "rock_sample"])
def solver(request: pytest.FixtureRequest) -> hypgen.Solver:
    try:
        nvcc = cuda_tools.find_nvcc()
    except ToolchainError as error:
        pytest.skip(f"needs nvcc: {error}")
    cuda = CudaBuild(nvcc, cuda_tools.architectures_of("native", nvcc) if HAS_GPU else (90,))
    model = hypgen.load(EXAMPLES / f"{request.param}.pomdp")
    return hypgen.Solver(model.program("library", cuda=cuda))


def assert_equal(worlds: list[hypgen.Worlds]) -> None:
    one, other = worlds
    for name in ("rewards", "seen", "keys", "visible", "legal", "terminal", "success"):
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes(), name


def some_actions(worlds: hypgen.Worlds, random: np.random.Generator) -> np.ndarray:
    """Return a legal action for each world, or its next episode where there is none."""
    chances = random.random(worlds.legal.shape) * worlds.legal
    return np.where(worlds.legal.any(1), chances.argmax(1), worlds.NEXT_EPISODE)


@pytest.mark.skipif(not HAS_GPU, reason="needs a GPU")
def test_worlds_of_both_are_equal(solver: hypgen.Solver) -> None:
    worlds = [solver.worlds(COUNT, seed=5, device=device) for device in ("cpu", "cuda")]
    random = np.random.default_rng(1)
    for each in worlds:
        each.reset()
    ends = 0
    for step in range(STEPS):
        actions = some_actions(worlds[0], random)
        if step % 50 == 20:
            mask = random.random(COUNT) < 0.5
            numbers = random.integers(0, 2**32, COUNT).tolist() if step < 100 else None
            for each in worlds:
                each.reset(numbers, mask)
            assert_equal(worlds)
            actions = some_actions(worlds[0], random)
        for each in worlds:
            each.step(actions)
        assert_equal(worlds)
        ends += int(worlds[0].terminal.sum())
    assert ends > 0
    for each in worlds:
        each.close()


@pytest.mark.skipif(not HAS_GPU, reason="needs a GPU")
def test_what_is_refused_moves_no_world(solver: hypgen.Solver) -> None:
    worlds = [solver.worlds(COUNT, seed=5, device=device) for device in ("cpu", "cuda")]
    told = []
    for each in worlds:
        with pytest.raises(hypgen.PlannerError, match="world 0: no action is legal") as before:
            each.step([0] * COUNT)
        each.reset()
        actions = np.zeros(COUNT, np.int32)
        actions[[1000, 2000]] = len(each.actions), -1
        with pytest.raises(hypgen.PlannerError, match="world 1000: expected an action from 0") as wrong:
            each.step(actions)
        told.append((str(before.value), str(wrong.value)))
        each.step([0] * COUNT)
    assert told[0] == told[1]
    assert_equal(worlds)


@pytest.mark.skipif(HAS_GPU, reason="this machine has a GPU")
def test_no_gpu_is_told(solver: hypgen.Solver) -> None:
    with pytest.raises(hypgen.PlannerError, match="no GPU") as caught:
        solver.worlds(2, device="cuda")
    assert caught.value.status == "no_gpu"
    with solver.worlds(2, device="cpu") as worlds:
        worlds.reset()
