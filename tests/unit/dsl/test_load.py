# SPDX-License-Identifier: Apache-2.0
"""Reading files, merging instances and settings."""

from pathlib import Path

import pytest
from support.paths import EXAMPLES, ROOT

from hypgen.dsl import load as driver
from hypgen.dsl.load import load
from hypgen.dsl.messages.diagnostic import Diagnostic, ModelError
from hypgen.dsl.types import Float


def failure(path: Path | str, **options: object) -> tuple[Diagnostic, ModelError]:
    with pytest.raises(ModelError) as caught:
        load(path, **options)  # type: ignore[arg-type]
    (diagnostic,) = caught.value.diagnostics
    return diagnostic, caught.value


@pytest.fixture
def tiger(tmp_path: Path) -> Path:
    path = tmp_path / "tiger.pomdp"
    path.write_text((EXAMPLES / "tiger.pomdp").read_text())
    return path


def write_instance(folder: Path, text: str, name: str = "i.pomdp") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def test_missing_file(tmp_path: Path) -> None:
    diagnostic, _ = failure(tmp_path / "none.pomdp")
    assert (diagnostic.code, diagnostic.span) == ("E0001", None)
    assert str(tmp_path / "none.pomdp") in diagnostic.message


def test_folder(tmp_path: Path) -> None:
    assert failure(tmp_path)[0].code == "E0002"


def test_path_that_cannot_be_opened(tiger: Path) -> None:
    assert failure(tiger / "below")[0].code == "E0003"
    assert failure("a\0b")[0].code == "E0003"
    assert failure("a" * 5000)[0].code == "E0003"


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (b"model M\xff\xfe", "E0004"),
        (b"\x7fELF\0\0\0", "E0004"),
        ("model M".encode("utf-16"), "E0004"),
        (b"", "E0005"),
        (b"\xef\xbb\xbf", "E0005"),
        (b" \r\n\t\n", "E0005"),
    ],
)
def test_content_that_is_no_model(content: bytes, code: str, tmp_path: Path) -> None:
    path = tmp_path / "m.pomdp"
    path.write_bytes(content)
    assert failure(path)[0].code == code


def test_large_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(driver, "MAX_BYTES", 100)
    assert failure(write_instance(tmp_path, "model M" + " " * 100))[0].code == "E0006"


def test_byte_order_mark_and_line_ends(tiger: Path) -> None:
    plain = load(tiger)
    tiger.write_bytes(b"\xef\xbb\xbf" + tiger.read_bytes().replace(b"\n", b"\r\n"))
    assert load(tiger) == plain


def test_error_carries_the_text_that_it_points_into(tmp_path: Path) -> None:
    path = write_instance(tmp_path, "model M\nconst n = 3\n")
    diagnostic, error = failure(path)
    assert diagnostic.span is not None
    assert error.sources[diagnostic.span.file].line(2) == "const n = 3"


