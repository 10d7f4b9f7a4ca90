# SPDX-License-Identifier: Apache-2.0
"""The language server over standard input and output, as editors start it; and its answers in process."""

from __future__ import annotations

import asyncio
import random
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from lsprotocol import types as lsp
from pygls.lsp.client import BaseLanguageClient

from hypgen.editor import answers
from hypgen.editor.document import Document
from hypgen.editor.fixes import fixes
from hypgen.editor.words import lexemes

EXAMPLES = Path(__file__).parents[3] / "examples"
TIGER = (EXAMPLES / "tiger.pomdp").read_text()
INITIALS = "from hypgen.cli.main import main; main()"


def opened(tmp_path: Path, text: str = TIGER, good: str | None = None) -> Document:
    """Return a checked document; ``good`` is an earlier text of it."""
    document = Document(str(tmp_path / "model.pomdp"), good or text)
    document.check()
    document.text = text
    document.check()
    return document


def test_a_server_answers_an_editor_from_opening_to_closing(tmp_path: Path) -> None:
    asyncio.run(asyncio.wait_for(_session(tmp_path), 60))


async def _session(tmp_path: Path) -> None:
    client = BaseLanguageClient("test", "1")
    found: list[list[lsp.Diagnostic]] = []
    told = asyncio.Event()

    @client.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
    def diagnostics(params: lsp.PublishDiagnosticsParams) -> None:
        found.append(list(params.diagnostics))
        told.set()

    await client.start_io(sys.executable, "-c", INITIALS, "lsp")
    await client.initialize_async(lsp.InitializeParams(capabilities=lsp.ClientCapabilities()))
    client.initialized(lsp.InitializedParams())
    uri = (tmp_path / "tiger.pomdp").as_uri()
    document = lsp.TextDocumentIdentifier(uri)

    async def change(text: str) -> list[lsp.Diagnostic]:
        told.clear()
        version = lsp.VersionedTextDocumentIdentifier(version=len(found) + 2, uri=uri)
        whole = [lsp.TextDocumentContentChangeWholeDocument(text)]
        client.text_document_did_change(lsp.DidChangeTextDocumentParams(version, whole))
        await told.wait()
        return found[-1]

    client.text_document_did_open(
        lsp.DidOpenTextDocumentParams(lsp.TextDocumentItem(uri, "hypgen", 1, TIGER))
    )
    await told.wait()
    assert found == [[]]
    where = place(TIGER, "tiger: Door")
    shown = await client.text_document_hover_async(lsp.HoverParams(document, where))
    assert "hidden room.tiger" in str(shown) and "1 bit" in str(shown)
    at = await client.text_document_definition_async(lsp.DefinitionParams(document, place(TIGER, "Door)", 0)))
    assert isinstance(at, lsp.Location) and at.range.start == place(TIGER, "Door {")
    uses = await client.text_document_references_async(
        lsp.ReferenceParams(lsp.ReferenceContext(True), document, where)
    )
    assert uses is not None and len(uses) == sum(t.text == "tiger" for t in lexemes(TIGER))
    edit = await client.text_document_rename_async(lsp.RenameParams(document, where, "beast"))
    assert edit is not None and edit.changes is not None and len(edit.changes[uri]) == len(uses)
    ask = lsp.DocumentSymbolParams(document)
    symbols = await client.text_document_document_symbol_async(ask)
    assert symbols is not None and {"Door", "room", "outcome"} <= {s.name for s in symbols}
    folds = await client.text_document_folding_range_async(lsp.FoldingRangeParams(document))
    assert folds is not None and len(folds) == 2
    tokens = await client.text_document_semantic_tokens_full_async(lsp.SemanticTokensParams(document))
    assert tokens is not None and len(tokens.data) > 5 * 100 and min(tokens.data) >= 0
    whole = lsp.Range(lsp.Position(0, 0), lsp.Position(100, 0))
    hints = await client.text_document_inlay_hint_async(lsp.InlayHintParams(document, whole))
    assert hints is not None and "room.tiger: 1 bit" in [h.label for h in hints]
    lenses = await client.text_document_code_lens_async(lsp.CodeLensParams(document))
    assert lenses is not None and [c.command.command for c in lenses if c.command] == [
        "hypgen.check",
        "hypgen.sim",
        "hypgen.explain",
    ]
    slip = await change(TIGER.replace("uniform(Door)\n  tiger'", "uniform(Dor)\n  tiger'"))
    assert [d.code for d in slip] and "did you mean 'Door'?" in slip[0].message
    context = lsp.CodeActionContext(slip)
    made = await client.text_document_code_action_async(
        lsp.CodeActionParams(document, slip[0].range, context)
    )
    assert made is not None and "Write Door" in [a.title for a in made]
    assert [d.severity for d in await change(TIGER.replace("room {", "room {{"))] == [1]
    shown = await client.text_document_hover_async(lsp.HoverParams(document, where))
    assert "hidden room.tiger" in str(shown), "the last good model answers"
    ragged = TIGER.replace("  hidden", "     hidden")
    assert await change(ragged) == []
    options = lsp.FormattingOptions(2, True)
    laid = await client.text_document_formatting_async(lsp.DocumentFormattingParams(document, options))
    assert laid is not None and laid[0].new_text == TIGER
    foreign = await change("discount: 0.95\nvalues: reward\nstates: 2\n")
    assert foreign
    made = await client.text_document_code_action_async(
        lsp.CodeActionParams(document, foreign[0].range, lsp.CodeActionContext(foreign))
    )
    assert "hypgen.import" in str(made)
    client.text_document_did_close(lsp.DidCloseTextDocumentParams(document))
    await client.shutdown_async(None)
    client.exit(None)
    await client.stop()


