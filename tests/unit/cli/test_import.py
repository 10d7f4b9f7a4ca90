# SPDX-License-Identifier: Apache-2.0
"""``hypgen import``, and the other commands on files in other formats."""

import re
import shlex
from pathlib import Path

import pytest
from support.paths import ROOT

from hypgen.cli import main
from hypgen.dsl import load
from hypgen.dsl.foreign.tables.names import Names
from hypgen.dsl.format.formatter import format_source
from hypgen.dsl.messages.source import Source
from hypgen.dsl.syntax.parse import _load_lark
from hypgen.dsl.types.builtin_names import RESERVED_CALLS, RESERVED_VALUES

CORPUS = ROOT.parent / "shared" / "corpus"
MACHINE = """# A machine that wears out.
discount: 0.9
states: new worn-out
actions: run repair
observations: fine rattle
start: new
T: run
0.8 0.2
0 1
T: repair : * : new 1
O: *
0.9 0.1
0.3 0.7
R: run : new : * : * 2
R: repair : * : * : * -1
"""
TEXT = """# -*- hypgen -*-
# Imported by hypgen from Cassandra's format: machine.POMDP
model Machine

enum Action { run, repair }
enum State { new, worn_out }
enum Observation { fine, rattle }

discount 0.9
action act: Action

element system {
  hidden state: State
  init state = new
  state' ~ match act {
    run => match state {
      new      => { new: 0.8, else worn_out }
      worn_out => worn_out
    }
    repair => new
  }
}

observe seen: Observation ~ match system.state' {
  new      => { fine: 0.9, else rattle }
  worn_out => { fine: 0.3, else rattle }
}

reward gain = match act {
  run => match system.state {
    new      => 2
    worn_out => 0
  }
  repair => -1
}

# Of the policies that always do the same, the best from the start: 7.143.
policy default = run
"""


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    path = tmp_path / "machine.POMDP"
    path.write_text(MACHINE)
    return path


def test_the_text_reads_as_if_written_by_hand(machine: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["import", str(machine)]) == 0
    out, err = capsys.readouterr()
    assert out == TEXT
    assert err == f"{machine}: Cassandra's format, 2 states, 2 actions, 2 observations\n"


def test_files_are_written_whole_and_not_replaced(machine: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = machine.with_name("machine.pomdp")
    assert main.run(["import", str(machine), "-o", str(output), "--name", "Wear", "--horizon", "9"]) == 0
    text = output.read_text()
    assert "model Wear\n" in text and "horizon 9\n" in text
    assert main.run(["import", str(machine), "-o", str(output)]) == 2
    assert "is there already" in capsys.readouterr().err and output.read_text() == text
    assert main.run(["import", str(machine), "-o", str(output), "--force"]) == 0
    assert output.read_text() == TEXT
    assert main.run(["import", str(machine), "-o", str(machine.parent / "no" / "x.pomdp")]) == 2
    assert main.run(["import", str(machine), "--name", "a-b"]) == 2
    assert sorted(p.name for p in machine.parent.iterdir()) == ["machine.POMDP", "machine.pomdp"]


def test_other_commands_import_on_the_way(machine: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["sim", str(machine), "--policy", "default", "--steps", "1"]) == 0
    out, err = capsys.readouterr()
    assert "step 0: run" in out
    assert err == (
        f"note: {machine}: Cassandra's format, 2 states, 2 actions, 2 observations; "
        "imported (`hypgen import` writes the model)\n"
    )
    assert main.run(["explain", str(machine)]) == 0
    assert "Machine: discount 0.9" in capsys.readouterr().out
    assert main.run(["check", str(machine)]) == 2
    assert "`hypgen import FILE -o NEW.pomdp` writes it" in capsys.readouterr().err


def test_a_discount_of_1_comes_with_the_command_to_type(
    machine: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(machine.parent)
    Path("the machine.POMDP").write_text(MACHINE.replace("0.9\n", "1\n", 1))
    assert main.run(["run", "the machine.POMDP"]) == 2
    command = re.findall(r"`(hypgen import [^`]*)`", capsys.readouterr().err)[0]
    assert command == "hypgen import 'the machine.POMDP' --horizon 100 -o 'the machine_100.pomdp'"
    assert main.run(shlex.split(command)[1:]) == 0
    assert main.run(["check", "the machine_100.pomdp"]) == 0


def test_what_is_no_other_format_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for content, code in (
        (TEXT.encode(), "E0913"),
        (b"discount: 0.9\n\0\1", "E0004"),
        (b"\xff\xfe\x00", "E0004"),
        (b"", "E0005"),
        (b"<html></html>", "E0913"),
    ):
        path = tmp_path / "file"
        path.write_bytes(content)
        assert main.run(["import", str(path)]) == 2
        assert f"error[{code}]" in capsys.readouterr().err
    assert main.run(["import", str(tmp_path / "none")]) == 2
    assert "error[E0001]" in capsys.readouterr().err


def test_names_of_the_language_are_not_taken() -> None:
    words = {t.pattern.value for t in _load_lark().terminals if t.pattern.type == "str"}
    for word in {w for w in words if w.isidentifier()} | RESERVED_CALLS | RESERVED_VALUES:
        assert Names().unique(word, "x") != word


@pytest.mark.skipif(not CORPUS.exists(), reason="the corpus is not beside the checkout")
def test_imported_files_are_laid_out_and_warn_of_nothing(tmp_path: Path) -> None:
    paths = sorted(p for p in CORPUS.rglob("*") if p.suffix in (".pomdp", ".pomdpx"))
    assert len(paths) == 22
    for path in paths:
        output = tmp_path / f"{path.parent.name}-{path.stem}.pomdp"
        assert main.run(["import", str(path), "-o", str(output), "--horizon", "50"]) == 0
        source = Source(output.name, output.read_text())
        assert format_source(source) == source.text
        assert load.load(output).warnings == (), path
