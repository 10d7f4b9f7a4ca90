# SPDX-License-Identifier: Apache-2.0
"""What solvers record with ``--record``: read, replayed and written for other tools."""

from hypgen.recordings.reader import (
    Recording,
    RecordingError,
    header_from,
    open_recording,
    part_of,
    started,
)
from hypgen.recordings.recording import End, Header, Start, Step, Variable
from hypgen.recordings.terms import params_of, reward_terms

__all__ = [
    "End",
    "Header",
    "Recording",
    "RecordingError",
    "Start",
    "Step",
    "Variable",
    "header_from",
    "open_recording",
    "params_of",
    "part_of",
    "reward_terms",
    "started",
]
