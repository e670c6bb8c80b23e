"""Mechanisms as engines build them, beside MuJoCo's model of the same bodies."""

import mujoco
import numpy as np

from plumbob.engines.adapters.mujoco.options import collected
from plumbob.engines.stepper import State

STEP = 1e-3  # [s]


def largest_difference_of_terms(model, mechanism, made, terms):
    """The largest difference of the mass matrix and of each kind of force between MuJoCo and a
    stepper that an engine `made`, in random states, relative to the largest number of each; the
    bias, whose parts may cancel, to the size of its parts, too. States that are put come back.
    `terms` gives the engine's, by the stepper, mechanism, qpos and controls."""
    data = mujoco.MjData(model)
    rng = np.random.default_rng(0)
    worst = 0.0
    for _ in range(3):
        data.qpos[:] = model.qpos0
        mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), 1.0)
        data.qvel[:] = rng.normal(size=model.nv)
        controls = 2.0 * rng.normal(size=model.nu)
        data.ctrl[:] = controls
        driven = {a.control for a in mechanism.actuators}
        data.ctrl[[i for i in range(model.nu) if i not in driven]] = 0.0
        with collected():
            mujoco.mj_forward(model, data)
        made.put(State(data.qpos, data.qvel))
        state = made.state()
        np.testing.assert_allclose(state.qpos, data.qpos, atol=1e-14)
        np.testing.assert_allclose(state.qvel, data.qvel, atol=1e-14)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        # MuJoCo's passive forces carry weights that engines leave out of their bias.
        bias, passive = (x - data.qfrc_gravcomp for x in (data.qfrc_bias, data.qfrc_passive))
        wanted = (mass, bias, passive, data.qfrc_actuator)
        found = terms(made, mechanism, data.qpos, controls)
        moved = np.abs(mass).max() * np.square(data.qvel).max() + np.abs(data.qfrc_bias).max()
        for got, expected in zip(found, wanted, strict=True):
            size = max(np.abs(expected).max(), moved if expected is bias else 0.0)
            worst = max(worst, np.abs(got - expected).max() / (size or 1.0))
    return worst


def stepped(made, scene_parts, steps, first=0):
    """The state of a stepper after so many steps of STEP under a scene's controls, from the step
    number `first` on."""
    controls = scene_parts.controls
    rows = None if controls is None else controls(STEP * np.arange(first, first + steps))
    made.advance(rows, steps)
    return made.state()


def assert_nothing_survives_put(make, parts):
    """A stepper of a scene that has taken steps, and is put into a state, goes on as a fresh one,
    to the bit; `make` makes one."""
    used = make()
    used.put(parts.start)
    between = stepped(used, parts, 100)
    stepped(used, parts, 50, 100)
    for state, time in ((between, 100 * STEP), (parts.start, 0.0)):
        fresh = make()
        for made in (used, fresh):
            made.put(state, time)
        after, expected = (
            stepped(made, parts, 20, round(time / STEP)) for made in (used, fresh)
        )
        np.testing.assert_array_equal(after.qpos, expected.qpos)
        np.testing.assert_array_equal(after.qvel, expected.qvel)
