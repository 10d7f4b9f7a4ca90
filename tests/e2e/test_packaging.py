# SPDX-License-Identifier: Apache-2.0
"""What others get: the source distribution, the wheel that is built from it, and exported projects."""

import email
import json
import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from hypgen import __version__
from hypgen.cli import main
from hypgen.cli.exit_codes import Exit

ROOT = Path(__file__).parents[2]
LICENCES = ("LICENSE", "NOTICE")
NOT_COPIED = shutil.ignore_patterns(".git", ".venv", ".*_cache", "__pycache__", "build", "dist", "*.egg-info")


def build(kind: str, source: Path) -> Path:
    """Build a distribution without an environment of its own, which would need a network."""
    code = f"from setuptools import build_meta; print(build_meta.build_{kind}('dist'))"
    done = subprocess.run([sys.executable, "-c", code], cwd=source, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return source / "dist" / done.stdout.splitlines()[-1]


@pytest.fixture(scope="module")
def sdist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source distribution, unpacked."""
    pytest.importorskip("setuptools", minversion="77")
    folder = tmp_path_factory.mktemp("packaging")
    shutil.copytree(ROOT, folder / "checkout", symlinks=True, ignore=NOT_COPIED)
    with tarfile.open(build("sdist", folder / "checkout")) as archive:
        archive.extraction_filter = getattr(tarfile, "data_filter", None)  # Python 3.11.3 has none
        archive.extractall(folder)
    return folder / f"hypgen-{__version__}"


@pytest.fixture(scope="module")
def wheel(sdist: Path) -> Path:
    """The wheel that is built from the source distribution, unpacked."""
    folder = sdist.parent / "wheel"
    with zipfile.ZipFile(build("wheel", sdist)) as archive:
        archive.extractall(folder)
    return folder


def test_the_source_distribution_is_the_checkout(sdist: Path) -> None:
    for name in (*LICENCES, "CITATION.cff", "SECURITY.md", "CHANGELOG.md", "README.md", ".ci/style"):
        assert (sdist / name).read_bytes() == (ROOT / name).read_bytes(), name
    assert (sdist / "tests" / "golden" / "tiger" / "CMakeLists.txt").is_file()


def test_the_wheel_says_what_it_is_and_under_which_licence(wheel: Path) -> None:
    information = wheel / f"hypgen-{__version__}.dist-info"
    metadata = email.message_from_string((information / "METADATA").read_text(encoding="utf-8"))
    assert metadata["Version"] == __version__
    assert metadata["License-Expression"] == "Apache-2.0"
    assert metadata.get_all("License-File") == list(LICENCES)
    for name in LICENCES:
        assert (information / "licenses" / name).read_bytes() == (ROOT / name).read_bytes()


def test_the_wheel_works_by_itself(wheel: Path, tmp_path: Path) -> None:
    model, project = ROOT / "examples" / "tiger.pomdp", tmp_path / "project"
    arguments = ["compile", str(model), "-o", str(project), "--emit-only"]
    code = f"from hypgen.cli.main import main; main({arguments})"
    done = subprocess.run(
        [sys.executable, "-P", "-c", code],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(wheel)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == Exit.OK, done.stderr
    runtime = (
        "include/hypgen.hpp",
        "include/hypgen/model/model.hpp",
        "src/search/tree.cpp",
        "cmake/Install.cmake",
    )
    for name in ("CMakeLists.txt", *(f"hypgen/{name}" for name in runtime)):
        assert (project / name).is_file(), name


def test_an_exported_project_has_the_licence_of_what_it_takes_along(tmp_path: Path) -> None:
    project = tmp_path / "tiger"
    model = str(ROOT / "examples" / "tiger.pomdp")
    assert main.run(["compile", model, "-o", str(project), "--emit-only"]) == Exit.OK
    for name in LICENCES:
        assert (project / "hypgen" / name).read_bytes() == (ROOT / name).read_bytes()
        assert not (project / "hypgen" / name).is_symlink()
    page = (project / "README.md").read_text(encoding="utf-8")
    assert "belong to the owner of the model" in page and "hypgen/LICENSE" in page
    marker = json.loads((project / ".hypgen-project").read_text(encoding="utf-8"))
    assert marker["hypgen"] == __version__ and "hypgen/LICENSE" in marker["files"]


def test_the_version_stands_in_one_place() -> None:
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode != 0:
        pytest.skip("not a git checkout")
    sources = {".py", ".toml", ".cff", ".hpp", ".cpp", ".cu", ".cuh", ".j2", ".txt", ".yml"}
    found = [
        name
        for name in listed.stdout.split("\0")
        if (Path(name).suffix in sources or name.startswith("tests/golden/"))
        and __version__ in (ROOT / name).read_text(encoding="utf-8")
    ]
    assert found == ["src/hypgen/__init__.py"]
