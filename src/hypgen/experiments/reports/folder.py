# SPDX-License-Identifier: Apache-2.0
"""Makes a report of the folder that a suite was played in, which is all that it needs."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path

from hypgen.api.model import FilePath
from hypgen.experiments.record import Record, read_record
from hypgen.experiments.reports import export
from hypgen.experiments.reports.figure_file import figure_file
from hypgen.experiments.reports.figures import figures_of
from hypgen.experiments.reports.page import anchor, page_of
from hypgen.experiments.results import read_cells
from hypgen.experiments.store import Store
from hypgen.experiments.tables import Table, tables_of
from hypgen.whole_files import write_whole


@dataclass(frozen=True)
class Report:
    """What a folder has played: for each study its tables, one a task."""

    record: Record
    studies: tuple[tuple[Table, ...], ...]

    @property
    def tables(self) -> list[Table]:
        """All tables in order."""
        return [table for study in self.studies for table in study]

    def page(self) -> str:
        """Return the page as HTML."""
        return page_of(self.record, self.studies)

    def csv(self) -> str:
        """Return CSV with a row for each setting and each published value."""
        return export.as_csv(export.settings(self.tables))

    def figures(self) -> dict[str, str]:
        """Return the figures as texts of SVG files, by names made of study and task."""
        found: dict[str, str] = {}
        for study in self.studies:
            for task, figure in figures_of(study):
                name = anchor(f"{study[0].study.name} {task}")
                number = next(i for i in itertools.count(1) if _numbered(name, i) not in found)
                found[_numbered(name, number)] = figure_file(figure)
        return found

    def write_parquet(self, file: Path) -> None:
        """Write a row for each episode; this needs polars."""
        export.write_parquet(export.episodes(self.tables), file)

    def write_figures(self, folder: Path) -> None:
        """Write each figure as SVG into a folder, which is made where there is none."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in self.figures().items():
            write_whole(folder / f"{name}.svg", text)


def _numbered(name: str, number: int) -> str:
    return name if number == 1 else f"{name}-{number}"


def read_report(folder: Path) -> Report:
    """Return what a folder has played; raise ``SuiteError`` where it is no folder of a suite."""
    store = Store(folder)
    record = read_record(store)
    return Report(
        record,
        tuple(tuple(tables_of(one.study, read_cells(one.study, one.cells, store))) for one in record.studies),
    )


def report(
    folder: FilePath,
    page: FilePath,
    *,
    csv: FilePath | None = None,
    parquet: FilePath | None = None,
    figures: FilePath | None = None,
) -> None:
    """Write the page of a folder that ``bench`` has played a suite in.

    ``csv`` names a file for a row of each setting, ``parquet`` one for a row of each episode (this needs
    polars), ``figures`` a folder for each figure as SVG. A folder without a suite raises ``SuiteError``.
    """
    found = read_report(Path(folder))
    write_whole(Path(page), found.page())
    if csv is not None:
        write_whole(Path(csv), found.csv())
    if parquet is not None:
        found.write_parquet(Path(parquet))
    if figures is not None:
        found.write_figures(Path(figures))
