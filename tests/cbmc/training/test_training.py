"""Training as a whole: what it learns, that it is the same again, and what it says when it cannot."""

import importlib.util
from dataclasses import replace

import numpy as np
import pytest
from torquebench.cbmc.training import PRESETS, Lesson, train_cerebellum
from torquebench.cbmc.training.watch import unwatched
from torquebench.controllers import InvalidInput, UnknownName
from torquebench.training import lesson_for, workspace_of

ARRAYS = ("granule", "granule_bias", "purkinje", "purkinje_bias", "readout", "readout_bias")


@pytest.fixture
def torch():
    """Skips where torch is not installed: running needs none."""
    return pytest.importorskip("torch")


@pytest.fixture(scope="module")
def arm(rizon):
    return workspace_of(rizon)


@pytest.fixture
def short(monkeypatch):
    """Makes the preset ``smoke`` shorter still: two joints are soon learnt."""
    monkeypatch.setitem(PRESETS, "smoke", replace(PRESETS["smoke"], steps=80, samples=4000))


def smoke(robot, **changes):
    return lesson_for(robot, **{"loads": (0.0,), "training_set": "", "preset": "smoke", "seed": 1} | changes)


def rmse_by_group(patterns):
    return {row["group"]: row["rmse"] for row in patterns.notes["evaluation"]["rows"]}


def test_a_smoke_run_knows_gravity_to_about_a_newton_metre(torch, rizon, arm):
    """On the paths, which it never saw, where the torques themselves reach 70 N m."""
    errors = rmse_by_group(train_cerebellum(arm, smoke(rizon), unwatched))
    assert len(errors) == 12
    assert max(errors.values()) < 1.2


def test_one_seed_gives_one_result_and_another_seed_another(torch, short, planar_robot):
    """To the bit, on one machine; whatever number of threads torch would use."""
    arm = workspace_of(planar_robot)
    threads = torch.get_num_threads()
    first, second, other = (train_cerebellum(arm, smoke(planar_robot, seed=seed), unwatched) for seed in (1, 1, 2))
    assert torch.get_num_threads() == threads
    for name in ARRAYS:
        assert getattr(first, name).tobytes() == getattr(second, name).tobytes()
    assert first.notes == second.notes
    assert first.purkinje.tobytes() != other.purkinje.tobytes()


def test_any_list_of_loads_gives_a_pattern_each(torch, short, planar_robot):
    """Two are the paper's; nothing in the record says two."""
    lesson = smoke(planar_robot, loads=(0.0, 1.5, 3.0))
    shares = []
    patterns = train_cerebellum(workspace_of(planar_robot), lesson, shares.append)
    assert patterns.loads == (0.0, 1.5, 3.0)
    assert patterns.granule.shape == (3, 300, 2) and patterns.purkinje.shape == (3, 300, 400)
    assert all(getattr(patterns, name).dtype == np.float32 for name in ARRAYS)
    assert shares == sorted(shares) and shares[-1] == 1.0
    assert max(row["rmse"] for row in patterns.notes["evaluation"]["rows"]) < 1.2


def test_the_papers_own_descent_learns_its_circles(torch, rizon, arm, monkeypatch):
    """Two of its fifty epochs show that the error falls: no torque at all is 25 N m away."""
    monkeypatch.setitem(PRESETS, "paper", replace(PRESETS["paper"], epochs=2))
    patterns = train_cerebellum(arm, smoke(rizon, preset="paper"), unwatched)
    assert patterns.notes["training_set"] == {"name": "paper", "postures": [3000, 3000]}
    errors = rmse_by_group(patterns)
    assert max(errors["S1"], errors["S2"]) < 8.0


def test_a_folded_group_moves_as_the_mean_of_its_neurons_would(torch):
    """Plain gradient descent depends on how the readout is written down; the paper's has 20 neurons a joint."""
    from torquebench.cbmc.training.network import GROUP, PURKINJE, Weights, fold_dcn
    from torquebench.cbmc.training.trainer import _folded_rates

    z = torch.rand((5, PURKINJE), dtype=torch.float64)
    dcn = torch.randn((2 * GROUP, PURKINJE), dtype=torch.float64, requires_grad=True)
    bias = torch.randn(2 * GROUP, dtype=torch.float64, requires_grad=True)
    before = [part.detach().clone() for part in fold_dcn(dcn, bias)]
    readout, offset = fold_dcn(dcn, bias)
    slope = 2.0 * (z @ readout.T + offset)
    (slope.detach() * (z @ readout.T + offset)).sum().backward()
    with torch.no_grad():
        after = fold_dcn(dcn - 0.01 * dcn.grad, bias - 0.01 * bias.grad)
    rates = _folded_rates(Weights.zeros(2), 0.01)
    gradients = torch.cat(((slope.T @ z).flatten(), slope.sum(dim=0))).detach()
    moved = torch.cat([(new - old).flatten() for old, new in zip(before, after, strict=True)])
    np.testing.assert_allclose(moved, -rates[-len(gradients) :].double() * gradients, rtol=1e-5)


def test_without_torch_the_message_says_what_to_install(planar_robot, monkeypatch):
    """A user who only compares has none, and may still type the command."""
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InvalidInput, match=r"pip install 'torquebench\[train\]'"):
        train_cerebellum(workspace_of(planar_robot), smoke(planar_robot), unwatched)


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"loads": ()}, InvalidInput),
        ({"loads": (3.0, 0.0)}, InvalidInput),
        ({"loads": (-1.0,)}, InvalidInput),
        ({"loads": (0.0, float("nan"))}, InvalidInput),
        ({"seed": -1}, InvalidInput),
        ({"preset": "bset"}, UnknownName),
        ({"training_set": "tubes"}, UnknownName),
    ],
)
def test_a_lesson_that_cannot_be_given_is_refused_at_once(changes, error):
    """Before minutes of training, not after them."""
    with pytest.raises(error):
        Lesson(robot="any", load_centre=0.2, **changes)
