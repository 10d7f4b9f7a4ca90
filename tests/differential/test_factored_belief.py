# SPDX-License-Identifier: Apache-2.0
"""Particles of single factors, as generated, come to the exact posterior, which traces check in all bits."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from support.belief_program import beliefs
from support.factored_models import FACTORED, model_of

from hypgen.codegen.generate import generate
from hypgen.dsl import ir

pytestmark = pytest.mark.cxx

PARTICLES, STEPS = 100_000, 30


def marginals(model: ir.Model, folder: Path) -> npt.NDArray[np.float64]:
    """Return, for each step of some episodes, its status and the belief's marginals."""
    header = next(t for path, t in generate(model).items() if path.endswith(".hpp"))
    rows = beliefs(header, model.name, "FactoredBelief", folder, PARTICLES, STEPS)
    return np.delete(rows, (1, 2), axis=1)


@pytest.mark.parametrize("name", ["mixed", "crowd", "first_looks"])
def test_particles_of_factors_come_to_their_posteriors(name: str, tmp_path: Path) -> None:
    model = model_of(FACTORED[name])
    exact = marginals(model, tmp_path / "exact")
    inexact = tuple(dataclasses.replace(f, size=0, inexact="as a test") for f in model.factors)
    sampled = marginals(dataclasses.replace(model, factors=inexact), tmp_path / "sampled")
    assert exact.shape == sampled.shape == (STEPS, 1 + 8 * (exact.shape[1] // 8))
    assert (exact[:, 0] == sampled[:, 0]).all()  # how each step ended
    assert len(np.unique(exact[:, 1:].round(3))) > 100
    assert np.abs(exact - sampled).max() < 0.03
