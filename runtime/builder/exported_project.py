# SPDX-License-Identifier: Apache-2.0
"""Writes what was generated to a folder of the user's: a project that builds by itself, or a library."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from hypgen import __version__
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.solver import runtime_files, solver_name
from hypgen.runtime.builder.tools import find_json
from hypgen.whole_files import sync

# Names hypgen's version and the files that it wrote, with their digests: only those that are still the same
# are ever replaced.
MARKER = ".hypgen-project"
TARGET_FILE = "target.cmake"
SYSTEM_LICENCE = Path("/usr/share/doc/nlohmann-json3-dev/copyright")


@dataclass(frozen=True)
class Kept:
    """A file that is not what hypgen wrote, and so was left alone; ``new`` is hypgen's, if there is one."""

    path: Path
    new: Path | None


def export(
    files: Mapping[str, str],
    directory: Path,
    executable: Path | None = None,
    architectures: tuple[int, ...] = (),
    project: str = "",
) -> list[Kept]:
    """Write the project, the runtime's sources and the third-party header to ``directory``.

    With ``architectures``, its own build compiles for those GPUs unless told otherwise. ``project`` is the
    folder of the project, where the files are more than that. Returns what the user has changed and stays.
    """
    target = {str(PurePosixPath(project, name)): text for name, text in _target(architectures).items()}
    return _replace(directory, lambda stage: _stage({**files, **target}, executable, stage, project))


def export_library(library: Path, directory: Path) -> tuple[Path, list[Kept]]:
    """Copy a library with its headers and pages to ``directory``; return its path there, and what stays."""
    package = library.parent.parent

    def stage(to: Path) -> None:
        for path in sorted(package.rglob("*")):
            if path.is_file():
                _copy(path, _parent(to / path.relative_to(package)))
        licence = _json_licence()
        if licence is not None:
            shutil.copyfile(licence, to / "LICENSE.nlohmann-json")

    kept = _replace(directory, stage)
    return directory / library.relative_to(package), kept


def _replace(directory: Path, make: Callable[[Path], None]) -> list[Kept]:
    """Put what ``make`` writes to a folder into the place of what hypgen wrote before; return what stays.

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
            make(stage)
            new = {name: _digest(stage / name) for name in _names(stage)}
            if directory.exists():
                return _merge(stage, directory, old, new)
            _mark(stage, new)
            for name in (*new, MARKER):
                sync(stage / name)
            stage.rename(directory)
            sync(directory.parent)
            return []
    except OSError as error:
        raise ToolchainError(
            f"cannot write '{directory}': {error.strerror}", "name another folder with -o"
        ) from error


def _merge(stage: Path, directory: Path, old: Mapping[str, set[str]], new: Mapping[str, str]) -> list[Kept]:
    """Move files into the folder, each beside what is not hypgen's there; return what stays."""
    kept, places, written = [], {}, dict(new)
    for name, digest in new.items():
        place = name
        while not _may_go(directory / place, {*old.get(place, ()), digest}):
            place += ".new"
        places[name] = place
        written[place] = digest
        if place != name:
            kept.append(Kept(directory / name, directory / place))
    _mark(stage, written, old)  # a kill from here on must not make hypgen's files look like the user's
    _move(stage / MARKER, directory / MARKER)
    for name, place in places.items():
        if not (directory / place).exists() or _digest(directory / place) != new[name]:
            _move(stage / name, directory / place)
    for name in sorted(old.keys() - written.keys()):
        path = directory / name
        if _may_go(path, old[name]):
            path.unlink(missing_ok=True)
        else:
            kept.append(Kept(path, None))
    for folder in sorted({(directory / place).parent for place in places.values()}):
        sync(folder)
    _mark(stage, written)
    _move(stage / MARKER, directory / MARKER)
    return kept


def _may_go(path: Path, digests: set[str]) -> bool:
    """Return whether a file is absent, or one that hypgen wrote and nobody has changed."""
    if not path.exists() or path.is_symlink():
        return not path.is_symlink()
    return path.is_dir() or _digest(path) in digests


def check_target(directory: Path) -> dict[str, set[str]]:
    """Return the files that hypgen wrote to ``directory`` before, with the digests that are hypgen's.

    A folder that is not hypgen's is refused.
    """
    marker = directory / MARKER
    if marker.is_file():
        try:
            listing = json.loads(marker.read_text(encoding="utf-8"))
            found = {str(name): {str(digest)} for name, digest in listing["files"].items()}
            for name, digests in listing.get("before", {}).items():
                found.setdefault(str(name), set()).update(map(str, digests))
        except (ValueError, KeyError, TypeError, AttributeError):
            return {}
        # The folder may come from someone else: its list must not reach outside it.
        return {n: d for n, d in found.items() if not n.startswith("/") and ".." not in n.split("/")}
    if directory.exists() and (not directory.is_dir() or any(directory.iterdir())):
        raise ToolchainError(
            f"'{directory}' exists and was not written by hypgen", "name a new or an empty folder with -o"
        )
    return {}


def _stage(files: Mapping[str, str], executable: Path | None, stage: Path, project: str) -> None:
    """Write all files to ``stage``. ``project`` is a folder in it."""
    for name, text in files.items():
        _parent(stage / name).write_text(text, encoding="utf-8")
    for name, path in runtime_files().items():
        shutil.copyfile(path, _parent(stage / project / "hypgen" / name))
    third_party = stage / project / "third_party" / "nlohmann"
    shutil.copytree(find_json() / "nlohmann", third_party)
    licence = _json_licence()
    if licence is not None:
        shutil.copyfile(licence, third_party / "LICENSE")
    if executable is not None:
        _copy(executable, _parent(stage / "bin" / solver_name(files)))


def _mark(directory: Path, files: Mapping[str, str], before: Mapping[str, set[str]] | None = None) -> None:
    """Write the marker: the digest of each file, and while files are moved, those of the files before."""
    listing: dict[str, object] = {"hypgen": __version__, "files": dict(sorted(files.items()))}
    if before is not None:
        listing["before"] = {name: sorted(digests) for name, digests in sorted(before.items())}
    (directory / MARKER).write_text(json.dumps(listing, indent=1) + "\n", encoding="utf-8")


def _names(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def _digest(path: Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


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
    """Put a file into the place of another, once a crash of the machine cannot lose it."""
    sync(source)
    os.replace(source, _parent(target))


def _json_licence() -> Path | None:
    """Return the licence text of nlohmann-json (without one, its headers still state it)."""
    try:
        listed = importlib.metadata.files("nlohmann-json") or []
    except importlib.metadata.PackageNotFoundError:
        listed = []
    found = [Path(str(file.locate())) for file in listed if file.name.startswith("LICENSE")]
    return next((path for path in (*found, SYSTEM_LICENCE) if path.is_file()), None)
