# SPDX-License-Identifier: Apache-2.0
"""What all tests share."""

import os
import signal
from collections.abc import Iterator

import pytest


@pytest.fixture(scope="session", autouse=True)
def build_cache(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep solvers that tests build out of the user's cache, but from one run of the tests to the next."""
    cache = getattr(request.config, "cache", None)  # missing where its plugin is switched off
    folder = cache.mkdir("hypgen") if cache is not None else tmp_path_factory.mktemp("hypgen")
    folder.chmod(0o700)  # hypgen refuses a cache that the umask lets others write
    before = os.environ.get("HYPGEN_CACHE_DIR")
    os.environ["HYPGEN_CACHE_DIR"] = str(folder)
    yield
    if before is None:
        del os.environ["HYPGEN_CACHE_DIR"]
    else:
        os.environ["HYPGEN_CACHE_DIR"] = before


@pytest.fixture(scope="session", autouse=True)
def quick_builds() -> Iterator[None]:
    """Let what tests build be optimised less than what users build: that is quicker, and no bit differs."""
    with pytest.MonkeyPatch.context() as patch:
        if "CXXFLAGS" not in os.environ:
            # g++ warns at -O1 of words that PhiloxDraws always computes before it reads them.
            patch.setenv("CXXFLAGS", "-O1 -Werror -Wno-maybe-uninitialized")
        yield


@pytest.fixture(scope="session", autouse=True)
def interruptible() -> None:
    """Let this process and what it starts heed signals that a shell's background or `nohup` ignores."""
    for number, usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, usual)
