# SPDX-License-Identifier: Apache-2.0
"""The page of a run that goes on, in a browser."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from support import recorded_episodes as recorded

from hypgen.dsl.load import load
from hypgen.views.live import LiveEpisodes
from hypgen.views.live_server import serve_live

playwright = pytest.importorskip("playwright.sync_api", reason="needs playwright: pip install 'hypgen[test]'")
CHROMIUM = shutil.which("chromium")
if CHROMIUM is None:
    pytest.skip("needs Debian's chromium", allow_module_level=True)
expect = playwright.expect


class Run:
    """A run that a test plays line by line."""

    def __init__(self, folder: Path) -> None:
        model = recorded.model_file(folder)
        self.episodes = LiveEpisodes(load(model).model, "tiger.pomdp")
        self._lines = [json.dumps(line, separators=(",", ":")) for line in recorded.lines_of(model)]

    def play(self, count: int) -> None:
        for line in self._lines[:count]:
            self.episodes.take(f"{line}\n".encode())
        del self._lines[:count]


@pytest.fixture
def page() -> Iterator[Any]:
    with playwright.sync_playwright() as runner:
        browser = runner.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page()
        page.set_default_timeout(10_000)
        page.errors = []
        page.on("pageerror", lambda error: page.errors.append(str(error)))
        page.on("console", lambda said: page.errors.append(said.text))
        yield page
        browser.close()


def test_a_page_follows_a_run_to_its_end(page: Any, tmp_path: Path) -> None:
    run = Run(tmp_path)
    with serve_live(run.episodes) as address:
        run.play(3)
        page.goto(address)
        place, button, said = (page.locator(name) for name in ("#place", "#live", "#live-said"))
        expect(place).to_have_text("step 0 of 0")
        run.play(1)
        expect(place).to_have_text("step 1 of 1")
        assert page.locator("#world .truth .true").count() == 1
        page.keyboard.press("Home")
        expect(button).to_have_attribute("aria-pressed", "false")
        run.play(1)
        expect(place).to_have_text("step 0 of 2")
        assert page.locator(".history .field").count() == 3
        run.play(3)  # the end, and the next episode
        expect(said).to_have_text("Episode 4 is played: “Live” shows it.")
        expect(place).to_have_text("step 0 of 2")
        button.click()
        expect(page.locator(".lead")).to_contain_text("Episode 4, while it is played")
        run.play(3)
        expect(place).to_have_text("the end")
        assert "It earned" in page.inner_text("#decision")
        run.episodes.end()
        expect(said).to_have_text("The run is over.")
        assert page.errors == []
    page.keyboard.press("Home")
    expect(place).to_have_text("step 0 of 2")


def test_a_run_that_is_killed_ends_the_page_in_words(page: Any, tmp_path: Path) -> None:
    run = Run(tmp_path)
    with serve_live(run.episodes) as address:
        page.goto(address)
        assert "The first decision is not made yet" in page.inner_text("body")
        run.play(3)
        expect(page.locator("#place")).to_have_text("step 0 of 0")
    expect(page.locator("#live-said")).to_have_text("The run is over.")
    assert page.locator("#world .truth .true").count() == 1
