"""The page: complete without network and scripts, safe, and honest about what is missing."""

import os
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from torquebench.controllers import InvalidInput
from torquebench.evaluation.report import write_report
from torquebench.evaluation.report.numbers import significant
from torquebench.scenarios.result import RunResult

VOID = {"meta", "br", "wbr", "link", "img", "input", "hr"}


class Reader(HTMLParser):
    """Collects what tests ask of a page, and complains about tags that do not nest."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open, self.ids, self.links, self.loads, self.tags = [], [], [], [], []
        self.words, self.silent = [], 0
        self.feed(html)
        assert not self.open, f"never closed: {self.open}"

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.tags.append(tag)
        self.ids += [values["id"]] if "id" in values else []
        self.links += [values["href"]] if tag == "a" else []
        self.loads += [values[name] for name in ("src", "srcset", "poster", "data") if name in values]
        self.loads += [values["href"]] if tag in ("link", "image", "use", "base") else []
        self.silent += tag in ("script", "style")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        self.silent -= tag in ("script", "style")
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words += [] if self.silent else [data]

    @property
    def text(self) -> str:
        return re.sub(r"\s+", " ", "".join(self.words))


def test_the_page_is_one_well_formed_document_with_one_first_heading(quick):
    reader = Reader(quick.html)
    assert quick.html.lstrip().startswith("<!DOCTYPE html>")
    assert '<html lang="en">' in quick.html
    assert reader.tags.count("h1") == 1
    assert len(reader.ids) == len(set(reader.ids))


def test_the_page_asks_nothing_of_the_network(quick):
    """Pages that load their library from elsewhere are blank on the train."""
    reader = Reader(quick.html)
    assert reader.loads == []
    assert not [link for link in reader.links if re.match(r"(https?:)?//", link)]
    assert not re.search(r"url\(|@import|fetch\(|XMLHttpRequest|<script[^>]*\ssrc", quick.html)
    assert not re.search(r"https?://(?!www\.w3\.org/)", quick.html)


def test_every_link_within_the_page_leads_somewhere(quick):
    reader = Reader(quick.html)
    fragments = {link[1:] for link in reader.links if link.startswith("#")}
    assert fragments - set(reader.ids) == set()
    folder = quick.files.index.parent
    files = {link for link in reader.links if not link.startswith(("#", "data:"))}
    figures = {f"figures/{name}" for name in os.listdir(folder / "figures")}
    tables = {f"tables/{name}" for name in os.listdir(folder / "tables")}
    assert files == {"summary.json", "runs.csv", "comparisons.csv", *figures, *tables}
    assert all((folder / name).is_file() for name in files)


def test_every_run_can_be_found_on_the_page(quick):
    assert len(set(re.findall(r'<tr id="(run-[0-9a-f]{12})"', quick.html))) == 5 * 8 * 3 + 2


def test_nothing_is_left_to_scripts(quick):
    """Numbers, words and figures stand in the HTML: it prints and reads the same with scripts off."""
    static = re.sub(r"<script.*?</script>", "", quick.html, flags=re.DOTALL)
    text = Reader(static).text
    world = quick.summary["worlds"][0]
    for sentence in (text for sentences in world["sentences"].values() for text in sentences if len(text) > 1):
        assert sentence in text
    for label, controller in world["controllers"].items():
        assert label in text
        mean = controller["metrics"]["run.tcp_position_error_mean"]["mean"]
        assert mean is None or f"{1000 * mean:.2f}" in text
    assert static.count('role="img"') == 7


def test_figures_have_a_title_and_a_description_that_exist(quick):
    ids = Reader(quick.html).ids
    for labelled in re.findall(r'role="img" aria-labelledby="([^"]+)"', quick.html):
        assert set(labelled.split()) <= set(ids)


def test_every_controller_stands_with_its_knowledge(quick):
    labels = list(quick.summary["worlds"][0]["controllers"])
    assert "computed_torque / oracle" in labels
    assert "computed_torque / none" in labels
    assert "The true payload" in Reader(quick.html).text


def test_no_number_is_ever_called_nan(quick):
    assert not re.search(r"\b(nan|None|inf)\b", Reader(quick.html).text)
    assert not re.search(r"\bNaN\b", quick.files.summary.read_text())


def test_failures_come_first_and_are_listed_with_their_reason(quick):
    text = Reader(quick.html).text
    failures = text.index("1 run of 120 failed: flexiv_full_ff / none (1). 2 runs were refused before the start.")
    assert failures < text.index("has the lowest mean position error")
    assert "joint 4 is 1.02 rad from its plan" in text
    assert "2.125 s" in text
    assert text.count("gain margin 0.4 < 1") == 2


def test_what_a_user_types_is_text_not_markup(shelf):
    """Labels reach tables, figures, sentences and links; none of them may open a tag."""
    shelf.grid({("<b>x</b>", "none"): 1e-4, ("flexiv_factory", "none"): 1e-2}, ("T1", "T2"), (1.5,))
    run = shelf.specification("<b>x</b>", "none", "T3")
    shelf.put(run, RunResult(role="run", status="failed", cause="<i>", reason="</script><script>alert(1)</script>"))
    record = shelf.record()
    record["notes"] = ['"><img src=x onerror=alert(1)>']
    page = shelf.campaign(record).report()
    assert not re.search(r"<b>x|<i>|<script>alert|<img", page.html)
    assert "<b>x</b> / none" in Reader(page.html).text


def test_two_reports_of_one_store_are_equal_to_the_byte(shelf):
    page = shelf.grid(trajectories=("T1", "T2"), masses=(1.5,)).campaign().report()
    again = write_report(shelf.folder)
    assert again.index.read_text(encoding="utf-8") == page.html


def test_a_report_that_cannot_be_written_leaves_the_old_page(shelf, monkeypatch):
    page = shelf.grid(trajectories=("T1",), masses=(1.5,)).campaign().report()
    replaced = os.replace

    def full_disk(source, target):
        if str(target).endswith("index.html"):
            raise OSError(28, "No space left on device")
        replaced(source, target)

    page.files.index.write_text("the old page")
    monkeypatch.setattr(os, "replace", full_disk)
    with pytest.raises(InvalidInput, match="No space left"):
        write_report(shelf.folder)
    assert page.files.index.read_text() == "the old page"
    assert sorted(file.name for file in page.files.index.parent.iterdir()) == [
        "comparisons.csv", "figures", "index.html", "runs", "runs.csv", "summary.json", "tables",
    ]  # fmt: skip


def test_a_folder_without_a_store_is_named(tmp_path):
    with pytest.raises(InvalidInput, match="holds no run store"):
        write_report(tmp_path)


def test_a_page_of_14_rows_stays_light(shelf):
    scales = {(f"law_{number}", level): 1e-3 * (number + 1) for number in range(7) for level in ("none", "oracle")}
    page = shelf.grid(scales).campaign().report()
    assert len(page.html.encode()) < 1.5e6


def test_the_best_of_those_told_nothing_is_named_when_the_best_of_all_knew_the_load(shelf):
    """Otherwise the informed law wins the headline and the reader learns nothing about laws at equal knowledge."""
    sizes = {("flexiv_factory", "none"): 1e-2, ("pid", "none"): 1e-3, ("pid", "oracle"): 1e-4}
    text = Reader(shelf.grid(sizes).campaign().report().html).text
    assert text.index("pid / oracle tracked best in position") < text.index(
        "Of those told nothing of the load pid / none comes first"
    )


def test_nothing_is_added_when_the_best_of_all_was_told_nothing(shelf):
    """One sentence says it."""
    sizes = {("flexiv_factory", "none"): 1e-2, ("pid", "none"): 1e-4, ("pid", "oracle"): 1e-3}
    assert "Of those told nothing" not in shelf.grid(sizes).campaign().report().html


def test_who_ran_more_cells_is_said_to_be_as_good_as_where_the_others_ran_too(shelf):
    """A mean over heavier loads beside one without them would make the second of a ranking look like its first."""
    sizes = {("flexiv_factory", "none"): 1e-2, ("pid", "none"): 1e-3, ("computed_torque", "none"): 1.2e-3}
    shelf.grid(sizes, masses=(1.5,)).grid({("pid", "none"): 1e-3}, masses=(2.5, 3.5, 4.5)).campaign()
    runs = [run for run in shelf.store.runs() if run.specification.controller == "pid"]
    errors = {run.address: run.result.metrics["run"]["tcp_position_error_mean"]["value"] for run in runs}
    light = [errors[run.address] for run in runs if run.specification.schedule.entries[0][1].mass == 1.5]
    text = Reader(shelf.report().html).text
    assert f"pid / none tracked best in position: mean error {significant(1e3 * np.mean(light))} mm" in text
    assert significant(1e3 * np.mean(light)) != significant(1e3 * np.mean(list(errors.values())))
    assert "They are ranked over the 8 cells" in text
    assert "lowest position error first, by the cells that most of them ran" in text


def test_nothing_is_said_of_common_cells_where_all_ran_all(quick):
    assert "Not all controllers ran all cells" not in quick.html


def test_the_first_where_all_ran_may_be_behind_over_all_runs_and_is_said_to_be(shelf):
    """To call that undecided would hide the heavier loads, which only two of the laws carried."""
    sizes = {("pid", "none"): 1e-3, ("flexiv_factory", "none"): 2e-3}
    others = {(f"law_{number}", "none"): 5e-3 for number in range(3)}
    shelf.grid(sizes | others, masses=(1.5,))
    shelf.grid({("pid", "none"): 2e-2, ("flexiv_factory", "none"): 2e-3}, masses=(2.5, 3.5, 4.5)).campaign()
    text = Reader(shelf.report().html).text
    assert re.search(r"but against flexiv_factory / none it is \S+ times higher over all runs that both have", text)


def test_a_failure_of_the_lead_in_is_called_one(shelf):
    """A time before zero reads like a slip of the pen."""
    shelf.grid({("flexiv_factory", "none"): 1e-2, ("pid", "none"): 1e-3})
    early = RunResult(role="run", status="failed", cause="divergence", reason="joint 7", failed_at=-0.745)
    shelf.put(shelf.specification("pid", "oracle"), early)
    assert "\N{MINUS SIGN}0.745 s, in the lead-in" in shelf.campaign().report().html
