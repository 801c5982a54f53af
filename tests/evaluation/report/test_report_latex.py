"""LaTeX files of tables, held by a strict reader: what it passes, pdflatex with booktabs sets.

There is no LaTeX where the tests run. The reader knows the few commands that a table may use, keeps track of braces,
formulas and environments, counts the cells of every row, and refuses signs that inputenc's utf8 has no glyph for.
"""

import ast
import re
from pathlib import Path

import pytest
import torquebench.evaluation.report
from hypothesis import given
from hypothesis import strategies as st
from torquebench.evaluation.report.table import Cell, Column, Table
from torquebench.evaluation.report.table_files import _LATEX, latex

TEXT_COMMANDS = {"textbackslash", "textasciicircum", "textasciitilde", "textless", "textgreater", "textbar"}
TEXT_COMMANDS |= {"textasciigrave"}
FORMULA_COMMANDS = {"times", "geq", "leq", "emptyset", "bigtriangledown", "bigtriangleup", "diamond", "tau", "mu"}
FORMULA_COMMANDS |= {"surd", "otimes", "pm", "div", "sqrt", "dagger", "infty", "nabla", "equiv", "rightarrow"}
FORMULA_COMMANDS |= {"uparrow"}
ESCAPED = set("{}$&#_%")
LETTERS = set("äöüßÄÖÜéèêàâçñåÅøØæÆ")
"""Beyond ASCII only these: inputenc sets them with every font."""

SIGNS = sorted({chr(code) for code in range(32, 127)} | {sign for sign in _LATEX if len(sign) == 1})
"""What hypothesis makes words of."""

TOKEN = re.compile(r"\\[A-Za-z]+ ?|\\.|[{}$&#_%^~]|[^\\{}$&#_%^~]+", re.DOTALL)
SHAPE = re.compile(
    r"% needs \\usepackage\{booktabs\}\n\\begin\{table\}\n\\centering\n\\caption\{(?P<caption>.*)\}\n"
    r"\\label\{tab:(?P<label>[\w:-]+)\}\n\\begin\{tabular\}\{(?P<columns>[lr]+)\}\n\\toprule\n(?P<head>.*) \\\\\n"
    r"\\midrule\n(?P<body>(?:.* \\\\\n)+)\\bottomrule\n\\end\{tabular\}\n(?P<notes>(?:\\par\\footnotesize .*\n)*)"
    r"\\end\{table\}\n"
)


def cells_of(text: str) -> list[str]:
    """Return the cells of a row, or of any text its only one.

    Raises:
        AssertionError: If LaTeX would stop at it, or read one of its signs as a command.
    """
    depth, formula, cells = 0, False, [""]
    for token in TOKEN.findall(text):
        name = token[1:].strip()
        if token == "&":
            assert depth == 0 and not formula, f"a cell ends within braces or a formula: {text!r}"
            cells.append("")
            continue
        if token == "$":
            formula = not formula
        elif token in "{}":
            depth += 1 if token == "{" else -1
            assert depth >= 0, f"a brace closes that none opened: {text!r}"
        elif token == "^":
            assert formula, f"a superscript outside of a formula: {text!r}"
        elif token in "#_%~":
            raise AssertionError(f"{token!r} is not escaped: {text!r}")
        elif token.startswith("\\") and name not in ESCAPED:
            known = FORMULA_COMMANDS if formula else TEXT_COMMANDS
            assert name in known, f"{token!r} is no command of {'formulas' if formula else 'text'} here: {text!r}"
            assert formula or not token.endswith(" "), f"{token!r} swallows the space after it: {text!r}"
        else:
            strange = {sign for sign in token if not sign.isascii()} - LETTERS
            assert not strange, f"no glyph for {sorted(strange)}: {text!r}"
            assert "--" not in token and "`" not in token, f"read as a dash or a quotation mark: {text!r}"
        cells[-1] += token
    assert depth == 0 and not formula, f"a brace or a formula stays open: {text!r}"
    return cells


