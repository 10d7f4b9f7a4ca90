# SPDX-License-Identifier: Apache-2.0
"""``hypgen view``: an episode as one offline page: the world, each decision's tree, and curves."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import click

from hypgen.cli.building import as_model, report
from hypgen.cli.exit_codes import EXIT_CODES, Exit
from hypgen.cli.model_arguments import load, model_options, require_params
from hypgen.cli.output import say, say_warnings
from hypgen.cli.progress import notice

_SECONDS = "0.1"  # of a decision, where nothing else limits it


@click.command(epilog=EXIT_CODES, context_settings={"ignore_unknown_options": True})
@model_options
@click.option("--episode", metavar="N", type=click.IntRange(0, 2**32 - 1), default=0, help="Which one [0].")
@click.option("--steps", metavar="N", type=click.IntRange(min=1), help="Most steps; the horizon, or else 90.")
@click.option(
    "--step", "first", metavar="K", type=click.IntRange(min=0), help="The step that is shown first [0]."
)
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    type=click.Path(path_type=Path, dir_okay=False),
    help="The page [MODEL.html].",
)
@click.option("--open", "opens", is_flag=True, help="Open the page in a browser.")
@click.argument("solver_options", metavar="[SOLVER OPTIONS]...", nargs=-1, type=click.UNPROCESSED)
def command(
    model: Path,
    instance: Path | None,
    settings: tuple[str, ...],
    episode: int,
    steps: int | None,
    first: int | None,
    output: Path | None,
    opens: bool,
    solver_options: tuple[str, ...],
) -> int:
    """Play an episode of MODEL and write it as one page that needs no network.

    The page has the world and the belief, the search tree of each decision and why it was taken, and curves
    over the episode, on one time line. Options that hypgen does not know go to the planner; without a limit a
    decision takes 0.1 s.

    \b
    Examples:
      hypgen view examples/tiger.pomdp --open
      hypgen view examples/rock_sample.pomdp --mode despot --time 0.5 --seed 7 -o rocks.html
      hypgen view examples/navigation.pomdp --episode 3 --step 12
    """
    if str(model).startswith("-"):
        raise click.UsageError(f"The model comes first, before the planner's options (found '{model}').")
    options = _options(solver_options)
    loaded = load(model, instance, settings)
    say_warnings(loaded)
    require_params(loaded)
    from hypgen.api.c_interface import PlannerError
    from hypgen.views import entries_of, page_of, view_of
    from hypgen.views.playing import play
    from hypgen.whole_files import write_whole

    if not {"time", "trials", "period", "settings"} & set(options):
        options["time"] = _SECONDS
    page = output if output is not None else Path(f"{model.stem}.html")
    try:
        with notice(f"{model}: playing"):
            played = play(
                as_model(loaded, model, instance), options, episode=episode, steps=steps, progress=report
            )
    except PlannerError as error:
        raise click.ClickException(str(error)) from None
    if first is not None and first >= len(played.steps):
        raise click.ClickException(f"--step {first}: the episode has the steps 0 to {len(played.steps) - 1}")
    header = played.header | {"first": first or 0}
    view = view_of(header, played.steps, played.end, entries=entries_of(loaded.model))
    try:
        write_whole(page, page_of(view))
    except OSError as error:
        raise click.ClickException(f"{error.filename or page} cannot be written: {error.strerror}") from None
    say(f"page: {page}")
    if opens and not webbrowser.open(page.absolute().as_uri()):
        say("note: no browser was found that could open it")
    return Exit.OK


def _options(words: tuple[str, ...]) -> dict[str, str | bool]:
    """Return the planner's options of a command line: ``--time 0.5``, ``--time=0.5``, ``--flag``."""
    found: dict[str, str | bool] = {}
    waiting = ""
    for word in words:
        if word.startswith("--"):
            name, is_given, value = word[2:].partition("=")
            waiting = "" if is_given else name.replace("-", "_")
            found[name.replace("-", "_")] = value if is_given else True
        elif waiting:
            found[waiting], waiting = word, ""
        else:
            raise click.UsageError(f"Unexpected '{word}': an option of the planner starts with two dashes.")
    return found
