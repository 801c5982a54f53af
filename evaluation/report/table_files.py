"""Every table of the page as a file: CSV for programs, Markdown for pages, LaTeX for papers."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass

from .table import Cell, Table

FORMATS = ("csv", "md", "tex")
"""Suffixes of the files of a table."""

_MARKDOWN = {"&": "&amp;", "<": "&lt;", ">": "&gt;", "|": "&#124;"} | {mark: f"\\{mark}" for mark in "\\`*_[]~#$"}
"""The pipe as an entity: not every reader of tables knows it behind a backslash."""

_LATEX = {
    **{mark: f"\\{mark}" for mark in "{}$&#_%"},
    "\\": r"\textbackslash{}",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "[": "{[}",
    "]": "{]}",
    "*": "{*}",
    "`": r"\textasciigrave{}",
    "\N{MINUS SIGN}": "$-$",
    "\N{MULTIPLICATION SIGN}": r"$\times$",
    "\N{DIVISION SIGN}": r"$\div$",
    "\N{PLUS-MINUS SIGN}": r"$\pm$",
    "\N{SQUARE ROOT}": r"$\sqrt{}$",
    "\N{IDENTICAL TO}": r"$\equiv$",
    "\N{INFINITY}": r"$\infty$",
    "\N{UPWARDS ARROW}": r"$\uparrow$",
    "\N{RIGHTWARDS ARROW}": r"$\rightarrow$",
    "\N{CHECK MARK}": r"$\surd$",
    "\N{BALLOT X}": r"$\otimes$",
    "\N{BLACK FLAG}": r"$\dagger$",
    "\N{GREATER-THAN OR EQUAL TO}": r"$\geq$",
    "\N{LESS-THAN OR EQUAL TO}": r"$\leq$",
    "\N{EMPTY SET}": r"$\emptyset$",
    "\N{BLACK DOWN-POINTING TRIANGLE}": r"$\bigtriangledown$",
    "\N{BLACK UP-POINTING TRIANGLE}": r"$\bigtriangleup$",
    "\N{WHITE DOWN-POINTING SMALL TRIANGLE}": r"$\nabla$",
    "\N{WHITE DIAMOND}": r"$\diamond$",
    "\N{SUPERSCRIPT TWO}": "$^2$",
    "\N{SUPERSCRIPT SIX}": "$^6$",
    "\N{MICRO SIGN}": r"$\mu$",
    "\N{GREEK SMALL LETTER TAU}": r"$\tau$",
}
"""What LaTeX reads as a command, and signs that its standard fonts have in formulas only.

Brackets and stars stand in braces: a row may not begin with what the end of the row before would take for its own.
"""


def tables_in(value: object) -> list[Table]:
    """Return every table with rows within nested sequences and dataclasses, each once, in their order."""
    found: dict[str, Table] = {}
    for table in _walk(value):
        found.setdefault(table.id, table)
    return [table for table in found.values() if table.rows]


def stem(table: Table) -> str:
    """Return the name of a table's files; what no file name should have becomes a dash."""
    return re.sub(r"[^\w-]", "-", table.id)


def table_files(tables: Sequence[Table]) -> dict[str, str]:
    """Return the files of tables by their names."""
    texts: Mapping[str, Callable[[Table], str]] = {"csv": lambda table: table.csv, "md": markdown, "tex": latex}
    return {f"{stem(table)}.{suffix}": texts[suffix](table) for table in tables for suffix in FORMATS}


def markdown(table: Table) -> str:
    """Return a table in Markdown, its caption above and its notes below."""
    head = [_in_markdown(column.title) for column in table.columns]
    rule = ["---:" if column.numeric else "---" for column in table.columns]
    body = [[_in_markdown(_whole(cell)) for cell in row] for row in table.rows]
    lines = [f"| {' | '.join(row)} |" for row in (head, rule, *body)]
    notes = [f"- {_in_markdown(name)}: {_in_markdown(note)}" for name, note in table.notes]
    return "\n".join([_in_markdown(table.caption), "", *lines, *([""] if notes else []), *notes]) + "\n"


def latex(table: Table) -> str:
    """Return a table as a ``table`` environment; its rules are those of the package booktabs."""
    head, *body = (
        " & ".join(_in_latex(text) for text in row) + r" \\"
        for row in ([column.title for column in table.columns], *(map(_whole, row) for row in table.rows))
    )
    lines = [
        "% needs \\usepackage{booktabs}",
        "\\begin{table}",
        "\\centering",
        f"\\caption{{{_in_latex(table.caption)}}}",
        f"\\label{{tab:{stem(table)}}}",
        f"\\begin{{tabular}}{{{''.join('r' if column.numeric else 'l' for column in table.columns)}}}",
        "\\toprule",
        head,
        "\\midrule",
        *body,
        "\\bottomrule",
        "\\end{tabular}",
        *(f"\\par\\footnotesize {_in_latex(name)}: {_in_latex(note)}" for name, note in table.notes),
        "\\end{table}",
    ]
    return "\n".join(lines) + "\n"


def _walk(value: object) -> Iterator[Table]:
    if isinstance(value, Table):
        yield value
    elif is_dataclass(value) and not isinstance(value, type):
        yield from _walk([getattr(value, field.name) for field in fields(value)])
    elif isinstance(value, list | tuple):
        for entry in value:
            yield from _walk(entry)


def _whole(cell: Cell) -> str:
    """Return what a cell shows, its second line in parentheses."""
    return f"{cell.text} ({cell.note})" if cell.note else cell.text


def _in_markdown(text: str) -> str:
    return _replaced(text, _MARKDOWN)


def _in_latex(text: str) -> str:
    # Between two hyphens, which would become a dash, a pair of braces.
    return re.sub("-(?=-)", "-{}", _replaced(text, _LATEX))


def _replaced(text: str, signs: Mapping[str, str]) -> str:
    """Return one line of text with every special sign replaced."""
    return "".join(signs.get(sign, sign) for sign in re.sub(r"\s+", " ", text).strip())
