"""Tables as files: whatever a name holds comes out of CSV, Markdown and LaTeX as it went in, and breaks nothing."""

import csv
import html
import io
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation.report import write_report
from torquebench.evaluation.report.table import Cell, Column, Table
from torquebench.evaluation.report.table_files import _LATEX, FORMATS, latex, markdown, table_files, tables_in

NASTY = r"a_b & <script> | \x"


def table_of(*texts, name="w1-test"):
    """Return a table of one column of words and one of numbers."""
    rows = [(Cell(text, kind="head"), Cell("1.5", 1.5)) for text in texts]
    columns = [Column("Controller", numeric=False), Column("Error", "mm", group="Position")]
    return Table(id=name, caption="Errors", columns=columns, rows=rows)


def cells_of_markdown(text):
    """Return the cells of a Markdown table as a reader shows them."""
    lines = [line for line in text.splitlines() if line.startswith("| ")]
    split = [re.split(r"(?<!\\)\|", line)[1:-1] for line in lines]
    return [[html.unescape(re.sub(r"\\([!-/:-@\[-`{-~])", r"\1", cell.strip())) for cell in row] for row in split]


def words_of_latex(text):
    """Return what LaTeX prints for escaped words."""
    for sign, command in sorted(_LATEX.items(), key=lambda pair: -len(pair[1])):
        text = text.replace(command, sign) if len(command) > 2 else text
    return re.sub(r"\\([{}$&#_%])", r"\1", text)


def test_a_name_with_every_special_sign_comes_out_of_all_three(tmp_path):
    """A controller may be called anything, and its row must stay one row of two cells."""
    table = table_of(NASTY, "plain")
    assert list(csv.reader(io.StringIO(table.csv))) == [
        ["Controller", "Position: Error [mm]"], [NASTY, "1.5"], ["plain", "1.5"],
    ]  # fmt: skip
    assert cells_of_markdown(markdown(table))[2:] == [[NASTY, "1.5"], ["plain", "1.5"]]
    row = next(line for line in latex(table).splitlines() if "script" in line)
    assert row == r"a\_b \& \textless{}script\textgreater{} \textbar{} \textbackslash{}x & 1.5 \\"


@given(st.text(st.characters(codec="ascii", exclude_categories=["Cc"]), min_size=1))
def test_no_text_opens_a_cell_a_tag_or_a_comment(text):
    """Markdown and LaTeX have signs that end a cell: whatever comes, the table keeps its shape."""
    shown = " ".join(text.split())
    written = markdown(table_of(text))
    assert cells_of_markdown(written)[2] == [shown, "1.5"]
    assert "<" not in written
    row = next(line for line in latex(table_of(text)).splitlines() if line.endswith(r"& 1.5 \\"))
    assert len(re.findall(r"(?<!\\)&", row)) == 1
    assert not re.search(r"(?<!\\)[%#_^~]", row)


@pytest.mark.parametrize("text", [NASTY, "100 % of {x}^2 ~ [1]", r"\_ \\ $5", "a<b>c|d"])
def test_latex_prints_the_words_that_came(text):
    """An escape that changes a word would change a controller's name in a paper."""
    row = next(line for line in latex(table_of(text)).splitlines() if line.endswith(r"& 1.5 \\"))
    assert words_of_latex(row.removesuffix(r" & 1.5 \\")) == text


def test_units_stand_in_the_header_and_words_where_there_is_no_number():
    """A file without the page around it has to say what its numbers are."""
    table = Table(
        id="w1-x",
        caption="Lag",
        columns=[Column("Controller", numeric=False), Column("Lag", "ms", note="by correlation"), Column("Ratio", "1")],
        rows=[(Cell("pid"), Cell("\N{EMPTY SET} failed", note="2 runs"), Cell("0.50", 0.5))],
    )
    assert table.csv.splitlines()[0] == "Controller,Lag [ms],Ratio"
    assert "(2 runs)" in markdown(table) and markdown(table).endswith("- Lag: by correlation\n")
    assert r"$\emptyset$ failed (2 runs)" in latex(table)
    assert r"\begin{tabular}{lrr}" in latex(table)


def test_tables_are_found_wherever_they_stand_once_and_only_with_rows():
    """A section that somebody adds next year is exported without a line of its own."""
    first, empty, second = table_of("a", name="a"), table_of(name="empty"), table_of("b", name="b")
    assert tables_in([(first, [empty]), Cell("no table"), [("label", second), first]]) == [first, second]
    assert set(table_files([first])) == {f"a.{suffix}" for suffix in FORMATS}
    assert "w1-a-b-py-C.csv" in table_files([table_of("a", name="w1-a/b.py:C")])


def test_every_table_of_the_page_is_a_file_and_the_page_links_it(quick):
    """The headline table has the same numbers in its file as on the page."""
    folder = quick.files.tables
    names = {file.name for file in folder.iterdir()}
    assert {f"w1-table.{suffix}" for suffix in FORMATS} <= names
    assert all(f'href="tables/{name}"' in quick.html for name in names)
    for identity in {name.rpartition(".")[0] for name in names}:
        assert {f"{identity}.{suffix}" for suffix in FORMATS} <= names
    rows = list(csv.reader(io.StringIO((folder / "w1-table.csv").read_text())))
    assert rows[1][0] == "computed_torque_pid / none" and rows[1][0] in quick.html.replace("<wbr>", "")


def test_a_table_that_the_page_no_longer_has_leaves_the_folder_and_other_files_stay(shelf):
    """What outlives its data is read as data."""
    page = shelf.grid(trajectories=("T1",), masses=(1.5,)).campaign().report()
    stale, own = page.files.tables / "w9-headline.tex", page.files.tables / "notes.txt"
    for file in (stale, own):
        file.write_text("x")
    write_report(shelf.folder)
    assert not stale.exists() and own.exists()


def test_a_report_written_again_is_the_same_bytes_in_every_file(shelf):
    """Page, figures, tables and data: a store says one thing."""
    folder = shelf.grid(trajectories=("T1", "T2")).campaign().report().files.index.parent
    first = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    write_report(shelf.folder)
    assert {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()} == first
