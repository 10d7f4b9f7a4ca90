# SPDX-License-Identifier: Apache-2.0
"""Builds a program that compares walks through random models on a GPU with those on the host.

PYTHONPATH=tests python benchmarks/device/random_walks.py [--models N] [--first SEED] [--jobs J]
    [--batch B] [--out FOLDER]

The models are those of tests/differential/test_random.py, by seed. Needs nvcc and no GPU: the program needs
nothing but a driver where it runs. Run again, it compiles what has changed.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from support.random_models import batches, failures

from hypgen.codegen.generate import generate_verify
from hypgen.dsl import ir
from hypgen.runtime.builder.compile_flags import host_flags, nvcc_flags
from hypgen.runtime.builder.cuda_tools import find_nvcc
from hypgen.runtime.builder.tools import find_compiler

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
RUNTIME = ROOT / "runtime"

# Not -march=native: the machine with the GPU is another one. Every H100's host has these instructions.
HOST_FLAGS = ["-std=c++17", "-O2", "-march=x86-64-v3", *host_flags(), "-w"]
# The digests' kernels are half a megabyte a model unless they are compressed for size.
GPU = ["-gencode", "arch=compute_90,code=sm_90", "--compress-mode=size"]
STATIC = ["-static-libstdc++", "-static-libgcc"]


@dataclass(frozen=True)
class Unit:
    """What one call of a compiler makes of one source."""

    source: Path
    target: Path
    command: Sequence[str]


def write(path: Path, text: str) -> None:
    """Write a file unless it is there with this text, so that what was compiled of it stays."""
    if not path.is_file() or path.read_text() != text:
        path.write_text(text)


def write_models(seeds: Sequence[int], folder: Path) -> dict[int, ir.Model]:
    """Write each seed's model, its header and its device unit; return the models."""
    models = {}
    for seed in seeds:
        text = str(failures.accepted(seed))
        model = batches.lowered(text, seed)
        assert isinstance(model, ir.Model), model
        files = generate_verify(model)
        write(folder / f"batch{seed}.pomdp", text)
        write(folder / f"batch{seed}.hpp", files[f"src/batch{seed}.hpp"])
        write(folder / f"batch{seed}.cuh", files["src/device_digests.cu"])
        models[seed] = model
    return models


def write_batch(number: int, models: dict[int, ir.Model], folder: Path) -> None:
    """Write a batch's unit for each compiler."""
    device = [f'#include "batch{seed}.cuh"' for seed in models]
    write(folder / f"device{number}.cu", "\n".join(device) + "\n")
    lines = ['#include "random_walks.hpp"', *(f'#include "batch{seed}.hpp"' for seed in models), ""]
    lines += [f"void add_{number}(std::vector<random_walks::Entry>& to) {{"]
    for seed, model in models.items():
        lines += ["  {", "    hypgen::ParamValues values;"]
        for param in model.params:
            numbers = ", ".join(repr(float(x)) for x in param.default or ())
            lines += [f'    values.set("{param.name}", {{{numbers}}});']
        name = f"Batch{seed}"
        lines += [f'    to.push_back(random_walks::entry<hypgen::models::{name}>("{name}", values));', "  }"]
    write(folder / f"host{number}.cpp", "\n".join([*lines, "}"]) + "\n")


def write_registry(batches: int, folder: Path) -> None:
    """Write the unit that knows all batches."""
    lines = ['#include "random_walks.hpp"', ""]
    lines += [f"void add_{i}(std::vector<random_walks::Entry>& to);" for i in range(batches)]
    lines += ["", "std::vector<random_walks::Entry> random_walks::entries() {", "  std::vector<Entry> all;"]
    lines += [f"  add_{i}(all);" for i in range(batches)]
    write(folder / "registry.cpp", "\n".join([*lines, "  return all;", "}"]) + "\n")


def compile_unit(unit: Unit) -> None:
    """Compile a unit unless its object is newer than all that it is made of."""
    dependencies = unit.target.with_suffix(".d")
    if unit.target.is_file() and dependencies.is_file():
        named = dependencies.read_text().replace("\\\n", " ").partition(":")[2].split()
        made = unit.target.stat().st_mtime
        if all(Path(name).is_file() and Path(name).stat().st_mtime < made for name in named):
            return
    outputs = ["-MD", "-MF", str(dependencies), "-c", str(unit.source), "-o", str(unit.target)]
    started = time.time()
    subprocess.run(["nice", *unit.command, *outputs], check=True)
    os.utime(unit.target, (started, started))  # what was edited meanwhile is newer
    print(unit.target.name, flush=True)


def build(folder: Path, batches: int, jobs: int) -> Path:
    """Compile and link all; return the program."""
    nvcc, compiler = find_nvcc(), str(find_compiler().path)
    include = [f"-I{RUNTIME / 'include'}", f"-I{HERE}", f"-I{folder}"]
    host = [compiler, *HOST_FLAGS, *include]
    flags = nvcc_flags()
    shared = [f"-Xcompiler={flag}" for flag in HOST_FLAGS[1:]]
    device = [str(nvcc.path), *flags, "-w", *GPU, "-ccbin", compiler, *shared, *include]
    sources = [
        RUNTIME / "src" / "verify" / "digest_walks.cpp",
        HERE / "random_walks.cpp",
        folder / "registry.cpp",
    ]
    sources += [folder / f"host{i}.cpp" for i in range(batches)]
    units = [Unit(folder / f"device{i}.cu", folder / f"device{i}.o", device) for i in range(batches)]
    units += [Unit(source, folder / f"{source.stem}.o", host) for source in sources]
    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(compile_unit, units))
    program = folder / "random_walks"
    libraries = ["-pthread", f"-L{nvcc.library}", "-lcudart_static", "-ldl", "-lrt"]
    objects = [str(unit.target) for unit in units]
    subprocess.run([compiler, "-s", *STATIC, *objects, *libraries, "-o", str(program)], check=True)
    return program


def main() -> None:
    """Write, compile and link."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--models", type=int, default=200, help="how many (200)")
    parser.add_argument("--first", type=int, default=0, help="the first one's seed (0)")
    parser.add_argument("--batch", type=int, default=10, help="models of a translation unit (10)")
    parser.add_argument("--jobs", type=int, default=2, help="compilers at a time (2)")
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "device" / "random_walks")
    asked = parser.parse_args()
    folder = asked.out.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    seeds = range(asked.first, asked.first + asked.models)
    groups = [seeds[i : i + asked.batch] for i in range(0, len(seeds), asked.batch)]
    for number, group in enumerate(groups):
        write_batch(number, write_models(group, folder), folder)
    write_registry(len(groups), folder)
    program = build(folder, len(groups), asked.jobs)
    print(f"{program}: {program.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
