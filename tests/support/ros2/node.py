# SPDX-License-Identifier: Apache-2.0
"""Compiles a generated node, with our own stubs in place of ROS 2, and programs that drive it."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Sequence
from pathlib import Path

from hypgen.codegen.generate import generate_library, generate_ros2
from hypgen.dsl import ir
from hypgen.runtime.builder import tools
from hypgen.runtime.builder.solver import build_solver
from support.ros2 import rosidl

HERE = Path(__file__).parent
HYPGEN_H = HERE.parent.parent.parent / "runtime" / "include"
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
# Functions of packages of ROS that are not there.
FUNCTIONS = {
    "ament_cmake": """function(ament_package)
endfunction()
function(ament_export_dependencies)
endfunction()
""",
    "rosidl_default_generators": """function(rosidl_generate_interfaces target)
  foreach(file IN LISTS ARGN)
    if(NOT EXISTS "${CMAKE_CURRENT_SOURCE_DIR}/${file}")
      message(FATAL_ERROR "no ${file}")
    endif()
  endforeach()
endfunction()
""",
}
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
    text = (source / "planner.cpp").read_text()
    function, header = (re.findall(pattern, text)[0] for pattern in (r"hypgen_model_\w+", r"<(\w+\.h)>"))
    declaration = f'extern "C" const hypgen_model* {function}(void);'
    (folder / header).write_text(f"#include <hypgen.h>\n{declaration}\n")
    for path in sorted(source.glob("*.cpp")):
        _run([*_compiler(folder, source, HYPGEN_H), "-fsyntax-only", str(path)])


def build(model: ir.Model, main: Path, folder: Path) -> tuple[Path, Path]:
    """Return a program of the node, the model's library and ``main``; and that library.

    AddressSanitizer looks for what the node leaves behind.
    """
    source = write(model, folder)
    library = build_solver(generate_library(model), str(folder), lambda step: None)
    command = [*_compiler(folder, source, library.parent.parent / "include"), "-fsanitize=address,undefined"]
    node = [str(path) for path in sorted(source.glob("*.cpp")) if path.name != "main.cpp"]
    link = [f"-L{library.parent}", f"-l{library.stem.removeprefix('lib')}", f"-Wl,-rpath,{library.parent}"]
    program = folder / "drive"
    _run([*command, *node, str(main), *link, "-o", str(program)])
    return program, library


def install_ros(model: ir.Model, prefix: Path) -> None:
    """Put packages of CMake into ``prefix``, as ROS and the message package do: our stubs and headers."""
    headers = write(model, prefix / "include").parent
    messages = headers.name.replace("_planner", "_msgs")
    targets = {name: f"{name}::{name}" for name in ("rclcpp", "rclcpp_action", "rclcpp_lifecycle", messages)}
    include = f'"{HERE / "stubs"};{prefix / "include"}"'
    for name, target in targets.items():
        text = (
            f"add_library({target} INTERFACE IMPORTED)\n"
            f"set_target_properties({target} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES {include})\n"
            f"set({name}_TARGETS {target})\n"
        )
        _configure(prefix, name, text)
    for name, text in FUNCTIONS.items():
        _configure(prefix, name, text)


def _configure(prefix: Path, name: str, text: str) -> None:
    folder = prefix / "share" / name / "cmake"
    folder.mkdir(parents=True)
    (folder / f"{name}Config.cmake").write_text(text)


def _compiler(*include: Path) -> list[str]:
    compiler = str(tools.find_tools().compiler.path)
    return [compiler, *FLAGS, *(f"-I{path}" for path in (*include, HERE / "stubs"))]


def _run(command: Sequence[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
