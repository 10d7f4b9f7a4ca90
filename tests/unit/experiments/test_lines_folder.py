# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

from hypgen.experiments.lines_folder import lines_folder


def test_a_folder_of_a_process_that_was_killed_goes_with_the_next_one(tmp_path: Path) -> None:
    (left := tmp_path / "lines-left").mkdir()
    (left / "cell").touch()
    with lines_folder(tmp_path) as folder:
        assert folder.is_dir()
        assert not left.exists()
    assert list(tmp_path.iterdir()) == []


def test_a_folder_of_a_process_that_lives_stays(tmp_path: Path) -> None:
    with lines_folder(tmp_path) as first, lines_folder(tmp_path) as second:
        assert first != second
        assert first.is_dir()
        assert second.is_dir()


def test_a_link_is_not_followed(tmp_path: Path) -> None:
    (elsewhere := tmp_path / "elsewhere").mkdir()
    (parent := tmp_path / "parent").mkdir()
    (parent / "lines-link").symlink_to(elsewhere)
    with lines_folder(parent):
        pass
    assert elsewhere.is_dir()
