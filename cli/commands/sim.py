# SPDX-License-Identifier: Apache-2.0
"""``hypgen sim``: play an episode of a model in the terminal."""

from __future__ import annotations

import contextlib
import itertools
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING

import click

from hypgen.cli.exit_codes import EXIT_CODES, Exit
from hypgen.cli.interrupts import interrupt_code
from hypgen.cli.model_arguments import load, model_options, require_params
from hypgen.cli.output import say

if TYPE_CHECKING:
    from hypgen.cli.show.sim_report import Report
    from hypgen.dsl.interpret.episode import Episode

HELP = """\
  ACTION     take it; words may be cut short and brackets left out: `ch 3` for check(3)
  policy     let the default policy choose     random     take any legal action
  state      print the whole state             legal      print the legal actions: the first ones,
                                               all with `legal all`, some with `legal check 3`
  belief     print what the agent believes and the policy remembers
  undo       take the last step back           quit       end (so does Ctrl-D)
A `:` before a word makes sure that it is a command and no action."""
HINT = "Type an action, or: policy, random, legal, state, belief, undo, help, quit.\n"
_LISTED = 8
COMMANDS = ("policy", "random", "state", "legal", "belief", "undo", "quit", "help")


class NoSuchActionError(Exception):
    """What was typed names no action that can be taken; the message says so and what to do."""


@click.command(epilog=EXIT_CODES)
@model_options
@click.option("--seed", metavar="N", type=click.IntRange(min=0), default=0, help="Seed of the world (0).")
@click.option(
    "--episode",
    "number",
    metavar="N",
    type=click.IntRange(0, 2**32 - 1),
    default=0,
    help="Which episode: the solver's of that number with that seed plays in the same world (0).",
)
@click.option("--steps", metavar="N", type=click.IntRange(min=0), help="Most steps; the horizon, or else 90.")
@click.option(
    "--policy", type=click.Choice(["default", "random"]), help="Who acts; without it, you are asked."
)
@click.option(
    "--script",
    metavar="FILE",
    type=click.File(encoding="utf-8", errors="replace"),
    help="Take actions from a file, one a line; `-` is standard input.",
)
@click.option("--show-hidden/--hide-hidden", default=True, help="Print hidden variables or not (they are).")
@click.option(
    "--draw/--no-draw", "draws", default=None, help="Draw cells and gauges or not (in a terminal they are)."
)
@click.option("--json", "as_json", is_flag=True, help="Print a JSON object a line.")
def command(
    model: Path,
    instance: Path | None,
    settings: tuple[str, ...],
    seed: int,
    number: int,
    steps: int | None,
    policy: str | None,
    script: IO[str] | None,
    show_hidden: bool,
    draws: bool | None,
    as_json: bool,
) -> int:
    """Play an episode of MODEL, step by step.

    On the reference interpreter: nothing is compiled. You choose the actions, or a script or a policy does;
    states, observations and rewards are shown by name. The model's `draw` declarations are drawn, with what
    an exact posterior believes as shades.

    \b
    Examples:
      hypgen sim examples/tiger.pomdp
      hypgen sim examples/tag.pomdp --hide-hidden --seed 7
      hypgen sim examples/rock_sample.pomdp --policy default
      printf 'listen\\nopen_left\\n' | hypgen sim examples/tiger.pomdp --json
    """
    if policy is not None and script is not None:
        raise click.UsageError("Give --policy or --script: one of them chooses the actions.")
    loaded = load(model, instance, settings)
    require_params(loaded)
    checked = loaded.model
    from hypgen.cli.show.sim_report import JsonReport, TextReport
    from hypgen.dsl.interpret.episode import Episode

    episode = Episode(checked, seed, number)
    draws = sys.stdout.isatty() if draws is None else draws
    report: Report = (
        JsonReport(episode, show_hidden) if as_json else TextReport(episode, show_hidden, draws=draws)
    )
    most = steps if steps is not None else checked.horizon or 90
    code: int = Exit.OK
    try:
        report.start(seed, number)
        lines, interactive = _lines(policy, script, episode)
        if interactive:
            report.note(HINT)
        _play(episode, report, lines, interactive, most)
    except KeyboardInterrupt as error:
        say("")
        code = interrupt_code(error)
    report.end()
    return code


