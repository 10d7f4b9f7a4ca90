# SPDX-License-Identifier: Apache-2.0
"""``hypgen bench``: plays a suite of experiments, goes on where it was, and prints its tables."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hypgen.cli.building import report
from hypgen.cli.exit_codes import Exit, exit_codes
from hypgen.cli.interrupts import interrupt_code
from hypgen.cli.output import say
from hypgen.cli.progress import progress

if TYPE_CHECKING:
    from hypgen.experiments.cluster import DaskExecutor
    from hypgen.experiments.running import State
    from hypgen.experiments.suite import Suite
    from hypgen.experiments.tables import Table


@click.command(epilog=exit_codes("a cell could not be played"))
@click.argument("suite", type=click.Path(path_type=Path, dir_okay=False, exists=True))
@click.option(
    "-o",
    "--output",
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Folder of the results [NAME.bench].",
)
@click.option(
    "--jobs",
    metavar="N",
    type=click.IntRange(1),
    help="Processes at a time, each on cores of its own; by default as many as there are cores.",
)
@click.option(
    "--gpus",
    metavar="N",
    type=click.IntRange(0),
    help="GPUs to use, one a process [1].",
)
@click.option(
    "--dask",
    metavar="ADDRESS",
    help="Play on the workers of a Dask scheduler, such as tcp://host:8786.",
)
@click.option("--limit", metavar="S", type=click.FloatRange(0), help="Seconds to play, about, in all.")
@click.option(
    "--cell-limit",
    metavar="S",
    type=click.FloatRange(1),
    default=3600.0,
    show_default=True,
    help="Seconds after which a process that plays a cell is killed.",
)
@click.option("--only", metavar="LIST", help="Names of studies, separated by commas.")
@click.option("--retry", is_flag=True, help="Play again what failed before.")
@click.option("--tables", "only_tables", is_flag=True, help="Play nothing: print what is known.")
def command(
    suite: Path,
    output: Path | None,
    jobs: int | None,
    gpus: int | None,
    dask: str | None,
    limit: float | None,
    cell_limit: float,
    only: str | None,
    retry: bool,
    only_tables: bool,
) -> int:
    """Play the experiments of SUITE, a TOML file, and print what each setting earned.

    All settings play the same episodes, so differences are paired. Each search stands beside the default
    policy and one-ply rollouts. Results are kept in DIR, a file for a few episodes of a setting. Run again,
    the command plays only what is missing; after Ctrl-C it prints what is known.

    \b
    Examples:
      hypgen bench benchmarks/smoke.toml
      hypgen bench my-suite.toml -o results --jobs 4 --limit 600
      hypgen bench benchmarks/paper.toml --dask tcp://head:8786
    """
    if importlib.util.find_spec("scipy") is None:
        raise click.ClickException("experiments need scipy: pip install 'hypgen[bench]'")
    if dask is not None and (jobs is not None or gpus is not None):
        raise click.UsageError("--jobs and --gpus are of this machine; with --dask the workers say theirs.")
    from hypgen.experiments import running, shares
    from hypgen.experiments.store import Store
    from hypgen.experiments.suite import read_suite
    from hypgen.experiments.suite_values import SuiteError

    try:
        whole = read_suite(suite)
        asked = _only(whole, only)
        store = Store(output if output is not None else Path(f"{suite.stem}.bench"))
        store.open(asked.title)
        if retry:
            store.forget_failures()
        cluster = None if dask is None or only_tables else _cluster(dask, cell_limit)
        builds = running.build(asked, progress=report)
        running.check_options(asked, builds)
        running.describe(whole, builds, store)
    except SuiteError as error:
        raise click.ClickException(str(error)) from None
    visible = shares.visible_gpus(1 if gpus is None else gpus)
    own = running.local(builds, jobs or len(shares.visible_cores()), visible, cell_limit)
    interrupted: KeyboardInterrupt | None = None
    state = None
    if not only_tables:
        with progress("cells") as show:

            def tell(state: State) -> None:
                show(state.done, state.total, "" if state.last is None else str(state.last.setting))

            try:
                state = running.play(asked, builds, store, cluster or own, limit=limit, tell=tell)
            except KeyboardInterrupt as error:
                interrupted = error
            except SuiteError as error:
                raise click.ClickException(str(error)) from None
            finally:
                if cluster is not None:
                    cluster.close()
    for table in running.tables(asked, builds, store):
        _print(table)
    say(f"results: {store.folder}")
    if interrupted is not None:
        return interrupt_code(interrupted)
    if state is not None:
        for failure in state.failures:
            say(f"{failure.cell.setting}: {failure.problem}")
        if state.failures:
            say("what failed is left out; --retry plays it again")
            return Exit.DIFFERENT
        if state.done < state.total:
            say(f"{state.done} of {state.total} cells are played; run the command again to go on")
    return Exit.OK


def _only(suite: Suite, names: str | None) -> Suite:
    """Return a suite with some of its studies."""
    import dataclasses

    if names is None:
        return suite
    asked = [name.strip() for name in names.split(",")]
    known = [study.name for study in suite.studies]
    if unknown := next((name for name in asked if name not in known), None):
        raise click.UsageError(f"There is no study '{unknown}': there are {', '.join(known)}.")
    return dataclasses.replace(suite, studies=tuple(one for one in suite.studies if one.name in asked))


def _cluster(address: str, cell_limit: float) -> DaskExecutor:
    from hypgen.experiments.cluster import DaskExecutor

    return DaskExecutor(address, cell_limit)


def _print(table: Table) -> None:
    from hypgen.experiments.tables import markdown

    whole = "" if table.is_whole else ", not all episodes are played yet"
    click.echo(f"\n## {table.study.name}: {table.task.name}{whole}\n\n{markdown(table)}")
