# SPDX-License-Identifier: Apache-2.0
"""The work of ``hypgen check --beliefs``: plays, ranks true values in the belief, and says what it found."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hypgen.cli.building import build
from hypgen.cli.exit_codes import Exit
from hypgen.cli.interrupts import interrupt_code
from hypgen.cli.model_arguments import require_params
from hypgen.cli.output import say
from hypgen.cli.progress import phases
from hypgen.dsl.messages import c_sampling
from hypgen.dsl.messages.render import render, to_json
from hypgen.play.played_programs import lines_of
from hypgen.play.rank_statistics import Ranks, corrected

if TYPE_CHECKING:
    from hypgen.dsl import ir
    from hypgen.dsl.load import Loaded
    from hypgen.dsl.messages.diagnostic import Diagnostic
    from hypgen.dsl.messages.source import Source

LEVEL = 0.001  # of all variables together
HALF, MOST = 0.5, 0.95  # the central intervals whose coverage is shown
COLUMNS = ("variable", "p", "50 % interval", "95 % interval", "ranks of true values, low to high")


@dataclass(frozen=True)
class Asked:
    """What the user asks for; ``seconds`` None: no limit."""

    episodes: int
    belief: str = "auto"
    particles: int = 5000
    seed: int = 0
    seconds: float | None = None


@dataclass
class Played:
    """The ranks of each hidden variable so far, and in how many episodes nothing explained what was seen."""

    values: dict[str, list[float]] = field(default_factory=dict)
    episodes: int = 0
    unexplained: int = 0

    def take(self, line: dict[str, Any]) -> None:
        """Take a line of the program."""
        if line["type"] == "beliefs":
            self.values = {name: [] for name in line["variables"]}
        elif line["type"] == "ranks":
            self.episodes += 1
            self.unexplained += line["unexplained"] > 0
            for values, rank in zip(self.values.values(), line["ranks"], strict=True):
                values.append(rank)


@dataclass(frozen=True)
class Finding:
    """A belief that is wrong."""

    diagnostic: Diagnostic
    ranks: Ranks

    def render(self, sources: Mapping[str, Source]) -> str:
        """Return the finding as text, its histogram last."""
        where = "where true values lie in the belief, from its lowest value to its highest"
        return f"{render(self.diagnostic, sources)}{where}:\n  {self.ranks.blocks()}\n"


def run(
    loaded: Loaded,
    model: Path,
    instance: Path | None,
    asked: Asked,
    facts: dict[str, Any] | None,
    strict: bool,
) -> int:
    """Check the beliefs of a model; print findings, or with ``facts`` everything, warnings too, as JSON."""
    require_params(loaded)
    if all(variable.visible for variable in loaded.model.variables):
        raise click.UsageError("The model has no hidden variables, so that there is no belief to check.")
    played = Played()
    interrupted: KeyboardInterrupt | None = None
    try:
        _play(build("verify", loaded, model, instance), asked, played)
    except KeyboardInterrupt as error:
        interrupted = error
    except RuntimeError as error:
        raise click.ClickException(str(error)) from None
    ranks = {name: Ranks(values) for name, values in played.values.items()}
    found = findings(loaded.model, ranks, asked)
    if facts is None:
        for finding in found:
            say(finding.render(loaded.sources))
        _print(loaded.model, ranks, played, asked, len(found))
    else:
        shown = [*map(to_json, loaded.warnings), *(to_json(f.diagnostic) for f in found)]
        checked = {"beliefs": _numbers(ranks, played, asked, interrupted is not None)}
        click.echo(json.dumps({"ok": not found, "diagnostics": shown, **facts, **checked}, indent=2))
    if interrupted:
        say("interrupted")
        return interrupt_code(interrupted)
    if found:
        return Exit.MISTAKE
    return Exit.DIFFERENT if strict and loaded.warnings else Exit.OK


def _play(program: Path, asked: Asked, played: Played) -> None:
    options = {"check-beliefs": asked.episodes, "belief": asked.belief, "particles": asked.particles}
    options["seed"] = asked.seed
    command = [str(program), *(f"--{name}={value}" for name, value in options.items()), "--json=-"]
    with phases(time.monotonic) as progress:
        for line in lines_of(command, asked.seconds):
            played.take(line)
            progress("episodes", played.episodes, asked.episodes)


def findings(model: ir.Model, ranks: Mapping[str, Ranks], asked: Asked) -> list[Finding]:
    """Return what is wrong, in the order of the declarations."""
    found = []
    for name, p in _p_values(ranks).items():
        if p < LEVEL:
            remedy, span = _remedy(model, name, asked), model.variable(name).span
            diagnostic = c_sampling.wrong_belief(name, ranks[name].shape(), p, remedy, span)
            found.append(Finding(diagnostic, ranks[name]))
    return found


def _p_values(ranks: Mapping[str, Ranks]) -> dict[str, float]:
    return dict(zip(ranks, corrected([r.p() for r in ranks.values()]), strict=True))


def _is_exact(model: ir.Model, name: str, asked: Asked) -> bool:
    """Return whether the belief of a variable has no particles."""
    in_exact = any(factor.exact and name in factor.variables for factor in model.factors)
    return in_exact and model.factored and asked.belief != "particle"


def _remedy(model: ir.Model, name: str, asked: Asked) -> str:
    if _is_exact(model, name, asked):
        return "its posterior is exact, so this is a bug of hypgen: please report it with the model"
    return (
        f"try more particles, --particles {4 * asked.particles} here and in `hypgen run`; "
        "if ranks stay as they are, it is a bug of hypgen: please report it with the model"
    )


def _print(model: ir.Model, ranks: Mapping[str, Ranks], played: Played, asked: Asked, wrong: int) -> None:
    episodes = f"{played.episodes:,} episode{'' if played.episodes == 1 else 's'}"
    if played.episodes < asked.episodes:
        episodes = f"{played.episodes:,} of {asked.episodes:,} episodes"
    of_particles = f", --particles {asked.particles}"
    if all(_is_exact(model, name, asked) for name in ranks):
        of_particles = ", exact posteriors"
    verdict = f"{wrong} belief{'' if wrong == 1 else 's'} wrong" if wrong else "nothing wrong"
    click.echo(f"{model.file}: {episodes}, seed {asked.seed}{of_particles}: {verdict}")
    if played.unexplained:
        click.echo(
            f"in {played.unexplained:,} of them some step saw what nothing in the belief explained: "
            "add --particles, or give the model's sensors more noise"
        )
    if played.episodes:
        click.echo(table(ranks))


def table(ranks: Mapping[str, Ranks]) -> str:
    """Return a row for each variable: p, how often central intervals hold the true value, its histogram."""
    rows: list[tuple[str, ...]] = [COLUMNS]
    for name, p in _p_values(ranks).items():
        held = (_share(ranks[name].coverage(share)) for share in (HALF, MOST))
        rows.append((name, f"{p:.2g}", *held, ranks[name].blocks()))
    widths = [max(len(row[i]) for row in rows) for i in range(len(COLUMNS))]
    return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)


def _share(coverage: tuple[float, float, float]) -> str:
    held, low, high = (100 * share for share in coverage)
    return f"{held:.1f} ({low:.1f} .. {high:.1f})"


def _numbers(ranks: Mapping[str, Ranks], played: Played, asked: Asked, interrupted: bool) -> dict[str, Any]:
    variables = [
        {
            "name": name,
            "p": ranks[name].p(),
            "corrected_p": p,
            "histogram": ranks[name].histogram(),
            "held50": dict(zip(("share", "low", "high"), ranks[name].coverage(HALF), strict=True)),
            "held95": dict(zip(("share", "low", "high"), ranks[name].coverage(MOST), strict=True)),
        }
        for name, p in _p_values(ranks).items()
        if played.episodes
    ]
    return {
        "episodes": played.episodes,
        "unexplained": played.unexplained,
        "seed": asked.seed,
        "particles": asked.particles,
        "interrupted": interrupted,
        "variables": variables,
    }
