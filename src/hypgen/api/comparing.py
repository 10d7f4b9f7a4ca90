# SPDX-License-Identifier: Apache-2.0
"""What the planners of a model earn in the same episodes, beside what is proven of the best."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from hypgen.api.model import Model
from hypgen.api.programs import Progress
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.play.played_programs import (
    EXACT,
    GPU_PLANNERS,
    PLANNERS,
    Comparison,
    Policy,
    left_out,
    play_exact,
    play_mode,
    steps_needed,
)
from hypgen.runtime.builder.cuda_tools import CudaBuild, choose


def compare(
    model: Model,
    modes: Sequence[str] | None = None,
    *,
    runs: int = 20,
    time: float | None = None,
    trials: int | None = None,
    steps: int | None = None,
    seed: int = 0,
    param: Path | None = None,
    solve_time: float = 60.0,
    cuda: CudaBuild | str | None = "auto",
    progress: Progress | None = None,
    show: Callable[[Policy], None] | None = None,
    into: Comparison | None = None,
) -> Comparison:
    """Play a model with each mode in the same episodes, and return what they earn.

    ``modes`` are some of ``PLANNERS``, ``GPU_PLANNERS`` and ``EXACT``; by default all that this machine has.
    The last act on the exact belief. A decision takes ``time`` seconds, 0.1 unless there are ``trials``.
    ``steps`` is the most of an episode; by default as many as leave out a thousandth of the sum of discounts.
    ``param`` is a JSON file with values of params. ``solve_time`` seconds go to solving for ``EXACT``.
    ``cuda`` is a target such as "cpu", or how to compile for GPUs.

    ``progress`` is told of what is built, and ``show`` of a policy after each episode. An interrupt leaves in
    ``into`` what is known by then.
    """
    build = choose(cuda, "", "").build if isinstance(cuda, str) else cuda
    asked = list(PLANNERS + (GPU_PLANNERS if build else ()) + EXACT) if modes is None else list(modes)
    if unknown := [mode for mode in asked if mode not in PLANNERS + GPU_PLANNERS + EXACT]:
        raise ValueError(f"modes: there is no mode {unknown[0]!r}")
    comparison = Comparison() if into is None else into
    law = (model.loaded.model.discount, model.loaded.model.horizon)
    comparison.steps = steps_needed(*law) if steps is None else steps
    comparison.left_out = left_out(*law, comparison.steps)
    options = [] if param is None else [f"--param={param}"]
    options += [f"--runs={runs}", f"--steps={comparison.steps}", f"--seed={seed}"]
    limits = [f"--trials={trials}"] if trials else []
    limits += [f"--time={0.1 if time is None else time}"] if time is not None or not trials else []
    tell = show or (lambda policy: None)
    if planners := [mode for mode in asked if mode not in EXACT]:
        solver = model.program("solver", cuda=build, progress=progress)
        for mode in planners:
            play_mode(solver, comparison.add(mode), [*options, *limits], tell)
    if kinds := [mode for mode in asked if mode in EXACT]:
        try:
            program = model.program("exact", progress=progress)
        except ModelError as error:
            for kind in kinds:
                comparison.add(kind, problem=f"cannot be enumerated: {error.diagnostics[0].message}")
        else:
            play_exact(program, kinds, [*options, f"--time={solve_time}"], tell, comparison)
    return comparison
