# SPDX-License-Identifier: Apache-2.0
"""nvcc takes every example's device units without a warning, and both builds make a solver of it."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import pytest

from hypgen.codegen.generate import generate, generate_verify
from hypgen.dsl.load import load
from hypgen.runtime.builder import cache, cuda_tools, solver, tools
from hypgen.runtime.builder.compile_flags import host_flags, nvcc_flags
from hypgen.runtime.builder.cuda_tools import CudaBuild
from hypgen.runtime.builder.errors import ToolchainError

pytestmark = [pytest.mark.cxx, pytest.mark.gpu]
ROOT = Path(__file__).parent.parent.parent
TIGER = ROOT / "examples" / "tiger.pomdp"
EXAMPLES = [*sorted((ROOT / "examples").glob("*.pomdp")), *sorted((ROOT / "examples").glob("*/*.pomdp"))]
FIRST_LOOK = ROOT / "tests" / "golden" / "first_look.pomdp"
WARNINGS = ["-Werror=all-warnings", "-Xcompiler=-Wall,-Wextra"]
QUICK = ("--mode=despot", "--runs=1", "--trials=20", "--scenarios=50", "--steps=5", "--quiet", "--signature")


@pytest.fixture(scope="module")
def cuda() -> CudaBuild:
    try:
        return CudaBuild(cuda_tools.find_nvcc(), (90,))
    except ToolchainError as error:
        pytest.skip(f"needs nvcc: {error}")


def compile_device_units(example: Path, cuda: CudaBuild, folder: Path) -> str:
    """Return what nvcc has to say."""
    for name, text in generate_verify(load(example).model).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    flags = nvcc_flags()
    # What the compiler accepts and warns of is the same; optimised, all examples take minutes.
    flags += [*WARNINGS, "--Ofast-compile=max"] if numbers_of(cuda) >= (13, 0) else WARNINGS
    command = cuda_tools.nvcc_command(cuda, flags, tools.find_compiler().path, host_flags())
    include = [f"-I{folder / 'src'}", f"-I{ROOT / 'runtime' / 'include'}"]
    said = ""
    for unit in sorted((folder / "src").glob("*.cu")):
        files = ["-c", str(unit), "-o", str(unit.with_suffix(".o"))]
        done = subprocess.run([*command, *include, *files], capture_output=True, text=True)
        assert (done.returncode == 0) == unit.with_suffix(".o").is_file()
        said += done.stdout + done.stderr
    return said


def numbers_of(cuda: CudaBuild) -> tuple[int, ...]:
    return tools.numbers(cuda.nvcc.version)


@pytest.fixture(scope="module")
def messages(
    cuda: CudaBuild, tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest
) -> Iterator[dict[Path, Future[str]]]:
    """What nvcc says of the examples that were asked for, as many at a time as there are cores."""
    asked = {item.callspec.params["example"] for item in request.session.items if is_ours(item)}
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        yield {
            path: pool.submit(compile_device_units, path, cuda, tmp_path_factory.mktemp(path.stem))
            for path in [*EXAMPLES, FIRST_LOOK]
            if path in asked
        }


def is_ours(item: pytest.Item) -> bool:
    return getattr(item, "originalname", "") == "test_nvcc_has_nothing_to_say"


@pytest.mark.parametrize(
    "example",
    [
        pytest.param(p, id=p.stem, marks=[pytest.mark.slow] if p.parent.name == "classics" else [])
        for p in [*EXAMPLES, FIRST_LOOK]
    ],
)
def test_nvcc_has_nothing_to_say(example: Path, messages: dict[Path, Future[str]]) -> None:
    assert messages[example].result() == ""


def test_a_solver_with_device_code_plans_as_without(cuda: CudaBuild) -> None:
    """Also on a machine without a driver."""
    steps: list[solver.Step] = []
    files = generate(load(TIGER).model)
    both = solver.build_solver(files, "device/tiger", steps.append, cuda=cuda)
    assert steps[-1].what == "tiger for CPU and sm_90"
    plain = solver.build_solver(files, "device/tiger", steps.append)
    assert both != plain and (not steps[-1].reason or "another target" in steps[-1].reason)
    outputs = [subprocess.run([s, *QUICK], capture_output=True, text=True, check=True) for s in (both, plain)]
    assert outputs[0].stdout == outputs[1].stdout != ""


def test_an_exported_project_builds_for_gpus_with_plain_cmake(cuda: CudaBuild, tmp_path: Path) -> None:
    project = tmp_path / "tiger"
    command = [sys.executable, "-c", "from hypgen.cli.main import main; main()", "compile", str(TIGER)]
    options = ["--nvcc", str(cuda.nvcc.path), "--arch", "sm_90", "-o", str(project), "--emit-only"]
    subprocess.run([*command, *options], check=True, capture_output=True)
    cmake = str(tools.find_cmake().path)
    solver.build_solver(generate(load(TIGER).model), "device/tiger", lambda step: None)
    packages = cache.folder("runtime").glob(f"*/{cache.FILES}/lib/cmake/hypgen_runtime")
    package = max(packages, key=lambda path: path.parents[3].stat().st_mtime)  # the one used last
    runtime = ["-DHYPGEN_FIND_RUNTIME=ON", f"-Dhypgen_runtime_DIR={package}"]
    for arguments in (
        ["-B", "build", f"-DCMAKE_CUDA_COMPILER={cuda.nvcc.path}", *runtime],
        ["--build", "build", "--parallel", "2"],
    ):
        done = subprocess.run([cmake, *arguments], cwd=project, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-5000:]
    assert re.search(r"HYPGEN_CUDA_ARCHITECTURES:STRING=90", (project / "build/CMakeCache.txt").read_text())
    assert (project / "build" / "device.cu.o").is_file()
    built = subprocess.run([project / "build" / "tiger", *QUICK], capture_output=True, text=True, check=True)
    assert built.stdout.startswith("signature ")
