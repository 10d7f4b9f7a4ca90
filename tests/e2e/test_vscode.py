# SPDX-License-Identifier: Apache-2.0
"""The extension of VS Code: npm's packages as locked, its own tests against the server, and its package."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
NPM = shutil.which("npm")
pytestmark = [pytest.mark.editor, pytest.mark.skipif(NPM is None, reason="needs npm")]


@pytest.fixture(scope="module")
def extension(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the extension with its packages; a clone stays as it is."""
    root = tmp_path_factory.mktemp("clone")
    made = root / "editors" / "vscode"
    left_out = shutil.ignore_patterns("node_modules", "*.vsix")
    shutil.copytree(ROOT / "editors" / "vscode", made, ignore=left_out)
    (root / "examples").mkdir()
    shutil.copy(ROOT / "examples" / "tiger.pomdp", root / "examples")
    npm(made, "ci", "--ignore-scripts", "--no-audit", "--no-fund")
    return made


def npm(folder: Path, *arguments: str) -> str:
    assert NPM is not None
    environment = os.environ | {"HYPGEN_LSP": str(Path(sys.executable).with_name("hypgen"))}
    command = [NPM, *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_its_own_tests_pass(extension: Path) -> None:
    said = npm(extension, "test")
    assert "# fail 0\n" in said and "# skipped 0\n" in said


def test_its_package_holds_what_it_runs_and_no_tests(extension: Path) -> None:
    npm(extension, "run", "package")
    (package,) = extension.glob("*.vsix")
    with zipfile.ZipFile(package) as content:
        names = {name.removeprefix("extension/") for name in content.namelist()}
    assert {"client.js", "icon.png", "syntaxes/pomdp.tmLanguage.json", "snippets/pomdp.json"} <= names
    assert "node_modules/vscode-languageclient/package.json" in names
    assert not [name for name in names if name.startswith("tests/")]
