"""The digest: whatever can change a result is in it, and nothing else."""

import hashlib
from dataclasses import replace

import pytest
from torquebench.scenarios import digest as place
from torquebench.scenarios.digest import LIBRARIES, SHARED_ROOMS, STUDY_ROOMS, library_versions, room_digest, run_digest
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import RunSpecification

LAW = "class Law:\n    def reset(self, task): pass\n    def compute(self, o, t): pass\n"


@pytest.fixture
def law(tmp_path):
    """A law in a file of its own, and the door to it."""
    file = tmp_path / "law.py"
    file.write_text(LAW)
    return f"{file}:Law"


@pytest.fixture
def room(tmp_path, monkeypatch):
    """A room of two files in which tests may move things about."""
    folder = tmp_path / "room"
    (folder / "data").mkdir(parents=True)
    (folder / "law.py").write_text("one = 1\n")
    (folder / "data" / "arm.toml").write_text("mass = 1.0\n")

    class Found:
        submodule_search_locations = (str(folder),)

    monkeypatch.setattr(place.importlib.util, "find_spec", lambda name: Found)
    room_digest.cache_clear()
    yield folder
    room_digest.cache_clear()


def digest_of(room_name="anything"):
    """Return the digest of a room, read again."""
    room_digest.cache_clear()
    return room_digest(room_name)


def test_a_digest_is_the_hash_of_names_and_bytes_in_order(room):
    """Recomputed by hand: sorted paths, each followed by its content."""
    expected = hashlib.sha256()
    for name in ("data/arm.toml", "law.py"):
        expected.update(name.encode())
        expected.update((room / name).read_bytes())
    assert digest_of() == expected.hexdigest()


@pytest.mark.parametrize("name", ["law.py", "data/arm.toml"])
def test_one_byte_of_code_or_data_is_another_result(room, name):
    """A mass in a table changes a run as much as a line of code."""
    before = digest_of()
    (room / name).write_text((room / name).read_text().replace("1", "2"))
    assert digest_of() != before


def test_a_file_that_moves_is_another_result(room):
    """Imports go by name: the same bytes elsewhere are other code."""
    before = digest_of()
    (room / "law.py").rename(room / "laws.py")
    assert digest_of() != before


@pytest.mark.parametrize("name", ["__pycache__/law.pyc", "benchmarks/quick.toml", "data/__pycache__/x.pyc"])
def test_what_cannot_change_a_result_is_not_in_it(room, name):
    """Bytecode depends on who imported what; a benchmark only chooses runs, and a comment in it must redo none."""
    before = digest_of()
    (room / name).parent.mkdir(exist_ok=True)
    (room / name).write_bytes(b"anything")
    assert digest_of() == before


def test_a_room_is_read_once_a_process(room):
    """A campaign of thousands of runs hashes its source once; code cannot change under a running process."""
    before = digest_of()
    (room / "law.py").write_text("three = 3\n")
    assert room_digest("anything") == before


def test_a_room_that_is_not_there_is_the_hash_of_nothing(monkeypatch):
    """A wheel may leave a room out; the digest says so and does not fall over."""
    monkeypatch.setattr(place.importlib.util, "find_spec", lambda name: None)
    assert digest_of() == hashlib.sha256().hexdigest()
    room_digest.cache_clear()


def test_an_absent_library_is_a_word_among_versions():
    """Installing PyBullet later must give other addresses: its absence is part of what ran."""
    found = library_versions()
    assert tuple(found) == LIBRARIES
    assert all(found.values())


def test_equal_runs_have_equal_digests(run_of):
    """Repetition, laps and knowledge are in the specification; the digest is of code and data alone."""
    here = run_of(controller="computed_torque")
    assert run_digest(here) == run_digest(replace(here, repetition=3, laps=5, lead_in=2.0))


@pytest.mark.parametrize(
    "change",
    [
        {"controller": "cbmc_v3"},
        {"robot": "rizon4s", "tool": "flange", "controller": "LAW"},
        {"controller": "LAW"},
    ],
)
def test_another_room_or_file_is_another_digest(run_of, law, change):
    """Each law brings its own source: editing one must not redo the runs of the others."""
    chosen = {name: law if value == "LAW" else value for name, value in change.items()}
    assert run_digest(run_of(controller="computed_torque")) != run_digest(run_of(**chosen))


