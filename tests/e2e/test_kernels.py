# SPDX-License-Identifier: Apache-2.0
"""A GPU's kernels, run on this CPU, give the host's bits: steps, leaves and trees.

The order in which a real GPU runs threads of a warp is not tried here: that takes one.
"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest
from support.paths import EXAMPLES, ROOT

from hypgen.codegen.generate import generate_verify
from hypgen.dsl.load import load
from hypgen.runtime.builder.cuda_tools import CudaBuild, Nvcc
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.solver import build_solver
from hypgen.runtime.builder.tools import find_tools

pytestmark = [pytest.mark.cxx, pytest.mark.kernels]

NVCC = Path(__file__).parent.parent / "support" / "cuda_on_cpu" / "nvcc"
# Of each kind: few observations, records of the past, steps shared by warps, draws that are seen, many bins.
MODELS = {
    "tag": EXAMPLES / "tag.pomdp",
    "laser_tag": EXAMPLES / "laser_tag.pomdp",
    "rock_sample": EXAMPLES / "rock_sample.pomdp",
    "crowd_driving": EXAMPLES / "crowd_driving.pomdp",
    "light_dark_1d": ROOT / "benchmarks" / "models" / "light_dark_1d.pomdp",
}


@pytest.fixture(scope="module")
def build(tmp_path_factory: pytest.TempPathFactory) -> CudaBuild:
    """A CUDA compiler whose GPU is this CPU."""
    try:
        find_tools()
    except ToolchainError as error:
        pytest.skip(f"needs a C++ compiler: {error}")
    library = tmp_path_factory.mktemp("cudart")
    subprocess.run(["ar", "rcs", str(library / "libcudart_static.a")], check=True)
    return CudaBuild(Nvcc(NVCC, "13.0", library, (90,)), (90,))


@pytest.mark.parametrize("name", MODELS)
def test_a_device_computes_what_the_host_does(name: str, build: CudaBuild) -> None:
    files = generate_verify(load(MODELS[name]).model)
    program = build_solver(files, f"kernels/{name}", lambda step: None, cuda=build)
    command = [str(program), "--lanes", "64", "--steps", "10", "--seed", "3", "--json", "-"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=900)
    checks = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    assert done.returncode == 0, done.stdout + done.stderr
    of_device = {(one["check"], one["variant"]): one for one in checks if one["check"].endswith(" 0")}
    for check in (("search 0", "16 at once"), ("search 0", "weighted"), ("leaves 0", "weighted")):
        assert of_device[check]["steps"] > 0, check
    assert all(one["differing"] == 0 for one in checks)
