# SPDX-License-Identifier: Apache-2.0
"""Names of a model stay what they are in C++, but for those that C++ or its headers have taken."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from support.paths import EXAMPLES, ROOT

from hypgen.codegen.generate import generate
from hypgen.codegen.layout.naming import Scope
from hypgen.dsl.load import load


@pytest.mark.parametrize("name", ["for", "NULL", "errno", "SIGINT", "M_PI", "MAP_FIXED", "std", "State"])
def test_a_taken_name_ends_with_an_underscore(name: str) -> None:
    assert Scope().unique(name) == f"{name}_"


@pytest.mark.parametrize("name", ["N", "X", "Robot", "UAVState", "rock_5", "time", "Door", "b2C"])
def test_other_names_stay(name: str) -> None:
    assert Scope().unique(name) == name


@pytest.mark.cxx
def test_no_macro_of_a_header_is_the_name_of_anything(tmp_path: Path) -> None:
    """Those with a leading underscore stay: C++ reserves such names, and no author writes them."""
    for path, text in generate(load(EXAMPLES / "tiger.pomdp").model).items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(text)
    compiler = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        pytest.skip("there is no C++ compiler")
    folders = (ROOT / "runtime" / "include", tmp_path / "src", tmp_path / "include")
    source = tmp_path / "src" / "library.cpp"
    command = [compiler, "-std=c++17", "-dM", "-E", *(f"-I{folder}" for folder in folders), str(source)]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    macros = set(re.findall(r"^#define ([A-Za-z]\w*)", listed, re.MULTILINE))
    assert "errno" in macros and "EOF" in macros
    assert {name for name in macros if Scope().unique(name) == name} == set()
