# SPDX-License-Identifier: Apache-2.0
"""Compiles a generated node, with our own stubs in place of ROS 2, and programs that drive it."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from pathlib import Path

from hypgen.codegen.generate import generate_library, generate_ros2
from hypgen.dsl import ir
from hypgen.runtime.builder import tools
from hypgen.runtime.builder.solver import build_solver
from support import rosidl

HERE = Path(__file__).parent
HYPGEN_H = HERE.parent.parent / "runtime" / "include"
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
FLAGS = ("-std=c++17", "-O1", "-pthread", *WARNINGS)


def write(model: ir.Model, folder: Path) -> Path:
    """Write the node's sources and headers of its messages to a folder; return where the sources are."""
    _, files = generate_ros2(model)
    package = min(files).partition("_msgs/")[0] + "_planner"
    sources = {path: text for path, text in files.items() if path.startswith(f"{package}/src/")}
    for path, text in {**sources, **rosidl.headers(files, package.replace("_planner", "_msgs"))}.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
    return folder / package / "src"


def check(model: ir.Model, folder: Path) -> None:
    """Compile the node's sources to nothing; the model's header is made up."""
    source = write(model, folder)
    text = (source / "planner_node.cpp").read_text()
    [name] = [line for line in text.splitlines() if "hypgen_model_" in line]
    function = "hypgen_model_" + name.partition("hypgen_model_")[2].partition("(")[0]
    header = next(line for line in text.splitlines() if line.endswith(".h>") and "hypgen.h" not in line)
    (folder / header.split("<")[1].rstrip(">")).write_text(
        f'#include <hypgen.h>\nextern "C" const hypgen_model* {function}(void);\n'
    )
    for path in sorted(source.glob("*.cpp")):
        _run([*_compiler(folder, source, HYPGEN_H), "-fsyntax-only", str(path)])


def build(model: ir.Model, main: Path, folder: Path, flags: Sequence[str] = ()) -> tuple[Path, Path]:
    """Return a program of the node, the model's library and ``main``; and that library."""
    source = write(model, folder)
    library = build_solver(generate_library(model), str(folder), lambda step: None)
    command = [*_compiler(folder, source, library.parent.parent / "include"), *flags]
    node = [str(source / name) for name in ("planner_node.cpp", "parameters.cpp")]
    link = [f"-L{library.parent}", f"-l{library.stem.removeprefix('lib')}", f"-Wl,-rpath,{library.parent}"]
    program = folder / "drive"
    _run([*command, *node, str(main), *link, "-o", str(program)])
    return program, library


def _compiler(*include: Path) -> list[str]:
    compiler = str(tools.find_tools().compiler.path)
    return [compiler, *FLAGS, *(f"-I{path}" for path in (*include, HERE / "ros2_stubs"))]


def _run(command: Sequence[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
