# SPDX-License-Identifier: Apache-2.0
"""An editor that talks to `hypgen lsp`: in the same process, which starts at once, or over its pipes."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from lsprotocol import types as lsp
from pygls.io_ import run_async
from pygls.lsp.client import BaseLanguageClient

from hypgen.editor.server import make_server


class Client(BaseLanguageClient):
    """A client that notes how its server ended."""

    status: int | None = None

    async def server_exit(self, server: asyncio.subprocess.Process) -> None:
        """Keep the exit status."""
        self.status = server.returncode


class Editor:
    """An editor with open texts, and the diagnostics that it has been sent for each."""

    def __init__(self) -> None:
        self.client = Client("test", "1")
        self.shown: dict[str, asyncio.Queue[lsp.PublishDiagnosticsParams]] = {}
        self._version = 1

        @self.client.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def diagnostics(params: lsp.PublishDiagnosticsParams) -> None:
            self._queue(params.uri).put_nowait(params)

    def _queue(self, uri: str) -> asyncio.Queue[lsp.PublishDiagnosticsParams]:
        return self.shown.setdefault(uri, asyncio.Queue())

    async def open(self, path: Path, text: str) -> list[lsp.Diagnostic]:
        """Open a text and return what is said of it."""
        item = lsp.TextDocumentItem(path.as_uri(), "hypgen", 1, text)
        self.client.text_document_did_open(lsp.DidOpenTextDocumentParams(item))
        return await self.told(path)

    async def change(self, path: Path, text: str) -> list[lsp.Diagnostic]:
        """Change a text and return what is said of it, and not of an earlier one."""
        self.send(path, text)
        return await self.told(path, self._version)

    def send(self, path: Path, text: str) -> None:
        """Change a text and wait for nothing."""
        self._version += 1
        version = lsp.VersionedTextDocumentIdentifier(version=self._version, uri=path.as_uri())
        whole = [lsp.TextDocumentContentChangeWholeDocument(text)]
        self.client.text_document_did_change(lsp.DidChangeTextDocumentParams(version, whole))

    async def told(self, path: Path, version: int = 0) -> list[lsp.Diagnostic]:
        """Return the next diagnostics that are sent for a file, of a version of its text or a later one."""
        while True:
            found = await asyncio.wait_for(self._queue(path.as_uri()).get(), 60)
            if (found.version or 0) >= version:
                return list(found.diagnostics)


@asynccontextmanager
async def in_process() -> AsyncIterator[Editor]:
    """Give an editor with a server in this process and thread."""
    editor, server, stop = Editor(), make_server(), threading.Event()
    to_server, to_editor = asyncio.StreamReader(), asyncio.StreamReader()
    server.protocol.set_writer(_Pipe(to_editor))
    editor.client.protocol.set_writer(_Pipe(to_server))
    tasks = [
        asyncio.ensure_future(run_async(stop, to_server, server.protocol)),
        asyncio.ensure_future(run_async(stop, to_editor, editor.client.protocol)),
    ]
    await _greet(editor)
    yield editor
    stop.set()
    for reader in (to_server, to_editor):
        reader.feed_eof()
    await asyncio.gather(*tasks)


@asynccontextmanager
async def over_pipes(*command: str) -> AsyncIterator[Editor]:
    """Give an editor with a server that ``command`` starts, as editors do."""
    editor = Editor()
    await editor.client.start_io(*command)
    await _greet(editor)
    yield editor
    await editor.client.shutdown_async(None)
    editor.client.exit(None)
    while not editor.client.stopped:
        await asyncio.sleep(0.01)
    await editor.client.stop()
    assert editor.client.status == 0


async def _greet(editor: Editor) -> None:
    await editor.client.initialize_async(lsp.InitializeParams(capabilities=lsp.ClientCapabilities()))
    editor.client.initialized(lsp.InitializedParams())


class _Pipe:
    """The writing end of a reader of the same process."""

    def __init__(self, reader: asyncio.StreamReader) -> None:
        self._reader = reader

    def write(self, data: bytes) -> None:
        self._reader.feed_data(data)

    def close(self) -> None:
        pass
