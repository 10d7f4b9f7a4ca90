# SPDX-License-Identifier: Apache-2.0
"""Puts the playground together in a folder: the page, Pyodide and the editor by npm, hypgen as a zip file."""

import json
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from importlib.util import find_spec
from pathlib import Path

from hypgen.dsl.types.palette import PALETTE

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
VIEWS = ROOT / "src" / "hypgen" / "views"
PYODIDE, CODEMIRROR = "314.0.7", "5.65.19"
_TAKEN = {
    f"pyodide@{PYODIDE}": {
        "pyodide": (
            "pyodide.mjs",
            "pyodide.asm.mjs",
            "pyodide.asm.wasm",
            "pyodide-lock.json",
            "python_stdlib.zip",
        )
    },
    f"codemirror@{CODEMIRROR}": {
        "editor": ("lib/codemirror.js", "lib/codemirror.css", "addon/mode/simple.js", "LICENSE")
    },
}
_DRAWING = ("values.js", "world.js")  # of the page of `hypgen view`
_PACKAGES = ("dsl", "codegen", "cli")  # of hypgen; what is compiled is no part of the page


def build(out: Path) -> None:
    """Write the page to ``out``; npm's registry and an environment that has hypgen are needed."""
    out.mkdir(parents=True, exist_ok=True)
    for package, folders in _TAKEN.items():
        for folder, files in folders.items():
            _fetch(package, files, out / folder)
    for name in ("index.html", "page.css", "page.js"):
        shutil.copyfile(HERE / name, out / name)
    for name in _DRAWING:
        shutil.copyfile(VIEWS / name, out / name)
    (out / "world.css").write_text(_style(), encoding="utf-8")
    worker = (HERE / "worker.js").read_text(encoding="utf-8")
    (out / "worker.js").write_text(worker.replace("%PYODIDE%", PYODIDE), encoding="utf-8")
    (out / "models.json").write_text(json.dumps(_models()), encoding="utf-8")
    with zipfile.ZipFile(out / "python.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for path, name in _python():
            archive.write(path, name)


def _fetch(package: str, files: tuple[str, ...], out: Path) -> None:
    out.mkdir(exist_ok=True)
    if all((out / Path(file).name).exists() for file in files):
        return
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            ["npm", "pack", "--silent", package], cwd=folder, check=True, stdout=subprocess.DEVNULL
        )
        (packed,) = Path(folder).glob("*.tgz")
        with tarfile.open(packed) as archive:
            for file in files:
                content = archive.extractfile(f"package/{file}")
                assert content is not None
                (out / Path(file).name).write_bytes(content.read())


def _models() -> dict[str, object]:
    """Return the examples by name, and the words that the editor colours."""
    sys.path.insert(0, str(HERE.parent))
    import colours

    files = sorted((ROOT / "examples").glob("*.pomdp"))
    types = sorted(colours.TYPES)
    return {
        "examples": {path.name: path.read_text(encoding="utf-8") for path in files},
        "words": [word for word in colours.reserved_words() if word not in types],
        "types": types,
    }


def _style() -> str:
    """Return the look of what is drawn: that of the page of `hypgen view`, for one element of this page."""
    colours = (VIEWS.parent / "colours.css").read_text(encoding="utf-8")
    names = "".join(f"--c-{name}: {light}; " for name, (light, _) in PALETTE.items())
    # The page around it has one look, by day and by night.
    bright = colours.partition("@media")[0] + f":root {{ --believed: #1d5fbf; {names}}}\n"
    return bright + f"#world {{\n{(VIEWS / 'page.css').read_text(encoding='utf-8')}}}\n"


def _python() -> list[tuple[Path, str]]:
    """Return the files that Python needs, with their names in the archive."""
    found = [(HERE / "browser.py", "browser.py")]
    found += [(path, f"hypgen/{path.name}") for path in sorted((ROOT / "src" / "hypgen").glob("*.py"))]
    for package in _PACKAGES:
        found += [
            (path, f"hypgen/{package}/{path.relative_to(ROOT / package)}") for path in _code(ROOT / package)
        ]
    for library in ("lark", "click"):
        spec = find_spec(library)
        assert spec is not None and spec.origin is not None
        folder = Path(spec.origin).parent
        found += [(path, f"{library}/{path.relative_to(folder)}") for path in _code(folder)]
    found += [(path, f"examples/{path.name}") for path in sorted((ROOT / "examples").glob("*.pomdp"))]
    return found


def _code(folder: Path) -> list[Path]:
    kept = (".py", ".lark", ".json")
    return sorted(path for path in folder.rglob("*") if path.suffix in kept and path.is_file())


if __name__ == "__main__":
    build(Path(sys.argv[1]))
