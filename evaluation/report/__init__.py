"""The report: one page and its tables from a run store."""

from .write import ReportFiles, write_report

__all__ = ["ReportFiles", "write_report"]
