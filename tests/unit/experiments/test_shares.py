# SPDX-License-Identifier: Apache-2.0
"""What cells and compilations hold of a machine, and a solver whose player dies."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from hypgen.experiments import shares, worker
from hypgen.experiments.generated import program_of
from hypgen.experiments.shares import Stopped, held
from hypgen.runtime.builder.solver import Report, Step


@pytest.fixture(autouse=True)
def four_cores(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HYPGEN_CACHE_DIR", str(tmp_path))
    for module in (shares, worker):
        monkeypatch.setattr(module, "visible_cores", lambda: [0, 1, 2, 5])


def test_no_two_cells_share_a_core_or_a_gpu() -> None:
    with held(3, ["7"], lambda: False) as (cores, gpu), held(1, [], lambda: False) as (others, none):
        assert sorted([*cores, *others]) == [0, 1, 2, 5]
        assert gpu == "7" and none is None
        with pytest.raises(Stopped), held(1, [], lambda: True):
            pass
    with held(9, ["7"], lambda: False) as (cores, gpu):
        assert cores == [0, 1, 2, 5], "one with more threads than cores takes all"


def test_a_large_cell_is_served_before_small_ones_that_come_later() -> None:
    order: list[str] = []

    def take(name: str, cores: int) -> None:
        with held(cores, [], lambda: False):
            order.append(name)

    with held(1, [], lambda: False):
        large = threading.Thread(target=take, args=("large", 4))
        large.start()
        while not any(path.name.endswith("core5") for path in Path(shares.cache.folder("shares")).iterdir()):
            time.sleep(0.005)
        small = threading.Thread(target=take, args=("small", 1))
        small.start()
        time.sleep(0.1)
        assert order == []
    large.join()
    small.join()
    assert order == ["large", "small"]


def test_a_worker_compiles_once_and_alone_on_its_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = {"src/main.cpp": "int main() {}"}
    built: list[str] = []

    def build_solver(given: object, origin: str, report: Report, cuda: object) -> Path:
        assert given == files and cuda is None
        report(Step("runtime", ""))  # the cache has it
        with held(1, [], lambda: False):
            pass
        for what in ("runtime", "tiger"):
            report(Step(what, "new model"))
            with pytest.raises(Stopped), held(1, [], lambda: True):
                pass
            built.append(what)
        return Path(sys.executable)

    monkeypatch.setattr(worker, "build_solver", build_solver)
    work = worker.Work(program_of(files), worker.pack(files), (), None, 1, False, 10.0, "0.2")
    first = worker._solver(work, lambda: False)
    assert worker._solver(work, lambda: False) == first
    assert built == ["runtime", "tiger"]
    with held(4, [], lambda: False):
        pass


def test_a_solver_ends_where_its_player_is_killed() -> None:
    code = (
        "from hypgen.experiments.process import SolverProcess; from pathlib import Path; import os, time\n"
        "mine = sorted(os.sched_getaffinity(0))[:1]\n"
        "one = SolverProcess(['sh', '-c', 'exec sleep 100'], Path('none'), mine, None, {}, 100, None)\n"
        "print(one._process.pid, flush=True); time.sleep(100)"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as player:
        assert player.stdout is not None
        solver = int(player.stdout.readline())
        stat = Path(f"/proc/{solver}/cmdline")
        while not stat.read_text().startswith("sleep"):  # setpriv and taskset come first
            time.sleep(0.01)
        player.send_signal(signal.SIGKILL)
    end = time.monotonic() + 10
    while _lives(solver):
        assert time.monotonic() < end
        time.sleep(0.01)


def _lives(process: int) -> bool:
    try:
        os.kill(process, 0)
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"
