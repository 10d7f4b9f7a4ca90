# SPDX-License-Identifier: Apache-2.0
"""Finding tools, the cache, and exporting projects; with a tiny runtime in place of hypgen's own."""

import hashlib
import json
import os
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from hypgen.cache_folder import cache_folder
from hypgen.runtime.builder import cache, exported_project, solver
from hypgen.runtime.builder import tools as toolchain
from hypgen.runtime.builder.errors import BuildError, ToolchainError

FILES = {
    "src/toy.hpp": "#pragma once\ninline int toy() { return 3; }\n",
    "src/main.cpp": '#include <tiny.hpp>\n#include "toy.hpp"\nint main() { return tiny(toy()); }\n',
    "CMakeLists.txt": "cmake_minimum_required(VERSION 3.20)\nproject(toy CXX)\nadd_subdirectory(hypgen)\n"
    "add_executable(toy src/main.cpp)\ntarget_link_libraries(toy hypgen_runtime)\n",
}
TINY = {
    "CMakeLists.txt": "cmake_minimum_required(VERSION 3.20)\nproject(tiny CXX)\n"
    "add_library(hypgen_runtime STATIC src/tiny.cpp)\n"
    "target_compile_features(hypgen_runtime PUBLIC cxx_std_17)\n"
    "target_include_directories(hypgen_runtime PUBLIC include)\n"
    "install(TARGETS hypgen_runtime DESTINATION lib COMPONENT hypgen_runtime)\n",
    "include/tiny.hpp": "#pragma once\nint tiny(int x);\n",
    "src/tiny.cpp": "#include <tiny.hpp>\nint tiny(int x) { return x + 4; }\n",
}


LIBRARY = {
    "src/toy.hpp": FILES["src/toy.hpp"],
    "src/library.cpp": '#include "toy.h"\n#include "toy.hpp"\nint hypgen_toy() { return toy(); }\n',
    "src/shared.cpp": '#include "toy.h"\nint hypgen_library() { return hypgen_toy(); }\n',
    "include/toy.h": "int hypgen_toy();\nint hypgen_library();\n",
    "cmake/toy-config.cmake.in": 'set(id "@HYPGEN_RUNTIME_ID@")\nset(cuda "@HYPGEN_CUDA@")\n',
    "README.md": "A toy.\n",
}
FOR_LIBRARIES = {
    "CMakeLists.txt": TINY["CMakeLists.txt"]
    + "install(FILES include/hypgen.h DESTINATION include COMPONENT hypgen_runtime)\n"
    + "install(FILES cmake/hypgen_runtime-config-version.cmake DESTINATION lib/cmake/hypgen_runtime\n"
    + "  COMPONENT hypgen_runtime)\n",
    "include/hypgen.h": "\n",
    "cmake/hypgen_runtime-config-version.cmake": "set(PACKAGE_VERSION 1)\n",
    "cmake/exported_symbols.map": "{ global: *hypgen_*; local: *; };\n",
    "LICENSE": "\n",
    "NOTICE": "\n",
}


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("HYPGEN_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def tiny(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A runtime that compiles in no time."""
    folder = tmp_path / "tiny-runtime"
    for name, text in TINY.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    monkeypatch.setattr(solver, "RUNTIME_FOLDER", folder)
    return folder


def make(files: dict[str, str] = FILES, **options: bool) -> tuple[Path, list[tuple[str, str]]]:
    steps: list[tuple[str, str]] = []
    model = files["src/toy.hpp"]
    path = solver.build_solver(
        files, "toy.pomdp", lambda s: steps.append((s.what, s.reason)), model=model, **options
    )
    return path, steps


@pytest.mark.cxx
def test_this_machine_has_the_tools() -> None:
    tools = toolchain.find_tools()
    assert tools.compiler.path.is_file()
    assert (tools.json_include / "nlohmann" / "json.hpp").is_file()
    assert (toolchain.find_eigen() / "Eigen" / "SparseCore").is_file()


def test_a_wrong_cxx_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(ToolchainError, match="CXX names 'no-such-compiler'") as error:
        toolchain.find_compiler()
    assert "unset CXX" in error.value.remedy


def test_without_any_compiler_the_remedy_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CXX", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ToolchainError, match=r"no C\+\+ compiler found") as error:
        toolchain.find_compiler()
    assert "apt-get install g++" in error.value.remedy


def test_without_ar_the_remedy_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ToolchainError, match="no ar found") as error:
        toolchain.find_archiver()
    assert "apt-get install binutils" in error.value.remedy


