# SPDX-License-Identifier: Apache-2.0
"""Sphinx makes the site of the Markdown files where they lie: the source folder is the repository."""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "docs" / "site"), str(ROOT / "src")]

project = "hypgen"
author = "The hypgen authors"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_click", "generated_pages", "links"]
root_doc = "README"
include_patterns = [
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "benchmarks/**.md",
    "docs/**.md",
    "examples/**.md",
    "cli/**.md",
    "codegen/**.md",
    "dsl/**.md",
    "runtime/**.md",
    "editors/**.md",
    "src/hypgen/**.md",
]
exclude_patterns = [".*", "build", "tests", "src/*/cli", "src/*/codegen", "src/*/dsl", "src/*/runtime"]

myst_heading_anchors = 4
suppress_warnings = ["myst.header"]  # an entry of the error index has no heading above its own level
highlight_language = "text"  # of blocks that name no language: messages, formulas
default_role = "code"
add_module_names = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True

html_theme = "furo"
html_title = "hypgen"
html_static_path = ["style.css"]
html_css_files = ["style.css"]
html_extra_path = ["start"]
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
