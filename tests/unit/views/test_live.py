# SPDX-License-Identifier: Apache-2.0
"""What a page is told of a run that goes on, and whom its server answers."""

from __future__ import annotations

import html
import http.client
import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from support import recorded_episodes as recorded

from hypgen.dsl.load import load
from hypgen.views.live import LiveEpisodes
from hypgen.views.live_server import serve_live

Lines = list[dict[str, Any]]


def taken(episodes: LiveEpisodes, lines: Lines) -> None:
    for line in lines:
        episodes.take(json.dumps(line, separators=(",", ":")).encode() + b"\n")


@pytest.fixture
def lines(tmp_path: Path) -> Lines:
    return recorded.lines_of(recorded.model_file(tmp_path))


@pytest.fixture
def episodes(tmp_path: Path, lines: Lines) -> LiveEpisodes:
    return LiveEpisodes(load(recorded.model_file(tmp_path)).model, "tiger.pomdp")


def test_steps_come_one_by_one_and_what_was_earned_at_the_end(episodes: LiveEpisodes, lines: Lines) -> None:
    taken(episodes, lines[:2])
    assert "The first decision is not made yet" in episodes.page()
    taken(episodes, lines[2:4])
    news = episodes.news(3, 1)
    assert [one["step"] for one in news["steps"]] == [1] and news["earned"] == [None, None]
    assert news["steps"][0]["truth"][0]["name"] == "tiger" and not news["over"]
    taken(episodes, lines[4:6])
    news = episodes.news(3, 3)
    assert news["steps"] == [] and news["ended"] == "step_limit" and None not in news["earned"]
    assert news["end"]["state"]


def test_the_newest_episode_is_shown_once_it_has_a_step(episodes: LiveEpisodes, lines: Lines) -> None:
    taken(episodes, lines[:6])
    episodes.page()
    taken(episodes, lines[6:7])
    assert episodes.news(3, 0)["episode"] == 3
    taken(episodes, lines[7:8])
    news = episodes.news(3, 3)
    assert news["episode"] == 4 and "steps" not in news
    assert "Episode 4, while it is played" in episodes.page()


def test_a_line_that_cannot_be_read_is_said(episodes: LiveEpisodes, lines: Lines) -> None:
    taken(episodes, [*lines[:3], {"type": "step", "name": "<b>"}])
    assert "is broken" in episodes.news(3, 0)["problem"]
    assert episodes.news(3, 0)["episode"] == 3, "what came before is shown"


def test_a_run_ends_when_an_open_page_has_heard_of_it(episodes: LiveEpisodes, lines: Lines) -> None:
    episodes.end()  # nobody has asked: it does not wait
    taken(episodes, lines[:3])
    episodes.page()
    ending = threading.Thread(target=episodes.end)
    ending.start()
    assert episodes.news(3, 1)["over"]
    ending.join(timeout=1.0)
    assert not ending.is_alive()


@pytest.fixture
def address(episodes: LiveEpisodes, lines: Lines) -> Iterator[str]:
    taken(episodes, lines[:4])
    with serve_live(episodes) as found:
        yield found


def asked(address: str, path: str, host: str | None = None) -> tuple[int, str]:
    place = urlsplit(address)
    connection = http.client.HTTPConnection(place.hostname or "", place.port, timeout=10)
    connection.request("GET", path, headers={} if host is None else {"Host": host})
    answer = connection.getresponse()
    found = answer.status, answer.read().decode()
    connection.close()
    return found


def test_the_server_is_of_this_machine_alone(address: str) -> None:
    place = urlsplit(address)
    assert place.hostname == "127.0.0.1"
    for host in ("evil.example", f"evil.example:{place.port}", "127.0.0.1", ""):
        for path in ("/", "/news?episode=3&steps=0"):
            assert asked(address, path, host)[0] == 403
    assert asked(address, "/", f"localhost:{place.port}")[0] == 200


@pytest.mark.parametrize(
    ("path", "status"),
    [
        ("/", 200),
        ("/news?episode=3&steps=0", 200),
        ("/news", 400),
        ("/news?episode=x&steps=0", 400),
        ("/../tiger.pomdp", 404),
        ("/news/", 404),
    ],
)
def test_the_server_has_a_page_and_its_news(address: str, path: str, status: int) -> None:
    assert asked(address, path)[0] == status


def test_the_page_may_ask_its_own_server_alone(address: str) -> None:
    _, page = asked(address, "/")
    assert "default-src 'none'" in page and "connect-src 'self'" in html.unescape(page)
    assert len(json.loads(asked(address, "/news?episode=3&steps=1")[1])["steps"]) == 1


def test_the_server_ends(episodes: LiveEpisodes) -> None:
    with serve_live(episodes) as address:
        pass
    with pytest.raises(ConnectionRefusedError):
        asked(address, "/")
