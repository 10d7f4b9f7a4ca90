# SPDX-License-Identifier: Apache-2.0
"""``hypgen run``: compile a model if need be, then become its solver."""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path

import click

from hypgen.cli.building import build
from hypgen.cli.exit_codes import exit_codes
from hypgen.cli.model_arguments import choose_cuda, load, model_options, require_params, target_options
from hypgen.cli.output import say_warnings
from hypgen.cli.recorded_runs import play_live, play_recorded, without_record

ANSWERED_WITHOUT_PARAMS = ("--param", "--help", "--version")


@click.command(
    epilog=exit_codes("the solver failed: a file, memory or --require-gpu"),
    context_settings={"ignore_unknown_options": True},
)
@model_options
@target_options
@click.option(
    "--live",
    is_flag=True,
    help="Show the episode while it is played, as a page for browsers of this machine.",
)
@click.option("--force", is_flag=True, help="Compile the model again even if nothing has changed.")
@click.argument("solver_options", metavar="[SOLVER OPTIONS]...", nargs=-1, type=click.UNPROCESSED)
def command(
    model: Path,
    instance: Path | None,
    settings: tuple[str, ...],
    target: str,
    arch: str,
    nvcc: str,
    live: bool,
    force: bool,
    solver_options: tuple[str, ...],
) -> int:
    """Compile MODEL unless the cache has it, and run its solver.

    Options that hypgen does not know go to the solver, as does everything after a `--`. The exit code is
    the solver's. With `--record FILE.mcap` the solver's recording becomes a log for Foxglove and ROS. With
    `--live` a page shows the newest episode until the run ends; --record keeps all of them.

    \b
    Examples:
      hypgen run examples/tiger.pomdp
      hypgen run examples/rock_sample.pomdp --runs 10 --time 0.1 --json steps.jsonl
      hypgen run examples/rs_11_11.pomdp --mode rollout --trials 100
      hypgen run examples/tag.pomdp --target cpu
      hypgen run examples/tag.pomdp --runs 1 --record tag.mcap
      hypgen run examples/navigation.pomdp --time 1 --live
      hypgen run examples/tiger.pomdp -- --help
    """
    if str(model).startswith("-"):
        raise click.UsageError(f"The model comes first, before the solver's options (found '{model}').")
    cuda = choose_cuda(target, arch, nvcc)
    loaded = load(model, instance, settings)
    say_warnings(loaded)
    if not any(option.split("=")[0] in ANSWERED_WITHOUT_PARAMS for option in solver_options):
        require_params(loaded, " or --param FILE")
    told, log = without_record(solver_options)
    is_mcap = log is not None and log.suffix == ".mcap"
    if is_mcap and importlib.util.find_spec("mcap") is None:
        raise click.ClickException("logs in MCAP need mcap: pip install 'hypgen[mcap]'")
    if live and any(option.split("=")[0] == "--serve" for option in solver_options):
        raise click.UsageError("--serve plays no episodes that --live could show.")
    solver = build("solver", loaded, model, instance, cuda, force)
    if live:
        return play_live(solver, told, log, loaded.model, model.name)
    if is_mcap:
        return play_recorded(solver, told, log)
    sys.stdout.flush()
    sys.stderr.flush()
    # The solver takes this process's place: signals and the exit code need no forwarding.
    try:
        os.execv(solver, [solver.name, *solver_options])
    except OSError as error:  # a cache on a file system without programs: say where it is
        raise OSError(error.errno, error.strerror, str(solver)) from None
