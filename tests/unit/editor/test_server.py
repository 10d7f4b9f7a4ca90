# SPDX-License-Identifier: Apache-2.0
"""The language server: over standard input and output, as editors start it, and in the tests' process."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable, Coroutine
from pathlib import Path

import pytest
from lsprotocol import types as lsp
from support.editor_session import Editor, in_process, over_pipes

from hypgen.editor import server
from hypgen.editor.words import lexemes

TIGER = (Path(__file__).parents[3] / "examples" / "tiger.pomdp").read_text()
COMMAND = (sys.executable, "-c", "from hypgen.cli.main import main; main()", "lsp")
WHOLE = lsp.Range(lsp.Position(0, 0), lsp.Position(1000, 0))
LIBRARY = "library Lib\n# of doors\n\nfn twice(x: int): int = 2 * x\n"
USER = (
    TIGER.replace("model Tiger\n", 'model Tiger\nimport "lib.pomdp"\n')
    + "reward more = if act == listen then twice(1) else 0\n"
)

Test = Callable[[Editor, Path], Coroutine[None, None, None]]


def session(test: Test) -> Callable[[Path, pytest.MonkeyPatch], None]:
    """Make a test of what an editor does with a server that checks at once."""

    def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(server, "PAUSE", 0.0)

        async def talk() -> None:
            async with in_process() as editor:
                await test(editor, tmp_path)

        asyncio.run(asyncio.wait_for(talk(), 60))

    run.__doc__ = test.__doc__
    return run


def place(text: str, piece: str, skip: int = 0) -> lsp.Position:
    start = text.index(piece) + skip
    return lsp.Position(text.count("\n", 0, start), start - text.rfind("\n", 0, start) - 1)


def document(path: Path) -> lsp.TextDocumentIdentifier:
    return lsp.TextDocumentIdentifier(path.as_uri())


async def titles(editor: Editor, path: Path, found: list[lsp.Diagnostic]) -> dict[str, str]:
    """Return the code actions of a text by title; lsprotocol's client takes some for commands."""
    params = lsp.CodeActionParams(document(path), WHOLE, lsp.CodeActionContext(found))
    made = await editor.client.text_document_code_action_async(params)
    return {a.title: str(a) for a in made or ()}


def test_an_editor_starts_the_command_and_ends_it(tmp_path: Path) -> None:
    async def talk() -> None:
        async with over_pipes(*COMMAND) as editor:
            assert await editor.open(tmp_path / "tiger.pomdp", TIGER) == []

    asyncio.run(asyncio.wait_for(talk(), 60))


@session
async def test_names_of_a_good_model(editor: Editor, folder: Path) -> None:
    """Hover, definition, references and rename."""
    path, where = folder / "tiger.pomdp", place(TIGER, "tiger: Door")
    assert await editor.open(path, TIGER) == []
    client, it = editor.client, document(path)
    shown = await client.text_document_hover_async(lsp.HoverParams(it, where))
    assert "hidden room.tiger" in str(shown) and "1 bit" in str(shown)
    at = await client.text_document_definition_async(lsp.DefinitionParams(it, place(TIGER, "Door)", 0)))
    assert isinstance(at, lsp.Location) and at.range.start == place(TIGER, "Door {")
    uses = await client.text_document_references_async(
        lsp.ReferenceParams(lsp.ReferenceContext(True), it, where)
    )
    assert uses is not None and len(uses) == sum(t.text == "tiger" for t in lexemes(TIGER))
    edit = await client.text_document_rename_async(lsp.RenameParams(it, where, "beast"))
    assert edit is not None and edit.changes is not None and len(edit.changes[it.uri]) == len(uses)


@session
async def test_the_whole_of_a_good_model(editor: Editor, folder: Path) -> None:
    """Symbols, folds, colours, hints and lenses."""
    path = folder / "tiger.pomdp"
    await editor.open(path, TIGER)
    client, it = editor.client, document(path)
    symbols = await client.text_document_document_symbol_async(lsp.DocumentSymbolParams(it))
    assert symbols is not None and {"Door", "room", "outcome"} <= {s.name for s in symbols}
    folds = await client.text_document_folding_range_async(lsp.FoldingRangeParams(it))
    assert folds is not None and len(folds) == 2
    tokens = await client.text_document_semantic_tokens_full_async(lsp.SemanticTokensParams(it))
    assert tokens is not None and len(tokens.data) > 5 * 100 and min(tokens.data) >= 0
    hints = await client.text_document_inlay_hint_async(lsp.InlayHintParams(it, WHOLE))
    assert hints is not None
    assert {"room.tiger: 1 bit", "outcome: -100 .. 10"} <= {str(h.label) for h in hints}
    lenses = await client.text_document_code_lens_async(lsp.CodeLensParams(it))
    assert lenses is not None
    commands = [c.command.command for c in lenses if c.command]
    assert commands == ["hypgen.check", "hypgen.sim", "hypgen.explain"]


