# SPDX-License-Identifier: Apache-2.0
"""Turns a generated project into a solver: hypgen's runtime once, then the model, for a GPU too if asked for.

Both results are cached by content, so a solver is compiled again only when something that it is made
of has changed; ``Step.reason`` says what.
"""

from __future__ import annotations

import hashlib
import json
import os
import shlex
import shutil
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from hypgen.runtime.builder import cache
from hypgen.runtime.builder.commands import call
from hypgen.runtime.builder.compile_flags import lane_flags, nvcc_flags
from hypgen.runtime.builder.cuda_tools import CudaBuild, nvcc_command
from hypgen.runtime.builder.preflight import require_current_folder, require_room
from hypgen.runtime.builder.process_group import ProcessGroup
from hypgen.runtime.builder.tools import (
    Tools,
    cpu_features,
    find_archiver,
    find_eigen,
    find_json,
    find_tools,
    user_flags,
    widest_lanes,
)

RUNTIME_FOLDER = Path(__file__).parent.parent
RUNTIME_PARTS = ("CMakeLists.txt", "LICENSE", "NOTICE", "cmake", "include", "src")
EXACT_MAIN = "src/exact.cpp"  # a project with it is the exact solver's program
VERIFY_MAIN = "src/verify.cpp"  # a project with it is the program that checks the model's code
MAIN = "src/main.cpp"  # a project with it is a solver; one with none of the three is libraries
LANES = "src/lanes.cpp"  # compiled for this machine's processor alone
SHARED = "src/shared.cpp"  # what only the shared library has
CHANGES = {
    "model": "the model or its settings changed",
    "code": "hypgen generates other code for it",
    "runtime": "hypgen's runtime changed",
    "compiler": "another compiler",
    "flags": "CXXFLAGS or LDFLAGS changed",
    "cpu": "another CPU",
    "target": "another target, GPU architecture or nvcc",
}


@dataclass(frozen=True)
class Step:
    """Something about to be built, and why; ``reason`` is empty where the cache has it."""

    what: str
    reason: str


@dataclass(frozen=True)
class Library:
    """A target of the runtime's CMake project; ``eigen``: headers that it and its users take too, if any."""

    target: str
    what: str
    eigen: Path | None = None


Report = Callable[[Step], None]


def build_solver(
    files: Mapping[str, str],
    origin: str,
    report: Report,
    *,
    model: str = "",
    cuda: CudaBuild | None = None,
    again: bool = False,
) -> Path:
    """Return the executable or library of a generated project, built unless the cache has it.

    ``origin`` (the model's path) and ``model`` (a hash of its text) decide nothing but the reason that is
    reported: measured against the origin's last build, and telling its text from its generated code.
    ``cuda``, if given, compiles the model for GPUs too. ``again`` builds the model's part in any case.
    """
    require_current_folder()
    tools = find_tools()
    name = solver_name(files)
    base = _components(tools)
    code = cache.digest(*(part for item in sorted(files.items()) for part in item))
    components = {"model": model, "code": code, **base, "target": _target(cuda)}
    key = cache.digest(code, *base.values(), components["target"])
    record = cache.digest(origin, name)
    found = None if again else cache.entry("solvers", key)
    reason = "as asked for" if again else _reason(components, cache.read_record("records", record))
    step = Step(f"{Path(name).name}{_suffix(cuda)}", "" if found else reason)
    if found is None:
        require_room()  # what is missing is said before anything is compiled
        libraries = _libraries(files)
        folders = [_library(library, tools, base, report) for library in libraries]
        report(step)
        found = cache.make(
            "solvers",
            key,
            lambda to: _compile(files, tools, libraries, folders, cuda, to / name),
            again=again,
        )
    else:
        report(step)
    cache.write_record("records", record, components)
    return found / name


def solver_name(files: Mapping[str, str]) -> str:
    """Return what is built of a project: a program, called after its model's header, or lib/lib*.so."""
    model = next(Path(path).stem for path in sorted(files) if path.endswith(".hpp"))
    if _is_library(files):
        return f"lib/lib{model}.so"
    if VERIFY_MAIN in files:
        return f"{model}_verify"
    return f"{model}_exact" if EXACT_MAIN in files else model


def runtime_id() -> str:
    """Return what tells the runtime and the header that it takes from those of other versions.

    CMake computes the same in ``runtime/cmake/RuntimeId.cmake``, for those who build without hypgen.
    """
    lines = [_sha256(find_json() / "nlohmann" / "json.hpp")]
    lines += [f"{_sha256(path)} {name}" for name, path in sorted(runtime_files().items())]
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:12]


