# SPDX-License-Identifier: Apache-2.0
"""Writes what was generated to a folder of the user's: a project that builds by itself, or a library."""

from __future__ import annotations

import filecmp
import importlib.metadata
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path, PurePosixPath

from hypgen import __version__
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.solver import runtime_files, runtime_id, solver_name
from hypgen.runtime.builder.tools import find_json

# Names hypgen's version and the files that it wrote, so that only those are ever replaced.
MARKER = ".hypgen-project"
TARGET_FILE = "target.cmake"
ID_FILE = "id.cmake"  # in the runtime's folder: tells its version
SYSTEM_LICENCE = Path("/usr/share/doc/nlohmann-json3-dev/copyright")


def export(
    files: Mapping[str, str],
    directory: Path,
    executable: Path | None = None,
    architectures: tuple[int, ...] = (),
    project: str = "",
) -> None:
    """Write the project, the runtime's sources and the third-party header to ``directory``.

    With ``architectures``, its own build compiles for those GPUs unless told otherwise. ``project`` is the
    folder of the project, where the files are more than that.
    """
    target = {str(PurePosixPath(project, name)): text for name, text in _target(architectures).items()}
    _replace(directory, lambda stage: _stage({**files, **target}, executable, stage, project))


def export_library(library: Path, directory: Path) -> Path:
    """Copy a library with its headers and pages to ``directory``; return its path there."""
    package = library.parent.parent

    def stage(to: Path) -> list[str]:
        for path in sorted(package.rglob("*")):
            if path.is_file():
                _copy(path, _parent(to / path.relative_to(package)))
        licence = _json_licence()
        if licence is not None:
            shutil.copyfile(licence, to / "LICENSE.nlohmann-json")
        return _mark(to)

    _replace(directory, stage)
    return directory / library.relative_to(package)


def _replace(directory: Path, make: Callable[[Path], list[str]]) -> None:
    """Put what ``make`` writes to a folder, and lists, into the place of what hypgen wrote before.

    Everything is staged first and then moved into place, so that a failure leaves no half-written
    project. Unchanged files keep their times (a CMake build in the folder stays incremental), files of
    the user's are left alone, and a folder that holds only other things is refused.
    """
    try:
        old = check_target(directory)
        directory.parent.mkdir(parents=True, exist_ok=True)
        inside = directory if directory.exists() else directory.parent
        with tempfile.TemporaryDirectory(prefix=".hypgen-", dir=inside) as temporary:
            stage = Path(temporary) / "project"
            written = make(stage)
            if not directory.exists():
                stage.rename(directory)
                return
            for name in written:
                _move(stage / name, directory / name)
            for name in set(old) - set(written):
                (directory / name).unlink(missing_ok=True)
    except OSError as error:
        raise ToolchainError(
            f"cannot write '{directory}': {error.strerror}", "name another folder with -o"
        ) from error


def check_target(directory: Path) -> list[str]:
    """Return the files that hypgen wrote to ``directory`` before; refuse a folder that is not hypgen's."""
    marker = directory / MARKER
    if marker.is_file():
        try:
            names = [str(name) for name in json.loads(marker.read_text(encoding="utf-8"))["files"]]
            # The folder may come from someone else: its list must not reach outside it.
            return [name for name in names if not name.startswith("/") and ".." not in name.split("/")]
        except (ValueError, KeyError, TypeError):
            return []
    if directory.exists() and (not directory.is_dir() or any(directory.iterdir())):
        raise ToolchainError(
            f"'{directory}' exists and was not written by hypgen", "name a new or an empty folder with -o"
        )
    return []


def _stage(files: Mapping[str, str], executable: Path | None, stage: Path, project: str) -> list[str]:
    """Write all files to ``stage``; return their names, the marker last. ``project`` is a folder in it."""
    for name, text in files.items():
        _parent(stage / name).write_text(text, encoding="utf-8")
    for name, path in runtime_files().items():
        shutil.copyfile(path, _parent(stage / project / "hypgen" / name))
    (stage / project / "hypgen" / ID_FILE).write_text(
        f'set(HYPGEN_RUNTIME_ID "{runtime_id()}")\n', encoding="utf-8"
    )
    third_party = stage / project / "third_party" / "nlohmann"
    shutil.copytree(find_json() / "nlohmann", third_party)
    licence = _json_licence()
    if licence is not None:
        shutil.copyfile(licence, third_party / "LICENSE")
    if executable is not None:
        _copy(executable, _parent(stage / "bin" / solver_name(files)))
    return _mark(stage)


def _mark(stage: Path) -> list[str]:
    """Write the marker; return the names of all files, the marker last."""
    written = sorted(path.relative_to(stage).as_posix() for path in stage.rglob("*") if path.is_file())
    listing = json.dumps({"hypgen": __version__, "files": [*written, MARKER]}, indent=1)
    (stage / MARKER).write_text(listing + "\n", encoding="utf-8")
    return [*written, MARKER]


def _target(architectures: tuple[int, ...]) -> dict[str, str]:
    """Return the file that the project's CMakeLists.txt takes its defaults from; none for the CPU alone."""
    if not architectures:
        return {}
    numbers = ";".join(map(str, architectures))
    lines = [
        'set(HYPGEN_CUDA ON CACHE BOOL "Compile for GPUs too")',
        f'set(HYPGEN_CUDA_ARCHITECTURES "{numbers}" CACHE STRING "GPUs to compile for, ascending")',
    ]
    return {TARGET_FILE: "".join(f"{line}\n" for line in lines)}


def _parent(path: Path) -> Path:
    """Return ``path`` with the folder that it is to stand in made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def _copy(source: Path, target: Path) -> None:
    """Copy a file out of the cache. Others may read and run the copy if the umask lets them."""
    shutil.copyfile(source, target)
    if os.access(source, os.X_OK):
        mode = target.stat().st_mode
        target.chmod(mode | (mode & 0o444) >> 2)


def _move(source: Path, target: Path) -> None:
    """Put ``source`` in the place of ``target`` unless they are the same."""
    if target.is_file() and filecmp.cmp(source, target, shallow=False):
        return
    os.replace(source, _parent(target))


def _json_licence() -> Path | None:
    """Return the licence text of nlohmann-json (without one, its headers still state it)."""
    try:
        listed = importlib.metadata.files("nlohmann-json") or []
    except importlib.metadata.PackageNotFoundError:
        listed = []
    found = [Path(str(file.locate())) for file in listed if file.name.startswith("LICENSE")]
    return next((path for path in (*found, SYSTEM_LICENCE) if path.is_file()), None)
