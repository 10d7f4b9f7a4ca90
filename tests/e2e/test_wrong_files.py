# SPDX-License-Identifier: Apache-2.0
"""Files that are no model: every command says what they are, where it knows, and what to do."""

from pathlib import Path

import pytest

from hypgen.cli import main

FILES = {
    "empty.pomdp": b"",
    "binary.pomdp": b"\x7fELF\x00\xff\xfe",
    "library.pomdp": b"library colours const red: int = 1\n",
    "orphan.pomdp": b'instance orphan of "gone.pomdp" {}\n',
    "cassandra.pomdp": b"discount: 0.95\nvalues: reward\n",
    "broken.pomdp": b"model Broken discount\n",
}
CASES = [
    ("missing.pomdp", "error[E0001]: there is no file"),
    ("", "error[E0002]"),
    ("empty.pomdp", "is empty"),
    ("binary.pomdp", "error[E0004]"),
    ("library.pomdp", "is the library 'colours', not a model"),
    ("orphan.pomdp", "there is no file"),
    ("cassandra.pomdp", ""),  # check and fmt say what it is, the others what it lacks
    ("broken.pomdp", "broken.pomdp:"),
]
FORMATTED = ("library.pomdp", "orphan.pomdp")  # by themselves, they can be laid out


@pytest.mark.parametrize("command", ["check", "explain", "sim", "compile", "fmt"])
@pytest.mark.parametrize(("name", "message"), CASES)
def test_what_is_no_model_is_refused(
    command: str, name: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for file, content in FILES.items():
        (tmp_path / file).write_bytes(content)
    code = main.run([command, str(tmp_path / name)])
    text = capsys.readouterr().err
    fine = name in FORMATTED and command == "fmt" or (name, command) == ("library.pomdp", "check")
    assert code == (0 if fine else 2)
    assert fine or (message in text and "help: " in text)
    assert "Traceback" not in text and "bug of hypgen" not in text
    if name == "cassandra.pomdp":
        assert ("Cassandra's POMDP format" if command in ("check", "fmt") else "the states are not") in text


@pytest.mark.parametrize("command", ["explain", "sim"])
def test_an_instance_is_as_good_as_a_model(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    instance = Path(__file__).parent.parent.parent / "examples" / "rs_11_11.pomdp"
    options = ["--policy", "default", "--steps", "1"] if command == "sim" else []
    assert main.run([command, str(instance), *options]) == 0
    assert "RockSample" in capsys.readouterr().out
