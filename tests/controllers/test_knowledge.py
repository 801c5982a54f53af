"""Payload knowledge: what the model in a controller's hands is told about the load."""

import numpy as np
import pytest
from torquebench.controllers import Actuation, NoKnowledge, Observation, Oracle, PayloadTruth, discovery


@pytest.fixture
def actuation():
    """Drives without limits."""
    return Actuation(
        tier="ideal",
        delay_ticks=0,
        torque_lag=0.0,
        velocity_filter_hz=None,
        effort=np.full(7, 100.0),
        torque_rate=None,
        rotor_inertia=np.zeros(7),
    )


@pytest.fixture
def reading():
    """A tick at which nothing is measured."""
    return Observation(
        time=0.0, q=np.zeros(7), dq=np.zeros(7), wrench=np.zeros(6), command=np.zeros(7), torque=np.zeros(7)
    )


def test_without_knowledge_the_model_is_arm_and_gripper(arm_of, actuation, reading, brick):
    """A model that was used before must not carry an old payload into the run."""
    arm = arm_of(7)
    arm.set_payload(brick.parameters)
    provider = NoKnowledge()
    provider.reset(arm, actuation, PayloadTruth(parameters=brick.parameters))
    provider.refresh(reading)
    assert not arm.payload.any()
    assert not arm.disturbance.any()


def test_the_oracle_knows_the_load_from_the_first_tick(arm_of, actuation, brick):
    """All ten parameters, not the mass alone."""
    arm = arm_of(7)
    Oracle().reset(arm, actuation, PayloadTruth(parameters=brick.parameters))
    assert np.array_equal(arm.payload, brick.parameters)


def test_the_oracle_follows_a_load_step(arm_of, actuation, reading, brick):
    """The harness writes the new load and its revision; the next tick's model has it."""
    arm, truth = arm_of(7), PayloadTruth(parameters=brick.parameters)
    provider = Oracle()
    provider.reset(arm, actuation, truth)
    truth.parameters[:] = brick.scaled(2.0).parameters
    truth.revision += 1
    provider.refresh(reading)
    assert np.array_equal(arm.payload, brick.scaled(2.0).parameters)


def test_the_oracle_leaves_the_model_alone_while_the_load_stays(arm_of, actuation, reading, brick):
    """A revision that grew every tick would make every planner start anew every tick."""
    arm, provider = arm_of(7), Oracle()
    provider.reset(arm, actuation, PayloadTruth(parameters=brick.parameters, revision=3))
    revision = arm.revision
    for _ in range(3):
        provider.refresh(reading)
    assert arm.revision == revision


def test_an_oracle_can_be_used_for_a_second_run(arm_of, actuation, reading, brick):
    """Its revision starts with the run's."""
    arm, provider = arm_of(7), Oracle()
    provider.reset(arm, actuation, PayloadTruth(parameters=brick.parameters, revision=3))
    provider.reset(arm, actuation, PayloadTruth(parameters=np.zeros(10)))
    provider.refresh(reading)
    assert not arm.payload.any()


def test_both_providers_are_registered():
    """The harness finds them by name like any plug-in."""
    assert discovery.load("knowledge", "none") is NoKnowledge
    assert discovery.load("knowledge", "oracle") is Oracle
