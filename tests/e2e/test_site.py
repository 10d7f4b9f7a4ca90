# SPDX-License-Identifier: Apache-2.0
"""The documentation site: it builds without warnings, no link is broken, and a browser shows it."""

import functools
import http.server
import json
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urldefrag

import browser as browser_calls
import pytest
from support.npm import require_npm

ROOT = Path(__file__).parents[2]
CHROMIUM = shutil.which("chromium")
pytestmark = pytest.mark.site
pytest.importorskip("furo", reason="needs hypgen[docs]")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if built := os.environ.get("HYPGEN_SITE"):
        return Path(built)
    out = tmp_path_factory.mktemp("site")
    command = [
        sys.executable,
        "-m",
        "sphinx",
        "-j",
        "auto",
        "-W",
        "--keep-going",
        "-q",
        "-c",
        "docs/site",
        ".",
    ]
    command.append(str(out))
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return out


@pytest.fixture(scope="module")
def playground(site: Path) -> Path:
    require_npm()
    build = ROOT / "docs" / "site" / "playground" / "build.py"
    subprocess.run([sys.executable, str(build), str(site / "playground")], cwd=ROOT, check=True)
    return site


class Page(HTMLParser):
    """The links of a page, and the places that links may lead to."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.places: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if value and name in ("href", "src", "xlink:href"):
                self.links.append(value)
            if value and name in ("id", "name"):
                self.places.add(value)


def test_no_link_is_broken(site: Path) -> None:
    pages = {path: Page(path) for path in site.rglob("*.html")}
    broken = []
    for path, page in pages.items():
        for link in page.links:
            target, place = urldefrag(link)
            if ":" in target or target.startswith("//"):
                continue
            file = (path.parent / unquote(target.partition("?")[0])).resolve() if target else path
            is_there = file.exists() and (
                not place or file not in pages or unquote(place) in pages[file].places
            )
            if not is_there and file.name != "index.html" and "playground" not in file.parts:
                broken.append(f"{path.relative_to(site)}: {link}")
    assert not broken, broken


@pytest.fixture
def browser(site: Path) -> Iterator[Any]:
    api = pytest.importorskip("playwright.sync_api")
    if CHROMIUM is None:
        pytest.skip("needs chromium")
    sandbox = ["--no-sandbox"] if os.getuid() == 0 else []
    with api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=sandbox)
        yield started
        started.close()


@pytest.fixture
def address(site: Path) -> Iterator[str]:
    handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=str(site))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.mark.parametrize("width", [1400, 390])
def test_pages_fit_their_window(browser: Any, address: str, width: int, tmp_path: Path) -> None:
    page = browser.new_page(viewport={"width": width, "height": 900})
    for name in ("README", "docs/guide/solver", "docs/reference/grammar", "docs/reference/errors/e02"):
        page.goto(f"{address}/{name}.html")
        assert page.evaluate("document.documentElement.scrollWidth") <= width, name
        page.screenshot(path=tmp_path / f"{name.replace('/', '-')}-{width}.png")


def test_drawings_of_the_grammar_have_their_style(browser: Any, address: str) -> None:
    page = browser.new_page()
    page.goto(f"{address}/docs/reference/grammar.html")
    style = "all => all.map(r => getComputedStyle(r).fill)"
    fills = page.eval_on_selector_all(".railroad .non-terminal rect, .railroad path", style)
    assert set(fills) == {"none"}


def test_the_search_finds_a_code(browser: Any, address: str) -> None:
    page = browser.new_page()
    page.goto(f"{address}/search.html?q=E0201")
    page.wait_for_selector("#search-results li a")
    found = page.eval_on_selector_all("#search-results li a", "all => all.map(a => a.getAttribute('href'))")
    assert any("errors/" in link for link in found)


def test_the_playground_checks_in_a_browser(browser: Any, playground: Path, address: str) -> None:
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.goto(f"{address}/playground/index.html")
    told = "document.getElementById('status').textContent.includes('{}')"
    page.wait_for_function(told.format("OK: Tiger"), timeout=120_000)
    page.evaluate(
        "() => { const e = document.querySelector('.CodeMirror').CodeMirror;"
        "e.setValue(e.getValue().replace('room.tiger == left', 'rom.tiger == left')); }"
    )
    assert "E0201" in page.wait_for_selector(".message.error").inner_text()
    page.select_option("#examples", "tag.pomdp")
    page.wait_for_function(told.format("OK: Tag"), timeout=60_000)
    page.click("#explain")
    page.wait_for_function("document.getElementById('result').textContent.startsWith('Tag: discount')")
    assert not wrong


def test_the_playground_draws_an_episode(
    browser: Any, playground: Path, address: str, tmp_path: Path
) -> None:
    # NumPy for Pyodide is out of reach of tests: Python answers beforehand, in the place of the worker.
    played = browser_calls.play((ROOT / "examples" / "rock_sample.pomdp").read_text(), "rocks.pomdp", 7)
    answers = {
        "check": {"line": "OK", "diagnostics": []},
        "play": played,
        "act": browser_calls.act("2"),
    }
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    worker = "onmessage = ({ data }) => postMessage({ id: data.id, answer: ANSWERS[data.call] });"
    body = worker.replace("ANSWERS", json.dumps(answers))
    page.route("**/worker.js", lambda route: route.fulfill(body=body, content_type="text/javascript"))
    page.goto(f"{address}/playground/index.html")
    page.wait_for_function("document.getElementById('status').textContent === 'OK'")
    page.click("#start")
    page.wait_for_selector("#world svg.world .truth .shape")
    before = page.inner_html("#world .truth")
    page.click("[data-act=policy]")
    page.wait_for_function("document.getElementById('result').textContent.includes('step 0:')")
    assert page.inner_html("#world .truth") != before
    for width in (1280, 390):
        page.set_viewport_size({"width": width, "height": 900})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        page.screenshot(path=tmp_path / f"episode-{width}.png", full_page=True)
    assert not wrong
