# SPDX-License-Identifier: Apache-2.0
"""Serves the page of a run that goes on, to this machine alone."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import parse_qs, urlsplit

from hypgen.views.live import LiveEpisodes

_LOOPBACK = "127.0.0.1"
_TYPES = {"/": "text/html", "/news": "application/json"}


@contextmanager
def serve_live(episodes: LiveEpisodes) -> Iterator[str]:
    """Yield the address of the page, which is served meanwhile. Raises ``OSError``.

    The port is a free one. Requests that name another host are refused: a page of another site, whose name
    leads to this machine, learns nothing.
    """

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            url = urlsplit(self.path)
            if self.headers.get("Host") not in hosts:
                self._send(HTTPStatus.FORBIDDEN, "text/plain", f"Only {address} is served.\n")
            elif url.path not in _TYPES:
                self._send(HTTPStatus.NOT_FOUND, "text/plain", "There is no such page.\n")
            elif url.path == "/":
                self._send(HTTPStatus.OK, _TYPES["/"], episodes.page())
            else:
                asked = {name: found[0] for name, found in parse_qs(url.query).items()}
                try:
                    news = episodes.news(int(asked["episode"]), int(asked["steps"]))
                except (KeyError, ValueError):
                    self._send(
                        HTTPStatus.BAD_REQUEST, "text/plain", "Say which episode, and how many steps.\n"
                    )
                else:
                    self._send(HTTPStatus.OK, _TYPES["/news"], json.dumps(news, allow_nan=False))

        def _send(self, status: HTTPStatus, kind: str, text: str) -> None:
            body = text.encode()
            self.send_response(status)
            self.send_header("Content-Type", f"{kind}; charset=utf-8")
            self.send_header("Content-Length", str(len(body)))
            self.send_header("Cache-Control", "no-store")
            self.send_header("X-Content-Type-Options", "nosniff")
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_: object) -> None:
            """Say nothing: standard error is the run's."""

    class Server(ThreadingHTTPServer):
        daemon_threads = True

        def handle_error(self, *_: object) -> None:
            """Say nothing where a browser has gone away."""

    with Server((_LOOPBACK, 0), Handler) as server:
        port = server.server_address[1]
        address = f"http://{_LOOPBACK}:{port}/"
        hosts = {f"{_LOOPBACK}:{port}", f"localhost:{port}"}
        thread = threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True)
        thread.start()
        try:
            yield address
        finally:
            server.shutdown()
            thread.join()
