"""The rules of ARCHITECTURE.md that can be read off the files."""

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
LAYERS = {"dsl": ROOT / "dsl", "codegen": ROOT / "codegen", "cli": ROOT / "cli", "runtime": ROOT / "runtime"}
NUMPY_MODULES = re.compile(r"interpreter\w*|eval_\w+|float_\w+|philox|trace")
MAX_SOURCE_LINES = 500
MAX_TEMPLATE_LINES = 150

SETUPTOOLS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]


def sources(*suffixes: str) -> list[Path]:
    """Return the project's own text files with these suffixes; what is generated is not among them."""
    folders = (*LAYERS.values(), ROOT / "src", ROOT / "tests", ROOT / "benchmarks", ROOT / "examples")
    return sorted(
        path
        for folder in folders
        for path in folder.rglob("*")
        if path.suffix in suffixes and path.is_file() and not {"build", "golden"} & set(path.parts)
    )


def imports(path: Path) -> Iterator[str]:
    """Yield the full name of every module that a file imports, and of every name taken from hypgen."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def foreign(path: Path) -> set[str]:
    """Return the packages that a file imports, the standard library's and hypgen's own left out."""
    return {name.split(".")[0] for name in imports(path)} - set(sys.stdlib_module_names) - {"hypgen"}


def own_layers(path: Path) -> set[str]:
    """Return the layers of hypgen that a file imports."""
    return {name.split(".")[1] for name in imports(path) if re.match(r"hypgen\.\w+", name)} & set(LAYERS)


def python_files(layer: str) -> list[Path]:
    return sorted(LAYERS[layer].rglob("*.py"))


@pytest.mark.parametrize("path", python_files("dsl"), ids=lambda p: p.name)
def test_dsl_imports_lark_and_only_its_interpreter_numpy(path: Path) -> None:
    allowed = {"numpy"} if NUMPY_MODULES.fullmatch(path.stem) else {"lark"}
    assert foreign(path) <= allowed
    assert own_layers(path) <= {"dsl"}


@pytest.mark.parametrize("path", sorted((LAYERS["dsl"] / "foreign").glob("*.py")), ids=lambda p: p.name)
def test_other_formats_are_read_by_what_knows_nothing_of_the_language(path: Path) -> None:
    modules = {".".join(n.split(".")[:3]) for n in imports(path) if n.startswith("hypgen.")}
    assert modules <= {f"hypgen.dsl.{name}" for name in ("diagnostics", "foreign", "source")}
    assert foreign(path) == set()


@pytest.mark.parametrize("path", python_files("codegen"), ids=lambda p: p.name)
def test_codegen_sees_the_ir_and_never_the_syntax_tree(path: Path) -> None:
    assert foreign(path) <= {"jinja2"}
    assert own_layers(path) <= {"dsl", "codegen"}
    modules = {".".join(n.split(".")[:3]) for n in imports(path) if n.startswith("hypgen.dsl.")}
    known = {f"hypgen.dsl.{name}" for name in ("ir", "ir_walk", "keys", "types", "source", "diagnostics")}
    assert modules <= known, f"codegen may not import {modules - known}"


@pytest.mark.parametrize("path", python_files("runtime"), ids=lambda p: p.name)
def test_runtime_imports_the_standard_library_only(path: Path) -> None:
    assert foreign(path) == set()
    assert own_layers(path) <= {"runtime"}


@pytest.mark.parametrize(
    "path", [p for layer in ("dsl", "codegen", "runtime") for p in python_files(layer)], ids=lambda p: p.name
)
def test_only_cli_prints_or_exits(path: Path) -> None:
    called = {
        n.func.id
        for n in ast.walk(ast.parse(path.read_text()))
        if isinstance(n, ast.Call) and isinstance(n.func, ast.Name)
    }
    assert not called & {"print", "exit", "quit"}
    assert "sys.exit" not in path.read_text()


def test_the_package_list_equals_the_folders() -> None:
    folders = SETUPTOOLS["package-dir"]
    assert set(SETUPTOOLS["packages"]) == set(folders)
    found = {
        package
        for package, folder in folders.items()
        for init in [ROOT / folder / "__init__.py"]
        if init.is_file()
    }
    assert found == set(folders)
    packed = {ROOT / folder for folder in folders.values()}
    nested = [p for folder in LAYERS.values() for p in folder.rglob("__init__.py") if p.parent not in packed]
    assert not nested, "a sub-package would be missing from the wheel"


def test_the_wheel_has_every_data_file() -> None:
    for package, folder in SETUPTOOLS["package-dir"].items():
        base = ROOT / folder
        packed = {p for pattern in SETUPTOOLS["package-data"].get(package, []) for p in base.glob(pattern)}
        present = {
            p for p in base.rglob("*") if p.is_file() and "__pycache__" not in p.parts and p.suffix != ".py"
        }
        assert present <= packed, f"not in {package}'s package-data: {present - packed}"


@pytest.mark.parametrize(
    "path", sources(".py", ".cpp", ".hpp", ".cu", ".cuh", ".lark", ".pomdp"), ids=lambda p: p.name
)
def test_no_source_file_is_too_long(path: Path) -> None:
    assert len(path.read_text().splitlines()) <= MAX_SOURCE_LINES


def test_templates_are_short() -> None:
    for path in (LAYERS["codegen"] / "templates").rglob("*"):
        if path.is_file():
            assert len(path.read_text().splitlines()) <= MAX_TEMPLATE_LINES, path


def includes(text: str) -> list[str]:
    return re.findall(r"^\s*#\s*include\s*([<\"][^>\"]+[>\"])", text, re.MULTILINE)


def test_the_runtime_includes_its_own_headers_the_standard_library_and_json() -> None:
    """It never includes generated code: quoted includes are files of the runtime. Eigen is for `exact`."""
    own = {
        p.relative_to(ROOT / "runtime" / "include").as_posix()
        for p in sources(".hpp", ".cuh")
        if "include" in p.parts
    }
    private = {p.name for p in (ROOT / "runtime" / "src").rglob("*.hpp")}
    for path in [p for p in sources(".hpp", ".cpp", ".cuh") if LAYERS["runtime"] in p.parents]:
        for include in includes(path.read_text()):
            name = include[1:-1]
            standard = include[0] == "<" and ("/" not in name or name.startswith("sys/"))
            standard |= include == "<cuda_runtime.h>" and path.suffix == ".cuh"
            standard |= name.startswith("Eigen/") and "exact" in path.parts
            assert standard or name in own | private or name == "nlohmann/json.hpp", f"{path}: {include}"


def test_generated_code_includes_public_headers_only(generated: dict[str, str]) -> None:
    stems = {f'"{Path(name).name}"' for name in generated if name.endswith(".hpp")}
    for name, text in generated.items():
        for include in includes(text):
            public = re.fullmatch(r"<(\w+|hypgen/(exact/)?\w+\.hpp|hypgen/cuda/\w+\.cuh)>", include)
            assert public or include in stems, f"{name}: {include}"


@pytest.fixture(params=sorted((ROOT / "examples").glob("*.pomdp")), ids=lambda p: p.stem)
def generated(request: pytest.FixtureRequest) -> dict[str, str]:
    from hypgen.codegen import driver as codegen
    from hypgen.dsl import driver as dsl

    return codegen.generate(dsl.load(request.param).model)
