"""The page of settings: it is what the code says today, whole, and what cannot be had is named."""

import json
import re
from dataclasses import dataclass
from pathlib import Path

import pytest
from click.testing import CliRunner
from torquebench import ledger_page
from torquebench.commands.ledger import command
from torquebench.controllers import InvalidInput, LedgerEntry, discovery
from torquebench.ledger_page import Section, controller_sections, knowledge_sections, page

PAGE = Path(__file__).resolve().parents[2] / "docs" / "gains.md"
NUMBER = re.compile(r"-?\d+\.?\d*(?:e[+-]?\d+)?")
ENTRY = LedgerEntry(setting="gain", value=1.0, source="chosen")


def apart(text):
    """Return a page's words with a mark for each number, and the numbers."""
    return NUMBER.sub("#", text), [float(number) for number in NUMBER.findall(text)]


def table(**changes):
    """Return the one row of a page with one entry, as cells."""
    entry = LedgerEntry(**{"setting": "gain", "value": 1.0, "source": "chosen"} | changes)
    text = page([Section(name="mine", meaning="A law.", entries=(entry,))], ())
    (row,) = [line for line in text.splitlines() if line.startswith("| `")]
    return row.strip("| ").split(" | ") if not entry.note else row


def test_the_page_is_what_the_ledgers_say_today():
    """Who changes a gain changes the page: `torquebench ledger > docs/gains.md`. Last digits may differ by machine."""
    found = page(controller_sections(), knowledge_sections())
    words, numbers = apart(PAGE.read_text(encoding="utf-8"))
    words_now, numbers_now = apart(found)
    assert words.splitlines() == words_now.splitlines()
    assert numbers == pytest.approx(numbers_now, rel=2e-3)


def test_a_page_that_is_one_gain_behind_is_seen():
    """The check of the check: a fiftieth of a gain, and a source."""
    text = PAGE.read_text(encoding="utf-8")
    words, numbers = apart(text)
    assert apart(text.replace("| 10000 |", "| 9800 |"))[1] != pytest.approx(numbers, rel=2e-3)
    assert apart(text.replace("published", "chosen"))[0] != words


def test_every_registered_controller_and_level_has_a_section():
    """None may be left out because its gains are hard to explain."""
    headings = set(re.findall(r"^### `(.+)`$", PAGE.read_text(encoding="utf-8"), re.MULTILINE))
    assert headings == {*discovery.names("controllers"), *discovery.names("knowledge")}


def test_every_controller_that_ships_declares_its_settings():
    """An empty section would be a law without an origin."""
    assert [section.name for section in controller_sections() if not section.entries] == []


@dataclass(kw_only=True)
class Needs:
    """A law whose data are not there: says so, or finds out."""

    late: bool = False
    missing = "no patterns for this arm; train them"

    def supports(self, task):
        return None if self.late else self.missing

    def reset(self, task):
        raise InvalidInput(self.missing)

    def compute(self, observation, target):
        raise AssertionError


@pytest.mark.parametrize("late", [False, True])
def test_what_a_controller_misses_stands_in_its_section(monkeypatch, late):
    """The page is made all the same, and nobody wonders where the gains went."""
    found = discovery.load
    monkeypatch.setattr(
        discovery, "load", lambda kind, name: (lambda: Needs(late=late)) if name == "pid" else found(kind, name)
    )
    section = ledger_page._section("controllers", "pid")
    assert section.entries == () and Needs.missing in section.missing
    assert f"Not here: {section.missing}" in page([section], ())


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (1234.5678, "1235"),
        (0.00012346, "0.0001235"),
        (12345.6, "12350"),
        (-1e300, "-1e+300"),
        (7, "7"),
        (True, "true"),
        (None, "none"),
        ("as printed", "as printed"),
        ([], "none"),
        ([1.0, 2.55555], "1, 2.556"),
        (list(range(20)), "0, 1, 2, 3, 4, 5, 6, 7, ... (20)"),
        ({"joint 7": {"limit": 1.23456}, "joint 6": 2}, "joint 7: limit: 1.235; joint 6: 2"),
    ],
)
def test_values_are_short(value, shown):
    """Four digits identify a gain; forty numbers in a cell identify nothing."""
    assert table(value=value)[1] == shown


def test_a_bar_in_a_note_does_not_end_its_cell():
    r"""A rule may say \|x\|: unescaped it would shift every cell behind it."""
    row = table(note="|e| below\n1")
    assert r"\|e\| below 1" in row
    assert len(re.split(r"(?<!\\)\|", row)) == len(ledger_page.COLUMNS) + 2


def test_trials_and_what_was_learnt_are_on_the_page():
    """The two figures that make a comparison unfair if nobody sees them."""
    row = table(source="tuned", note="searched", trials=13, learnt_before="on T1")
    assert "| tuned | searched | 13 | on T1 |" in row


def test_the_command_prints_the_page_or_the_same_as_data(monkeypatch):
    """Only JSON is read by programs; both come from one call."""
    sections = (Section(name="mine", meaning="A law.", entries=(ENTRY,)),)
    monkeypatch.setattr(ledger_page, "controller_sections", lambda: sections)
    monkeypatch.setattr(ledger_page, "knowledge_sections", lambda: ())
    assert CliRunner().invoke(command).output == page(sections, ())
    (mine,) = json.loads(CliRunner().invoke(command, ["--json"]).output)["controllers"]
    assert mine["name"] == "mine" and mine["entries"][0]["setting"] == "gain"
