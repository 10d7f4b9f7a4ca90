# SPDX-License-Identifier: Apache-2.0
"""The language server: the protocol's requests as questions to ``answers``, ``facts`` and ``fixes``."""

from __future__ import annotations

import asyncio
import logging
import os
import threading
from typing import Any

from lsprotocol import types as lsp
from pygls import uris
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer

from hypgen.dsl.foreign.recognise import recognise
from hypgen.dsl.format.formatter import format_source
from hypgen.dsl.load import Loaded
from hypgen.dsl.messages.diagnostic import Diagnostic, ModelError
from hypgen.dsl.messages.source import Source, Span
from hypgen.dsl.syntax import ast
from hypgen.editor import answers, renames
from hypgen.editor.document import Checked, Declared, Document, citation
from hypgen.editor.facts import facts
from hypgen.editor.fixes import fixes
from hypgen.editor.words import lexemes

PAUSE = 0.15  # seconds without a key before a text is checked
_SYMBOLS = {
    "element": lsp.SymbolKind.Class,
    "enum": lsp.SymbolKind.Enum,
    "variant": lsp.SymbolKind.EnumMember,
    "record": lsp.SymbolKind.Struct,
    "field": lsp.SymbolKind.Field,
    "fn": lsp.SymbolKind.Function,
    "policy": lsp.SymbolKind.Function,
    "const": lsp.SymbolKind.Constant,
    "type": lsp.SymbolKind.TypeParameter,
}
_INNER = ("binder",)
TOKENS = ("keyword", "type", "function", "variable", "enumMember", "number", "string", "comment", "operator")
_COLOURS = {
    "declarations": "keyword",
    "control": "keyword",
    "operators": "keyword",
    "types": "type",
    "constants": "keyword",
    "functions": "function",
    "values": "variable",
    "COMMENT": "comment",
    "STRING": "string",
    "FLOAT": "number",
    "INT": "number",
    "symbols": "operator",
}
_NAMES = {"fn": "function", "enum": "type", "record": "type", "type": "type", "variant": "enumMember"}