def _lines(policy: str | None, script: IO[str] | None, episode: Episode) -> tuple[Iterator[str], bool]:
    """Return the lines to obey, and whether a person types them."""
    if policy is not None:
        return itertools.repeat(":policy" if policy == "default" else ":random"), False
    if script is not None:
        return iter(script), False
    return (_typed(episode), True) if sys.stdin.isatty() else (iter(sys.stdin), False)


def _typed(episode: Episode) -> Iterator[str]:
    with contextlib.suppress(ImportError):
        import readline  # noqa: F401  # input() then has line editing and a history
    while True:
        try:
            yield input(f"{episode.now.time}> ")
        except EOFError:
            click.echo()
            return


def _play(episode: Episode, report: Report, lines: Iterator[str], interactive: bool, most: int) -> None:
    """Do what the lines say until the episode or they end."""
    number = 0
    while episode.now.time < most and not episode.now.terminal:
        if not episode.legal():
            report.note("no action is legal here: the episode cannot go on")
            break
        line = next(lines, None)
        number += 1
        try:
            if line is None or not _obey(line.split("#")[0].strip(), episode, report):
                break
        except NoSuchActionError as error:
            if not interactive:
                raise click.ClickException(f"line {number} of the script: {error}") from None
            report.note(str(error))


def _obey(line: str, episode: Episode, report: Report) -> bool:
    """Do what a line says; return False if it says to end."""
    word = line.removeprefix(":").strip()
    if not word:
        return True
    name, _, rest = word.partition(" ")
    if name == "legal" and rest:
        report.legal(rest.strip())
        return True
    if word in COMMANDS and (line.startswith(":") or not _is_action(word, episode)):
        return _command(word, episode, report)
    _take(_action(line, episode), episode, report)
    return True


def _is_action(word: str, episode: Episode) -> bool:
    from hypgen.dsl.interpret.value_text import action_text, find_action

    action = episode.model.action
    return [action_text(code, action) for code in find_action(word, action)] == [word]


def _command(word: str, episode: Episode, report: Report) -> bool:
    match word:
        case "quit":
            return False
        case "policy":
            _take(episode.policy_action(), episode, report)
        case "random":
            _take(episode.random_action(), episode, report)
        case "undo":
            report.undone() if episode.undo() else report.note("there is no step to take back")
        case "state":
            report.state()
        case "legal":
            report.legal()
        case "belief":
            report.belief()
        case _:
            report.note(HELP)
    return True


def _take(action: int, episode: Episode, report: Report) -> None:
    before = episode.values()
    report.step(before, episode.step(action))


def _action(text: str, episode: Episode) -> int:
    """Return the legal action that the text means; raises ``NoSuchActionError``."""
    from hypgen.dsl.interpret.value_text import action_text, find_action
    from hypgen.dsl.messages.diagnostic import did_you_mean

    action = episode.model.action
    found = find_action(text, action)
    legal = [code for code in found if code in episode.legal()]
    if len(legal) == 1:
        return legal[0]
    names = [action_text(code, action) for code in legal or found]
    if len(names) > 1:
        raise NoSuchActionError(f"'{text}' may mean {_some(names)}: write more of it")
    if names:
        raise NoSuchActionError(f"{names[0]} is not legal here; `legal` prints what is")
    every = (action_text(code, action) for code in range(action.count))
    hint = did_you_mean(text, [*every, *COMMANDS])
    raise NoSuchActionError(
        f"there is no action '{text}'; {hint or '`legal` prints those that may be taken'}"
    )


def _some(names: list[str]) -> str:
    shown = ", ".join(names[:_LISTED])
    return f"{shown} or {len(names) - _LISTED} more" if len(names) > _LISTED else shown