@session
async def test_mistakes_have_fixes_and_explanations(editor: Editor, folder: Path) -> None:
    path = folder / "tiger.pomdp"
    slip = await editor.open(path, TIGER.replace("uniform(Door)\n  tiger'", "uniform(Dor)\n  tiger'"))
    assert [d.code for d in slip] and "did you mean 'Door'?" in slip[0].message
    made = await titles(editor, path, slip)
    assert "Write Door" in made
    slip = await editor.change(path, TIGER.replace("room.tiger == left", "cave == left"))
    assert [d.code for d in slip] == ["E0201"]
    explained = (await titles(editor, path, slip))["What E0201 means"]
    assert "hypgen.error" in explained and "['E0201']" in explained.replace("\\", "")


@session
async def test_half_typed_texts_and_layout(editor: Editor, folder: Path) -> None:
    path, it = folder / "tiger.pomdp", document(folder / "tiger.pomdp")
    await editor.open(path, TIGER)
    assert [d.severity for d in await editor.change(path, TIGER.replace("room {", "room {{"))] == [1]
    where = lsp.HoverParams(it, place(TIGER, "tiger: Door"))
    shown = await editor.client.text_document_hover_async(where)
    assert "hidden room.tiger" in str(shown), "the last good model answers"
    assert await editor.change(path, TIGER.replace("  hidden", "     hidden")) == []
    options = lsp.DocumentFormattingParams(it, lsp.FormattingOptions(2, True))
    laid = await editor.client.text_document_formatting_async(options)
    assert laid is not None and laid[0].new_text == TIGER


@session
async def test_cassandras_format_is_offered_an_import(editor: Editor, folder: Path) -> None:
    path = folder / "tiger.pomdp"
    foreign = await editor.open(path, "discount: 0.95\nvalues: reward\nstates: 2\n")
    assert foreign
    (action,) = (await titles(editor, path, foreign)).values()
    assert "hypgen.import" in action


@session
async def test_a_librarys_mistake_shows_where_it_is_imported(editor: Editor, folder: Path) -> None:
    path, library = folder / "tiger.pomdp", folder / "lib.pomdp"
    library.write_text(LIBRARY.replace("2 * x", "2 * xx"))
    (found,) = await editor.open(path, USER)
    assert found.range == lsp.Range(place(USER, '"lib'), place(USER, '"lib', len('"lib.pomdp"')))
    assert found.message.startswith("in lib.pomdp, line 4: ")
    assert found.related_information is not None
    there = found.related_information[0].location
    assert there.uri == library.as_uri() and there.range.start == place(LIBRARY, "x\n")


@session
async def test_a_library_that_is_not_saved_counts_for_its_users(editor: Editor, folder: Path) -> None:
    path, library = folder / "tiger.pomdp", folder / "lib.pomdp"
    library.write_text(LIBRARY)
    assert await editor.open(path, USER) == []
    assert await editor.open(library, LIBRARY) == []
    assert await editor.told(path) == []
    assert await editor.change(library, LIBRARY.replace("twice", "double")) == []
    assert "twice" in (await editor.told(path))[0].message


@session
async def test_a_library_that_is_closed_counts_as_it_is_on_disk(editor: Editor, folder: Path) -> None:
    path, library = folder / "tiger.pomdp", folder / "lib.pomdp"
    assert await editor.open(library, LIBRARY) == []
    assert await editor.open(path, USER) == []
    editor.client.text_document_did_close(lsp.DidCloseTextDocumentParams(document(library)))
    assert "lib.pomdp" in (await editor.told(path))[0].message


@session
async def test_references_reach_the_library_that_declares_a_name(editor: Editor, folder: Path) -> None:
    path, library = folder / "tiger.pomdp", folder / "lib.pomdp"
    library.write_text(LIBRARY)
    await editor.open(path, USER)
    asked = lsp.ReferenceParams(lsp.ReferenceContext(True), document(path), place(USER, "twice"))
    found = await editor.client.text_document_references_async(asked)
    assert [(u.uri, u.range.start) for u in found or ()] == [
        (path.as_uri(), place(USER, "twice")),
        (library.as_uri(), place(LIBRARY, "twice")),
    ]


@session
async def test_notes_have_the_columns_of_their_own_file(editor: Editor, folder: Path) -> None:
    path, library = folder / "tiger.pomdp", folder / "lib.pomdp"
    library.write_text(LIBRARY)
    (found,) = await editor.open(path, USER + "fn twice(x: int): int = x\n")
    related = found.related_information or []
    assert [(r.location.uri, r.location.range.start.line) for r in related] == [(library.as_uri(), 3)]
    assert related[0].location.range.end.character > 0


@session
async def test_keys_while_a_check_goes_on_give_it_up(editor: Editor, folder: Path) -> None:
    """Of many keys at once, the last one's text is what is said something of."""
    path = folder / "tiger.pomdp"
    await editor.open(path, TIGER)
    for number in range(20):
        editor.send(path, TIGER.replace("room.tiger == left", f"cave{number} == left"))
    assert "cave19" in (await editor.told(path))[0].message
    assert editor.shown[path.as_uri()].empty()


def test_a_check_that_fails_is_logged(caplog: pytest.LogCaptureFixture) -> None:
    async def fail() -> None:
        raise RuntimeError("a mistake of hypgen")

    async def talk() -> None:
        task = asyncio.ensure_future(fail())
        task.add_done_callback(server._log_failure)
        await asyncio.wait([task])
        await asyncio.sleep(0)

    asyncio.run(talk())
    assert "a mistake of hypgen" in caplog.text