class Server(LanguageServer):
    """A server with the documents that are open, by address."""

    def __init__(self) -> None:
        super().__init__("hypgen", "1")
        self.open: dict[str, Document] = {}
        self.checks: dict[str, tuple[asyncio.Task[None], threading.Event]] = {}

    def document(self, uri: str) -> Document:
        """Return an open document with the text that the editor has now."""
        document = self.open.setdefault(uri, Document(uris.to_fs_path(uri) or uri))
        document.text = self._text(uri)
        document.edited = {
            os.path.realpath(d.path): self._text(u).encode("utf-8", "replace") for u, d in self.open.items()
        }
        return document

    def _text(self, uri: str) -> str:
        return self.workspace.get_text_document(uri).source.replace("\r\n", "\n")

    def offset(self, uri: str, position: lsp.Position) -> int:
        """Return the offset of an editor's position in a document's text."""
        lines = self.document(uri).text.split("\n")
        if position.line >= len(lines):
            return len(self.document(uri).text)
        codec = self.workspace.position_codec
        own = codec.position_from_client_units([f"{line}\n" for line in lines], position)
        before = sum(len(line) + 1 for line in lines[: own.line])
        return before + min(own.character, len(lines[own.line]))

    def range(self, text: str, start: int, end: int) -> lsp.Range:
        """Return the editor's range between two offsets of a text."""
        return lsp.Range(start=self._position(text, start), end=self._position(text, end))

    def range_of(self, text: str, span: Span) -> lsp.Range:
        """Return the editor's range of a place in a text."""
        lines = text.split("\n")

        def position(line: int, column: int) -> lsp.Position:
            line = max(1, min(line, len(lines)))
            before = lines[line - 1][: max(0, column - 1)]
            return lsp.Position(line - 1, self._units(before))

        return lsp.Range(position(span.line, span.column), position(span.end_line, span.end_column))

    def _position(self, text: str, offset: int) -> lsp.Position:
        start = text.rfind("\n", 0, offset) + 1
        return lsp.Position(text.count("\n", 0, offset), self._units(text[start:offset]))

    def _units(self, text: str) -> int:
        return int(self.workspace.position_codec.client_num_units(text))

    def check_soon(self, uri: str, pause: float, *, users: bool = True) -> None:
        """Check a document after a pause in seconds, in the place of any check of it that goes on.

        ``users``: what takes in this file is checked then, too.
        """
        self.stop_check(uri)
        stop = threading.Event()
        task = asyncio.ensure_future(self._check(uri, pause, stop, users))
        task.add_done_callback(_log_failure)
        self.checks[uri] = task, stop

    def stop_check(self, uri: str) -> None:
        """Give up the check of a document, if there is one."""
        if uri in self.checks:
            task, stop = self.checks.pop(uri)
            stop.set()
            task.cancel()

    async def _check(self, uri: str, pause: float, stop: threading.Event, users: bool) -> None:
        await asyncio.sleep(pause)
        document, version = self.document(uri), self.workspace.get_text_document(uri).version
        checked = await asyncio.to_thread(document.examine, document.text, stop.is_set)
        document.take(checked)
        found = [self.diagnostic(document.path, checked, d) for d in checked.found]
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, found, version))
        if users:
            self.check_users(uri, document.path)

    def check_users(self, uri: str, path: str) -> None:
        """Check the open texts that take in a file, now that it has changed."""
        for other, opened in self.open.items():
            if other != uri and citation(opened.checked, opened.path, path) is not None:
                self.check_soon(other, 0, users=False)

    def diagnostic(self, path: str, checked: Checked, found: Diagnostic) -> lsp.Diagnostic:
        """Return a diagnostic of the compiler as one of the protocol.

        What is wrong in another file shows where the text names that file, with the place itself as related.
        """
        span, message, notes = found.span, found.message, list(found.notes)
        if span is not None and span.file == path:
            place = self.range_of(checked.text, span)
        else:
            cited = None if span is None else citation(checked, path, span.file)
            place = _TOP if cited is None else self.range(checked.text, *cited)
            if span is not None:
                notes.insert(0, (span, message))
                message = f"in {os.path.basename(span.file)}, line {span.line}: {message}"
        related = []
        for where, note in notes:
            source = checked.sources.get(where.file)
            text = checked.text if where.file == path or source is None else source.text
            location = lsp.Location(_address(where.file), self.range_of(text, where))
            related.append(lsp.DiagnosticRelatedInformation(location, note))
        return lsp.Diagnostic(
            range=place,
            message=f"{message}\n{found.remedy}" if found.remedy else message,
            severity=lsp.DiagnosticSeverity.Error
            if found.severity == "error"
            else lsp.DiagnosticSeverity.Warning,
            code=found.code,
            source="hypgen",
            related_information=related or None,
        )


def _log_failure(task: asyncio.Task[None]) -> None:
    """Write a check's exception, a mistake of hypgen, where editors show what a server logs."""
    if not task.cancelled() and task.exception() is not None:
        logging.getLogger(__name__).error("a check failed", exc_info=task.exception())


def _address(path: str) -> str:
    return uris.from_fs_path(os.path.abspath(path)) or path


_TOP = lsp.Range(lsp.Position(0, 0), lsp.Position(0, 1))


def make_server() -> Server:
    """Return a server that has every feature and waits for ``start_io``."""
    server = Server()
    _follow_texts(server)
    _answer_positions(server)
    _answer_texts(server)
    _answer_edits(server)
    return server


def _follow_texts(server: Server) -> None:
    @server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
    def opened(params: lsp.DidOpenTextDocumentParams) -> None:
        server.check_soon(params.text_document.uri, 0)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
    def changed(params: lsp.DidChangeTextDocumentParams) -> None:
        server.check_soon(params.text_document.uri, PAUSE)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
    def closed(params: lsp.DidCloseTextDocumentParams) -> None:
        uri = params.text_document.uri
        server.stop_check(uri)
        server.open.pop(uri, None)
        server.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))
        server.check_users(uri, uris.to_fs_path(uri) or uri)


