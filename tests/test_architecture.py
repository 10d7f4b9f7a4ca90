# SPDX-License-Identifier: Apache-2.0
"""The rules of ARCHITECTURE.md that can be read off the files."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from support import import_graph

ROOT = Path(__file__).parent.parent
LAYERS = import_graph.LAYERS
PLAY = "hypgen.play"
MAX_SOURCE_LINES = 500
MAX_TEMPLATE_LINES = 150

# What each layer may import besides itself, by the beginning of the module's name; "" stands for the layer.
HYPGEN = {
    "dsl": (),
    "dsl.foreign": ("dsl.messages", "dsl.foreign"),
    "codegen": ("dsl.ir", "dsl.types", "dsl.messages"),
    "runtime": ("cache_folder", "whole_files"),
    "cli": (
        "dsl",
        "codegen",
        "runtime",
        "play",
        "api",
        "editor",
        "experiments",
        "tuning",
        "recordings",
        "pictures",
        "views",
        "whole_files",
    ),
}
OTHERS = {
    "dsl": {"lark"},
    "dsl.interpret": {"numpy"},
    "dsl.foreign": set(),
    "codegen": {"jinja2"},
    "runtime": set(),
}
SETUPTOOLS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]


def python_files(*layers: str) -> Iterator[tuple[str, Path]]:
    """Yield the modules of some layers with their names below ``hypgen``."""
    for layer in layers:
        for path in import_graph.python_files(ROOT / layer):
            yield ".".join(path.relative_to(ROOT).with_suffix("").parts), path


def longest(name: str, table: dict[str, object] | dict[str, set[str]]) -> str:
    """Return the longest key of a table that a module's name begins with."""
    return max((k for k in table if name == k or name.startswith(f"{k}.")), key=len, default="")


def sources(*suffixes: str) -> list[Path]:
    """Return the project's own text files with these suffixes; what is generated is not among them."""
    folders = [ROOT / name for name in (*LAYERS, "src", "tests", "benchmarks", "examples")]
    return sorted(
        path
        for folder in folders
        for path in folder.rglob("*")
        if path.suffix in suffixes and path.is_file() and "golden" not in path.parts
    )


@pytest.mark.parametrize("layer", LAYERS)
def test_a_layer_imports_the_layers_that_its_row_names(layer: str) -> None:
    for name, path in python_files(layer):
        own = HYPGEN[longest(name, HYPGEN)]
        allowed = own if "dsl.foreign" in own else (layer, *own)
        found = {n.removeprefix("hypgen.") for n in import_graph.imported(path) if n.startswith("hypgen.")}
        wrong = {n for n in found if not any(n == a or n.startswith(f"{a}.") for a in allowed)}
        assert wrong <= {"__version__"}, f"{path} may not import {wrong}"


@pytest.mark.parametrize("layer", OTHERS)
def test_a_layer_imports_the_libraries_that_its_row_names(layer: str) -> None:
    for name, path in python_files(layer.partition(".")[0]):
        if longest(name, OTHERS) == layer:
            found = {n.partition(".")[0] for n in import_graph.imported(path)}
            assert found - set(sys.stdlib_module_names) - {"hypgen"} <= OTHERS[layer], path


def test_no_import_runs_back_up() -> None:
    for row in import_graph.rows(ROOT):
        assert not row.circles_of_packages, row
        assert not row.circles_of_modules, row
        assert row.back == 0, row


def test_only_cli_prints_or_exits() -> None:
    for _, path in python_files("dsl", "codegen", "runtime"):
        text = path.read_text()
        calls = (n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Call))
        called = {n.func.id for n in calls if isinstance(n.func, ast.Name)}
        assert not called & {"print", "exit", "quit"}, path
        assert "sys.exit" not in text, path


def test_the_python_interface_imports_no_command_line() -> None:
    for path in import_graph.python_files(ROOT / "src" / "hypgen" / "api"):
        assert not any(name.startswith("hypgen.cli") for name in import_graph.imported(path)), path


def test_every_folder_with_modules_is_a_package() -> None:
    for _, path in python_files(*LAYERS):
        assert (path.parent / "__init__.py").is_file(), f"{path} would be missing from the wheel"


def test_the_wheel_has_every_data_file() -> None:
    packed = {
        path
        for package, patterns in SETUPTOOLS["package-data"].items()
        for pattern in patterns
        for path in (ROOT / "src" / package.replace(".", "/")).resolve().glob(pattern)
    }
    for layer in LAYERS:
        for path in (ROOT / layer).rglob("*"):
            documentation = path.name == "README.md" or "__pycache__" in path.parts
            if path.is_file() and path.suffix != ".py" and not documentation:
                assert path in packed, f"not in package-data: {path}"


def test_no_source_file_is_too_long() -> None:
    long = {
        p: len(p.read_text().splitlines()) for p in sources(".py", ".cpp", ".hpp", ".cu", ".cuh", ".lark")
    }
    long |= {p: len(p.read_text().splitlines()) for p in sources(".pomdp")}
    assert {p: n for p, n in long.items() if n > MAX_SOURCE_LINES} == {}


def test_templates_are_short() -> None:
    for path in (ROOT / "codegen" / "templates").rglob("*"):
        if path.is_file():
            assert len(path.read_text().splitlines()) <= MAX_TEMPLATE_LINES, path


def includes(text: str) -> list[str]:
    return re.findall(r"^\s*#\s*include\s*([<\"][^>\"]+[>\"])", text, re.MULTILINE)


def test_the_runtime_includes_its_own_headers_the_standard_library_and_json() -> None:
    """It never includes generated code: quoted includes are files of the runtime. Eigen is for `exact`."""
    runtime = ROOT / "runtime"
    own = {p.relative_to(runtime / "include").as_posix() for p in (runtime / "include").rglob("*.*")}
    private = {p.name for p in (runtime / "src").rglob("*.hpp")}
    for path in [p for p in sources(".hpp", ".cpp", ".cuh") if runtime in p.parents]:
        for include in includes(path.read_text()):
            name = include[1:-1]
            standard = include[0] == "<" and ("/" not in name or name.startswith("sys/"))
            standard |= include == "<cuda_runtime.h>" and path.suffix == ".cuh"
            standard |= name.startswith("Eigen/") and "exact" in path.parts
            mine = name in own or re.sub(r"^\.\./(solver|model)/", "", name) in private
            assert standard or mine or name == "nlohmann/json.hpp", f"{path}: {include}"


def test_generated_code_includes_public_headers_only(generated: dict[str, str]) -> None:
    own = {f'"{Path(name).name}"' for name in generated if name.endswith((".h", ".hpp"))}
    for name, text in generated.items():
        for include in includes(text):
            public = re.fullmatch(r"<(\w+|hypgen\.h|hypgen/\w+/\w+\.hpp|hypgen/cuda/\w+\.cuh)>", include)
            assert public or include in own, f"{name}: {include}"


@pytest.fixture(params=sorted((ROOT / "examples").glob("*.pomdp")), ids=lambda p: p.stem)
def generated(request: pytest.FixtureRequest) -> dict[str, str]:
    from hypgen.codegen.generate import generate
    from hypgen.dsl.load import load

    return generate(load(request.param).model)