def runtime_files() -> dict[str, Path]:
    """Return the runtime's sources and licence, without READMEs, by their path below the runtime's folder."""
    paths = (
        path
        for part in RUNTIME_PARTS
        for path in (RUNTIME_FOLDER / part, *(RUNTIME_FOLDER / part).rglob("*"))
    )
    files = (path for path in sorted(paths) if path.is_file() and path.suffix != ".md")
    return {path.relative_to(RUNTIME_FOLDER).as_posix(): path for path in files}


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _components(tools: Tools) -> dict[str, str]:
    """Return what a build depends on besides the model, each as a short text."""
    return {
        "runtime": runtime_id(),
        "compiler": f"{tools.compiler.version} ({tools.compiler.path})",
        "flags": " ".join([*user_flags("CXXFLAGS"), *user_flags("LDFLAGS")]),
        "cpu": cpu_features(),
    }


def _target(cuda: CudaBuild | None) -> str:
    """Return all that the GPU's part of a build depends on."""
    if cuda is None:
        return "cpu"
    read_by_nvcc = ("NVCC_CCBIN", "NVCC_PREPEND_FLAGS", "NVCC_APPEND_FLAGS")
    settings = " ".join(os.environ.get(name, "") for name in read_by_nvcc)
    return f"{cuda.architectures} {cuda.nvcc.version} ({cuda.nvcc.path}) {settings}"


def _suffix(cuda: CudaBuild | None) -> str:
    """Return what to say of a build's target: nothing of the CPU alone."""
    return f" for CPU and {', '.join(f'sm_{a}' for a in cuda.architectures)}" if cuda else ""


def _reason(components: Mapping[str, str], before: Mapping[str, str]) -> str:
    """Say in words why the cache does not have a build."""
    if not before:
        return "new model" if "model" in components else "first use"
    changed = [name for name, value in components.items() if before.get(name) != value]
    if "model" in changed:  # then its code is another one as a matter of course
        changed = [name for name in changed if name != "code"]
    return ", ".join(CHANGES[name] for name in changed) or "no longer whole in the cache"


def _libraries(files: Mapping[str, str]) -> list[Library]:
    """Return what a project is linked with, users of others first."""
    runtime = Library("hypgen_runtime", "hypgen's runtime")
    if VERIFY_MAIN in files:
        return [Library("hypgen_verify", "hypgen's checks"), runtime]
    if EXACT_MAIN in files:
        return [Library("hypgen_exact", "hypgen's exact solver", find_eigen()), runtime]
    return [runtime]


def _library(library: Library, tools: Tools, components: dict[str, str], report: Report) -> Path:
    """Return the folder with a library and the flags that it was compiled with."""
    key = cache.digest(library.target, str(library.eigen), *components.values())
    found = cache.entry("runtime", key)
    if found is None:
        require_room()
        report(Step(library.what, _reason(components, cache.read_record("records", library.target))))
        found = cache.make("runtime", key, lambda to: _build_library(library, tools, to))
        cache.write_record("records", library.target, components)
    return found


def _build_library(library: Library, tools: Tools, to: Path) -> None:
    """Build and install a library with the runtime's own CMake project, and keep the compiler flags."""
    build = to / "build"
    generator = ["-G", "Ninja", f"-DCMAKE_MAKE_PROGRAM={tools.ninja.path}"] if tools.ninja else []
    settings = {
        "CMAKE_BUILD_TYPE": "Release",
        # CMake puts CXXFLAGS before its own -O3: after it they hold too.
        "CMAKE_CXX_FLAGS_RELEASE": shlex.join(["-O3", "-DNDEBUG", *user_flags("CXXFLAGS")]),
        "CMAKE_CXX_COMPILER": tools.compiler.path,
        "CMAKE_EXPORT_COMPILE_COMMANDS": "ON",
        "HYPGEN_JSON_INCLUDE_DIR": tools.json_include,
        "HYPGEN_RUNTIME_ID": runtime_id(),
        "HYPGEN_WERROR": "OFF",  # another compiler may warn about more
    }
    if library.eigen is not None:
        settings["HYPGEN_EIGEN_INCLUDE_DIR"] = library.eigen
    definitions = [f"-D{name}={value}" for name, value in settings.items()]
    configure = [str(tools.cmake.path), "-S", str(RUNTIME_FOLDER), "-B", str(build), *generator, *definitions]
    make = [str(tools.cmake.path), "--build", str(build), "--target", library.target]
    install = [str(tools.cmake.path), "--install", str(build), "--prefix", str(to)]
    with ProcessGroup() as group:
        for command in (configure, make, [*install, "--component", library.target]):
            call(group, command, library.what, tools)
    commands = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    (to / "flags.json").write_text(json.dumps(_shared_flags(commands[0]["command"])), encoding="utf-8")
    shutil.rmtree(build)


def _archive(library: Library, folder: Path) -> Path:
    return next((folder / "lib").glob(f"lib{library.target}*.a"))


