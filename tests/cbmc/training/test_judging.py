"""How patterns are judged, and recipes: closed forms of errors, point loads, lessons that cannot be."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from torquebench.cbmc.cerebellum import Cerebellum
from torquebench.cbmc.pathways import Ascending, Descending
from torquebench.cbmc.patterns import Patterns, find_patterns
from torquebench.cbmc.point_payload import point_payload
from torquebench.cbmc.training import PRESETS, Lesson, answers, gravity_heldout, gravity_torques
from torquebench.cbmc.training.pipeline import EVERY, evaluation_groups
from torquebench.controllers import InvalidInput, UnknownName
from torquebench.scenarios.loads import Body


@pytest.fixture(scope="module")
def shipped(rizon):
    """The patterns of the Rizon."""
    return find_patterns(rizon.model())


@pytest.fixture
def postures(rizon, rng):
    """Twenty postures around home."""
    return rizon.home + rng.uniform(-0.3, 0.3, size=(20, rizon.n))


def constant_patterns(rows, loads):
    """Patterns whose neurons never fire: they answer with their offsets, whatever the posture."""
    count, joints = np.shape(rows)
    zeros = {"granule": (count, 30, joints), "granule_bias": (count, 30), "purkinje": (count, 30, 40)}
    zeros |= {"purkinje_bias": (count, 20), "readout": (count, joints, 20)}
    arrays = {name: np.zeros(shape, dtype=np.float32) for name, shape in zeros.items()}
    return Patterns(**arrays, readout_bias=np.array(rows, dtype=np.float32), loads=loads)


def test_an_answer_is_what_the_cerebellum_says_at_the_posture(shipped, postures):
    """One by one through the module that runs in the loop."""
    up, down = Ascending.of(7), Descending.of(7, shipped.count)
    cerebellum = Cerebellum(shipped)
    cerebellum.connect(up, down)
    said = answers(shipped, postures)
    assert said.shape == (20, 2, 7)
    for row, q in zip(said, postures, strict=True):
        up.q[:] = q
        cerebellum.compensate()
        assert np.array_equal(row, down.compensation)


def test_the_order_of_postures_does_not_matter(shipped, postures):
    """A window begins at rest: nothing of one posture is left in the next."""
    assert np.array_equal(answers(shipped, postures[::-1])[::-1], answers(shipped, postures))


def test_errors_of_patterns_that_never_change_are_those_of_gravity_itself(planar_robot, rng):
    """A network that is silent answers its offset: root mean squares by hand, the worst joint counted from one."""
    model, q = planar_robot.model(), rng.uniform(-1.0, 1.0, (50, 2))
    payloads = np.array([point_payload(load, 0.1) for load in (0.0, 2.0)])
    patterns = constant_patterns([[1.0, -2.0], [30.0, 0.5]], (0.0, 2.0))
    found = gravity_heldout(patterns, model, payloads, {"around": q, "first": q[:1]})
    assert [(row.group, row.load) for row in found] == [(g, load) for g in ("around", "first") for load in (0.0, 2.0)]
    for row in found:
        at, index = (q if row.group == "around" else q[:1]), int(row.load > 0.0)
        miss = np.array([[1.0, -2.0], [30.0, 0.5]])[index] - gravity_torques(model, at, payloads[index])
        by_joint = np.sqrt((miss**2).mean(axis=0))
        assert row.rmse == pytest.approx(np.sqrt((by_joint**2).mean()), rel=1e-6)
        assert (row.worst_joint, row.worst_rmse) == (by_joint.argmax() + 1, pytest.approx(by_joint.max(), rel=1e-6))


def test_judging_leaves_the_arm_as_it_was(planar_robot, rng):
    """The model belongs to whoever lent it; a payload left in it would teach the next pattern twice."""
    model = planar_robot.model()
    revision = model.revision
    gravity_torques(model, rng.uniform(-1.0, 1.0, (3, 2)), point_payload(2.0, 0.1))
    assert np.all(model.payload == 0.0) and model.revision == revision


@pytest.mark.parametrize(("mass", "centre"), [(0.0, 0.3), (3.0, 0.2646), (1.5, 0.0)])
def test_a_point_load_is_the_body_of_its_ten_parameters(mass, centre):
    """Mass, first moments and the inertia about the flange, recomputed by Steiner from a ball of no size."""
    found = point_payload(mass, centre)
    body = Body(mass=mass, com=np.array([0.0, 0.0, centre]), inertia=np.zeros((3, 3)))
    assert found == pytest.approx(body.parameters, abs=1e-15)


def test_gravity_under_a_load_is_linear_in_its_mass(rizon, postures):
    """What lets two patterns stand for every load between them."""
    torques = [gravity_torques(rizon.model(), postures, point_payload(mass, 0.26)) for mass in (0.0, 1.0, 3.0)]
    assert torques[1] == pytest.approx(torques[0] + (torques[2] - torques[0]) / 3.0, abs=1e-9)


def test_paths_are_judged_at_every_tenth_sample_beside_the_held_out_postures():
    """10 ms of a path; the workspace in full, last and under its own name."""
    paths = {"T1": np.arange(70.0).reshape(35, 2), "T2": np.arange(20.0).reshape(10, 2)}
    held_out = np.zeros((5, 2))
    groups = evaluation_groups(paths, held_out)
    assert list(groups) == ["T1", "T2", "workspace"]
    assert EVERY == 10 and groups["T1"][:, 0].tolist() == [0.0, 20.0, 40.0, 60.0]
    assert len(groups["T2"]) == 1 and groups["workspace"] is held_out


def test_recipes_are_frozen_and_the_paper_s_is_the_paper_s():
    """Table I and Algorithm 2: plain descent with momentum, fifty passes, noise on the labels, nothing of ours."""
    paper = PRESETS["paper"]
    assert (paper.optimiser, paper.epochs, paper.batch, paper.rate, paper.momentum) == ("sgd", 50, 10, 0.01, 0.5)
    assert (paper.slope, paper.gain, paper.label_noise, paper.scaled, paper.refit) == (5.0, 1.0, 1.0, False, False)
    with pytest.raises(FrozenInstanceError):
        paper.rate = 0.1


def test_better_presets_take_more_of_the_same():
    """One recipe at three prices: a user who pays more gets no other network."""
    smoke, default, best = (PRESETS[name] for name in ("smoke", "default", "best"))
    assert smoke.steps < default.steps < best.steps
    assert smoke.samples < default.samples < best.samples
    for preset in (smoke, best):
        assert replace(preset, steps=default.steps, samples=default.samples) == default


@pytest.mark.parametrize(
    ("changes", "error", "says"),
    [
        ({"loads": (0.0, float("nan"))}, InvalidInput, "loads '0,nan'"),
        ({"loads": (0.0, float("inf"))}, InvalidInput, "loads '0,inf'"),
        ({"loads": (1.0, 1.0)}, InvalidInput, "give increasing masses"),
        ({"training_set": "workspaces"}, UnknownName, "did you mean 'workspace'"),
        ({"preset": "smok"}, UnknownName, "did you mean 'smoke'"),
    ],
)
def test_a_lesson_that_cannot_be_learnt_is_refused_before_it_begins(changes, error, says):
    """Hours of training must not end in a file that nothing can read."""
    with pytest.raises(error) as refused:
        Lesson(**{"robot": "swing", "load_centre": 0.1} | changes)
    assert says in str(refused.value)


def test_a_lesson_has_a_payload_for_each_load():
    """The masses on the axis of the flange, at the one centre."""
    lesson = Lesson(robot="swing", loads=(0.0, 1.5, 3.0), load_centre=0.2)
    assert lesson.payloads.shape == (3, 10)
    assert lesson.payloads[:, 0].tolist() == [0.0, 1.5, 3.0]
    assert lesson.payloads[:, 3] == pytest.approx([0.0, 0.3, 0.6])
    assert lesson.recipe is PRESETS["default"]
