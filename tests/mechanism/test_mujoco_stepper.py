"""MuJoCo's stepper: a state that is put begins as in a new model, and steps are those of MuJoCo."""

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.adapters.mujoco.stepper import MujocoStepper
from plumbob.engines.registry import method
from plumbob.engines.stepper import State
from plumbob.models.registry import built_in_systems, case_of, scene

EULER = method("mujoco/euler")
STEPS = 20


def simulation_of(name):
    return compiled(case_of(scene(name)), EULER, 1e-3)


def controls_of(simulation):
    """The controls of the first steps; None where nothing is controlled."""
    if simulation.translation.control is None:
        return None
    return simulation.held_controls(np.arange(float(STEPS)), simulation.step)


@pytest.mark.parametrize("name", sorted(built_in_systems()))
def test_nothing_of_earlier_steps_survives(name):
    simulation = simulation_of(name)
    start = State(simulation.translation.qpos, simulation.translation.qvel)
    controls = controls_of(simulation)
    used, fresh = MujocoStepper(simulation.model), MujocoStepper(simulation.model)
    used.put(start)
    used.advance(controls, STEPS)
    middle = used.state()
    used.advance(controls, STEPS)
    for stepper in (used, fresh):
        stepper.put(middle)
        stepper.advance(controls, STEPS)
    assert (used.physics() == fresh.physics()).all()


def test_the_solvers_start_would_survive_without_a_reset():
    """The check above can fail: contacts are solved from the accelerations of the step before."""
    simulation = simulation_of("stack")
    model = simulation.model
    start = simulation.translation.qpos + 1e-3  # above its rest: contacts close and open
    ends = []
    for stepped in (0, STEPS):
        data = mujoco.MjData(model)
        data.qpos[:] = start
        mujoco.mj_step(model, data, stepped)
        data.qpos[:] = simulation.translation.qpos
        data.qvel[:] = 0.0
        mujoco.mj_step(model, data)
        ends.append(data.qvel.copy())
    assert (ends[0] != ends[1]).any()


def test_controls_are_held_for_a_step_each():
    simulation = simulation_of("simple-pendulum/forced-large")
    controls = controls_of(simulation)
    at_once, one_by_one = MujocoStepper(simulation.model), MujocoStepper(simulation.model)
    start = State(simulation.translation.qpos, simulation.translation.qvel)
    for stepper in (at_once, one_by_one):
        stepper.put(start)
    at_once.advance(controls, STEPS)
    for row in controls:
        one_by_one.advance(row[None], 1)
    assert (at_once.physics() == one_by_one.physics()).all()
    assert np.ptp(controls) > 0.0