def place(text: str, piece: str, skip: int = 0) -> lsp.Position:
    start = text.index(piece) + skip
    return lsp.Position(text.count("\n", 0, start), start - text.rfind("\n", 0, start) - 1)


@pytest.mark.parametrize(
    ("before", "after", "title"),
    [
        ("room.tiger ==", "room.tigr ==", "Write tiger"),
        ("init tiger ~", "init tiger =", "Write ~ for ="),
        ("act == listen then tiger", "act = listen then tiger", "Write =="),
    ],
)
def test_fixes_take_mistakes_away(tmp_path: Path, before: str, after: str, title: str) -> None:
    document = opened(tmp_path, TIGER.replace(before, after, 1))
    assert document.checked.found
    found = [f for mistake in document.checked.found for f in fixes(document, mistake)]
    assert title in [f.title for f in found]


def test_a_name_that_is_declared_twice_is_not_renamed(tmp_path: Path) -> None:
    twice = TIGER.replace("element room {", "element hall {\n  hidden tiger: Door\n}\nelement room {")
    document = opened(tmp_path, twice, TIGER)
    with pytest.raises(answers.RenameRefused):
        answers.rename(document, twice.index("tiger: Door"), "beast")
    document = opened(tmp_path)
    for taken in ("listen", "model", "a b", ""):
        with pytest.raises(answers.RenameRefused):
            answers.rename(document, TIGER.index("tiger: Door"), taken)


def test_a_param_is_renamed_in_instances_too(tmp_path: Path) -> None:
    document = opened(tmp_path)
    (tmp_path / "model.pomdp").write_text(TIGER)
    (tmp_path / "deaf.pomdp").write_text('instance deaf of "model.pomdp" { hearing = 0.5 }\n')
    edits = answers.rename(document, TIGER.index("hearing"), "ears")
    assert [Path(e.path).name for e in edits] == ["model.pomdp", "model.pomdp", "deaf.pomdp"]


def test_completions_are_of_the_scope_and_work_half_typed(tmp_path: Path) -> None:
    text = TIGER + "\nreward late = room."
    document = opened(tmp_path, text, TIGER)
    assert [i.label for i in answers.completions(document, len(text))] == ["tiger"]
    names = {i.label: i for i in answers.completions(document, text.index("reward late"))}
    assert {"room", "Door", "listen", "hearing", "match", "uniform"} <= set(names)
    assert "${1" in names["match"].snippet


def test_signatures_name_formals(tmp_path: Path) -> None:
    good = TIGER + "\nfn pay(a: Act, b: Door): int = 0\n"
    text = good + "\nreward late = pay(listen, "
    document = opened(tmp_path, text, good)
    assert answers.signature(document, len(text)) == ("pay(a: Act, b: Door)", ["a: Act", "b: Door"], 1)


def _edit(rng: random.Random, text: str) -> str:
    start = rng.randrange(len(text) + 1)
    end = min(len(text), start + rng.choice((0, 0, 1, 5, 40)))
    piece = rng.choice(
        ("", "{", "}", "(", "'", '"', "#", "\n", "let ", ".", "é", "~", "9", "if ", "match x {")
    )
    return text[:start] + piece + text[end:]


ASKED: tuple[Callable[[Document, int], Any], ...] = (
    answers.hover,
    answers.references,
    answers.completions,
    answers.signature,
)


@pytest.mark.parametrize("edits", [50, pytest.param(1000, marks=pytest.mark.slow)])
def test_random_edits_end_no_answer(tmp_path: Path, edits: int) -> None:
    rng = random.Random(7)
    document = opened(tmp_path)
    for _ in range(edits):
        document.text = _edit(rng, document.text if rng.random() < 0.7 else TIGER) or TIGER
        document.check()
        for ask in ASKED:
            ask(document, rng.randrange(len(document.text) + 1))
