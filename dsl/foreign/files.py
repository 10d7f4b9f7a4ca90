# SPDX-License-Identifier: Apache-2.0
"""Finds out which files are in another format, and reads them."""

from __future__ import annotations

import os

from hypgen.dsl.foreign.recognise import recognise
from hypgen.dsl.messages import e09_other_formats
from hypgen.dsl.messages.diagnostic import ModelError
from hypgen.dsl.messages.input_file import read_file
from hypgen.dsl.messages.source import Source

MAX_BYTES = 32_000_000
_HEAD = 65_536


def read(path: str | os.PathLike[str]) -> bytes | None:
    """Return the content of a file in another format, None if it is none; raises ``ModelError``."""
    name = os.fspath(path)
    if not os.path.isfile(name):
        return None  # missing, a folder, or a pipe, which can be read once only
    try:
        head = read_file(name, _HEAD)
        if b"\0" in head or recognise(source_of(name, head)) is None:
            return None
        content = read_file(name, MAX_BYTES)
    except OSError:
        return None
    if len(content) > MAX_BYTES:
        raise ModelError([e09_other_formats.large_file(name, MAX_BYTES)])
    return content


def refusal(path: str) -> ModelError:
    """Return what to tell about a file that is in no format known here."""
    return ModelError([e09_other_formats.unknown_format(path)])


def source_of(path: str, content: bytes) -> Source:
    """Return a file's text: names and comments of old files are often in Latin-1."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    return Source(path, text.replace("\r\n", "\n").replace("\r", "\n"))