def _answer_positions(server: Server) -> None:
    def asked(params: Any) -> tuple[str, Document, int]:
        uri = params.text_document.uri
        return uri, server.document(uri), server.offset(uri, params.position)

    @server.feature(lsp.TEXT_DOCUMENT_HOVER)
    def hover(params: lsp.HoverParams) -> lsp.Hover | None:
        _, document, offset = asked(params)
        shown = answers.hover(document, offset)
        return (
            lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, f"```pomdp\n{shown}\n```"))
            if shown
            else None
        )

    @server.feature(lsp.TEXT_DOCUMENT_DEFINITION)
    def definition(params: lsp.DefinitionParams) -> lsp.Location | None:
        _, document, offset = asked(params)
        found = answers.at(document, offset)
        return _location(server, document, found[0]) if found else None

    @server.feature(lsp.TEXT_DOCUMENT_REFERENCES)
    def references(params: lsp.ReferenceParams) -> list[lsp.Location]:
        uri, document, offset = asked(params)
        found = answers.references(document, offset)
        here = [lsp.Location(uri, server.range(document.text, t.start, t.end)) for t in found]
        return here + [
            lsp.Location(_address(source.name), server.range(source.text, t.start, t.end))
            for source, t in answers.references_in_libraries(document, offset)
        ]

    @server.feature(lsp.TEXT_DOCUMENT_RENAME)
    def rename(params: lsp.RenameParams) -> lsp.WorkspaceEdit:
        uri, document, offset = asked(params)
        try:
            edits = renames.rename(document, offset, params.new_name)
        except renames.RenameRefused as error:
            raise JsonRpcInvalidParams(str(error)) from None
        changes: dict[str, list[lsp.TextEdit]] = {}
        for edit in edits:
            here = edit.path == document.path
            address = uri if here else uris.from_fs_path(edit.path) or edit.path
            text = document.text if here else server.workspace.get_text_document(address).source
            made = lsp.TextEdit(server.range(text, edit.start, edit.end), edit.text)
            changes.setdefault(address, []).append(made)
        return lsp.WorkspaceEdit(changes=changes)

    @server.feature(lsp.TEXT_DOCUMENT_COMPLETION, lsp.CompletionOptions(trigger_characters=["."]))
    def completion(params: lsp.CompletionParams) -> list[lsp.CompletionItem]:
        _, document, offset = asked(params)
        return [
            lsp.CompletionItem(
                label=item.label,
                detail=item.detail,
                insert_text=item.snippet or None,
                insert_text_format=lsp.InsertTextFormat.Snippet if item.snippet else None,
            )
            for item in answers.completions(document, offset)
        ]

    @server.feature(lsp.TEXT_DOCUMENT_SIGNATURE_HELP, lsp.SignatureHelpOptions(trigger_characters=["(", ","]))
    def signature(params: lsp.SignatureHelpParams) -> lsp.SignatureHelp | None:
        _, document, offset = asked(params)
        found = answers.signature(document, offset)
        if found is None:
            return None
        label, formals, active = found
        one = lsp.SignatureInformation(label, parameters=[lsp.ParameterInformation(f) for f in formals])
        return lsp.SignatureHelp([one], active_signature=0, active_parameter=active)


