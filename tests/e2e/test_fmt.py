# SPDX-License-Identifier: Apache-2.0
"""``hypgen fmt``: what it writes, what it prints, and what it leaves alone."""

import io
from pathlib import Path

import pytest

from hypgen.cli import main

ROUGH = "model M\naction act : bool   # twice\ndiscount  0.5\n"
SMOOTH = "model M\naction act: bool    # twice\ndiscount 0.5\n"


@pytest.fixture
def rough(tmp_path: Path) -> Path:
    path = tmp_path / "rough.pomdp"
    path.write_text(ROUGH)
    return path


def test_a_file_is_replaced(rough: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rough.chmod(0o640)
    assert main.run(["fmt", str(rough)]) == 0
    assert rough.read_text() == SMOOTH
    assert rough.stat().st_mode & 0o777 == 0o640
    assert capsys.readouterr().err == f"{rough}: formatted\n"
    assert main.run(["fmt", str(rough), "--check"]) == 0
    assert capsys.readouterr().err == "1 file already formatted\n"
    assert list(rough.parent.iterdir()) == [rough]


def test_line_ends_of_other_systems_are_replaced(rough: Path) -> None:
    rough.write_bytes(b"\xef\xbb\xbf" + SMOOTH.replace("\n", "\r\n").encode())
    assert main.run(["fmt", "--check", str(rough)]) == 1
    assert main.run(["fmt", str(rough)]) == 0
    assert rough.read_bytes() == SMOOTH.encode()


def test_a_link_stays_a_link(rough: Path) -> None:
    link = rough.with_name("link.pomdp")
    link.symlink_to(rough)
    assert main.run(["fmt", str(link)]) == 0
    assert link.is_symlink() and rough.read_text() == SMOOTH


def test_check_and_diff_write_nothing(rough: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["fmt", "--check", str(rough)]) == 1
    assert capsys.readouterr().err == f"{rough}: not formatted\n"
    assert main.run(["fmt", "--diff", str(rough)]) == 0
    assert "\n-discount  0.5\n" in capsys.readouterr().out
    assert rough.read_text() == ROUGH


def test_standard_input(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(ROUGH.encode())))
    assert main.run(["fmt", "-"]) == 0
    assert capsys.readouterr().out == SMOOTH


def test_a_broken_file_is_explained_and_the_others_are_formatted(
    rough: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    broken = rough.with_name("broken.pomdp")
    broken.write_text("model M discount")
    missing = rough.with_name("missing.pomdp")
    assert main.run(["fmt", str(broken), str(missing), str(rough)]) == 2
    text = capsys.readouterr().err
    assert f"{broken}:1:" in text and "error[E0001]" in text
    assert broken.read_text() == "model M discount"
    assert rough.read_text() == SMOOTH
