# SPDX-License-Identifier: Apache-2.0
"""Writes what ``examples.py`` builds where hypgen cannot run: the code of all example and test models.

python benchmarks/device/emit.py FOLDER
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from hypgen.codegen.generate import generate
from hypgen.dsl.load import load
from hypgen.runtime.builder.solver import runtime_files
from hypgen.runtime.builder.tools import find_json

ROOT = Path(__file__).resolve().parent.parent.parent
MODELS = ("examples", "tests/differential/models")


def put(path: Path, text: str) -> None:
    """Write a file, its folder too."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def main() -> None:
    """Replace the folder's models, runtime and third-party headers."""
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit((__doc__ or "").strip())
    folder = Path(sys.argv[1])
    for part in ("models", "runtime", "third_party"):
        shutil.rmtree(folder / part, ignore_errors=True)
    for name, source in runtime_files().items():
        put(folder / "runtime" / name, source.read_text(encoding="utf-8"))
    shutil.copytree(find_json() / "nlohmann", folder / "third_party" / "nlohmann")
    paths = sorted(path for part in MODELS for path in (ROOT / part).rglob("*.pomdp"))
    for path in paths:
        for name, text in generate(load(path).model).items():
            if name.startswith(("src/", "include/")):
                put(folder / "models" / path.stem / Path(name).name, text)
    shutil.copy(Path(__file__).with_name("examples.py"), folder)
    print(f"{len(paths)} models in {folder}")


if __name__ == "__main__":
    main()
