"""The claims of the paper as data, and what the runs of a store say about them."""

from .book import Book, Claim, Inconsistency, RunSet, read_book
from .judge import judge, judge_all
from .readings import READINGS, Evidence
from .verdict import Measured, Verdict

__all__ = [
    "READINGS",
    "Book",
    "Claim",
    "Evidence",
    "Inconsistency",
    "Measured",
    "RunSet",
    "Verdict",
    "judge",
    "judge_all",
    "read_book",
]
