"""What the README and the pages say can be followed: links, anchors, commands, files."""

import re
import shlex
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
LINK = re.compile(r"(?<!\!)\[[^\]]*\]\(([^)\s]+)\)")
PICTURE = re.compile(r"!\[[^\]]*\]\(([^)\s]+)\)|<img[^>]+src=\"([^\"]+)\"")
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def prose(page: Path) -> str:
    """Return a page without its code blocks."""
    return FENCE.sub("", page.read_text(encoding="utf-8"))


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings as the usual viewers make them."""
    headings = re.findall(r"^#+\s+(.*?)\s*#*$", prose(page), re.MULTILINE)
    kept = (re.sub(r"[^\w\- ]", "", re.sub(r"[`*]", "", heading).lower()) for heading in headings)
    return {heading.replace(" ", "-") for heading in kept}


def broken_links(page: Path) -> list[str]:
    broken = []
    for link in LINK.findall(prose(page)):
        if re.match(r"[a-z]+:", link):
            continue
        target, _, anchor = link.partition("#")
        file = (page.parent / target).resolve() if target else page
        if not file.exists() or (anchor and file.suffix == ".md" and anchor not in anchors(file)):
            broken.append(link)
    return broken


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    assert broken_links(page) == []


def test_links_that_lead_nowhere_are_found(tmp_path):
    """The check of the check."""
    (tmp_path / "other.md").write_text("# A heading, with `code`\n", encoding="utf-8")
    page = tmp_path / "page.md"
    page.write_text("[a](other.md) [b](other.md#a-heading-with-code) [c](none.md) [d](other.md#x) [e](https://x.y)\n")
    assert broken_links(page) == ["none.md", "other.md#x"]


def test_pictures_are_files_of_the_project():
    """A page must open without the network."""
    for page in PAGES:
        for pair in PICTURE.findall(prose(page)):
            picture = pair[0] or pair[1]
            assert not re.match(r"[a-z]+:", picture), picture
            assert picture.startswith(("docs/images/", "images/")), picture


def quoted_commands(page: Path) -> list[list[str]]:
    """Return the shell commands that a page shows, as words."""
    blocks = [body for language, body in FENCE.findall(page.read_text(encoding="utf-8")) if language in ("sh", "bash")]
    joined = "\n".join(blocks).replace("\\\n", " ")
    return [words for line in joined.splitlines() if (words := shlex.split(line, comments=True))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_make_targets_that_are_quoted_exist(page):
    targets = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    for words in quoted_commands(page):
        if words[0] == "make" and len(words) > 1:
            assert words[1] in targets, " ".join(words)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_and_flags_that_are_quoted_exist(page):
    """A flag that was renamed must be renamed here, too."""
    cli = pytest.importorskip("torquebench.cli")
    import click

    group = getattr(cli, "main", None)
    if not isinstance(group, click.Group):
        group = next(value for value in vars(cli).values() if isinstance(value, click.Group))
    context = click.Context(group)
    for words in quoted_commands(page):
        if Path(words[0]).name != "torquebench" or len(words) < 2 or words[1].startswith("-"):
            continue
        found = group.get_command(context, words[1])
        assert found is not None, f"{page.name}: torquebench {words[1]}"
        flags = {flag for parameter in found.params for flag in (*parameter.opts, *parameter.secondary_opts)} | {
            "--help"
        }
        for word in words[2:]:
            flag = word.partition("=")[0]
            assert not flag.startswith("--") or flag in flags, f"{page.name}: {' '.join(words)}: {flag}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_python_that_is_quoted_compiles(page):
    for language, body in FENCE.findall(page.read_text(encoding="utf-8")):
        if language == "python":
            compile(body, page.name, "exec")


def own_controller(page: Path) -> str:
    """Return the controller of one's own that a page shows."""
    return next(body for language, body in FENCE.findall(page.read_text(encoding="utf-8")) if language == "python")


def test_the_controller_of_the_readme_is_that_of_the_docs():
    """Who reads on must not find another law."""
    assert own_controller(ROOT / "README.md") == own_controller(ROOT / "docs" / "writing-a-controller.md")
    assert own_controller(ROOT / "README.md").count("\n") <= 20


def test_the_controller_of_the_readme_holds_an_arm_at_rest(tmp_path):
    """On its plan and at rest the law of the README is the gravity torque, and its file is a door."""
    from torquebench.controllers import build_controller, discovery
    from torquebench.scenarios.robots import load_robot

    file = tmp_path / "mine.py"
    file.write_text(own_controller(ROOT / "README.md"), encoding="utf-8")
    mine = build_controller(discovery.load("controllers", f"{file}:Mine"), {"stiffness": 100.0}, name="Mine")
    robot = load_robot("rizon4s")
    rest = SimpleNamespace(q=robot.home, dq=np.zeros(robot.n), ddq=np.zeros(robot.n))
    mine.reset(SimpleNamespace(robot=robot.model()))
    assert mine.compute(rest, rest) == pytest.approx(robot.model().gravity(robot.home), abs=1e-12)