def _shared_flags(command: str) -> list[str]:
    """Return the flags of a compile command that the model's code must be compiled with too.

    Templates of the runtime are instantiated on both sides, so language, optimisation and floating-point
    flags have to agree. Paths are left out: the build may outlive the folders that it was made from.
    """
    kept, words = [], iter(shlex.split(command)[1:])
    for word in words:
        if word in ("-o", "-isystem", "-include", "-I"):
            next(words)
        elif word.startswith("-") and word != "-c" and not word.startswith(("-I", "-W", "-isystem")):
            kept.append(word)
    return kept


def _compile(
    files: Mapping[str, str],
    tools: Tools,
    libraries: Sequence[Library],
    folders: Sequence[Path],
    cuda: CudaBuild | None,
    executable: Path,
) -> None:
    """Compile the model's translation units, side by side, and link them with the libraries."""
    project = executable.parent / "project"
    for name, text in files.items():
        path = project / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    flags = json.loads((folders[-1] / "flags.json").read_text(encoding="utf-8"))
    folders_of_headers = (project / "src", project / "include", RUNTIME_FOLDER / "include")
    include = [*(f"-I{folder}" for folder in folders_of_headers), "-isystem", str(tools.json_include)]
    include += [word for library in libraries if library.eigen for word in ("-isystem", str(library.eigen))]
    version = f"-DHYPGEN_RUNTIME_ID=runtime_{runtime_id()}"
    compiler = [str(tools.compiler.path), *flags, version, *include]
    units = {name: compiler for name in sorted(files) if name.endswith(".cpp")}
    kind = widest_lanes(tools.compiler) if LANES in units else ""
    units.pop(LANES, None)
    if kind:
        units = {name: [*command, f"-DHYPGEN_HAS_{kind}"] for name, command in units.items()}
        units[LANES] = [*compiler, *lane_flags()[kind]]
    archives = [str(_archive(of, at)) for of, at in zip(libraries, folders, strict=True)]
    link = [*archives, "-pthread"]
    if cuda is not None:
        units = {name: [*command, "-DHYPGEN_CUDA"] for name, command in units.items()}
        device = [*nvcc_command(cuda, nvcc_flags(), tools.compiler.path, flags), *include]
        units |= {name: device for name in sorted(files) if name.endswith(".cu")}
        link += [f"-L{cuda.nvcc.library}", "-lcudart_static", "-ldl", "-lrt"]

    link += user_flags("LDFLAGS")
    if _is_library(files):
        symbols = RUNTIME_FOLDER / "cmake" / "exported_symbols.map"
        link += ["-shared", f"-Wl,--version-script={symbols}", f"-Wl,-soname,{executable.name}"]

    # Left first, the group ends the compilers that the pool's threads wait for.
    with ThreadPoolExecutor() as pool, ProcessGroup() as group:

        def compile_unit(name: str) -> str:
            unit = str(project / f"{name}.o")
            call(group, [*units[name], "-c", str(project / name), "-o", unit], "the model", tools, cuda)
            return unit

        objects = list(pool.map(compile_unit, units))
        words = [str(tools.compiler.path), *flags, *objects, *link, "-o", str(executable)]
        call(group, words, "the model", tools)
        if _is_library(files):
            static = [unit for unit in objects if unit != str(project / f"{SHARED}.o")]
            archive = executable.with_suffix(".a")
            call(group, [str(find_archiver()), "rcs", str(archive), *static], "the model", tools)
    if _is_library(files):
        _pack(project, files, folders[-1], cuda, executable.parent.parent)
    shutil.rmtree(project)


def _is_library(files: Mapping[str, str]) -> bool:
    return not {MAIN, EXACT_MAIN, VERIFY_MAIN} & files.keys()


def _pack(project: Path, files: Mapping[str, str], runtime: Path, cuda: CudaBuild | None, to: Path) -> None:
    """Put beside libraries what their users need: the runtime, headers, a page, and licences."""
    for folder in (project / "include", runtime / "include", runtime / "lib"):
        shutil.copytree(folder, to / folder.name, dirs_exist_ok=True)
    shutil.copy(project / "README.md", to / "README.md")
    version = runtime / "lib" / "cmake" / "hypgen_runtime" / "hypgen_runtime-config-version.cmake"
    for name in (Path(name) for name in files if name.endswith(".cmake.in")):
        model = name.name.removesuffix("-config.cmake.in")
        folder = to / "lib" / "cmake" / model
        folder.mkdir(parents=True)
        text = files[str(name)].replace("@HYPGEN_RUNTIME_ID@", runtime_id())
        text = text.replace("@HYPGEN_CUDA@", "ON" if cuda else "OFF")
        (folder / name.stem).write_text(text, encoding="utf-8")
        shutil.copy(version, folder / f"{model}-config-version.cmake")
    for licence in ("LICENSE", "NOTICE"):
        shutil.copy(RUNTIME_FOLDER / licence, to / f"{licence}.hypgen")
