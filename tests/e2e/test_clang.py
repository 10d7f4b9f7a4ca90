# SPDX-License-Identifier: Apache-2.0
"""clang++ takes the runtime and what is generated, has nothing to say of it, and searches the same trees."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.clang import Checker, find_clangs, takes
from support.native import build_with_cmake
from support.paths import EXAMPLES, ROOT
from support.pinned import PINS, signatures

from hypgen.api.programs import files
from hypgen.codegen.passes.enumerable import not_enumerable
from hypgen.dsl.load import load
from hypgen.runtime.builder.exported_project import export
from hypgen.runtime.builder.solver import build_solver

pytestmark = pytest.mark.cxx
CLANGS = find_clangs()
RUNTIME = sorted((ROOT / "runtime" / "src").rglob("*.cpp"))
MODELS = sorted(EXAMPLES.rglob("*.pomdp"))
PINNED = sorted(EXAMPLES.glob("*.pomdp"))
LIBRARIES = ("-stdlib=libstdc++", "-stdlib=libc++")

each_clang = pytest.mark.parametrize("clang", CLANGS or [None], ids=lambda path: Path(path or "none").name)
each_library = pytest.mark.parametrize("library", LIBRARIES)


def ids(path: Path) -> str:
    return path.stem


def checker(clang: str | None, library: str) -> Checker:
    """Return what checks with this clang and standard library, or skip where one is not installed."""
    if clang is None:
        pytest.skip("needs clang++ 14 or newer (Debian: clang)")
    if library != LIBRARIES[0] and not takes(clang, library):
        pytest.skip(f"{clang} has no libc++ (Debian: libc++-dev of the same version)")
    return Checker(clang, (library,))


def problems(check: Checker, model: Path, kind: str, folder: Path) -> str:
    """Return what clang has to say of a generated program."""
    generated = files(load(model), kind)
    for name, text in generated.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    units = [folder / name for name in sorted(generated) if name.endswith(".cpp")]
    return check.problems(units, (folder / "src", folder / "include"))


def test_clang_has_nothing_to_say_of_a_generated_project(tmp_path: Path) -> None:
    """Of the oldest clang that is found, as it refuses most. The model's unit has most of the headers."""
    check = checker(CLANGS[0] if CLANGS else None, LIBRARIES[0])
    assert problems(check, EXAMPLES / "rock_sample.pomdp", "solver", tmp_path) == ""


@pytest.mark.unoptimised
def test_clang_has_nothing_to_say_of_the_runtime() -> None:
    check = checker(CLANGS[0] if CLANGS else None, LIBRARIES[0])
    assert check.problems(RUNTIME) == ""


@pytest.mark.slow
@each_clang
@each_library
def test_each_clang_takes_the_runtime(clang: str | None, library: str) -> None:
    assert checker(clang, library).problems(RUNTIME) == ""


@pytest.mark.slow
@each_clang
@each_library
@pytest.mark.parametrize("model", MODELS, ids=ids)
def test_each_clang_takes_every_example(clang: str | None, library: str, model: Path, tmp_path: Path) -> None:
    check = checker(clang, library)
    kinds = ["solver", "verify", *([] if not_enumerable(load(model).model) else ["exact"])]
    assert [problems(check, model, kind, tmp_path / kind) for kind in kinds] == [""] * len(kinds)


@pytest.mark.slow
@each_clang
@each_library
@pytest.mark.parametrize("example", PINNED, ids=ids)
def test_clang_builds_the_same_trees_as_gcc(
    clang: str | None, library: str, example: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CXX", checker(clang, library).clang)
    monkeypatch.setenv("CXXFLAGS", library)
    monkeypatch.setenv("LDFLAGS", library)
    solver = build_solver(files(load(example), "solver"), f"signature/{example.stem}", lambda step: None)
    assert signatures(solver, example.stem) == PINS[example.stem]


@pytest.mark.slow
@each_clang
@each_library
def test_an_exported_project_builds_with_clang(clang: str | None, library: str, tmp_path: Path) -> None:
    used = checker(clang, library).clang
    project = tmp_path / "tiger"
    export(files(load(EXAMPLES / "tiger.pomdp"), "solver"), project)
    settings = (f"-DCMAKE_CXX_COMPILER={used}", f"-DCMAKE_CXX_FLAGS={library}", "-DHYPGEN_WERROR=ON")
    build = build_with_cmake(project, tmp_path / "build", *settings)
    assert signatures(build / "tiger", "tiger") == PINS["tiger"]
