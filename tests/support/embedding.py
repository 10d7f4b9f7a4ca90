# SPDX-License-Identifier: Apache-2.0
"""The functions of hypgen.h for tests, by ctypes."""

from __future__ import annotations

import ctypes
import json
from pathlib import Path
from typing import Any

FAILED = 100


class Options(ctypes.Structure):
    _fields_ = (("size", ctypes.c_size_t), ("settings", ctypes.c_char_p), ("params", ctypes.c_char_p))


class Decision(ctypes.Structure):
    _fields_ = (
        ("size", ctypes.c_size_t),
        ("action", ctypes.c_int32),
        ("status", ctypes.c_int32),
        ("action_name", ctypes.c_char_p),
        ("lower", ctypes.c_double),
        ("upper", ctypes.c_double),
        ("seconds", ctypes.c_double),
        ("trials", ctypes.c_uint64),
        ("expansions", ctypes.c_uint64),
        ("scenarios", ctypes.c_uint64),
        ("max_depth", ctypes.c_int32),
        ("unused", ctypes.c_int32),
    )


class Embedded:
    """A library and one planner of its model; a refused call raises with the library's text."""

    def __init__(self, path: Path, settings: str, params: str | None = None) -> None:
        self.library = ctypes.CDLL(str(path))
        self.library.hypgen_library_model.restype = ctypes.c_void_p
        self.library.hypgen_status_name.restype = ctypes.c_char_p
        self.library.hypgen_free.argtypes = [ctypes.c_void_p]
        self.model = ctypes.c_void_p(self.library.hypgen_library_model())
        self.planner = ctypes.c_void_p()
        given = params.encode() if params is not None else None
        options = Options(ctypes.sizeof(Options), settings.encode(), given)
        self.call("create", self.model, ctypes.byref(options), ctypes.byref(self.planner), planner=False)

    def call(self, name: str, *arguments: Any, planner: bool = True) -> int:
        error = ctypes.c_void_p()
        given = (self.planner, *arguments) if planner else arguments
        status: int = getattr(self.library, f"hypgen_{name}")(*given, ctypes.byref(error))
        if status >= FAILED:
            text = ctypes.cast(error, ctypes.c_char_p).value or b""
            self.library.hypgen_free(error)
            raise ValueError(f"{self.status_name(status)}: {text.decode()}")
        return status

    def status_name(self, status: int) -> str:
        name: bytes = self.library.hypgen_status_name(status)
        return name.decode()

    def json(self, name: str, *arguments: Any, planner: bool = True) -> Any:
        text = ctypes.c_void_p()
        self.call(name, *arguments, ctypes.byref(text), planner=planner)
        found = json.loads(ctypes.cast(text, ctypes.c_char_p).value or b"null")
        self.library.hypgen_free(text)
        return found

    def plan(self, seconds: float = 0.0) -> Decision:
        decision = Decision(size=ctypes.sizeof(Decision))
        self.call("plan", ctypes.c_double(seconds), ctypes.byref(decision))
        return decision

    def reset(self, visible: dict[str, Any] | None = None, episode: int = 0) -> int:
        text = json.dumps(visible or {}).encode()
        return self.call("reset_named", ctypes.c_char_p(text), ctypes.c_uint64(episode))

    def update(self, action: int, seen: dict[str, Any]) -> int:
        return self.call("update_named", ctypes.c_int32(action), ctypes.c_char_p(json.dumps(seen).encode()))

    def update_key(self, action: int, words: list[int]) -> int:
        key = (ctypes.c_uint64 * len(words))(*words)
        return self.call("update", ctypes.c_int32(action), key, ctypes.c_size_t(len(words)))

    def decode(self, words: list[int]) -> Any:
        return self.json("decode", (ctypes.c_uint64 * len(words))(*words), ctypes.c_size_t(len(words)))

    def close(self) -> None:
        assert self.library.hypgen_destroy(self.planner) == 0
