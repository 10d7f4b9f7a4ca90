# SPDX-License-Identifier: Apache-2.0
"""Where texts of messages stand: in dsl/messages, in the module of their group, each with an example."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.paths import ROOT

from hypgen.cli.show.error_index import entries

MODULES = sorted(p for p in (ROOT / "dsl" / "messages").glob("*.py") if re.match(r"e\d\d_|[wc]_", p.name))
RULES = ROOT / "dsl" / "syntax" / "errors"  # each rule of syntax holds its own text
CODE = re.compile(r"[EC]\d{4}|W\d\d")


def codes(path: Path) -> set[str]:
    strings = (n.value for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.Constant))
    return {value for value in strings if isinstance(value, str) and CODE.fullmatch(value)}


def written() -> Iterator[Path]:
    """Yield the modules that may make use of messages."""
    for layer in ("dsl", "codegen", "runtime", "cli"):
        yield from (p for p in sorted((ROOT / layer).rglob("*.py")) if p not in MODULES)


@pytest.mark.parametrize("path", MODULES, ids=lambda p: p.stem)
def test_a_module_has_the_codes_of_its_group(path: Path) -> None:
    group = path.stem.partition("_")[0].upper()
    assert codes(path) and all(code.startswith(group) for code in codes(path))


def test_every_code_has_an_entry_in_the_index_and_every_entry_a_code() -> None:
    known = {code for path in (*MODULES, *RULES.glob("*.py")) for code in codes(path)}
    assert known == set(entries())


def test_codes_stand_nowhere_else() -> None:
    found = {path.relative_to(ROOT).as_posix(): codes(path) for path in written() if path.parent != RULES}
    assert {path: numbers for path, numbers in found.items() if numbers} == {}
    assert all(code.startswith("E01") for path in RULES.glob("*.py") for code in codes(path))


def test_every_message_is_given_somewhere() -> None:
    text = "\n".join(path.read_text() for path in written())
    for path in MODULES:
        functions = [n for n in ast.parse(path.read_text()).body if isinstance(n, ast.FunctionDef)]
        public = [f for f in functions if not f.name.startswith("_")]
        assert [f.name for f in public if f"{path.stem}.{f.name}" not in text] == [], path.name


def test_a_message_is_data() -> None:
    """Every function returns a Diagnostic but one, which a remedy is asked of."""
    for path in MODULES:
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
                wanted = "str" if node.name == "number_remedy" else "Diagnostic"
                assert node.returns is not None and ast.unparse(node.returns) == wanted, node.name
