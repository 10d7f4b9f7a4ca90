# SPDX-License-Identifier: Apache-2.0
"""The graph of imports and includes, measured from the files: packages, floors, arrows back, circles.

python tests/support/import_graph.py [CHECKOUT] prints one row for each layer of a checkout (this one by
default). An arrow goes from the importing module to the imported one; imports for type checking and
imports inside functions count. A module's floor is the length of the longest way down from it, circles
taken as one. An arrow back leads to a module from which a depth-first walk has come.
"""

from __future__ import annotations

import ast
import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

LAYERS = ("dsl", "codegen", "runtime", "cli")
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)

Graph = dict[str, set[str]]


def python_files(layer: Path) -> Iterator[Path]:
    """Yield a layer's modules."""
    return (p for p in sorted(layer.rglob("*.py")) if "__pycache__" not in p.parts)


def imported(path: Path) -> Iterator[str]:
    """Yield the full name of every module that a file imports, and of every name that it takes from one."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def module_graph(root: Path, layers: Iterable[str] = LAYERS) -> Graph:
    """Return which modules of hypgen import which, without the prefix ``hypgen.``.

    A name that a package passes on leads to the package itself.
    """
    paths = {_module(path.relative_to(root)): path for layer in layers for path in python_files(root / layer)}
    graph: Graph = {}
    for name, path in paths.items():
        found = (_nearest(target.removeprefix("hypgen."), paths) for target in imported(path))
        graph[name] = {target for target in found if target is not None and target != name}
    return graph


def include_graph(root: Path) -> Graph:
    """Return which of the runtime's headers and sources include which headers, by path."""
    include, source = root / "runtime" / "include" / "hypgen", root / "runtime" / "src"
    headers = (p for p in include.rglob("*.*") if p.suffix in (".hpp", ".cuh"))
    files = {p.relative_to(include).as_posix(): p for p in headers}
    sources = {p.relative_to(source).as_posix(): p for p in source.rglob("*.?pp")}
    graph: Graph = {}
    for name, path in {**files, **sources}.items():
        targets = set()
        for target in INCLUDE.findall(path.read_text(encoding="utf-8")):
            private = os.path.normpath(f"{os.path.dirname(name)}/{target}")
            targets.add(private if private in sources else target.removeprefix("hypgen/"))
        graph[name] = targets & ({*files, *sources} - {name})
    return graph


def packages_of(graph: Graph, separator: str) -> Graph:
    """Return the graph of the folders that a graph's modules or files lie in."""
    result: Graph = {}
    for name, targets in graph.items():
        room = folder(name, graph, separator)
        rooms = result.setdefault(room, set())
        rooms.update(r for r in (folder(target, graph, separator) for target in targets) if r != room)
    return result


def folder(name: str, graph: Mapping[str, object], separator: str) -> str:
    """Return the package of a module (a package's own is itself), or the folder of a file."""
    if separator == "." and any(other.startswith(f"{name}.") for other in graph):
        return name
    return name.rpartition(separator)[0] or "."


def circles(graph: Graph) -> list[set[str]]:
    """Return the sets of nodes that reach each other (Tarjan's algorithm), those of one node left out."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[set[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for target in sorted(graph.get(node, ())):
            if target not in index:
                visit(target)
                low[node] = min(low[node], low[target])
            elif target in stack:
                low[node] = min(low[node], index[target])
        if low[node] == index[node]:
            circle: set[str] = set()
            while node not in circle:
                circle.add(stack.pop())
            if len(circle) > 1:
                found.append(circle)

    for node in sorted(graph):
        if node not in index:
            visit(node)
    return found


def arrows_back(graph: Graph) -> list[tuple[str, str]]:
    """Return the arrows that lead to a node from which a depth-first walk has come."""
    found: list[tuple[str, str]] = []
    done: set[str] = set()
    way: list[str] = []

    def visit(node: str) -> None:
        way.append(node)
        for target in sorted(graph.get(node, ())):
            if target in way:
                found.append((node, target))
            elif target not in done:
                visit(target)
        done.add(way.pop())

    for node in sorted(graph):
        if node not in done:
            visit(node)
    return found


def floors(graph: Graph) -> dict[str, int]:
    """Return each node's floor; 1 is the lowest."""
    back = set(arrows_back(graph))
    result: dict[str, int] = {}

    def floor(node: str) -> int:
        if node not in result:
            below = (floor(t) for t in graph.get(node, ()) if (node, t) not in back)
            result[node] = 1 + max(below, default=0)
        return result[node]

    for node in graph:
        floor(node)
    return result


@dataclass(frozen=True)
class Row:
    """What the graph of a layer comes to."""

    layer: str
    modules: int
    packages: int
    floors_of_modules: int
    floors_of_packages: int
    circles_of_modules: list[set[str]]
    circles_of_packages: list[set[str]]
    back: int


def measure(layer: str, graph: Graph, separator: str) -> Row:
    """Return the row of a layer."""
    rooms = packages_of(graph, separator)
    return Row(
        layer,
        len(graph),
        len(rooms),
        max(floors(graph).values()),
        max(floors(rooms).values()),
        circles(graph),
        circles(rooms),
        len(arrows_back(graph)),
    )


def rows(root: Path) -> list[Row]:
    """Return a row for each Python layer, one for all of them, and one for the C++ runtime."""
    python = [measure(layer, module_graph(root, [layer]), ".") for layer in LAYERS]
    whole = measure("all Python", module_graph(root), ".")
    return [*python, whole, measure("runtime (C++)", include_graph(root), "/")]


def _module(path: Path) -> str:
    parts = path.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _nearest(name: str, modules: Mapping[str, Path]) -> str | None:
    """Return the longest beginning of a dotted name that is a module."""
    while name and name not in modules:
        name = name.rpartition(".")[0]
    return name or None


def main() -> None:
    """Print the table."""
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[2]
    head = (
        "layer",
        "modules",
        "packages",
        "floors",
        "floors of packages",
        "arrows back",
        "circles",
        "circles of packages",
    )
    print(f"| {' | '.join(head)} |\n|{'---|' * len(head)}")
    for row in rows(root):
        cells = (
            row.layer,
            row.modules,
            row.packages,
            row.floors_of_modules,
            row.floors_of_packages,
            row.back,
            _sizes(row.circles_of_modules),
            _sizes(row.circles_of_packages),
        )
        print(f"| {' | '.join(map(str, cells))} |")


def _sizes(found: list[set[str]]) -> str:
    return ", ".join(f"1 of {len(circle)}" for circle in found) or "0"


if __name__ == "__main__":
    main()
