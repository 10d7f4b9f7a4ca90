# SPDX-License-Identifier: Apache-2.0
"""``hypgen solve``: the value of a small model, between proven bounds."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import click

from hypgen.cli.building import build_exact
from hypgen.cli.exit_codes import exit_codes
from hypgen.cli.model_arguments import load, model_options, param_option, require_params
from hypgen.cli.output import say_warnings


@click.command(epilog=exit_codes("the model is too large, or a file cannot be written"))
@model_options
@param_option
@click.option(
    "--time",
    metavar="S",
    type=click.FloatRange(0, 1e9),
    default=60.0,
    show_default=True,
    help="Seconds to solve, once all states are known.",
)
@click.option(
    "--gap",
    metavar="GAP",
    type=click.FloatRange(0, 1e9),
    default=0.001,
    show_default=True,
    help="Stop where upper and lower bound are so close, relative to the value's size.",
)
@click.option(
    "--memory",
    metavar="MIB",
    type=click.IntRange(1, 1_000_000),
    default=4096,
    show_default=True,
    help="Memory for the matrices, and again for the search.",
)
@click.option("--max-states", metavar="N", type=click.IntRange(1), help="Most states; 1,000,000 by default.")
@click.option(
    "--max-outcomes",
    metavar="N",
    type=click.IntRange(1),
    help="Most outcomes, each a state, an action, an observation and a next state; 100,000,000 by default.",
)
@click.option(
    "--policy", metavar="FILE", type=click.Path(path_type=Path), help="Write the policy that was found."
)
@click.option(
    "--policy-format",
    type=click.Choice(["hypgen", "appl"]),
    help="Format of --policy; appl is SARSOP's, over the states of `hypgen export`.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object.")
@click.option("--force", is_flag=True, help="Compile the model again even if nothing has changed.")
def command(
    model: Path,
    instance: Path | None,
    settings: tuple[str, ...],
    param: Path | None,
    time: float,
    gap: float,
    memory: int,
    max_states: int | None,
    max_outcomes: int | None,
    policy: Path | None,
    policy_format: str | None,
    as_json: bool,
    force: bool,
) -> None:
    """Find all states of MODEL and bound the value of its best policy from both sides.

    Every state that can be reached is found by trying all outcomes of all draws in the very code that plans
    online. Then heuristic search closes the gap between a lower bound (alpha vectors, which are a policy)
    and an upper bound. Both are proven at any moment: Ctrl-C prints them as far as they have come.

    It takes a model with up to about a million states. A float that is drawn from a continuous law has too
    many values; what depends on it cannot be solved so.

    \b
    Examples:
      hypgen solve examples/tiger.pomdp
      hypgen solve examples/rock_sample.pomdp --gap 0.5 --time 300
      hypgen solve examples/tag.pomdp --json | jq .lower
    """
    loaded = load(model, instance, settings)
    say_warnings(loaded)
    if param is None:
        require_params(loaded, " or --param FILE")
    solver = build_exact(loaded, model, instance, force)
    options = [f"--time={time!r}", f"--gap={gap!r}", f"--memory={memory}"]
    options += ["--json=-", "--quiet"] if as_json else []
    given: dict[str, object] = {
        "param": param,
        "max-states": max_states,
        "max-outcomes": max_outcomes,
        "policy": policy,
        "policy-format": policy_format,
    }
    options += [f"--{name}={value}" for name, value in given.items() if value is not None]
    sys.stdout.flush()
    sys.stderr.flush()
    # As for `run`: signals and the exit code need no forwarding.
    os.execv(solver, [solver.name, *options])