def test_laws_of_one_room_share_its_digest(run_of):
    """A room is the unit: what two laws of it may import from each other is not followed."""
    assert run_digest(run_of(controller="computed_torque")) == run_digest(run_of(controller="computed_torque_pid"))


def test_a_law_behind_a_door_is_followed_to_its_file(run_of, law):
    """Saving the file again with a change makes its runs new ones."""
    before = run_digest(run_of(controller=law))
    file = law.rpartition(":")[0]
    with open(file, "a", encoding="utf-8") as stream:
        stream.write("# a word\n")
    assert run_digest(run_of(controller=law)) != before


def test_a_file_that_a_setting_names_is_read(run_of, tmp_path):
    """Weights that were trained again under the same name are other weights."""
    weights = tmp_path / "weights.npz"
    weights.write_bytes(b"first")
    run = run_of(controller="computed_torque", settings={"patterns": str(weights)})
    before = run_digest(run)
    weights.write_bytes(b"second")
    assert run_digest(run) != before
    weights.unlink()
    assert run_digest(run) not in (before, "")


def test_a_text_that_names_no_file_is_no_part_of_it(run_of):
    """It stands in the specification already."""
    one, two = (run_of(controller="computed_torque", settings={"mode": word}) for word in ("soft", "stiff"))
    assert run_digest(one) == run_digest(two)


def test_a_material_of_ones_own_is_followed_to_its_file(run_of, tmp_path):
    """Denser gravel is another load under the same name; a material that does not hang there changes nothing."""
    file = tmp_path / "gravel.py"
    file.write_text("from torquebench.scenarios.materials import sand as gravel\n")
    heavy = LoadSchedule.constant(Payload(mass=3.5, material=f"{file}:gravel"))
    before, light = (run_digest(run_of(controller="computed_torque", **load)) for load in ({"schedule": heavy}, {}))
    file.write_text("from torquebench.scenarios.materials import sand\ngravel = sand\n")
    assert run_digest(run_of(controller="computed_torque", schedule=heavy)) != before
    assert run_digest(run_of(controller="computed_torque")) == light


def test_an_object_from_code_is_known_by_the_file_of_its_class(run_of):
    """Nobody registered it: the file that defines it is all there is to go by."""

    class Own:
        pass

    plug_ins = {"mine": Own}
    found = run_digest(run_of(), plug_ins)
    assert found == run_digest(run_of(), {"mine": Own()})
    assert found != run_digest(run_of(controller="computed_torque"))


def test_the_rooms_of_every_run_are_there():
    """A room that was renamed would silently drop out of every address."""
    nothing = hashlib.sha256().hexdigest()
    digests = [room_digest(room) for room in (*SHARED_ROOMS, *STUDY_ROOMS, "baselines", "cbmc")]
    assert nothing not in digests
    assert len(set(digests)) == len(digests)


def test_the_code_of_a_knowledge_provider_enters_the_address_of_the_runs_that_it_informs(monkeypatch):
    """A better estimator gives other results, for a law of any room."""
    before = [run_digest(run_at(level)) for level in ("none", "ft_estimate")]
    real = place.room_digest
    monkeypatch.setattr(place, "room_digest", lambda room: "changed" if room == "baselines" else real(room))
    after = [run_digest(run_at(level)) for level in ("none", "ft_estimate")]
    assert before[0] == after[0]
    assert before[1] != after[1]


def test_the_code_that_judges_a_study_enters_its_address_and_no_other(monkeypatch):
    """Another rule of failure is another margin; a run knows nothing of it."""
    run = run_at("none")
    studies = [run, replace(run, study="load_margin")]
    before = [run_digest(item) for item in studies]
    real = place.room_digest
    monkeypatch.setattr(place, "room_digest", lambda room: "changed" if room == "judging" else real(room))
    assert [run_digest(item) == old for item, old in zip(studies, before, strict=True)] == [True, False]


def run_at(level):
    """Return a run of a law outside the baselines at a knowledge level."""
    return RunSpecification(
        controller="cbmc_v3",
        knowledge=level,
        trajectory="T1",
        schedule=LoadSchedule.constant(Payload(mass=1.5)),
        robot="rizon4s",
        plant="pinocchio",
        tier="ideal",
    )
