# SPDX-License-Identifier: Apache-2.0
"""``hypgen solve``: the value of a small model, between proven bounds."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import click

from hypgen.cli.building import build
from hypgen.cli.exit_codes import code_of_program, exit_codes
from hypgen.cli.model_arguments import load, model_options, param_option, require_params
from hypgen.cli.output import say_warnings, write_file
from hypgen.play import signals


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
@click.option(
    "--graph",
    metavar="N",
    type=click.IntRange(1, 10000),
    help="Show the policy as a graph of at most N nodes: what to do after each observation.",
)
@click.option(
    "--graph-file",
    metavar="FILE",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Draw that graph, of 20 nodes without --graph: .svg, .pdf or .png; or write it as .json.",
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
    graph: int | None,
    graph_file: Path | None,
    as_json: bool,
    force: bool,
) -> int:
    """Find all states of MODEL and bound the value of its best policy from both sides.

    Every state that can be reached is found by trying all outcomes of all draws in the code that plans
    online. Then heuristic search closes the gap between a lower bound (alpha vectors, which are a policy)
    and an upper bound. Both are proven at any moment: Ctrl-C prints them as far as they have come.

    It takes a model with up to about a million states. A float that is drawn from a continuous law has too
    many values; what depends on it cannot be solved so.

    \b
    Examples:
      hypgen solve examples/tiger.pomdp
      hypgen solve examples/rock_sample.pomdp --gap 0.5 --time 300
      hypgen solve examples/tag.pomdp --json | jq .lower
      hypgen solve examples/tiger.pomdp --graph 10 --graph-file tiger.svg
    """
    drawn = None if graph_file is None or graph_file.suffix == ".json" else graph_file
    if drawn is not None:
        _check_drawing(drawn, graph)
    loaded = load(model, instance, settings)
    say_warnings(loaded)
    if param is None:
        require_params(loaded, " or --param FILE")
    solver = build("precise", loaded, model, instance, force=force)
    options = [f"--time={time!r}", f"--gap={gap!r}", f"--memory={memory}"]
    options += ["--json=-", "--quiet"] if as_json else []
    given: dict[str, object] = {
        "param": param,
        "max-states": max_states,
        "max-outcomes": max_outcomes,
        "policy": policy,
        "policy-format": policy_format,
        "graph": graph,
        "graph-file": graph_file if drawn is None else None,
    }
    options += [f"--{name}={value}" for name, value in given.items() if value is not None]
    sys.stdout.flush()
    sys.stderr.flush()
    if drawn is None:
        # As for `run`: signals and the exit code need no forwarding.
        os.execv(solver, [solver.name, *options])
    return _solve_and_draw([str(solver), *options], loaded.model.name, drawn)


def _check_drawing(file: Path, nodes: int | None) -> None:
    """Refuse before anything is solved what could not be drawn afterwards."""
    from hypgen.cli.show import policy_drawing

    if file.suffix not in policy_drawing.SUFFIXES:
        kinds = ", ".join((*policy_drawing.SUFFIXES, ".json"))
        raise click.ClickException(f"{file}: a graph is drawn to a file that ends with one of {kinds}.")
    if nodes is not None and nodes > policy_drawing.MOST_NODES:
        raise click.ClickException(
            f"--graph: a drawing has at most {policy_drawing.MOST_NODES} nodes; "
            "as text and as .json a graph may have more."
        )
    if missing := policy_drawing.missing_libraries():
        raise click.ClickException(
            f"{file}: drawing needs {' and '.join(missing)}: pip install 'hypgen[draw]'. "
            "--graph shows the graph as text, and a file that ends with .json gets it as JSON."
        )


def _solve_and_draw(command: list[str], title: str, file: Path) -> int:
    """Run the solver, draw the graph that it leaves, and return the solver's exit code."""
    from hypgen.cli.show import policy_drawing

    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "graph.json"
        solver = subprocess.Popen([*command, f"--graph-file={written}"], text=True, process_group=0)
        with solver, signals.passed_to(solver):  # it ends with what is proven so far
            code = code_of_program(solver.wait())
        if not written.exists():
            return code
        graph = json.loads(written.read_text(encoding="utf-8"))
    write_file(file, policy_drawing.draw(graph, title, file.suffix))
    return code
