"""Four doors lead to a plug-in; behind a broken one stands a sentence."""

import json
import subprocess
import sys
from importlib.metadata import EntryPoint

import pytest
from torquebench.controllers import InvalidInput, PlugInFailure, UnknownName, discovery

PLUG_IN = """
class Floppy:
    def reset(self, task): self.n = task.robot.n
    def compute(self, observation, target): return 0.0 * observation.q
class Outer:
    class Inner: pass
_private = 1
"""


@pytest.fixture
def plug_in(tmp_path):
    """A file with a controller, as an author would write it."""
    file = tmp_path / "floppy.py"
    file.write_text(PLUG_IN)
    return file


@pytest.fixture
def registry(monkeypatch):
    """Registers entry points for one test."""

    def register(*points):
        group = "torquebench.controllers"
        table = [EntryPoint(name=name, value=value, group=group) for name, value in points]
        monkeypatch.setattr(discovery, "entry_points", lambda group: [p for p in table if p.group == group])
        discovery.registered.cache_clear()

    yield register
    monkeypatch.undo()
    discovery.registered.cache_clear()


def test_the_first_door_is_a_registered_name(registry):
    """Built-ins come through it too."""
    registry(("sink", "collections:OrderedDict"))
    assert discovery.load("controllers", "sink").__name__ == "OrderedDict"


def test_the_second_door_is_a_module_and_a_name():
    """Whatever can be imported, nested names included."""
    assert discovery.load("controllers", "json.decoder:JSONDecoder") is json.JSONDecoder
    assert discovery.load("controllers", "json:JSONDecoder.decode") is json.JSONDecoder.decode


def test_the_third_door_is_a_file_and_a_name(plug_in):
    """No package, no installation; imported once, so that its classes are one and the same."""
    floppy = discovery.load("controllers", f"{plug_in}:Floppy")
    assert floppy.__name__ == "Floppy"
    assert discovery.load("controllers", f"{plug_in}:Floppy") is floppy
    assert discovery.load("controllers", f"{plug_in}:Outer.Inner").__name__ == "Inner"


def test_a_relative_file_is_found_from_the_working_folder(plug_in, monkeypatch):
    """``./file.py:Name`` is what the help text says."""
    monkeypatch.chdir(plug_in.parent)
    assert discovery.load("controllers", "./floppy.py:Floppy").__name__ == "Floppy"


def test_two_files_of_one_name_do_not_shadow_each_other(plug_in, tmp_path):
    """Every author calls her file controller.py."""
    other = tmp_path / "elsewhere" / "floppy.py"
    other.parent.mkdir()
    other.write_text("class Floppy: other = True\n")
    assert not hasattr(discovery.load("controllers", f"{plug_in}:Floppy"), "other")
    assert discovery.load("controllers", f"{other}:Floppy").other


def test_the_fourth_door_is_the_object_itself():
    """From code, nothing is looked up."""
    thing = object()
    assert discovery.load("controllers", thing) is thing


@pytest.mark.parametrize("kind", discovery.KINDS)
def test_an_unknown_name_lists_what_is_known(kind):
    """Of the right kind, by its word in the singular."""
    with pytest.raises(UnknownName, match=f"unknown {discovery.SINGULAR[kind]} 'qqqq'") as caught:
        discovery.load(kind, "qqqq")
    assert caught.value.known == discovery.names(kind)


def test_an_unknown_name_names_the_nearest():
    """A typing error is the usual reason."""
    with pytest.raises(UnknownName, match="unknown trajectory 't1'"):
        discovery.load("trajectories", "t1")
    with pytest.raises(UnknownName, match="did you mean 'pinocchio'"):
        discovery.load("plants", "pinochio")


def test_an_unknown_kind_is_refused():
    """A slip of a developer, with the same sentence."""
    with pytest.raises(UnknownName, match="did you mean 'controllers'"):
        discovery.names("controler")


def test_a_missing_file_is_named(tmp_path):
    """Before any import machinery speaks."""
    with pytest.raises(InvalidInput, match=r"no such file .*nothing.py"):
        discovery.load("controllers", f"{tmp_path}/nothing.py:Law")


