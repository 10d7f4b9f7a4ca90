# SPDX-License-Identifier: Apache-2.0
"""``hypgen compare``: what the planners earn in the same episodes, beside what is proven of the best."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import click

from hypgen.cli.building import as_model, report
from hypgen.cli.exit_codes import EXIT_CODES, Exit
from hypgen.cli.interrupts import interrupt_code
from hypgen.cli.model_arguments import (
    choose_cuda,
    load,
    model_options,
    param_option,
    require_params,
    target_options,
)
from hypgen.cli.output import say, say_warnings
from hypgen.play.played_programs import (
    EXACT,
    GPU_PLANNERS,
    LEFT_OUT,
    MOST_STEPS,
    PLANNERS,
    Comparison,
    Policy,
    numbers,
    outwards,
    table,
)


@click.command(epilog=EXIT_CODES)
@model_options
@target_options
@param_option
@click.option(
    "--runs",
    metavar="N",
    type=click.IntRange(1, 1_000_000),
    default=20,
    show_default=True,
    help="Episodes.",
)
@click.option(
    "--time",
    metavar="S",
    type=click.FloatRange(1e-4, 1e6),  # this range and the others are those of the solver
    help="Seconds for each decision of a planner; 0.1 unless there are --trials.",
)
@click.option(
    "--trials", metavar="N", type=click.IntRange(1, 2**64 - 1), help="Trials for each decision instead."
)
@click.option(
    "--steps",
    metavar="N",
    type=click.IntRange(1, 1_000_000),
    help="Most steps of an episode; by default as many as leave out no more than a thousandth of the sum "
    f"of discounts, up to {MOST_STEPS}.",
)
@click.option(
    "--seed",
    metavar="S",
    type=click.IntRange(0, 2**64 - 1),
    default=0,
    show_default=True,
    help="Of the worlds.",
)
@click.option(
    "--modes",
    metavar="LIST",
    help=f"What to compare, of {','.join(PLANNERS + GPU_PLANNERS + EXACT)}. Without a GPU, "
    f"{' and '.join(GPU_PLANNERS)} are left out, where `hypgen run` plans on the CPU.",
)
@click.option(
    "--solve-time",
    metavar="S",
    type=click.FloatRange(0, 1e9),
    default=60.0,
    show_default=True,
    help="Seconds to solve a small model for alpha, qmdp and blind.",
)
@click.option("--json", "as_json", is_flag=True, help="Print all returns and the table as one JSON object.")
def command(
    model: Path,
    instance: Path | None,
    settings: tuple[str, ...],
    target: str,
    arch: str,
    nvcc: str,
    param: Path | None,
    runs: int,
    time: float | None,
    trials: int | None,
    steps: int | None,
    seed: int,
    modes: str | None,
    solve_time: float,
    as_json: bool,
) -> int:
    """Play MODEL with every planner in the same episodes, and print what each earns.

    Episode i of a seed has the same start and the same draws for all, so that differences are paired:
    "minus the best" is the mean of them over the episodes. Where the model is small enough to be solved
    (see `hypgen solve`), policies on the exact belief play too: alpha (the vectors that prove the lower
    bound), qmdp and the best blind policy. The last line is then an interval that holds the value of the
    best policy. Ctrl-C prints what is known so far.

    \b
    Examples:
      hypgen compare examples/tiger.pomdp
      hypgen compare examples/tag.pomdp --runs 100 --time 0.05 --modes default,despot,alpha
      hypgen compare examples/rock_sample.pomdp --trials 1000 --json
    """
    from hypgen.api import comparing

    cuda = choose_cuda(target, arch, nvcc)
    asked = _asked(modes, PLANNERS + (GPU_PLANNERS if cuda else ()) + EXACT)
    loaded = load(model, instance, settings)
    say_warnings(loaded)
    if param is None:
        require_params(loaded, " or --param FILE")
    comparison = Comparison()
    interrupted: KeyboardInterrupt | None = None
    try:
        comparing.compare(
            as_model(loaded, model, instance),
            asked,
            runs=runs,
            time=time,
            trials=trials,
            steps=steps,
            seed=seed,
            param=param,
            solve_time=solve_time,
            cuda=cuda,
            progress=report,
            show=_show(runs),
            into=comparison,
        )
    except KeyboardInterrupt as error:
        interrupted = error
    _print(comparison, as_json)
    if interrupted:
        return interrupt_code(interrupted)
    is_fine = any(p.returns for p in comparison.policies) and not any(
        p.is_broken for p in comparison.policies
    )
    return Exit.OK if is_fine else Exit.MISTAKE


def _asked(modes: str | None, known: tuple[str, ...]) -> list[str]:
    """Return the modes to play, in the order that was asked for."""
    if modes is None:
        return list(known)
    asked = list(dict.fromkeys(mode.strip() for mode in modes.split(",")))
    for mode in asked:
        if mode not in PLANNERS + GPU_PLANNERS + EXACT:
            raise click.UsageError(f"There is no mode '{mode}': --modes takes some of {','.join(known)}.")
    return asked


def _show(runs: int) -> Callable[[Policy], None]:
    """Return what tells a person how far a policy is."""

    def show(policy: Policy) -> None:
        done = len(policy.returns)
        if done == runs:
            say(f"{policy.name}: {done} episodes, mean return {policy.mean:.3f}")

    return show


def _print(comparison: Comparison, as_json: bool) -> None:
    policies, value, rest = comparison.policies, comparison.solved, comparison.left_out
    if as_json:
        click.echo(json.dumps(numbers(comparison), indent=2))
    else:
        if any(policy.returns for policy in policies):
            click.echo(table(policies))
        if value is not None:
            cut = (
                f" ({comparison.steps} steps leave out {rest:.2g} of the sum of discounts)"
                if rest > LEFT_OUT
                else ""
            )
            click.echo(f"value of the best policy: {outwards(value['lower'], value['upper'])}{cut}")
    for policy in policies:
        if policy.unsearched and not policy.is_broken:
            some = f"{policy.unsearched:,} of {len(policy.seconds):,} steps"
            say(f"{policy.name}: in {some} there was no time to look ahead; raise --time")
    problems = {policy.problem: "" for policy in policies if policy.problem}
    for problem in problems:
        say(f"{', '.join(policy.name for policy in policies if policy.problem == problem)}: {problem}")
