"""Shipped patterns against Pinocchio, and patterns as files: written, read, found, refused."""

import json
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pinocchio as pin
import pytest
from torquebench.cbmc import patterns as module
from torquebench.cbmc.cerebellum import PAPER
from torquebench.cbmc.patterns import Patterns, find_patterns, load_patterns, robot_key, save_patterns
from torquebench.cbmc.point_payload import point_payload
from torquebench.cbmc.reference import compensate
from torquebench.cbmc.training import answers, gravity_heldout
from torquebench.controllers import InvalidInput
from torquebench.scenarios.robots import load_robot
from torquebench.training import joint_paths

TARGETS = {0.0: 0.30, 3.0: 0.40}
"""Largest error allowed on any path, by load beyond the gripper [N m]."""


@pytest.fixture(scope="module")
def shipped(rizon):
    return find_patterns(rizon.model())


@pytest.fixture(scope="module")
def paths(rizon):
    return {name: path[::10] for name, path in joint_paths(rizon).items()}


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch):
    """Nobody's own patterns take part in a test."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


@pytest.fixture
def small():
    """Patterns of an arm of two joints and two loads, with weights but without sense."""
    rng = np.random.default_rng(5)

    def draw(*shape):
        return rng.normal(size=shape).astype(np.float32)

    return Patterns(
        granule=draw(2, 30, 2),
        granule_bias=draw(2, 30),
        purkinje=draw(2, 30, 40),
        purkinje_bias=draw(2, 20),
        readout=draw(2, 2, 20),
        readout_bias=draw(2, 2),
        loads=(0.0, 3.0),
    )


def gravity_by_pinocchio(urdf, q, mass, centre):
    """Arm and gripper from the URDF, the load appended to the last joint: no line of ours."""
    model = pin.buildModelFromXML(urdf)
    flange = model.frames[model.getFrameId("flange")]
    point = pin.Inertia(mass, np.array([0.0, 0.0, centre]), np.zeros((3, 3)))
    model.appendBodyToJoint(flange.parentJoint, point, flange.placement)
    data = model.createData()
    return np.array([pin.computeGeneralizedGravity(model, data, row).copy() for row in q])


def test_shipped_patterns_know_gravity_on_every_path(rizon, shipped, paths):
    """Eleven motions that their training never saw; root mean square over samples and joints."""
    assert shipped.loads == (0.0, 3.0)
    assert shipped.notes["training_set"]["name"] == "workspace"
    assert len(paths) == 11
    for name, q in paths.items():
        said = answers(shipped, q)
        for index, load in enumerate(shipped.loads):
            error = said[:, index] - gravity_by_pinocchio(rizon.urdf, q, load, shipped.notes["load_centre"])
            assert np.sqrt(np.mean(error**2)) < TARGETS[load], (name, load)


def test_the_table_beside_the_shipped_patterns_is_true(rizon, shipped, paths):
    """What the notes claim is what the file does."""
    payloads = np.array([point_payload(load, shipped.notes["load_centre"]) for load in shipped.loads])
    rows = gravity_heldout(shipped, rizon.model(), payloads, paths)
    claimed = {(row["group"], row["load"]): row for row in shipped.notes["evaluation"]["rows"]}
    for row in rows:
        note = claimed[row.group, row.load]
        assert (note["rmse"], note["worst_rmse"]) == pytest.approx((row.rmse, row.worst_rmse), abs=2e-3)
        assert note["worst_joint"] == row.worst_joint


def test_single_precision_says_what_double_precision_says(shipped, paths):
    """A spike on the edge may fall either way; on these postures none does."""
    q = paths["T7"][::7]
    exact = np.array([compensate(shipped, PAPER, row).torque for row in q])
    np.testing.assert_allclose(answers(shipped, q), exact, atol=1e-4)


def test_a_mixture_is_the_gravity_of_the_mass_between(rizon, shipped, paths):
    """Gravity is affine in the mass: one weight names one load."""
    centre, q = shipped.notes["load_centre"], paths["T2"]
    light, heavy, half = (gravity_by_pinocchio(rizon.urdf, q, mass, centre) for mass in (0.0, 3.0, 1.2))
    np.testing.assert_allclose(0.6 * light + 0.4 * heavy, half, atol=1e-10)


def test_shipped_files_are_small():
    """A package, not a data set."""
    folder = files(module.__package__) / "data" / "patterns"
    assert sum(len(file.read_bytes()) for file in folder.iterdir()) < 3e6


def test_a_file_gives_back_what_was_saved_and_the_same_bytes_twice(tmp_path, small):
    """Round trip; no date, no address, no order of a dictionary in the files."""
    first, second = tmp_path / "a.safetensors", tmp_path / "deeper" / "a.safetensors"
    save_patterns(first, replace(small, notes={"seed": 3}))
    save_patterns(second, replace(small, notes={"seed": 3}))
    read = load_patterns(first)
    assert read.loads == small.loads and read.notes["seed"] == 3
    for name in module.ARRAYS:
        np.testing.assert_array_equal(getattr(read, name), getattr(small, name))
        assert not getattr(read, name).flags.writeable
    for suffix in (".safetensors", ".json"):
        assert first.with_suffix(suffix).read_bytes() == second.with_suffix(suffix).read_bytes()
    save_patterns(tmp_path / "b.safetensors", read)
    assert (tmp_path / "b.json").read_bytes() == first.with_suffix(".json").read_bytes()


def damaged(file, how):
    notes = file.with_suffix(".json")
    if how == "cut":
        file.write_bytes(file.read_bytes()[:1000])
    elif how == "changed":
        content = bytearray(file.read_bytes())
        content[-5] ^= 1
        file.write_bytes(content)
    elif how == "no arrays":
        file.unlink()
    elif how == "no notes":
        notes.unlink()
    elif how == "no json":
        notes.write_text("{")
    elif how == "other schema":
        notes.write_text(json.dumps(json.loads(notes.read_text()) | {"schema": 99}))
    else:
        notes.write_text(json.dumps(json.loads(notes.read_text()) | {"loads": [0.0]}))


@pytest.mark.parametrize(
    "how", ["cut", "changed", "no arrays", "no notes", "no json", "other schema", "one load too few"]
)
def test_a_damaged_file_is_refused_by_name(tmp_path, small, how):
    """A flipped bit in a weight is no reason to find out in a run."""
    file = tmp_path / "mine.safetensors"
    save_patterns(file, small)
    damaged(file, how)
    with pytest.raises(InvalidInput, match="mine") as caught:
        load_patterns(file)
    assert "\n" not in str(caught.value)


def test_an_arm_without_patterns_gets_one_line_that_names_the_command(planar_robot):
    """The way out, not only the wall."""
    with pytest.raises(InvalidInput, match="torquebench train cerebellum --robot FILE") as caught:
        find_patterns(planar_robot.model())
    assert "\n" not in str(caught.value)


def test_patterns_are_found_by_file_by_folder_and_in_the_users_own(tmp_path, small, planar_robot):
    """In a folder by the arm, whatever the file's name."""
    model = planar_robot.model()
    mine = replace(small, notes={"robot": {"name": "planar", "key": robot_key(model)}})
    save_patterns(tmp_path / "some.safetensors", mine)
    for source in ("some.safetensors", "some.json", ""):
        assert find_patterns(model, str(tmp_path / source)).joints == 2
    with pytest.raises(InvalidInput):
        find_patterns(model)
    save_patterns(module.user_folder() / "other.safetensors", mine)
    assert find_patterns(model).joints == 2


def test_patterns_of_another_arm_are_refused(tmp_path, small, planar_robot, rizon):
    """They would be worse than none."""
    file = tmp_path / "planar.safetensors"
    save_patterns(file, replace(small, notes={"robot": {"name": "planar", "key": robot_key(planar_robot.model())}}))
    with pytest.raises(InvalidInput, match=r"another arm \(planar\)"):
        find_patterns(rizon.model(), str(file))


def test_an_arm_is_known_by_its_gravity_alone(rizon, brick):
    """Tool point, rotor inertia, and what knowledge set change nothing; a gripper does."""
    key = robot_key(rizon.model())
    assert robot_key(load_robot("rizon4s", tool="flange").model()) == key
    assert robot_key(rizon.model(rotor_inertia=rizon.rotor_inertia)) == key
    known = rizon.model()
    known.set_payload(brick.parameters)
    assert robot_key(known) == key
    known.set_disturbance(np.ones(7))
    assert robot_key(known) == key
    assert np.all(known.disturbance == 1.0)
    assert robot_key(replace(rizon, gripper=None).model()) != key
