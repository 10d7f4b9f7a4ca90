# SPDX-License-Identifier: Apache-2.0
"""Who owns and may change what is in the cache; damaged entries; what processes leave that are killed."""

import errno
import json
import os
import signal
import stat
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from hypgen.cli import main
from hypgen.cli.commands import doctor
from hypgen.runtime.builder import cache, exported_project
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.process_group import ProcessGroup

NOBODY = 65534
as_root = pytest.mark.skipif(os.geteuid() != 0, reason="only root can act as another user")


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("HYPGEN_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture(params=[0, 0o002, 0o077])
def umask(request: pytest.FixtureRequest) -> Iterator[int]:
    before = os.umask(request.param)
    yield request.param
    os.umask(before)


def build(to: Path) -> None:
    (to / "lib").mkdir()
    (to / "lib" / "libtoy.so").write_text("a library")
    (to / "toy").write_text("#!/bin/sh\necho toy\n")
    (to / "toy").chmod(0o777)


def made(key: str = "abc") -> Path:
    return cache.make("solvers", key, build)


def rights(path: Path) -> int:
    return stat.S_IMODE(path.lstat().st_mode)


def test_only_the_user_has_rights_whatever_the_umask(umask: int, own_cache: Path, tmp_path: Path) -> None:
    made()
    cache.write_record("records", "r", {"model": "m"})
    cache.write_log("log", "text")
    for path in (own_cache, *own_cache.rglob("*")):
        is_open = path.is_dir() or path.name == "toy"
        assert rights(path) == (0o700 if is_open else 0o600), path
    assert len(list(own_cache.rglob("*"))) == 14


def test_what_is_taken_out_of_the_cache_has_the_rights_of_the_users_files(
    umask: int, own_cache: Path, tmp_path: Path
) -> None:
    library, _ = exported_project.export_library(made() / "lib" / "libtoy.so", tmp_path / "out")
    assert library == tmp_path / "out" / "lib" / "libtoy.so"
    assert rights(library) == rights(tmp_path / "out" / exported_project.MARKER) == 0o666 & ~umask
    assert rights(tmp_path / "out" / "toy") == 0o777 & ~umask
    assert not list((tmp_path / "out").rglob(cache.MANIFEST))


PLACES: dict[str, Callable[[Path], Path]] = {
    "root": lambda folder: folder,
    "kind": lambda folder: folder / "solvers",
    "entry": lambda folder: folder / "solvers" / "abc",
    "manifest": lambda folder: folder / "solvers" / "abc" / cache.MANIFEST,
    "files": lambda folder: folder / "solvers" / "abc" / cache.FILES,
    "program": lambda folder: folder / "solvers" / "abc" / cache.FILES / "toy",
    "library": lambda folder: folder / "solvers" / "abc" / cache.FILES / "lib" / "libtoy.so",
}


@pytest.mark.parametrize("place", PLACES)
def test_what_others_may_write_is_refused(place: str, own_cache: Path) -> None:
    made()
    path = PLACES[place](own_cache)
    for bit in (0o020, 0o002):
        path.chmod(rights(path) & 0o700 | bit)
        with pytest.raises(ToolchainError, match=f"'{path}' of .* may be written by others") as error:
            cache.entry("solvers", "abc")
        assert f"chmod -R go-w {path}" in error.value.remedy
        with pytest.raises(ToolchainError, match="may be written by others"):
            made()
        with pytest.raises(ToolchainError, match="may be written by others"):
            cache.contents()


@as_root
@pytest.mark.parametrize("place", PLACES)
def test_what_others_own_is_refused(place: str, own_cache: Path) -> None:
    made()
    path = PLACES[place](own_cache)
    os.chown(path, NOBODY, NOBODY)
    with pytest.raises(ToolchainError, match=f"'{path}' belongs to .*, and hypgen runs as root") as error:
        cache.entry("solvers", "abc")
    assert "HYPGEN_CACHE_DIR" in error.value.remedy
    with pytest.raises(ToolchainError, match="belongs to"):
        made()


@as_root
def test_the_second_user_of_a_cache_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A team's cache: even where all may read and write it, each user has one of their own."""
    with tempfile.TemporaryDirectory() as name:  # pytest's own folders are closed to others
        Path(name).chmod(0o755)
        monkeypatch.setenv("HYPGEN_CACHE_DIR", f"{name}/team")
        made()
        for path in (Path(name) / "team").rglob("*"):
            path.chmod(0o777)
        (Path(name) / "team").chmod(0o777)
        assert_refused_for_nobody()


def assert_refused_for_nobody() -> None:
    child = os.fork()
    if child == 0:
        code = 1
        try:
            os.setgroups([])
            os.setresgid(NOBODY, NOBODY, NOBODY)
            os.setresuid(NOBODY, NOBODY, NOBODY)
            code = 0 if refuses(lambda: cache.entry("solvers", "abc")) and refuses(made) else 2
        finally:
            os._exit(code)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def refuses(action: Callable[[], object]) -> bool:
    try:
        action()
    except ToolchainError as error:
        return "belongs to root" in error.message and "of your own" in error.remedy
    return False


@pytest.mark.parametrize("place", PLACES)
def test_a_planted_link_is_refused(place: str, own_cache: Path, tmp_path: Path) -> None:
    made()
    path = PLACES[place](own_cache)
    path.rename(tmp_path / "elsewhere")
    path.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(ToolchainError, match=f"'{path}' is a link"):
        cache.entry("solvers", "abc")


def test_links_in_place_of_locks_records_and_logs_reach_nothing(own_cache: Path, tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    victim.write_text("precious")
    for kind in cache.KINDS:
        cache.folder(kind)
    for name in ("solvers/lock-a", "records/r.json", "logs/log.log", "records/tmp-s.json", "solvers/tmp-bcd"):
        (own_cache / name).symlink_to(victim)
    with pytest.raises(ToolchainError, match="lock-a' is a link"):
        made()
    assert cache.read_record("records", "r") == {}
    cache.write_record("records", "r", {"model": "m"})
    cache.write_record("records", "s", {"model": "m"})
    assert cache.read_record("records", "r") == cache.read_record("records", "s") == {"model": "m"}
    assert cache.write_log("log", "text").read_text() == "text"
    made("bcd")
    assert victim.read_text() == "precious"
    with pytest.raises(ToolchainError, match="lock-a' is a link"):
        cache.contents()


def test_a_pipe_in_place_of_a_file_does_not_make_hypgen_wait(own_cache: Path) -> None:
    made()
    manifest = own_cache / "solvers" / "abc" / cache.MANIFEST
    manifest.unlink()
    os.mkfifo(manifest, 0o600)
    with pytest.raises(ToolchainError, match="is no file"):
        cache.entry("solvers", "abc")


def test_a_folder_that_anybody_may_move_is_refused(own_cache: Path, tmp_path: Path) -> None:
    tmp_path.chmod(0o777)
    for action in (made, lambda: cache.entry("solvers", "abc")):
        with pytest.raises(ToolchainError, match=f"anybody may replace what is in '{tmp_path}'") as error:
            action()
    assert f"chmod o-w {tmp_path}" in error.value.remedy
    assert not own_cache.exists()
    tmp_path.chmod(0o1777)
    made()


DAMAGES: dict[str, Callable[[Path], object]] = {
    "other bytes of the same size": lambda path: (path / "files/toy").write_text("#!/bin/sh\necho bad\n"),
    "shorter": lambda path: os.truncate(path / "files/toy", 3),
    "empty": lambda path: os.truncate(path / "files/lib/libtoy.so", 0),
    "missing file": lambda path: (path / "files/toy").unlink(),
    "more files": lambda path: (path / "files/lib/libmore.so").write_text("more"),
    "files gone": lambda path: (path / "files").rename(path.parent / "gone"),
    "no manifest": lambda path: (path / cache.MANIFEST).unlink(),
    "empty manifest": lambda path: (path / cache.MANIFEST).write_text(""),
    "manifest of bytes": lambda path: (path / cache.MANIFEST).write_bytes(b"\xff\xfe"),
    "manifest of numbers": lambda path: (path / cache.MANIFEST).write_text('{"toy": 3}'),
    "manifest that is a list": lambda path: (path / cache.MANIFEST).write_text("[]"),
    "manifest with short rows": lambda path: (path / cache.MANIFEST).write_text('{"toy": []}'),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_entry_is_made_again(damage: str, own_cache: Path) -> None:
    path = made()
    before = os.umask(0o077)
    DAMAGES[damage](path.parent)
    os.umask(before)
    assert cache.entry("solvers", "abc") is None
    assert subprocess.run([made() / "toy"], capture_output=True, text=True).stdout == "toy\n"
    assert cache.entry("solvers", "abc") == path
    assert not list(own_cache.glob("*/tmp-*"))


def test_a_manifest_lists_size_and_digest(own_cache: Path) -> None:
    rows = json.loads((made().parent / cache.MANIFEST).read_text())
    assert {name: row[0] for name, row in rows.items()} == {"lib/libtoy.so": 9, "toy": 19}
    assert all(len(row[1]) == 64 for row in rows.values())


def test_an_entry_that_is_asked_for_again_replaces_the_old_one() -> None:
    made()
    path = cache.make("solvers", "abc", lambda to: None, again=True)
    assert list(path.iterdir()) == []


def test_a_full_disk_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(to: Path) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(to))

    with pytest.raises(ToolchainError, match="No space left on device") as error:
        cache.make("solvers", "abc", fail)
    assert "make room" in error.value.remedy


def test_without_a_home_the_variable_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_home() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(cache, "cache_folder", no_home)
    for action in (made, lambda: cache.entry("solvers", "abc"), lambda: cache.write_log("log", "")):
        with pytest.raises(ToolchainError, match="no home folder") as error:
            action()
    assert "HYPGEN_CACHE_DIR" in error.value.remedy
    assert cache.read_record("records", "r") == {}
    cache.write_record("records", "r", {})


BUILD = """
import sys, time
from hypgen.runtime.builder import cache
def build(to):
    (to / "half").write_text("half")
    print("begun", flush=True)
    time.sleep(60)
cache.make("solvers", sys.argv[1], build)
"""


def test_what_a_killed_process_leaves_is_removed_at_the_next_use(own_cache: Path) -> None:
    path = made("bcd")
    with subprocess.Popen([sys.executable, "-c", BUILD, "abc"], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stdout.readline() == b"begun\n"
        temporary = own_cache / "solvers" / "tmp-abc"
        assert cache.entry("solvers", "bcd") == path and cache.entry("solvers", "abc") is None
        assert temporary.is_dir(), "a process that lives keeps its folder"
        (temporary / cache.FILES / "half").chmod(0o666)  # as compilers do where the umask is 0
        assert cache.contents().entries == 1
        process.kill()
        process.wait()
        assert temporary.is_dir()
        (own_cache / "records" / "tmp-name.json").write_text("{")
        assert cache.entry("solvers", "bcd") == path
        assert not list(own_cache.glob("*/tmp-*"))


GROUP = """
import sys
from hypgen.runtime.builder.process_group import ProcessGroup
with ProcessGroup() as group:
    group.run(["/bin/sh", "-c", "sleep 60 & echo $! > $0; wait", sys.argv[1]])
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGKILL, signal.SIGINT])
def test_a_kill_ends_what_compilers_have_started(number: signal.Signals, tmp_path: Path) -> None:
    file = tmp_path / "pid"
    command = [sys.executable, "-c", GROUP, file]
    # What runs in the background of a shell may ignore the signal.
    with subprocess.Popen(command, stderr=subprocess.DEVNULL, preexec_fn=lambda: reset(number)) as process:
        wait_for(lambda: file.exists() and file.read_text().endswith("\n"))
        process.send_signal(number)
        assert process.wait() != 0
    grandchild = int(file.read_text())
    wait_for(lambda: not is_running(grandchild))


def test_an_error_in_one_thread_ends_the_others_commands(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError), ProcessGroup() as group:
        inner = subprocess.Popen(["sleep", "60"], process_group=group._watcher.pid)
        raise RuntimeError("stop")
    assert inner.wait() == -signal.SIGTERM
    assert group.run(["true"]).returncode == -signal.SIGTERM, "nothing is started any more"


def test_a_group_that_ends_well_ends_nothing() -> None:
    with ProcessGroup() as group:
        inner = subprocess.Popen(["sleep", "60"], process_group=group._watcher.pid)
        assert group.run(["echo", "said"]).stdout == "said\n"
    assert inner.poll() is None
    inner.kill()
    inner.wait()


def reset(number: signal.Signals) -> None:
    if number != signal.SIGKILL:
        signal.signal(number, signal.SIG_DFL)


def wait_for(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + 20
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def is_running(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.cxx
def test_doctor_tells_of_the_cache(
    own_cache: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    made()
    main.run(["doctor"])
    line = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("cache"))
    assert str(own_cache) in line and "drwx------" in line and "1 entry" in line and " free" in line
    monkeypatch.setattr(doctor, "LITTLE_ROOM", 1 << 60)
    assert main.run(["doctor"]) == 0
    assert f"help: make room in '{own_cache}'" in capsys.readouterr().out
    own_cache.chmod(0o777)
    assert main.run(["doctor"]) == 2
    output = capsys.readouterr().out
    assert f"'{own_cache}' of" in output and f"help: run `chmod -R go-w {own_cache}`" in output