def check(document: str) -> list[list[str]]:
    """Return head and rows of a table file as cells.

    Raises:
        AssertionError: If LaTeX would stop at it, or set something else than what it says.
    """
    found = SHAPE.fullmatch(document)
    assert found, f"not the shape of a table:\n{document[:400]}"
    rows = [cells_of(row.removesuffix(r" \\")) for row in (found["head"], *found["body"].splitlines())]
    for row in rows:
        assert len(row) == len(found["columns"]), f"{len(row)} cells for {found['columns']!r}: {row}"
        assert not row[0].lstrip().startswith(("[", "*")), f"the line end before takes this for its own: {row[0]!r}"
    for text in (found["caption"], *re.findall(r"\\par\\footnotesize (.*)\n", found["notes"])):
        assert len(cells_of(text)) == 1, f"a cell ends outside of the table: {text!r}"
    return rows


def table_of(*texts, columns=2):
    """Return a table whose titles, caption, note and cells are these texts."""
    titles = [Column(texts[0], numeric=place > 0, note="" if place else texts[-1]) for place in range(columns)]
    return Table(id="w1-test", caption=texts[0], columns=titles, rows=[[Cell(text)] * columns for text in texts])


def test_every_table_of_a_page_is_read(quick):
    """With failed, refused and undecided rows among them; a table that does not compile costs its reader an evening."""
    files = [file for file in quick.files.tables.iterdir() if file.suffix == ".tex"]
    assert len(files) > 5
    for file in files:
        assert len(check(file.read_text(encoding="utf-8"))) > 1, file.name


@given(st.lists(st.text(st.sampled_from(SIGNS), min_size=1, max_size=12), min_size=1, max_size=3), st.integers(2, 4))
def test_whatever_a_cell_a_title_a_caption_or_a_note_says_the_file_is_read(texts, columns):
    """Names of controllers, settings and reasons are anybody's words."""
    rows = check(latex(table_of(*texts, columns=columns)))
    assert [len(row) for row in rows] == [columns] * (1 + len(texts))


def test_every_sign_that_the_report_writes_is_known():
    """A new sign on the page must come with its command, or one day a paper does not compile."""
    folder = Path(torquebench.evaluation.report.__file__).parent
    trees = [ast.parse(file.read_text(encoding="utf-8")) for file in sorted(folder.glob("*.py"))]
    words = [node.value for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Constant)]
    signs = {sign for word in words if isinstance(word, str) for sign in word if not sign.isascii()}
    assert {"\N{CHECK MARK}", "\N{SUPERSCRIPT SIX}", "\N{MICRO SIGN}"} <= signs
    assert signs - set(_LATEX) - LETTERS == set()


@pytest.mark.parametrize("sign", [sign for sign in _LATEX if not sign.isascii()])
def test_a_sign_beyond_ascii_becomes_a_formula(sign):
    """The standard fonts of text have none of them."""
    assert cells_of(_LATEX[sign]) == [_LATEX[sign]] and re.fullmatch(r"\$.+\$", _LATEX[sign])


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        ("a_b", "not escaped"),
        ("50 %", "not escaped"),
        ("#1", "not escaped"),
        ("a~b", "not escaped"),
        ("m^2", "superscript"),
        ("{a", "stays open"),
        ("a}", "none opened"),
        ("$a", "stays open"),
        ("{a & b}", "within braces"),
        (r"\foo{}", "no command"),
        (r"\textless a", "swallows"),
        (r"\times", "no command"),
        (r"$\textless{}$", "no command"),
        ("\N{CHECK MARK}", "no glyph"),
        ("a -- b", "dash"),
        ("`x`", "quotation"),
    ],
)
def test_the_reader_refuses_what_latex_would_stop_at_or_misread(row, reason):
    """The check of the check."""
    with pytest.raises(AssertionError, match=reason):
        cells_of(row)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("{lr}", "{lrr}"),
        ("\\midrule\n", ""),
        ("\\end{tabular}", "\\end{table}"),
        ("x & x", "[x & x"),
        ("x & x", "*x & x"),
        ("x & x", "x & x & x"),
        (" \\\\\n\\bottomrule", "\n\\bottomrule"),
    ],
)
def test_the_reader_refuses_a_table_that_lost_its_shape(old, new):
    """The check of the check."""
    document = latex(table_of("x"))
    assert check(document) == [["x ", " x"], ["x ", " x"]]
    assert old in document
    with pytest.raises(AssertionError):
        check(document.replace(old, new))
