# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import traces
from support.ir_samples import tiger

from hypgen.dsl.interpret.trace import columns, trace


def test_equal_traces_have_no_difference(tmp_path: Path) -> None:
    table = trace(tiger(), 1, 10, 5)
    table.astype("<i8").tofile(tmp_path / "trace")
    assert traces.difference(table, traces.read(tmp_path / "trace", tiger()), tiger(), 10) is None


def test_a_difference_names_row_column_and_both_values() -> None:
    table = trace(tiger(), 1, 10, 5)
    other = table.copy()
    place = columns(tiger()).index("upper")
    other[23, place] = np.float32(3.5).view(np.uint32)
    text = traces.difference(table, other, tiger(), 10)
    assert text is not None
    assert "row 23 (step 2, scenario 3), column 'upper'" in text
    assert "expected 0x43480000 (200.0), got 0x40600000 (3.5)" in text


def test_a_file_of_another_model_is_refused(tmp_path: Path) -> None:
    np.zeros(7, dtype="<i8").tofile(tmp_path / "trace")
    with pytest.raises(ValueError, match="no multiple of the 13 columns of Tiger"):
        traces.read(tmp_path / "trace", tiger())
