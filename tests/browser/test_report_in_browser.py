"""The report as a browser shows it: from disk, without a network, by mouse and by keyboard."""

import json
import shlex

import numpy as np
import pytest
from torquebench import run
from torquebench.scenarios.robots import rizon4s
from torquebench.scenarios.store import Store

PICTURE = "document.querySelector('.panel canvas').toDataURL()"
SLIDER = "document.querySelector('.player input')"


def open_run(tab, label):
    """Open the first run of a controller as a click would; its row is ``row`` from then on."""
    rows = "[...document.querySelectorAll('tr[data-run]')]"
    tab.run(f"globalThis.row = {rows}.find((row) => row.dataset.label === {json.dumps(label)})")
    tab.run("row.closest('details').open = true; row.querySelector('button.opens').click()")
    tab.wait("row.nextElementSibling.querySelector('.panel-title')")


@pytest.fixture
def page(tab, campaign):
    """The report, freshly opened."""
    tab.emulate()
    return tab.open(campaign)


@pytest.fixture
def drilled(page):
    """The report with the run of computed_torque on T1 opened."""
    open_run(page, "computed_torque / none")
    return page


def quiet(tab):
    """Nothing was asked of the network and nothing was complained of."""
    assert tab.run("1") == 1
    assert [url for url in tab.requests if not url.startswith(("file:", "data:"))] == []
    assert tab.complaints == []


def test_from_disk_without_a_network_all_is_drawn_and_nothing_is_complained_of(drilled):
    """The page must work on the train and in an archive."""
    empty = "!svg.querySelector('path, line, circle')"
    assert drilled.run(f"[...document.querySelectorAll('svg[role=img]')].filter((svg) => {empty}).length") == 0
    assert drilled.run("document.querySelectorAll('.panel path.curve').length") >= 3 + 7
    assert len([url for url in drilled.requests if "/runs/" in url]) == 1
    quiet(drilled)


def test_script_and_pinocchio_put_the_tool_at_the_same_place(page):
    """A replay that bends another way than the arm did would be believed."""
    robot = rizon4s()
    model = robot.model()
    skeleton = "Object.values(JSON.parse(document.getElementById('robots').textContent))[0]"
    for q in np.random.default_rng(5).uniform(robot.lower, robot.upper, (8, robot.n)):
        found = page.run(f"torquebench.toolPoint({skeleton}, {json.dumps(q.tolist())})")
        assert found == pytest.approx(model.forward_kinematics(q)[:3, 3], abs=1e-8)


def test_the_replay_moves_along_the_path_of_the_trace(page, campaign):
    """Quantised joint angles must still put the tool where the trace says it was, to a tenth of a millimetre."""
    with Store.read(campaign.parent.parent) as store:
        stored = next(found for found in store.runs() if found.trace and found.specification.trajectory == "T1")
        trace = store.trace(stored.trace)
    name = stored.address[:16]
    page.run(f"torquebench.load('{name}').then((record) => {{ globalThis.record = record; }})")
    shown = page.run(
        "(() => { const skeleton = Object.values(JSON.parse(document.getElementById('robots').textContent))[0];"
        " const columns = record.trace.q.map(torquebench.samples);"
        " return [...columns[0].keys()].map((i) => torquebench.toolPoint(skeleton, columns.map((c) => c[i]))); })()"
    )
    stride = round(page.run("record.trace.frame / record.trace.dt"))
    assert np.array(shown) == pytest.approx(trace["p"][::stride], abs=1e-4)


def test_one_cursor_moves_plots_replay_and_slider(drilled):
    """What is read off a curve is where the arm is drawn."""
    drilled.run(f"globalThis.before = {PICTURE}")
    drilled.run(
        "globalThis.plot = document.querySelector('.panel svg.lines'), globalThis.box = plot.getBoundingClientRect()"
    )
    middle = "{ pointerType: 'mouse', clientX: box.left + box.width / 2 }"
    drilled.run(f"plot.dispatchEvent(new PointerEvent('pointermove', {middle}))")
    assert drilled.run("Number(document.querySelector('.player input').value)") > 0.5
    places = drilled.run(
        "[...document.querySelectorAll('.panel .cursor')].map((line) => line.getAttribute('d').split(' ')[0])"
    )
    assert len(places) == 4
    assert len(set(places)) == 1
    assert drilled.run(f"{PICTURE} !== before")


def test_playing_moves_time_and_stops_at_the_end(drilled):
    """The button says what it will do."""
    drilled.run("document.querySelector('.player select').value = '4'")
    drilled.run("document.querySelector('.player .play').click()")
    assert drilled.run("document.querySelector('.player .play').textContent") == "Pause"
    drilled.wait("Number(document.querySelector('.player input').value) > 1")
    drilled.wait("document.querySelector('.player .play').textContent === 'Play'")
    slider = "document.querySelector('.player input')"
    assert drilled.run(f"Number({slider}.value) > Number({slider}.max) - 0.02")


