# SPDX-License-Identifier: Apache-2.0
"""Directives for what pages take from the sources: grammar, options, examples; and the colours of models."""

from pathlib import Path

import grammar_drawings
import option_tables
from colours import ModelLexer
from docutils import nodes
from docutils.parsers.rst import Directive
from sphinx.application import Sphinx

ROOT = Path(__file__).parents[2]


class Grammar(Directive):
    """The rules of the language, each drawn and written."""

    def run(self) -> list[nodes.Node]:
        """Return a section for each rule."""
        made: list[nodes.Node] = []
        for name, text, drawing in grammar_drawings.drawings():
            section = nodes.section(ids=[f"rule-{name.lower().replace('_', '-')}"], names=[name])
            section += nodes.title(text=name)
            section += nodes.raw("", f'<div class="railroad">{drawing}</div>', format="html")
            section += nodes.literal_block(text=f"{name} : {text}", language="text")
            made.append(section)
        return made


class SolverOptions(Directive):
    """The options of the program whose table stands in the named file under runtime/src."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return a definition list, as ``--help`` has it."""
        options = nodes.definition_list()
        for option in option_tables.read(self.arguments[0]):
            head = f"{option.name} {option.metavar}".rstrip()
            term = nodes.term("", "", nodes.literal(text=head))
            options += nodes.definition_list_item(
                "", term, nodes.definition("", nodes.paragraph(text=option.help))
            )
        return [options]


class Examples(Directive):
    """The models of ``examples``, each with its text."""

    def run(self) -> list[nodes.Node]:
        """Return a section for each file."""
        made: list[nodes.Node] = []
        for path in sorted((ROOT / "examples").rglob("*.pomdp")):
            self.state.document.settings.env.note_dependency(str(path))
            name = str(path.relative_to(ROOT))
            section = nodes.section(ids=[nodes.make_id(name)], names=[name])
            section += nodes.title(text=name)
            section += nodes.literal_block(text=path.read_text(encoding="utf-8"), language="pomdp")
            made.append(section)
        return made


def _as_written(app: Sphinx, ctx: object, lines: list[str]) -> None:
    """Keep stars of commands' help, which is plain text, from being marks of emphasis."""
    lines[:] = [line.replace("*", r"\*") for line in lines]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register directives and lexer with Sphinx."""
    app.connect("sphinx-click-process-description", _as_written)
    for alias in ModelLexer.aliases:
        app.add_lexer(alias, ModelLexer)
    app.add_directive("grammar", Grammar)
    app.add_directive("solver-options", SolverOptions)
    app.add_directive("examples", Examples)
    return {"parallel_read_safe": True}
