# SPDX-License-Identifier: Apache-2.0
"""Files of other formats are known by what they begin with, ours too, whatever they are called."""

import pytest

from hypgen.dsl.foreign.recognise import recognise
from hypgen.dsl.messages.source import Source

CASSANDRA = "# two doors\ndiscount: 0.95\nvalues: reward\nstates: 2\nactions: 1\nobservations: 1\n"


@pytest.mark.parametrize(
    ("written", "line"),
    [
        (CASSANDRA, 2),
        (CASSANDRA.replace("discount: 0.95", "DISCOUNT : 0.95"), 2),
        (CASSANDRA.replace("discount:", "discuont:"), 3),
        (CASSANDRA.replace("discount: 0.95", "states 2"), 3),
        (CASSANDRA.replace("# two", "// two"), 2),
    ],
)
def test_cassandras_format_is_known_in_spite_of_slips(written: str, line: int) -> None:
    found = recognise(Source("m.pomdp", written))
    assert found is not None and found.span is not None
    assert (found.code, found.span.line) == ("E0130", line)


@pytest.mark.parametrize(
    "text",
    [
        "model M\nrecord R {\nstates: 0 .. 3\nactions: 0 .. 3\n}\n",
        "# values: many\n# states: few\nlibrary tools\n",
        'instance i of "m.pomdp" {\nactions: 3\nstates: 4\n}',
        "discount 0.95\naction act: bool\n",
        "",
    ],
)
def test_this_language_is_never_taken_for_it(text: str) -> None:
    assert recognise(Source("m.POMDP", text)) is None