def test_nothing_moves_by_itself(drilled):
    """Whoever gets dizzy starts it, or does not."""
    time = "document.querySelector('.player input').value"
    before = drilled.run(time)
    drilled.run("new Promise((done) => setTimeout(done, 150))")
    assert drilled.run(time) == before


def test_a_ghost_adds_its_arm_and_its_curves(drilled):
    """The other controllers of the same cell and no others: same motion, load and repetition."""
    labels = drilled.run("[...document.querySelectorAll('.ghosts label')].map((label) => label.textContent.trim())")
    assert "flexiv_factory / none" in labels
    assert "computed_torque / none" not in labels
    curves = "document.querySelector('.panel svg.lines').querySelectorAll('.curve').length"
    assert drilled.run(curves) == 1
    drilled.run(f"globalThis.alone = {PICTURE}")
    drilled.run("[...document.querySelectorAll('.ghosts label')].find((l) => l.textContent.includes('flexiv')).click()")
    drilled.wait(f"{curves} === 2")
    assert drilled.run(f"{PICTURE} !== alone")
    quiet(drilled)


def test_a_header_sorts_and_an_open_run_stays_below_its_row(drilled):
    """Numbers as numbers, in both directions."""
    column = "[...row.closest('table').tHead.rows[0].cells].find((cell) => cell.textContent.startsWith('Repetition'))"
    values = "[...row.parentNode.rows].filter((r) => r.dataset.run).map((r) => Number(r.cells[3].textContent))"
    for word in ("ascending", "descending"):
        drilled.run(f"{column}.querySelector('button').click()")
        assert drilled.run(f"{column}.getAttribute('aria-sort')") == word
        found = drilled.run(values)
        assert found == sorted(found, reverse=word == "descending")
        assert drilled.run("row.nextElementSibling.className") == "run-panel"


def test_a_filter_hides_rows_and_says_how_many_are_left(drilled):
    """All words must be in the row; an emptied field shows all again."""
    field = "row.closest('.block').querySelector('input[type=search]')"
    for text, shown in (("t6 1.5", 7), ("T6 nonsense", 0), ("", 14)):
        drilled.run(f"{field}.value = {json.dumps(text)}; {field}.dispatchEvent(new Event('input'))")
        assert drilled.run("[...row.parentNode.rows].filter((r) => r.dataset.run && !r.hidden).length") == shown
        assert drilled.run("row.closest('.block').querySelector('output').textContent") == (
            f"{shown} of 14 rows" if text else ""
        )
    assert drilled.run("row.nextElementSibling.hidden") is False


def test_the_keyboard_opens_turns_and_closes(drilled):
    """All controls are native, so Tab and Enter reach them; arrows turn the arm."""
    drilled.run(f"document.querySelector('.panel canvas').focus(); globalThis.before = {PICTURE}")
    drilled.press("ArrowLeft", 37)
    assert drilled.run(f"{PICTURE} !== before")
    drilled.press("0", 48, "0")
    assert drilled.run(f"{PICTURE} === before")
    drilled.run("document.querySelector('.player input').focus()")
    before = drilled.run("Number(document.activeElement.value)")
    drilled.press("ArrowRight", 39)
    assert drilled.run("Number(document.activeElement.value)") == pytest.approx(before + 0.01)
    drilled.run("row.querySelector('button.opens').focus()")
    drilled.press("Enter", 13, "\r")
    drilled.wait("document.querySelector('.panel') === null")
    assert drilled.run("document.activeElement.getAttribute('aria-expanded')") == "false"


def test_alt_and_an_arrow_leave_the_page_as_everywhere(drilled):
    """The picture turns with the arrows, and must not take the browser's way back with them."""
    for held, taken in (("", True), ("altKey: true", False), ("ctrlKey: true", False)):
        event = f"new KeyboardEvent('keydown', {{ key: 'ArrowLeft', cancelable: true, {held} }})"
        assert drilled.run(f"!document.querySelector('.panel canvas').dispatchEvent({event})") == taken


def test_names_are_text_wherever_they_stand(page):
    """A name with a tag, a quote or a right-to-left mark is shown, not obeyed."""
    names = set(page.run("[...document.querySelectorAll('tr[data-run]')].map((row) => row.dataset.label)"))
    hostile = [name for name in names if not name.replace("_", "").replace(" / ", "").isascii() or "<" in name]
    assert len(hostile) == 3
    for name in [*hostile, "mpc / none"]:
        open_run(page, name)
        assert page.run("row.nextElementSibling.textContent").startswith(f"{name}: T")
    assert page.run("document.title").endswith("torquebench")
    assert page.run("document.querySelectorAll('img').length") == 0
    quiet(page)