def test_a_missing_name_in_a_file_lists_its_public_names(plug_in):
    """Private names are no suggestion."""
    with pytest.raises(UnknownName, match="did you mean 'Floppy'") as caught:
        discovery.load("controllers", f"{plug_in}:Flopy")
    assert "_private" not in caught.value.known


def test_a_missing_module_is_a_failed_plug_in():
    """The door, where it leads, and why not further."""
    with pytest.raises(PlugInFailure, match=r"nowhere_at_all:Law.*could not be loaded: ModuleNotFoundError"):
        discovery.load("controllers", "nowhere_at_all:Law")


@pytest.mark.parametrize(
    ("source", "cause"),
    [
        ("def broken(:\n", "SyntaxError"),
        ("import not_installed_here\n", "ModuleNotFoundError"),
        ("raise ValueError('first line\\nsecond line')\n", "ValueError: first line second line"),
        ("import sys\nsys.exit('no arguments given')\n", "SystemExit: no arguments given"),
    ],
    ids=["syntax", "import", "exception", "exit"],
)
def test_a_file_that_cannot_be_imported_is_one_line_with_its_cause(tmp_path, source, cause):
    """Also a script that ends the interpreter when it is imported."""
    file = tmp_path / "broken.py"
    file.write_text(source)
    for _ in range(2):
        with pytest.raises(PlugInFailure, match=cause) as caught:
            discovery.load("controllers", f"{file}:Law")
        assert "\n" not in str(caught.value)


def test_a_broken_entry_point_says_where_it_was_registered(registry):
    """The user did not write it and has to know whom to tell."""
    registry(("sink", "nowhere_at_all.laws:Sink"))
    with pytest.raises(PlugInFailure, match=r"controller 'sink' \(.*nowhere_at_all.laws:Sink\)"):
        discovery.load("controllers", "sink")


def test_one_name_for_two_objects_is_refused(registry):
    """Which of them runs would depend on the order of installation."""
    registry(("sink", "json:dumps"), ("sink", "json:loads"))
    with pytest.raises(InvalidInput, match=r"two distributions register the controller 'sink'.*json:dumps.*json:loads"):
        discovery.names("controllers")


def test_the_same_registration_twice_is_no_conflict(registry):
    """An editable install beside a wheel lists every entry point twice."""
    registry(("sink", "json:dumps"), ("sink", "json:dumps"))
    assert discovery.names("controllers") == ("sink",)


def test_built_ins_have_no_digest_of_their_own():
    """They are covered by the package's version."""
    assert discovery.source_digest("plants", "pinocchio") == ""


def test_a_file_that_changes_changes_its_digest(plug_in):
    """Results are addressed by the code that made them."""
    door = f"{plug_in}:Floppy"
    before = discovery.source_digest("controllers", door)
    assert len(before) == 64
    assert discovery.source_digest("controllers", discovery.load("controllers", door)) == before
    plug_in.write_text(PLUG_IN + "# tuned\n")
    assert discovery.source_digest("controllers", door) != before


def test_what_cannot_be_found_has_no_digest():
    """Loading it says why; asking for the digest must not fail before that."""
    assert discovery.source_digest("controllers", "nowhere_at_all.laws:Law") == ""
    assert discovery.source_digest("controllers", "./nothing.py:Law") == ""


def test_listing_names_imports_nothing_heavy():
    """``torquebench --help`` and ``list`` answer at once: no plug-in, no engine, no compiler is loaded."""
    program = (
        "import sys; from torquebench.controllers.discovery import KINDS, names; found = {k: names(k) for k in KINDS};"
        "import json; print(json.dumps([found['plants'], sorted(sys.modules)]))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    plants, modules = json.loads(done.stdout)
    assert "pinocchio" in plants
    for heavy in ("pybullet", "casadi", "scipy.optimize", "torch", "torquebench.baselines", "torquebench.scenarios"):
        assert heavy not in modules


def test_the_meaning_of_a_name_is_read_without_running_its_module():
    """`torquebench list controllers` shows a line each and loads none of them."""
    points = discovery.registered("controllers")
    assert discovery.meaning(points["computed_torque"]) == "Feedback linearisation, as delivered."
    assert discovery.meaning(points["cbmc_v3"]) == "Five spiking modules on three levels that learn online."
    assert all(discovery.meaning(point) for point in points.values())
