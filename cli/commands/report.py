# SPDX-License-Identifier: Apache-2.0
"""``hypgen report``: a page with the tables and figures of a suite that was played."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hypgen.cli.exit_codes import EXIT_CODES, Exit
from hypgen.cli.output import say

if TYPE_CHECKING:
    from hypgen.experiments.reports import Report

FILE = click.Path(path_type=Path, dir_okay=False)


@click.command(epilog=EXIT_CODES)
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path, file_okay=False, exists=True))
@click.option("-o", "--output", metavar="FILE", type=FILE, help="The page [DIR/report.html].")
@click.option("--csv", metavar="FILE", type=FILE, help="Write a row for each setting as CSV, too.")
@click.option(
    "--parquet", metavar="FILE", type=FILE, help="Write a row for each episode as Parquet, too; needs polars."
)
@click.option(
    "--figures",
    metavar="DIR",
    type=click.Path(path_type=Path, file_okay=False),
    help="Write each figure as SVG into a folder, too.",
)
def command(
    folder: Path, output: Path | None, csv: Path | None, parquet: Path | None, figures: Path | None
) -> int:
    """Make a page of what `hypgen bench` has played in DIR.

    The page is one file that needs no network: tables with intervals and what is shown, figures along the
    options that vary, published values beside ours, the machines, what is not played yet and what failed. It
    is made anew from all that DIR has, also while the suite still plays.

    \b
    Examples:
      hypgen report smoke.bench
      hypgen report results -o results.html --csv results.csv
    """
    for library, asked in (("scipy", True), ("polars", parquet is not None)):
        if asked and importlib.util.find_spec(library) is None:
            extra = "bench" if library == "scipy" else "parquet"
            raise click.ClickException(
                f"{'reports need' if library == 'scipy' else 'Parquet needs'} {library}: "
                f"pip install 'hypgen[{extra}]'"
            )
    from hypgen.experiments.reports import read_report
    from hypgen.experiments.suite_values import SuiteError
    from hypgen.whole_files import write_whole

    page = output if output is not None else folder / "report.html"
    try:
        found = read_report(folder)
        write_whole(page, found.page())
        if csv is not None:
            write_whole(csv, found.csv())
        if parquet is not None:
            found.write_parquet(parquet)
        if figures is not None:
            found.write_figures(figures)
    except SuiteError as error:
        raise click.ClickException(str(error)) from None
    except OSError as error:
        raise click.ClickException(f"{error.filename or page} cannot be written: {error.strerror}") from None
    _say_state(found)
    say(f"report: {page}")
    return Exit.OK


def _say_state(found: Report) -> None:
    """Say what the page lacks: it is found there, too."""
    played = [row.played for table in found.tables for row in table.rows]
    missing = sum(len(one.returns) < one.wanted and not one.problems for one in played)
    failed = sum(bool(one.problems) for one in played)
    for count, what in ((missing, "not played to the end"), (failed, "failed")):
        if count:
            say(f"{count} of {len(played)} settings {'are ' if what[0] == 'n' else ''}{what}")