def test_a_run_whose_script_is_gone_says_so(page):
    """A page that was sent without its folder."""
    page.run("globalThis.row = document.querySelector('tr[data-run]'); row.dataset.run = '0123456789abcdef'")
    page.run("row.querySelector('button.opens').click()")
    page.wait("row.nextElementSibling.textContent.includes('is not beside this page')")


def test_a_narrow_screen_scrolls_one_way_only(drilled):
    """What sticks out of 390 pixels is not read."""
    drilled.emulate(390, 844)
    assert drilled.run("document.documentElement.scrollWidth") == 390
    assert drilled.run("document.querySelector('.panel').getBoundingClientRect().right") <= 390


def test_a_caption_stays_in_sight_while_its_table_scrolls(page):
    """On a telephone the end of a wide table is far from its beginning."""
    page.emulate(width=400)
    page.run("globalThis.wide = document.getElementById('w1-table').closest('.scroll'), wide.scrollLeft = 9999")
    assert page.run("wide.scrollLeft") > 100
    left, right = page.run(
        "(({left, right}) => [left, right])(wide.querySelector('caption span').getBoundingClientRect())"
    )
    assert 0 <= left < right <= 400


def test_the_browser_s_own_parts_follow_the_button(page):
    """A white slider on a dark page is the first thing one sees."""
    page.emulate(prefers_color_scheme="light")
    page.run("document.querySelector('.theme').click()")
    assert page.run("getComputedStyle(document.documentElement).colorScheme") == "dark"
    page.run("document.querySelector('.theme').click()")
    assert page.run("getComputedStyle(document.documentElement).colorScheme") == "light"


def test_paper_has_no_controls_and_keeps_the_figures(drilled):
    """Buttons cannot be pressed on paper."""
    drilled.emulate(media="print")
    shown = "[...document.querySelectorAll('button, input, select')].filter((one) => one.offsetParent !== null)"
    # A header is its own button: without one there would be no word.
    assert drilled.run(f"{shown}.filter((one) => !one.closest('thead')).map((one) => one.outerHTML)") == []
    assert drilled.run("document.querySelector('.panel svg.lines').getBoundingClientRect().width") > 100
    assert drilled.pdf().startswith(b"%PDF")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_stands_out_from_its_ground(drilled, scheme):
    """WCAG asks for a contrast of 4.5; plots take the page's colours."""
    drilled.emulate(prefers_color_scheme=scheme)
    drilled.run("globalThis.style = getComputedStyle(document.documentElement)")
    names = ["--page", "--text", "--soft", "--link", "--bad", "--good"]
    colours = [drilled.run(f"style.getPropertyValue('{name}').trim()") for name in names]
    levels = [luminance(colour) for colour in colours]
    assert (levels[0] > 0.5) == (scheme == "light")
    for level in levels[1:]:
        high, low = max(level, levels[0]), min(level, levels[0])
        assert (high + 0.05) / (low + 0.05) >= 4.5


def luminance(colour: str) -> float:
    parts = np.array([int(colour[place : place + 2], 16) for place in (1, 3, 5)]) / 255.0
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def test_the_command_of_a_run_runs_it_again(page, campaign, tmp_path):
    """Same address, same numbers: that is what the page promises."""
    with Store.read(campaign.parent.parent) as store:
        stored = next(found for found in store.runs() if found.specification.controller == "flexiv_factory")
    page.run(f"torquebench.load('{stored.address[:16]}').then((record) => {{ globalThis.record = record; }})")
    words = shlex.split(page.run("record.command"))
    run(words[2], out=tmp_path / "again", changes=words[4::2], workers=1)
    with Store.read(tmp_path / "again") as store:
        (again,) = store.runs()
    assert again.address == stored.address
    assert again.result.metrics == stored.result.metrics


def test_whoever_asks_for_less_motion_gets_few_pictures(drilled):
    """Four a second at most, however fast the machine draws."""
    drilled.emulate(prefers_reduced_motion="reduce")
    drilled.run(
        "globalThis.times = []; new MutationObserver(() => times.push(performance.now()))"
        ".observe(document.querySelector('.player .time'), { childList: true }); times.push(performance.now())"
    )
    drilled.run("document.querySelector('.player .play').click()")
    drilled.wait("times.length > 3")
    drilled.run("document.querySelector('.player .play').click()")
    assert min(np.diff(drilled.run("times"))[1:]) > 200.0


@pytest.mark.parametrize("fragment", ["#%", "#%E0%A4%A", "#no-such-place"])
def test_a_link_that_leads_nowhere_stops_nothing(tab, campaign, fragment):
    """Mail programs cut links; a bare per cent sign is no text, and the theme and the tables must work all the same."""
    tab.emulate()
    tab.open(campaign, fragment)
    tab.run("document.querySelector('.theme').click()")
    assert tab.run("document.documentElement.dataset.theme") == "dark"
    quiet(tab)
