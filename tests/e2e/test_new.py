# SPDX-License-Identifier: Apache-2.0
"""``hypgen new``: what it writes is a formatted model that compiles, and it never overwrites."""

from pathlib import Path

import pytest

from hypgen.cli import main
from hypgen.cli.commands.new import TEMPLATES


@pytest.mark.cxx
@pytest.mark.parametrize("template", TEMPLATES)
def test_a_template_checks_is_formatted_and_compiles(
    template: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "new" / "folder"
    assert main.run(["new", "my_model", "--template", template, "-o", str(folder)]) == 0
    path = folder / "my_model.pomdp"
    output = capsys.readouterr()
    assert output.out == f"{path}\n" and f"hypgen sim {path}" in output.err
    assert "\nmodel MyModel\n" in path.read_text()
    assert main.run(["check", str(path), "--strict"]) == 0, capsys.readouterr().err
    assert main.run(["fmt", "--check", str(path)]) == 0
    assert main.run(["sim", str(path), "--policy", "default"]) == 0
    assert main.run(["compile", str(path)]) == 0


@pytest.mark.parametrize(
    ("name", "file", "model"),
    [
        ("Tiger2", "tiger2.pomdp", "Tiger2"),
        ("RockSample", "rock_sample.pomdp", "RockSample"),
        ("two-robots.pomdp", "two_robots.pomdp", "TwoRobots"),
    ],
)
def test_names(name: str, file: str, model: str, tmp_path: Path) -> None:
    assert main.run(["new", name, "-o", str(tmp_path)]) == 0
    assert f"\nmodel {model}\n" in (tmp_path / file).read_text()


def test_nothing_is_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.pomdp"
    path.write_text("mine")
    assert main.run(["new", "a", "-o", str(tmp_path)]) == 2
    assert path.read_text() == "mine"
    assert f"{path} is there already" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["", "3d", "a/b", "_", "a b", "é"])
def test_what_cannot_be_a_name(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["new", name, "-o", str(tmp_path)]) == 2
    assert "cannot name a model" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert main.run(["new", "a", "-o", str(tmp_path / "file" / "folder")]) == 2
    assert "cannot be written: Not a directory" in capsys.readouterr().err
