# SPDX-License-Identifier: Apache-2.0
"""Interrupts of a run whose recording hypgen takes, at every place where one may come."""

from __future__ import annotations

import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from hypgen.cli.recorded_runs import play_recorded


@pytest.mark.parametrize(("owner", "name"), [(ThreadPoolExecutor, "submit"), (subprocess, "Popen")])
def test_an_interrupt_before_the_solver_is_known_ends_the_run(
    owner: Any, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = getattr(owner, name)

    def interrupted(*args: Any, **options: Any) -> None:
        whole(*args, **options)
        raise KeyboardInterrupt

    monkeypatch.setattr(owner, name, interrupted)
    assert play_recorded(Path("/bin/true"), [], tmp_path / "log.jsonl") == 130