def _answer_texts(server: Server) -> None:
    @server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    def symbols(params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
        document = server.document(params.text_document.uri)
        own = [d for d in document.declared() if d.node.span.file == document.path and d.word not in _INNER]
        return [_symbol(server, document, d, own) for d in own if d.holder is None]

    @server.feature(lsp.TEXT_DOCUMENT_FOLDING_RANGE)
    def folds(params: lsp.FoldingRangeParams) -> list[lsp.FoldingRange]:
        text = server.document(params.text_document.uri).text
        opened: list[int] = []
        found = []
        for token in lexemes(text):
            if token.text in ("{", "(", "["):
                opened.append(text.count("\n", 0, token.start))
            elif token.text in ("}", ")", "]") and opened:
                first, last = opened.pop(), text.count("\n", 0, token.start)
                found += [lsp.FoldingRange(first, last)] if last > first else []
        return found

    @server.feature(lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, lsp.SemanticTokensLegend(list(TOKENS), []))
    def tokens(params: lsp.SemanticTokensParams) -> lsp.SemanticTokens:
        document = server.document(params.text_document.uri)
        text, named = document.text, {d.name: _NAMES.get(d.word, "variable") for d in document.declared()}
        data: list[int] = []
        line = column = 0
        for token in lexemes(text):
            kind = _COLOURS.get(token.kind) or named.get(token.text)
            if kind is None:
                continue
            place = server.range(text, token.start, token.end)
            at = place.start
            moved = at.line - line
            data += [moved, at.character - (0 if moved else column), place.end.character - at.character]
            data += [TOKENS.index(kind), 0]
            line, column = at.line, at.character
        return lsp.SemanticTokens(data)

    @server.feature(lsp.TEXT_DOCUMENT_INLAY_HINT)
    def hints(params: lsp.InlayHintParams) -> list[lsp.InlayHint]:
        document = server.document(params.text_document.uri)
        if not isinstance(document.loaded, Loaded) or document.loaded_text != document.text:
            return []
        result = []
        for fact in facts(document.loaded):
            if fact.hint and fact.span.file == document.path:
                where = server.range_of(document.text, fact.span)
                line = document.text.split("\n")[where.start.line]
                end = lsp.Position(where.start.line, server._units(line.partition("#")[0].rstrip()))
                result.append(lsp.InlayHint(end, f"{fact.name}: {fact.hint}", padding_left=True))
        return result

    @server.feature(lsp.TEXT_DOCUMENT_CODE_LENS)
    def lenses(params: lsp.CodeLensParams) -> list[lsp.CodeLens]:
        document = server.document(params.text_document.uri)
        foreign = recognise(Source(document.path, document.text)) is not None
        commands = ("import",) if foreign else ("check", "sim", "explain")
        if not foreign and not isinstance(document.tree, (ast.ModelFile, ast.InstanceFile)):
            return []
        return [
            lsp.CodeLens(
                _TOP, lsp.Command(f"hypgen {c}", f"hypgen.{c}", arguments=[params.text_document.uri])
            )
            for c in commands
        ]


def _answer_edits(server: Server) -> None:
    @server.feature(lsp.TEXT_DOCUMENT_FORMATTING)
    def formatting(params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit]:
        document = server.document(params.text_document.uri)
        try:
            text = format_source(Source(document.path, document.text))
        except ModelError:
            return []
        whole = server.range(document.text, 0, len(document.text))
        return [] if text == document.text else [lsp.TextEdit(whole, text)]

    @server.feature(lsp.TEXT_DOCUMENT_CODE_ACTION)
    def actions(params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        uri = params.text_document.uri
        document = server.document(uri)
        if recognise(Source(document.path, document.text)) is not None:
            title = "Import this model into hypgen's language"
            command = lsp.Command(title, "hypgen.import", arguments=[uri])
            return [lsp.CodeAction(title, kind=lsp.CodeActionKind.QuickFix, command=command)]
        result = []
        checked = document.current()
        for mistake in checked.found:
            shown = server.diagnostic(document.path, checked, mistake)
            if (
                shown.range.start.line > params.range.end.line
                or shown.range.end.line < params.range.start.line
            ):
                continue
            title = f"What {mistake.code} means"
            command = lsp.Command(title, "hypgen.error", arguments=[mistake.code])
            result.append(lsp.CodeAction(title, diagnostics=[shown], command=command))
            for fix in fixes(document, mistake):
                edit = lsp.TextEdit(server.range(document.text, fix.start, fix.end), fix.text)
                made = lsp.WorkspaceEdit(changes={uri: [edit]})
                kind = lsp.CodeActionKind.QuickFix
                result.append(lsp.CodeAction(fix.title, kind=kind, diagnostics=[shown], edit=made))
        return result


def _location(server: Server, document: Document, found: Declared) -> lsp.Location:
    span = document.name_span(found)
    text = document.text_of(span.file)
    return lsp.Location(_address(span.file), server.range_of(text, span))


def _symbol(server: Server, document: Document, found: Declared, all_: list[Declared]) -> lsp.DocumentSymbol:
    whole = server.range_of(document.tree_text, found.node.span)
    name = server.range_of(document.tree_text, document.name_span(found))
    inner = [d for d in all_ if d.holder == found.name and d is not found]
    kind = _SYMBOLS.get(found.word, lsp.SymbolKind.Variable)
    children = [_symbol(server, document, d, []) for d in inner]
    return lsp.DocumentSymbol(found.name, kind, whole, name, detail=found.word, children=children)
