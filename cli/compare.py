"""``hypgen compare``: what the planners earn in the same episodes, beside what is proven of the best."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hypgen.cli.common import (
    EXIT_CODES,
    Exit,
    choose_cuda,
    load,
    model_options,
    require_params,
    say,
    say_warnings,
    target_options,
)
from hypgen.cli.comparison import Policy, numbers, outwards, play_exact, play_modes, table

if TYPE_CHECKING:
    from hypgen.dsl.driver import Loaded

PLANNERS = ("default", "rollout", "despot", "parallel", "pomcp")
GPU_PLANNERS = ("gpu", "hyp")
EXACT = ("alpha", "qmdp", "blind")


@click.command(epilog=EXIT_CODES)
@model_options
@target_options
@click.option(
    "--param", metavar="FILE", type=click.Path(path_type=Path), help="JSON file that sets the model's params."
)
@click.option("--runs", metavar="N", type=click.IntRange(1), default=20, show_default=True, help="Episodes.")
@click.option(
    "--time",
    metavar="S",
    type=click.FloatRange(0, 1e9),
    help="Seconds for each decision of a planner; 0.1 unless there are --trials.",
)
@click.option("--trials", metavar="N", type=click.IntRange(1), help="Trials for each decision instead.")
@click.option(
    "--steps", metavar="N", type=click.IntRange(1), default=90, show_default=True, help="Most steps."
)
@click.option(
    "--seed", metavar="S", type=click.IntRange(0), default=0, show_default=True, help="Of the worlds."
)
@click.option(
    "--modes", metavar="LIST", help=f"What to compare, of {','.join(PLANNERS + GPU_PLANNERS + EXACT)}."
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
    steps: int,
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
    best policy.

    \b
    Examples:
      hypgen compare examples/tiger.pomdp
      hypgen compare examples/tag.pomdp --runs 100 --time 0.05 --modes default,despot,alpha
      hypgen compare examples/rock_sample.pomdp --trials 1000 --json
    """
    cuda = choose_cuda(target, arch, nvcc)
    asked = _asked(modes, PLANNERS + (GPU_PLANNERS if cuda else ()) + EXACT)
    loaded = load(model, instance, settings)
    say_warnings(loaded)
    if param is None:
        require_params(loaded, " or --param FILE")
    common = [f"--runs={runs}", f"--steps={steps}", f"--seed={seed}"]
    common += [] if param is None else [f"--param={param}"]
    limits = [f"--trials={trials}"] if trials else []
    limits += [f"--time={0.1 if time is None else time}"] if time is not None or not trials else []
    policies: list[Policy] = []
    solved = None
    try:
        from hypgen.cli.compile import build
        from hypgen.codegen import driver

        if planners := [mode for mode in asked if mode not in EXACT]:
            solver = build(loaded, driver.generate(loaded.model), model, instance, cuda, False)
            for policy in play_modes(solver, planners, [*common, *limits], _show(runs)):
                policies.append(policy)
        if kinds := [mode for mode in asked if mode in EXACT]:
            more, solved = _exact(loaded, model, instance, kinds, [*common, f"--time={solve_time}"], runs)
            policies += more
        interrupted = False
    except KeyboardInterrupt:
        interrupted = True
    _print(policies, solved, as_json)
    if interrupted:
        return Exit.INTERRUPTED
    return Exit.OK if any(policy.returns for policy in policies) else Exit.MISTAKE


def _asked(modes: str | None, known: tuple[str, ...]) -> list[str]:
    """Return the modes to play, in the order that was asked for."""
    if modes is None:
        return list(known)
    asked = [mode.strip() for mode in modes.split(",")]
    for mode in asked:
        if mode not in PLANNERS + GPU_PLANNERS + EXACT:
            raise click.UsageError(f"There is no mode '{mode}': --modes takes some of {','.join(known)}.")
    return asked


def _exact(
    loaded: Loaded, model: Path, instance: Path | None, kinds: list[str], options: list[str], runs: int
) -> tuple[list[Policy], dict[str, Any] | None]:
    """Play policies on the exact belief, where the model can be enumerated."""
    from hypgen.cli.solve import build_exact
    from hypgen.dsl.diagnostics import ModelError

    try:
        program = build_exact(loaded, model, instance)
    except ModelError as error:
        problem = f"cannot be enumerated: {error.diagnostics[0].message}"
        return [Policy(kind, problem=problem) for kind in kinds], None
    return play_exact(program, kinds, options, _show(runs))


def _show(runs: int) -> Callable[[Policy], None]:
    """Return what tells a person how far a policy is."""

    def show(policy: Policy) -> None:
        done = len(policy.returns)
        if done == runs:
            say(f"{policy.name}: {done} episodes, mean return {policy.mean:.3f}")

    return show


def _print(policies: list[Policy], solved: dict[str, Any] | None, as_json: bool) -> None:
    if as_json:
        click.echo(json.dumps(numbers(policies, solved), indent=2))
    else:
        click.echo(table(policies))
        if solved is not None:
            click.echo(f"value of the best policy: {outwards(solved['lower'], solved['upper'])}")
    problems = {policy.problem: "" for policy in policies if policy.problem}
    for problem in problems:
        say(f"{', '.join(policy.name for policy in policies if policy.problem == problem)}: {problem}")
