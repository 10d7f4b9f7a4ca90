# SPDX-License-Identifier: Apache-2.0
"""Libraries: what a model takes from them, and what is said of imports that cannot be."""

from pathlib import Path

import pytest

from hypgen.cli import main
from hypgen.dsl.load import Loaded, LoadedLibrary, load, load_any
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.render import render_all

MODEL = """model M
import "lib.pomdp"
enum Act { stay, go }
action act: Act
element robot {
  visible at: Row
  init at = 0
  at' = if act == go then next(at) else at
}
reward r = n
discount 0.9
"""
LIBRARY = """library Grid
const n: int = 4
type Row = 0 .. n
fn next(r: Row): Row = min(r + 1, n)
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lib.pomdp").write_text(LIBRARY)
    (tmp_path / "m.pomdp").write_text(MODEL)
    return tmp_path


def told(path: str = "m.pomdp") -> str:
    with pytest.raises(ModelError) as caught:
        load_any(path)
    return render_all(caught.value.diagnostics, caught.value.sources)


def test_a_model_has_what_its_library_declares(folder: Path) -> None:
    loaded = load("m.pomdp")
    assert loaded.model.name == "M"
    assert str(loaded.model.variable("robot.at").type) == "0 .. 4"
    assert set(loaded.sources) == {"m.pomdp", "lib.pomdp"}


def test_settings_reach_a_librarys_consts(folder: Path) -> None:
    assert str(load("m.pomdp", settings=["n=9"]).model.variable("robot.at").type) == "0 .. 9"


def test_a_change_of_the_library_changes_the_models_hash(folder: Path) -> None:
    before = load("m.pomdp").model.source_hash
    (folder / "lib.pomdp").write_text(LIBRARY + "# more\n")
    assert load("m.pomdp").model.source_hash != before


def test_paths_count_from_the_file_that_imports(folder: Path) -> None:
    (folder / "sub").mkdir()
    (folder / "sub" / "m.pomdp").write_text(MODEL.replace("lib.pomdp", "../outer.pomdp"))
    (folder / "outer.pomdp").write_text('library Outer\nimport "lib.pomdp"\n')
    assert load(folder / "sub" / "m.pomdp").model.name == "M"


def test_a_file_that_is_imported_twice_counts_once(folder: Path) -> None:
    (folder / "other.pomdp").write_text('library Other\nimport "lib.pomdp"\n')
    twice = 'import "other.pomdp"\nimport "./lib.pomdp"\nimport "lib.pomdp"\n'
    (folder / "m.pomdp").write_text(MODEL.replace('import "lib.pomdp"\n', twice))
    assert isinstance(load_any("m.pomdp"), Loaded)


def test_a_library_that_has_nothing(folder: Path) -> None:
    (folder / "empty.pomdp").write_text("library Empty\n")
    (folder / "m.pomdp").write_text(MODEL + 'import "empty.pomdp"\n')
    assert isinstance(load_any("m.pomdp"), Loaded)


def test_missing_libraries_are_all_named(folder: Path) -> None:
    (folder / "m.pomdp").write_text('model M\nimport "a.pomdp"\nimport "b.pomdp"\n')
    text = told()
    assert "there is no file 'a.pomdp'" in text and "there is no file 'b.pomdp'" in text
    assert " --> m.pomdp:3:8" in text


def test_a_circle_is_printed(folder: Path) -> None:
    (folder / "lib.pomdp").write_text('library A\nimport "b.pomdp"\n')
    (folder / "b.pomdp").write_text('library B\nimport "lib.pomdp"\n')
    assert told() == (
        "error[E0014]: the files import each other in a circle: lib.pomdp -> b.pomdp -> lib.pomdp\n"
        " --> b.pomdp:2:8\n  |\n"
        '2 | import "lib.pomdp"\n  |        ^^^^^^^^^^^\n'
        "help: remove one of the imports; what both files need can stand in a third\n"
    )


def test_a_model_is_no_library(folder: Path) -> None:
    (folder / "lib.pomdp").write_text(MODEL)
    assert "error[E0013]: 'lib.pomdp' is a model, and only libraries can be imported" in told()
    (folder / "lib.pomdp").write_text('instance i of "m.pomdp" { }')
    assert "'lib.pomdp' is an instance, and only" in told()


@pytest.mark.parametrize(
    ("item", "name"),
    [
        ("element e { }", "the element 'e'"),
        ("param p: int", "'param'"),
        ("discount 0.5", "a discount"),
        ("terminal when true", "'terminal when'"),
        ("reward r = 0", "'reward'"),
    ],
)
def test_a_library_has_no_state_and_no_settings(item: str, name: str, folder: Path) -> None:
    (folder / "lib.pomdp").write_text(LIBRARY + item)
    assert f"error[E0139]: a library cannot have {name}\n --> lib.pomdp:5:1" in told()


def test_names_declared_in_two_files_are_shown_in_both(folder: Path) -> None:
    (folder / "m.pomdp").write_text(MODEL + "const n: int = 5\n")
    text = told()
    assert "'n' is already declared" in text
    assert "--> m.pomdp:12:1" in text and "--> lib.pomdp:2:1" in text
    assert "const n: int = 4" in text


def test_a_library_is_checked_by_itself(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert isinstance(load_any("lib.pomdp"), LoadedLibrary)
    assert main.run(["check", "lib.pomdp"]) == 0
    assert capsys.readouterr().out == "lib.pomdp: OK: library Grid\n"
    (folder / "lib.pomdp").write_text(LIBRARY + "const big: Row = 5\n")
    assert "error[E0601]" in told("lib.pomdp")


@pytest.mark.parametrize("arguments", [["compile"], ["run"], ["check", "--set", "n=3"]])
def test_other_commands_say_what_a_library_is(
    arguments: list[str], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.run([arguments[0], "lib.pomdp", *arguments[1:]]) == 2
    assert "error[E0015]: 'lib.pomdp' is the library 'Grid', not a model" in capsys.readouterr().err


def test_an_instance_of_a_library(folder: Path) -> None:
    (folder / "i.pomdp").write_text('instance i of "lib.pomdp" { n = 3 }')
    assert "error[E0007]: 'lib.pomdp' is a library, not a model" in told("i.pomdp")
