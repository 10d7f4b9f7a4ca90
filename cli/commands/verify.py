# SPDX-License-Identifier: Apache-2.0
"""``hypgen verify``: does a model's code compute the same, however and wherever it runs?"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import click

from hypgen.cli.building import build
from hypgen.cli.exit_codes import Exit, code_of_program, exit_codes
from hypgen.cli.model_arguments import (
    choose_cuda,
    load,
    model_options,
    param_option,
    require_params,
    target_options,
)
from hypgen.cli.output import say_warnings

MOST_LANES = 100_000_000


@click.command(epilog=exit_codes("something differs; the first walk and step are named"))
@model_options
@target_options
@param_option
@click.option(
    "--seconds",
    metavar="S",
    type=click.FloatRange(0.1, 1e6),
    default=10.0,
    show_default=True,
    help="About how long to compare.",
)
@click.option(
    "--lanes",
    metavar="N",
    type=click.IntRange(1, MOST_LANES),
    help="Random walks to compare, instead of as many as --seconds allows.",
)
@click.option(
    "--steps",
    metavar="T",
    type=click.IntRange(1, 1_000_000),
    default=90,
    show_default=True,
    help="Steps of each walk.",
)
@click.option(
    "--seed",
    metavar="N",
    type=click.IntRange(0, 2**64 - 1),
    default=0,
    show_default=True,
    help="Seed of the walks.",
)
@click.option("--json", "as_json", is_flag=True, help="Print a JSON object for each check.")
def command(
    model: Path,
    instance: Path | None,
    settings: tuple[str, ...],
    target: str,
    arch: str,
    nvcc: str,
    param: Path | None,
    seconds: float,
    lanes: int | None,
    steps: int,
    seed: int,
    as_json: bool,
) -> int:
    """Compile a program that checks MODEL's code: it compares random walks, bit for bit.

    Steps that several warps of a GPU share, in any order of the warps, are compared with plain ones on the
    CPU; where there is a GPU, its steps with the CPU's. Everything counts that a step computes: states,
    observations, rewards, bounds, the filter, what the policy knows. The table says how many steps were
    compared, in how many walks something differs and where first, and what was left out.

    \b
    Examples:
      hypgen verify examples/tag.pomdp
      hypgen verify examples/crowd_driving.pomdp --seconds 60 --seed 7
      hypgen verify examples/rock_sample.pomdp --target cuda --lanes 1000000
    """
    cuda = choose_cuda(target, arch, nvcc)
    loaded = load(model, instance, settings)
    say_warnings(loaded)
    if param is None:
        require_params(loaded, " or --param FILE")
    program = build("verify", loaded, model, instance, cuda)
    test = [str(program), "--steps", str(steps), "--seed", str(seed)]
    test += ["--param", str(param)] if param is not None else []
    if lanes is None:
        try:
            lanes = _lanes_for(seconds, test)
        except subprocess.CalledProcessError as error:
            return code_of_program(error.returncode)
    sys.stdout.flush()
    done = subprocess.run([*test, "--lanes", str(lanes), *(["--json", "-"] if as_json else [])])
    return code_of_program(done.returncode)


def _lanes_for(seconds: float, test: list[str]) -> int:
    """Return how many walks can be compared in about so long, from the time that a few take."""
    few = 64 * (os.cpu_count() or 1)
    start = time.perf_counter()
    done = subprocess.run([*test, "--lanes", str(few), "--quiet"], stdout=subprocess.DEVNULL)
    if done.returncode not in (Exit.OK, Exit.DIFFERENT):
        raise subprocess.CalledProcessError(done.returncode, test)
    elapsed = time.perf_counter() - start
    return max(few, min(MOST_LANES, int(few * seconds / elapsed)))
