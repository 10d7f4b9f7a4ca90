# SPDX-License-Identifier: Apache-2.0
"""A solver under AddressSanitizer and UndefinedBehaviorSanitizer, which end it where it does wrong."""

from __future__ import annotations

import os
from pathlib import Path

from hypgen.codegen.generate import generate
from hypgen.dsl.load import load
from hypgen.runtime.builder import tools
from hypgen.runtime.builder.exported_project import export
from support.native import build_with_cmake

# Little optimisation: with more, compiling takes many minutes.
FLAGS = "-O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=undefined"
ENVIRONMENT = {
    # A refused allocation is the program's to report.
    "ASAN_OPTIONS": "allocator_may_return_null=1:exitcode=86:detect_leaks=0",
    "UBSAN_OPTIONS": "print_stacktrace=1:exitcode=86",
}
BROKEN = 86  # the exit code of a sanitizer that found something


def sanitized_solver(model: Path, folder: Path) -> Path:
    """Return a model's solver, built in ``folder`` with sanitizers unless it is there."""
    files = generate(load(model).model)
    export(files, folder / "project")
    ninja = tools.find_ninja()
    generator = ["-G", "Ninja", f"-DCMAKE_MAKE_PROGRAM={ninja.path}"] if ninja else []
    build_with_cmake(
        folder / "project",
        folder / "build",
        *generator,
        "-DCMAKE_BUILD_TYPE=None",
        "-DHYPGEN_NATIVE=OFF",
        f"-DCMAKE_CXX_FLAGS={FLAGS}",
    )
    name = next(Path(file).stem for file in sorted(files) if file.endswith(".hpp"))
    return next(p for p in (folder / "build").rglob(name) if p.is_file() and os.access(p, os.X_OK))
