# SPDX-License-Identifier: Apache-2.0
"""The functions of hypgen.h, by ctypes: calls that raise, and texts that are freed."""

from __future__ import annotations

import ctypes
import json
from pathlib import Path
from typing import Any

ABI_VERSION = 1
FAILED = 100  # HYPGEN_FAILED: statuses from here on are refusals


class PlannerError(Exception):
    """A call that the library refused; ``status`` is its name, such as ``wrong_argument``."""

    def __init__(self, status: str, text: str) -> None:
        self.status = status
        super().__init__(text)


class COptions(ctypes.Structure):
    """``hypgen_options``."""

    _fields_ = (("size", ctypes.c_size_t), ("settings", ctypes.c_char_p), ("params", ctypes.c_char_p))


class CDecision(ctypes.Structure):
    """``hypgen_decision``."""

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


class CWorldsOptions(ctypes.Structure):
    """``hypgen_worlds_options``."""

    _fields_ = (
        ("size", ctypes.c_size_t),
        ("count", ctypes.c_size_t),
        ("seed", ctypes.c_uint64),
        ("params", ctypes.c_char_p),
        ("device", ctypes.c_char_p),
    )


class CWorldsResults(ctypes.Structure):
    """``hypgen_worlds_results``."""

    _fields_ = (
        ("size", ctypes.c_size_t),
        ("rewards", ctypes.c_void_p),
        ("seen", ctypes.c_void_p),
        ("keys", ctypes.c_void_p),
        ("visible", ctypes.c_void_p),
        ("legal", ctypes.c_void_p),
        ("terminal", ctypes.c_void_p),
        ("success", ctypes.c_void_p),
    )


class CLibrary:
    """A library of a model, loaded into this process."""

    def __init__(self, path: Path) -> None:
        try:
            self._library = ctypes.CDLL(str(path))
            version = int(self._library.hypgen_abi_version())
            if version != ABI_VERSION:
                text = f"{path} has version {version} of the C interface, and this package {ABI_VERSION}"
                raise PlannerError("wrong_argument", f"{text}; compile the model again")
            self._library.hypgen_status_name.restype = ctypes.c_char_p
            self._library.hypgen_free.restype = None
            self._library.hypgen_free.argtypes = [ctypes.c_void_p]
            self._library.hypgen_library_model.restype = ctypes.c_void_p
            self.model = ctypes.c_void_p(self._library.hypgen_library_model())
        except (OSError, AttributeError) as error:
            raise PlannerError("wrong_argument", f"{path} is no library of hypgen: {error}") from None

    def call(self, name: str, *arguments: Any) -> int:
        """Call ``hypgen_<name>``, which takes an error text last; return its status."""
        error = ctypes.c_void_p()
        try:
            function = getattr(self._library, f"hypgen_{name}")
        except AttributeError:
            text = f"{self._library._name} has no function hypgen_{name}; compile the model again"
            raise PlannerError("wrong_argument", text) from None
        status = int(function(*arguments, ctypes.byref(error)))
        if status >= FAILED:
            raise PlannerError(self.status_name(status), self._taken(error))
        return status

    def json(self, name: str, *arguments: Any) -> Any:
        """Call a function that gives a JSON text before the error; return what it says."""
        text = ctypes.c_void_p()
        self.call(name, *arguments, ctypes.byref(text))
        return json.loads(self._taken(text))

    def cancel(self, planner: ctypes.c_void_p) -> None:
        """End the plan that another thread has under way."""
        self._library.hypgen_cancel(planner)

    def destroy(self, handle: ctypes.c_void_p, name: str = "destroy") -> None:
        """Free what a handle stands for; what another thread uses stays."""
        status = int(getattr(self._library, f"hypgen_{name}")(handle))
        if status >= FAILED:
            raise PlannerError(self.status_name(status), "another thread's call is under way")

    def status_name(self, status: int) -> str:
        """Return the name of a status."""
        name: bytes = self._library.hypgen_status_name(ctypes.c_int32(status))
        return name.decode()

    def _taken(self, text: ctypes.c_void_p) -> str:
        """Return a text that the library made, and free it."""
        content = ctypes.cast(text, ctypes.c_char_p).value or b""
        self._library.hypgen_free(text)
        return content.decode(errors="replace")
