# SPDX-License-Identifier: Apache-2.0
"""Models before and after the small forms: both are right, and docs/results/forms.md shows them."""

import forms
import pytest

from hypgen.cli.commands.check import summary
from hypgen.dsl.load import load


@pytest.mark.parametrize("name", forms.names())
def test_both_texts_have_the_same_actions_and_observations(name: str) -> None:
    loaded = [load(forms.HERE / when / f"{name}.pomdp") for when in ("before", "after")]
    before, after = (summary(found.model) for found in loaded)
    assert not any(found.warnings for found in loaded)
    assert {k: before[k] for k in ("actions", "observation_bits")} == {
        k: after[k] for k in ("actions", "observation_bits")
    }


def test_the_page_is_up_to_date() -> None:
    assert forms.PAGE.read_text() == forms.page(), "run python benchmarks/forms.py"