def test_instance_finds_its_model_beside_itself(
    tiger: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sub").mkdir()
    monkeypatch.chdir("/")
    path = write_instance(tmp_path / "sub", 'instance i of "../tiger.pomdp" { hearing = 0.75 }')
    loaded = load(path)
    assert loaded.ast.name == "Tiger"
    assert len(loaded.sources) == 2
    for model in (loaded.model, load(tiger, instance=path).model):
        assert [p.default for p in model.params] == [(0.75,)]


def test_instance_without_its_model(tmp_path: Path) -> None:
    path = write_instance(tmp_path, '# of "none.pomdp"\ninstance i of "none.pomdp" { }')
    diagnostic, error = failure(path)
    assert diagnostic.code == "E0001"
    assert diagnostic.span is not None and (diagnostic.span.line, diagnostic.span.column) == (2, 15)
    assert diagnostic.span.file in error.sources


def test_instance_of_an_instance(tiger: Path, tmp_path: Path) -> None:
    write_instance(tmp_path, 'instance i of "tiger.pomdp" { }')
    outer = write_instance(tmp_path, 'instance o of "i.pomdp" { }', "o.pomdp")
    assert failure(outer)[0].code == "E0007"


def test_instance_option_with_the_wrong_files(tiger: Path, tmp_path: Path) -> None:
    instance = write_instance(tmp_path, 'instance i of "tiger.pomdp" { }')
    foreign = write_instance(tmp_path, 'instance i of "other.pomdp" { }', "foreign.pomdp")
    assert failure(tiger, instance=tiger)[0].code == "E0008"
    assert failure(tiger, instance=foreign)[0].code == "E0009"
    assert failure(instance, instance=instance)[0].code == "E0012"


def test_name_set_twice_in_an_instance(tiger: Path, tmp_path: Path) -> None:
    text = 'instance i of "tiger.pomdp" {\n  hearing = 0.7\n  hearing = 0.8\n}'
    diagnostic, _ = failure(write_instance(tmp_path, text))
    assert diagnostic.code == "E0010"
    assert diagnostic.span is not None and diagnostic.span.line == 3
    assert diagnostic.notes[0][0].line == 2


def test_settings_win_over_the_instance_and_the_last_one_wins(tiger: Path, tmp_path: Path) -> None:
    path = write_instance(tmp_path, 'instance i of "tiger.pomdp" { hearing = 0.75 }')
    model = load(path, settings=["hearing=0.5", " hearing = 0.25"]).model
    assert [p.default for p in model.params] == [(0.25,)]


@pytest.mark.parametrize("setting", ["hearing", "=3", "hearing=", "3=4", "a b=3", "hearing==3", ""])
def test_setting_without_a_name_or_a_value(setting: str, tiger: Path) -> None:
    assert failure(tiger, settings=[setting])[0].code == "E0011"


def test_setting_that_does_not_parse_is_shown(tiger: Path) -> None:
    diagnostic, error = failure(tiger, settings=["hearing=1 +"])
    assert diagnostic.span is not None
    assert diagnostic.span.file == "--set hearing"
    assert error.sources["--set hearing"].text == "1 +"


def test_nesting_up_to_the_limit_loads(tmp_path: Path) -> None:
    for deep in (" + ".join(["1"] * 190), "-" * 190 + "1", "if room.tiger == left then 0 else " * 180 + "1"):
        text = (EXAMPLES / "tiger.pomdp").read_text() + f"reward deep = {deep}\n"
        load(write_instance(tmp_path, text))


def test_a_file_of_very_many_words_is_refused_at_once(tmp_path: Path) -> None:
    text = (EXAMPLES / "tiger.pomdp").read_text() + "const a: int = 3 + 4 * 5\n" * 15_000
    diagnostic, _ = failure(write_instance(tmp_path, text))
    assert diagnostic.code == "E0140" and diagnostic.span is not None
    assert "more than 100000" in diagnostic.message
    comments = (EXAMPLES / "tiger.pomdp").read_text() + "# a b c d e f g h i j k l\n" * 15_000
    assert load(write_instance(tmp_path, comments)).model.name == "Tiger"


@pytest.mark.parametrize("name", ["light_dark_1d", "laser_tag_continuous", "vdp_tag"])
def test_published_problems_with_continuous_readings_load(name: str) -> None:
    loaded = load(ROOT / "benchmarks" / "models" / f"{name}.pomdp")
    assert not loaded.warnings
    assert any(isinstance(o.type, Float) for o in loaded.model.observations)


@pytest.mark.parametrize("text", ['instance i of "other.pomdp" { n = 3 }', 'model M\nimport "other.pomdp"\n'])
def test_a_file_that_names_one_of_another_format_is_shown(text: str, tmp_path: Path) -> None:
    other = tmp_path / "other.pomdp"
    other.write_text("discount: 0.9\nvalues: reward\nstates: 2\n")
    diagnostic, _ = failure(write_instance(tmp_path, text))
    assert diagnostic.code == "E0130" and diagnostic.notes[0][0].file == str(tmp_path / "i.pomdp")
    assert f"`hypgen import {other} -o NEW.pomdp`, and name that" in str(diagnostic.remedy)
