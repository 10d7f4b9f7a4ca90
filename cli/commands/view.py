# SPDX-License-Identifier: Apache-2.0
"""``hypgen view``: an episode as one offline page, as GIF or as PNG."""

from __future__ import annotations

import importlib.util
import subprocess
import tempfile
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hypgen.cli.building import build
from hypgen.cli.exit_codes import EXIT_CODES, Exit
from hypgen.cli.model_arguments import choose_cuda, load, model_options, require_params, target_options
from hypgen.cli.output import say, say_warnings
from hypgen.cli.progress import notice

if TYPE_CHECKING:
    from hypgen.dsl.load import Loaded
    from hypgen.runtime.builder.cuda_tools import CudaBuild

_FILE = click.Path(path_type=Path, dir_okay=False)


@click.command(epilog=EXIT_CODES, context_settings={"ignore_unknown_options": True})
@model_options
@target_options
@click.option(
    "--log",
    metavar="FILE",
    type=click.Path(path_type=Path),
    help="Show a recording (--record of `hypgen run`).",
)
@click.option(
    "--episode",
    metavar="N",
    type=click.IntRange(0, 2**32 - 1),
    help="Which one [0; of a recording its first].",
)
@click.option("--steps", metavar="N", type=click.IntRange(min=1), help="Most steps; the horizon, or else 90.")
@click.option(
    "--step",
    "first",
    metavar="K",
    type=click.IntRange(min=0),
    default=0,
    help="The step of --png, and the one that a page shows first [0].",
)
@click.option(
    "-o", "--output", metavar="FILE", type=_FILE, help="The page [MODEL.html, unless a picture is asked for]."
)
@click.option("--gif", metavar="FILE", type=_FILE, help="Write the episode as GIF.")
@click.option("--png", metavar="FILE", type=_FILE, help="Write one step as PNG.")
@click.option("--open", "opens", is_flag=True, help="Open the page in a browser.")
@click.argument("solver_options", metavar="[SOLVER OPTIONS]...", nargs=-1, type=click.UNPROCESSED)
def command(
    model: Path,
    instance: Path | None,
    settings: tuple[str, ...],
    target: str,
    arch: str,
    nvcc: str,
    log: Path | None,
    episode: int | None,
    steps: int | None,
    first: int,
    output: Path | None,
    gif: Path | None,
    png: Path | None,
    opens: bool,
    solver_options: tuple[str, ...],
) -> int:
    """Show an episode of MODEL: as one page that needs no network, as GIF, or as PNG.

    The page has the world and the belief, the search tree of each decision and why it was taken, and curves
    over the episode, on one time line. Its solver plays the episode, unless --log names a recording of one.
    Options that hypgen does not know go to the solver.

    \b
    Examples:
      hypgen view examples/tiger.pomdp --open
      hypgen view examples/rock_sample.pomdp --mode despot --time 0.5 --seed 7 -o rocks.html
      hypgen view examples/navigation.pomdp --episode 3 --step 12
      hypgen view examples/tag.pomdp --log tag.jsonl --gif tag.gif
    """
    if str(model).startswith("-"):
        raise click.UsageError(f"The model comes first, before the solver's options (found '{model}').")
    if log is not None and (solver_options or steps is not None or target != "auto" or arch or nvcc):
        raise click.UsageError("--log shows what was played: leave out --steps and all options of a solver.")
    if (gif or png) and not all(map(importlib.util.find_spec, ("matplotlib", "PIL"))):
        raise click.ClickException("pictures need matplotlib and pillow: pip install 'hypgen[draw]'")
    cuda = None if log is not None else choose_cuda(target, arch, nvcc)
    loaded = load(model, instance, settings)
    say_warnings(loaded)
    from hypgen.recordings import RecordingError

    try:
        if log is not None:
            view = _view(log, loaded, model, episode, first)
        else:
            require_params(loaded, " or --param FILE")
            view = _played(loaded, model, instance, cuda, episode or 0, steps, first, solver_options)
    except RecordingError as error:
        raise click.ClickException(str(error)) from None
    page = output
    if page is None and (opens or not (gif or png)):
        page = Path(f"{model.stem}.html")
    _write(view, page, gif, png)
    if page is not None and opens and not webbrowser.open(page.absolute().as_uri()):
        say("note: no browser was found that could open it")
    return Exit.OK


def _played(
    loaded: Loaded,
    model: Path,
    instance: Path | None,
    cuda: CudaBuild | None,
    episode: int,
    steps: int | None,
    first: int,
    options: tuple[str, ...],
) -> dict[str, Any]:
    """Return what is shown of an episode that the solver plays now."""
    solver = build("solver", loaded, model, instance, cuda)
    with tempfile.TemporaryDirectory(prefix="hypgen-") as folder:
        log = Path(folder) / "recording.jsonl"
        told = [*options, "--runs=1", f"--first-run={episode}", f"--record={log}", "--quiet"]
        told += [f"--steps={steps}"] if steps is not None else []
        with notice(f"{model}: playing"):
            done = subprocess.run(
                [solver, *told], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
            )
        if done.returncode != 0:
            raise click.ClickException(done.stderr.strip() or f"the solver ended with {done.returncode}")
        if done.stderr:
            say(done.stderr, nl=False)
        return _view(log, loaded, model, episode, first)


def _view(log: Path, loaded: Loaded, model: Path, episode: int | None, first: int) -> dict[str, Any]:
    """Return what is shown of an episode of a recording: of its first one where none is named."""
    from hypgen.recordings import RecordingError, open_recording
    from hypgen.views import view_of_recording

    try:
        recording = open_recording(log, model_hash=loaded.model.source_hash)
        if not recording.episodes:
            raise RecordingError(f"{log} has no episode")
        if recording.cut_off:
            say(f"note: {log} is cut off: its last line is not read")
        if episode is None and len(set(recording.returns.values())) > 1:
            worst = min(recording.returns, key=lambda one: recording.returns[one])
            say(
                f"note: {log} has {len(recording.episodes)} episodes; the lowest return, "
                f"{recording.returns[worst]:.4g}, is that of --episode {worst}"
            )
        number = recording.episodes[0] if episode is None else episode
        return view_of_recording(recording, loaded.model, number, first=first, file=model.name)
    except OSError as error:
        raise click.ClickException(f"{log} cannot be read: {error.strerror}") from None


def _write(view: dict[str, Any], page: Path | None, gif: Path | None, png: Path | None) -> None:
    from hypgen.views import page_of
    from hypgen.whole_files import write_whole

    try:
        if page is not None:
            write_whole(page, page_of(view))
            say(f"page: {page}")
        if gif or png:
            from hypgen.pictures import render_gif, render_png

            if gif is not None:
                render_gif(view, gif)
                say(f"picture: {gif}")
            if png is not None:
                render_png(view, view["first"], png)
                say(f"picture: {png}")
    except OSError as error:
        raise click.ClickException(f"{error.filename or page} cannot be written: {error.strerror}") from None
