# SPDX-License-Identifier: Apache-2.0
"""``hypgen tune``: what it refuses before anything is compiled, and what it prints."""

from pathlib import Path

import pytest
from support.paths import EXAMPLES

from hypgen.cli.exit_codes import Exit
from hypgen.cli.main import run

pytest.importorskip("optuna", reason="tuning needs Optuna: pip install 'hypgen[tune]'")
TIGER = str(EXAMPLES / "tiger.pomdp")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--tune", "depht"], "no option 'depht' can be tuned: did you mean 'depth'?"),
        (["--tune", "xi=0.9..0.5"], "xi=0.9..0.5: the range is empty"),
        (["--tune-param", "hear"], "the model has no param 'hear'"),
        (["--fix", "scenarios"], "--fix takes NAME=VALUE, found 'scenarios'"),
        (["--fix", "scenarios=9"], "'scenarios' is both tuned and fixed"),
        (["--mode", "depot"], "there is no mode 'depot'"),
        (["--mode", "default"], "mode 'default' has no options to tune: name params"),
        (["--mode", "gpu", "--gpus", "0"], "mode 'gpu' needs a GPU"),
        (["--time", "1", "--trials", "5"], "give one of time, period, trials"),
        (["--candidates", "0"], "0 is not in the range"),
        (["--set", "hearing=maybe"], "error[E0"),
    ],
)
def test_what_cannot_be_tuned_is_refused(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], arguments: list[str], says: str
) -> None:
    assert run(["tune", TIGER, "-o", str(tmp_path / "out"), *arguments]) == Exit.MISTAKE
    assert says in capfd.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_model_with_mistakes_is_refused(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "wrong.pomdp").write_text("model Wrong\naction act: Way\n")
    assert run(["tune", str(tmp_path / "wrong.pomdp"), "-o", str(tmp_path / "out")]) == Exit.MISTAKE
    assert "error[E0" in capfd.readouterr().err


def test_optuna_is_asked_for(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert run(["tune", TIGER, "-o", str(tmp_path / "out")]) == Exit.MISTAKE
    assert "tuning needs Optuna and scipy: pip install 'hypgen[tune]'" in capfd.readouterr().err