def test_an_old_cmake_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    old = tmp_path / "cmake"
    old.write_text("#!/bin/sh\necho cmake version 3.5.1\n")
    old.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    monkeypatch.setattr(toolchain, "MINIMUM_CMAKE", (99, 0))
    with pytest.raises(ToolchainError, match="no CMake 99.0 or newer found .too old"):
        toolchain.find_cmake()


def test_cache_folder_follows_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("HYPGEN_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder() == tmp_path / "xdg" / "hypgen"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cache_folder() == tmp_path / ".cache" / "hypgen"


def test_a_cache_that_cannot_be_written_names_the_variable(own_cache: Path) -> None:
    own_cache.write_text("a file in the way")
    with pytest.raises(ToolchainError, match="cannot be written") as error:
        cache.folder("solvers")
    assert "HYPGEN_CACHE_DIR" in error.value.remedy


def test_an_entry_whose_build_fails_leaves_nothing(own_cache: Path) -> None:
    def fail(to: Path) -> None:
        (to / "half").write_text("half")
        raise RuntimeError("stop")

    with pytest.raises(RuntimeError):
        cache.make("things", "abc", fail)
    assert cache.entry("things", "abc") is None
    assert [p.name for p in (own_cache / "things").iterdir()] == ["lock-a"]


def test_two_that_want_the_same_entry_build_it_once() -> None:
    built: list[int] = []
    started = threading.Barrier(2)

    def want() -> None:
        started.wait()
        cache.make("things", "abc", lambda to: built.append(1))

    threads = [threading.Thread(target=want) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert built == [1]


def test_the_cache_keeps_what_was_used_last(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache, "KEPT_ENTRIES", 2)
    for number, key in enumerate("abc"):
        os.utime(cache.make("things", key, lambda to: None), (number, number))
    cache.make("things", "d", lambda to: None)
    assert [key for key in "abcd" if cache.entry("things", key)] == ["c", "d"]


@pytest.mark.cxx
def test_a_solver_is_built_once_and_says_why_it_is_built_again(
    tiny: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CXXFLAGS", "-O1")
    path, steps = make()
    assert steps == [("hypgen's runtime", "first use"), ("toy", "new model")]
    assert subprocess.run([path]).returncode == 7
    assert make() == (path, [("toy", "")])
    changed = {**FILES, "src/toy.hpp": "#pragma once\ninline int toy() { return 5; }\n"}
    other, steps = make(changed)
    assert steps == [("toy", "the model or its settings changed")]
    assert subprocess.run([other]).returncode == 9
    _, steps = make({**changed, "README.md": "\n"})
    assert steps == [("toy", "hypgen generates other code for it")]
    assert make(again=True)[1] == [("toy", "as asked for")]
    assert subprocess.run([path]).returncode == 7
    monkeypatch.setenv("CXXFLAGS", "-DNOTHING")
    assert make()[1][1] == ("toy", "CXXFLAGS or LDFLAGS changed")
    monkeypatch.setenv("CXXFLAGS", "-O0 -DWORDS='1 2'")
    assert make()[1][1] == ("toy", "CXXFLAGS or LDFLAGS changed")
    flags = [json.loads(path.read_text()) for path in cache.folder("runtime").glob("*/files/flags.json")]
    levels = [[flag for flag in one if flag.startswith("-O")][-1] for one in flags]
    assert sorted(levels) == ["-O0", "-O1", "-O3"]
    (tiny / "src" / "tiny.cpp").write_text("#include <tiny.hpp>\nint tiny(int x) { return x; }\n")
    path, steps = make()
    assert steps == [("hypgen's runtime", "hypgen's runtime changed"), ("toy", "hypgen's runtime changed")]
    assert subprocess.run([path]).returncode == 3


@pytest.mark.cxx
def test_a_compiler_error_goes_to_a_log(tiny: Path) -> None:
    with pytest.raises(BuildError) as error:
        make({**FILES, "src/main.cpp": "int main() { return undeclared; }\n"})
    assert "undeclared" in error.value.log.read_text()
    assert "undeclared" not in str(error.value)


def test_a_compiler_that_cannot_compile_is_the_machines_fault(
    tiny: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = tmp_path / "broken-c++"
    broken.write_text("#!/bin/sh\n[ $1 = --version ] && echo broken 1.0 && exit 0\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("CXX", str(broken))
    with pytest.raises(ToolchainError, match="cannot build a C.{2}17 program"):
        make()


@pytest.fixture
def target(tiny: Path, tmp_path: Path) -> Iterator[Path]:
    yield tmp_path / "out" / "project"


def listing(folder: Path) -> set[str]:
    return {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}


@pytest.mark.cxx
def test_an_exported_project_builds_by_itself(target: Path) -> None:
    exported_project.export(FILES, target)
    assert {"src/main.cpp", "hypgen/src/tiny.cpp", "third_party/nlohmann/json.hpp"} <= listing(target)
    assert (target / "third_party" / "nlohmann" / "LICENSE").is_file()
    tools = toolchain.find_tools()
    for arguments in (["-B", "build"], ["--build", "build"]):
        subprocess.run([tools.cmake.path, *arguments], cwd=target, check=True, capture_output=True)
    assert subprocess.run([target / "build" / "toy"]).returncode == 7


def test_a_project_is_written_without_cmake(target: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(toolchain, "_candidates", lambda name: [])
    with pytest.raises(ToolchainError, match=r"no CMake [\d.]+ or newer found") as error:
        toolchain.find_cmake()
    assert error.value.remedy == "run `pip install cmake`"
    exported_project.export(FILES, target)
    assert (target / "CMakeLists.txt").is_file()


def test_exporting_again_touches_only_what_changed(target: Path) -> None:
    exported_project.export({**FILES, "src/old.hpp": "\n"}, target)
    (target / "results.json").write_text("the user's")
    before = (target / "src" / "main.cpp").stat().st_mtime_ns
    exported_project.export({**FILES, "src/toy.hpp": "#pragma once\n"}, target)
    assert (target / "src" / "toy.hpp").read_text() == "#pragma once\n"
    assert (target / "src" / "main.cpp").stat().st_mtime_ns == before
    assert (target / "results.json").read_text() == "the user's"
    assert not (target / "src" / "old.hpp").exists()
    assert not [
        name
        for name in listing(target.parent)
        if "/.hypgen-" in f"/{name}" and not name.endswith(exported_project.MARKER)
    ]


def test_what_the_user_has_changed_stays_and_the_new_one_is_written_beside(target: Path) -> None:
    main, beside = target / "src" / "main.cpp", target / "src" / "main.cpp.new"
    old = {**FILES, "src/old.hpp": "\n", "src/older.hpp": "\n"}
    assert exported_project.export(old, target) == []
    main.write_text("mine")
    (target / "src" / "old.hpp").write_text("mine too")
    (target / "src" / "notes.hpp").write_text("of another origin")
    new = {**FILES, "src/notes.hpp": "generated"}
    for _ in range(2):  # what is beside is hypgen's, and so are files with hypgen's text
        assert exported_project.export(new, target) == [
            exported_project.Kept(main, beside),
            exported_project.Kept(target / "src" / "notes.hpp", target / "src" / "notes.hpp.new"),
            *[exported_project.Kept(target / "src" / "old.hpp", None)] * ("src/old.hpp" in old),
        ]
        old = new
        assert main.read_text() == "mine" and beside.read_text() == FILES["src/main.cpp"]
        assert (target / "src" / "old.hpp").read_text() == "mine too"
        assert (target / "src" / "notes.hpp").read_text() == "of another origin"
        assert not (target / "src" / "older.hpp").exists()
    beside.write_text("merged")
    (again,) = (kept for kept in exported_project.export(new, target) if kept.path == main)
    assert again.new == target / "src" / "main.cpp.new.new" and beside.read_text() == "merged"
    main.write_text(FILES["src/main.cpp"])
    assert all(kept.path != main for kept in exported_project.export(new, target))
    assert not (target / "src" / "main.cpp.new.new").exists()


def test_a_kill_makes_no_file_of_hypgens_look_like_the_users(
    target: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def killed(*_: object) -> None:
        raise KeyboardInterrupt

    exported_project.export(FILES, target)
    new = {**FILES, "src/toy.hpp": "#pragma once\n", "src/main.cpp": "int main() {}\n"}
    with monkeypatch.context() as patch:
        moves = iter((os.replace, killed))
        patch.setattr(exported_project.os, "replace", lambda a, b: next(moves)(a, b))
        with pytest.raises(KeyboardInterrupt):
            exported_project.export(new, target)
    assert exported_project.export({**new, "src/toy.hpp": "\n"}, target) == []
    assert (target / "src" / "main.cpp").read_text() == "int main() {}\n"


def test_the_marker_is_the_same_for_the_same_project(target: Path) -> None:
    exported_project.export(FILES, target)
    other = target.with_name("other")
    exported_project.export(FILES, other)
    text = (target / exported_project.MARKER).read_text()
    assert text == (other / exported_project.MARKER).read_text()
    assert str(target) not in text and "before" not in json.loads(text)


def test_a_folder_of_someone_elses_is_refused(target: Path) -> None:
    target.mkdir(parents=True)
    exported_project.check_target(target)
    (target / "thesis.tex").write_text("years of work")
    with pytest.raises(ToolchainError, match="was not written by hypgen"):
        exported_project.export(FILES, target)
    assert listing(target) == {"thesis.tex"}


def test_a_marker_cannot_reach_outside_its_folder(target: Path) -> None:
    exported_project.export(FILES, target)
    victim = target.parent / "victim"
    victim.write_text("precious")
    digest = hashlib.sha256(b"precious").hexdigest()
    names = ["../victim", str(victim)]
    (target / exported_project.MARKER).write_text(json.dumps({"files": dict.fromkeys(names, digest)}))
    exported_project.export(FILES, target)
    assert victim.exists()


def test_a_failed_export_leaves_nothing(target: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(exported_project.shutil, "copytree", fail)
    with pytest.raises(ToolchainError, match="No space left on device"):
        exported_project.export(FILES, target)
    assert not target.exists() and not listing(target.parent)


@pytest.mark.cxx
def test_the_solver_is_exported_with_its_project(target: Path) -> None:
    path, _ = make()
    exported_project.export(FILES, target, path)
    assert subprocess.run([target / "bin" / "toy"]).returncode == 7


@pytest.mark.cxx
def test_a_library_comes_with_what_its_users_need(tiny: Path) -> None:
    for name, text in FOR_LIBRARIES.items():
        (tiny / name).parent.mkdir(exist_ok=True)
        (tiny / name).write_text(text)
    path, _ = make(LIBRARY)
    package = path.parent.parent
    runtime = {"lib/libhypgen_runtime.a", "lib/cmake/hypgen_runtime/hypgen_runtime-config-version.cmake"}
    config, version = (f"lib/cmake/toy/toy-config{end}.cmake" for end in ("", "-version"))
    headers = {"include/toy.h", "include/hypgen.h"}
    pages = {"README.md", "LICENSE.hypgen", "NOTICE.hypgen"}
    libraries = {"lib/libtoy.so", "lib/libtoy.a", *runtime}
    assert listing(package) == {*libraries, config, version, *headers, *pages}
    assert (package / version).read_text() == "set(PACKAGE_VERSION 1)\n"
    assert (package / config).read_text() == f'set(id "{solver.runtime_id()}")\nset(cuda "OFF")\n'
    archived = subprocess.run(["ar", "t", path.with_suffix(".a")], capture_output=True, text=True)
    assert archived.stdout == "library.cpp.o\n", "several models in a program have no hypgen_library_model"
