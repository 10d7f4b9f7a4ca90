# SPDX-License-Identifier: Apache-2.0
"""``hypgen run``: compile a model if need be, then become its solver."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tempfile
from itertools import pairwise
from pathlib import Path

import click

from hypgen.cli.building import build
from hypgen.cli.exit_codes import Exit, code_of_program, exit_codes
from hypgen.cli.model_arguments import choose_cuda, load, model_options, require_params, target_options
from hypgen.cli.output import say_warnings

ANSWERED_WITHOUT_PARAMS = ("--param", "--help", "--version")


@click.command(
    epilog=exit_codes("the solver failed: a file, memory or --require-gpu"),
    context_settings={"ignore_unknown_options": True},
)
@model_options
@target_options
@click.option("--force", is_flag=True, help="Compile the model again even if nothing has changed.")
@click.argument("solver_options", metavar="[SOLVER OPTIONS]...", nargs=-1, type=click.UNPROCESSED)
def command(
    model: Path,
    instance: Path | None,
    settings: tuple[str, ...],
    target: str,
    arch: str,
    nvcc: str,
    force: bool,
    solver_options: tuple[str, ...],
) -> None:
    """Compile MODEL unless the cache has it, and run its solver.

    Options that hypgen does not know go to the solver, as does everything after a `--`. The exit code is
    the solver's. With `--record FILE.mcap` the solver's recording becomes a log for Foxglove and ROS.

    \b
    Examples:
      hypgen run examples/tiger.pomdp
      hypgen run examples/rock_sample.pomdp --runs 10 --time 0.1 --json steps.jsonl
      hypgen run examples/rs_11_11.pomdp --mode rollout --trials 100
      hypgen run examples/tag.pomdp --target cpu
      hypgen run examples/tag.pomdp --runs 1 --record tag.mcap
      hypgen run examples/tiger.pomdp -- --help
    """
    if str(model).startswith("-"):
        raise click.UsageError(f"The model comes first, before the solver's options (found '{model}').")
    cuda = choose_cuda(target, arch, nvcc)
    loaded = load(model, instance, settings)
    say_warnings(loaded)
    if not any(option.split("=")[0] in ANSWERED_WITHOUT_PARAMS for option in solver_options):
        require_params(loaded, " or --param FILE")
    log = _mcap_of(solver_options)
    if log is not None and importlib.util.find_spec("mcap") is None:
        raise click.ClickException("logs in MCAP need mcap: pip install 'hypgen[mcap]'")
    solver = build("solver", loaded, model, instance, cuda, force)
    if log is not None:
        sys.exit(_run_with_log(solver, solver_options, log))
    sys.stdout.flush()
    sys.stderr.flush()
    # The solver takes this process's place: signals and the exit code need no forwarding.
    try:
        os.execv(solver, [solver.name, *solver_options])
    except OSError as error:  # a cache on a file system without programs: say where it is
        raise OSError(error.errno, error.strerror, str(solver)) from None


def _mcap_of(options: tuple[str, ...]) -> Path | None:
    """Return the file of ``--record FILE.mcap``, if the solver is given one."""
    file = next((value for name, value in pairwise(options) if name == "--record"), "")
    file = next((o.partition("=")[2] for o in options if o.startswith("--record=")), file)
    return Path(file) if file.endswith(".mcap") else None


def _run_with_log(solver: Path, options: tuple[str, ...], log: Path) -> int:
    """Run the solver with a recording beside the log, and make the log. Gives the solver's exit code."""
    from hypgen.recordings import RecordingError, open_recording
    from hypgen.recordings.mcap_file import write_mcap

    try:
        with tempfile.TemporaryDirectory(prefix=".hypgen-", dir=log.parent) as folder:
            lines = Path(folder) / "recording.jsonl"
            told = [*_without_record(options), f"--record={lines}"]
            try:
                code = code_of_program(subprocess.run([solver, *told]).returncode)
            except KeyboardInterrupt:  # the solver was told, too: what it has recorded is kept
                code = int(Exit.INTERRUPTED)
            if lines.exists() and lines.stat().st_size > 0:
                write_mcap(open_recording(lines), log)
            return code
    except RecordingError as error:
        raise click.ClickException(str(error)) from None
    except OSError as error:
        raise click.ClickException(f"{log} cannot be written: {error.strerror}") from None


def _without_record(options: tuple[str, ...]) -> list[str]:
    kept = [o for o in options if not o.startswith("--record=")]
    if "--record" in kept:
        place = kept.index("--record")
        del kept[place : place + 2]
    return kept
