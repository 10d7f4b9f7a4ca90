# SPDX-License-Identifier: Apache-2.0
"""``hypgen tune``: looks for settings that suit a model, and tests them in other episodes."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hypgen.cli.building import report
from hypgen.cli.exit_codes import Exit, exit_codes
from hypgen.cli.model_arguments import TARGETS, model_options
from hypgen.cli.output import say
from hypgen.cli.progress import progress

if TYPE_CHECKING:
    from hypgen.tuning.outcome import Outcome
    from hypgen.tuning.playing import State


@click.command(epilog=exit_codes("no candidate could be played"))
@model_options
@click.option(
    "--tune",
    "options",
    metavar="NAME[=VALUES]",
    multiple=True,
    help="An option to tune, and LOW..HIGH or A,B,C; may be repeated. By default the usual ones of the mode.",
)
@click.option(
    "--tune-param",
    "params",
    metavar="NAME[=VALUES]",
    multiple=True,
    help="A param of the model to tune, by default over all of its type; may be repeated.",
)
@click.option(
    "--fix", metavar="NAME=VALUE", multiple=True, help="An option that all candidates have; may be repeated."
)
@click.option("--mode", metavar="MODE", default="despot", show_default=True, help="How to plan.")
@click.option(
    "--time", "seconds", metavar="S", type=click.FloatRange(1e-4), help="Seconds of a decision [0.1]."
)
@click.option(
    "--period", metavar="S", type=click.FloatRange(1e-4), help="In place of --time, with the update."
)
@click.option(
    "--trials", metavar="N", type=click.IntRange(1), help="Trials of a decision, in place of --time."
)
@click.option("--threads", metavar="N", type=click.IntRange(1), help="Of modes parallel and hyp [all cores].")
@click.option(
    "--candidates",
    metavar="N",
    type=click.IntRange(1),
    default=40,
    show_default=True,
    help="Settings to try.",
)
@click.option(
    "--runs",
    metavar="N",
    type=click.IntRange(3),
    default=50,
    show_default=True,
    help="Episodes of a candidate; fewer where it is clearly worse.",
)
@click.option(
    "--held-out",
    metavar="N",
    type=click.IntRange(0),
    default=100,
    show_default=True,
    help="Episodes of another seed that test the winner.",
)
@click.option(
    "--seed",
    metavar="N",
    type=click.IntRange(0),
    default=1,
    show_default=True,
    help="Of candidates' episodes.",
)
@click.option(
    "--sampler",
    type=click.Choice(("tpe", "gp")),
    default="tpe",
    show_default=True,
    help="What suggests candidates: Optuna's TPE or Gaussian process.",
)
@click.option("-o", "--output", metavar="DIR", type=click.Path(path_type=Path), help="Folder [NAME.tune].")
@click.option(
    "--write", metavar="FILE", type=click.Path(path_type=Path), help="File of settings [NAME.settings.json]."
)
@click.option("--jobs", metavar="N", type=click.IntRange(1), help="Processes at a time [as many as cores].")
@click.option(
    "--gpus", metavar="N", type=click.IntRange(0), default=1, show_default=True, help="GPUs, one a process."
)
@click.option("--limit", metavar="S", type=click.FloatRange(0), help="Seconds to play, about, in all.")
@click.option(
    "--cell-limit",
    metavar="S",
    type=click.FloatRange(1),
    default=3600.0,
    show_default=True,
    help="Seconds after which a process that plays some episodes is killed.",
)
@click.option("--target", type=click.Choice(TARGETS), default="auto", help="As of `hypgen run`.")
def command(
    model: Path,
    instance: Path | None,
    settings: tuple[str, ...],
    options: tuple[str, ...],
    params: tuple[str, ...],
    fix: tuple[str, ...],
    mode: str,
    seconds: float | None,
    period: float | None,
    trials: int | None,
    threads: int | None,
    candidates: int,
    runs: int,
    held_out: int,
    seed: int,
    sampler: str,
    output: Path | None,
    write: Path | None,
    jobs: int | None,
    gpus: int,
    limit: float | None,
    cell_limit: float,
    target: str,
) -> int:
    """Look for settings with which MODEL's solver earns more, and test them in other episodes.

    All candidates play the same episodes, and one that is clearly worse than the best ends early. The winner
    and the default settings then play episodes that no candidate has played. DIR keeps everything: run again,
    the command goes on where it was; after Ctrl-C it prints what is known. FILE is for --settings of the
    solver.

    \b
    Examples:
      hypgen tune examples/tag.pomdp --time 0.05
      hypgen tune examples/tag.pomdp --trials 200 --tune scenarios=50..500 --tune xi
      hypgen tune examples/rock_sample.pomdp --mode default --tune-param sure --tune-param senses_within
      hypgen run examples/tag.pomdp --settings tag.settings.json
    """
    if importlib.util.find_spec("scipy") is None or importlib.util.find_spec("optuna") is None:
        raise click.ClickException("tuning needs Optuna and scipy: pip install 'hypgen[tune]'")
    from hypgen.experiments.suite_values import SuiteError
    from hypgen.tuning import space, tune

    known: Outcome | None = None
    with progress("cells") as show:

        def tell(state: State) -> None:
            nonlocal known
            known = state.outcome
            show(state.done, state.total, _best(known))

        try:
            known = tune(
                model,
                output if output is not None else Path(f"{model.stem}.tune"),
                instance=instance,
                values=_pairs("--set", settings),
                mode=mode,
                options=dict(_split(one) for one in options),
                params=dict(_split(one) for one in params),
                fixed={name: space.value(text) for name, text in _pairs("--fix", fix).items()},
                seconds=seconds,
                period=period,
                trials=trials,
                threads=threads,
                candidates=candidates,
                runs=runs,
                held_out=held_out,
                seed=seed,
                sampler=sampler,
                jobs=jobs or len(os.sched_getaffinity(0)),
                gpus=[str(number) for number in range(gpus)],
                limit=limit,
                cell_limit=cell_limit,
                write=write,
                target=target,
                progress=report,
                tell=tell,
            )
        except (space.TuningError, SuiteError) as error:
            raise click.ClickException(str(error)) from None
        except KeyboardInterrupt:
            if known is None:
                raise
    return _print(known)


def _pairs(option: str, given: tuple[str, ...]) -> dict[str, str]:
    """Return the names and values of an option that is NAME=VALUE."""
    if wrong := next((one for one in given if "=" not in one), None):
        raise click.UsageError(f"{option} takes NAME=VALUE, found '{wrong}'.")
    return dict(one.split("=", 1) for one in given)


def _split(given: str) -> tuple[str, str | None]:
    name, equals, values = given.partition("=")
    return name, values if equals else None


def _best(outcome: Outcome | None) -> str:
    winner = None if outcome is None else outcome.winner
    return "" if winner is None else f"best so far: {winner.value:.3f}"


def _print(outcome: Outcome) -> int:
    """Print what is known, and return the exit code."""
    from hypgen.tuning.outcome import candidates_markdown, held_out_markdown

    click.echo(candidates_markdown(outcome))
    own = [one for one in outcome.tried if not one.is_default]
    failed, ended = (
        [one for one in own if one.problem],
        [one for one in own if one.is_ended_early(outcome.runs)],
    )
    done = sum(one.is_done for one in own)
    say(f"{done} of {outcome.asked} candidates: {len(ended)} ended early, {len(failed)} failed")
    for problem in dict.fromkeys(one.problem for one in failed):
        say(f"failed: {problem}")
    if outcome.held_out is not None:
        click.echo(f"\n{held_out_markdown(outcome.held_out)}")
    if not outcome.is_finished:
        say("not finished; run the command again to go on")
        return Exit.INTERRUPTED
    if outcome.winner is None:
        say("no candidate earned more than the default settings")
        return Exit.DIFFERENT if len(failed) == len(own) else Exit.OK
    say(outcome.verdict())
    say(
        f"settings: {outcome.file}"
        if outcome.file is not None
        else "no settings are written: they earn no more than the default ones"
    )
    return Exit.OK
