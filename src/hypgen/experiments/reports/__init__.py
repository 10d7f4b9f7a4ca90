# SPDX-License-Identifier: Apache-2.0
"""Reports: one offline page with the tables and figures of a suite's folder."""

from hypgen.experiments.reports.folder import Report, read_report, report

__all__ = ["Report", "read_report", "report"]
