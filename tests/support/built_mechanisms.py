"""Mechanisms as engines build them, beside MuJoCo's model of the same bodies."""

from dataclasses import replace

import mujoco
import numpy as np

from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
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


PAIR_OF_BODIES = """<mujoco><option gravity="0 0 0"/><worldbody>
  <body name="a" pos="0 0 1" quat="1 0.2 0.3 0"><freejoint/>
    <inertial pos="0.1 0.1 0" mass="1" diaginertia="0.1 0.2 0.15"/></body>
  <body name="b" pos="0.5 0 1" quat="1 0 0.3 0.4"><freejoint/>
    <inertial pos="0.1 0.1 0" mass="1" diaginertia="0.1 0.2 0.15"/></body>
</worldbody><equality><{}/></equality></mujoco>"""
LOOPS_OF_PAIR = {
    "weld": 'weld body1="a" body2="b"',
    "connect": 'connect body1="a" body2="b" anchor="0.2 0.1 0"',
}
SPIN = np.array([1.0, 2.0, 3.0])  # [rad/s]


def opening_of_a_loop(make, kind, misplacement=0.0):
    """The largest coordinate of the gap [m] between the points that a loop holds together, and the
    largest change of an element of the relative attitude, after 500 steps.

    Two free bodies are held by a loop of this kind in free space, and begin to turn as one body
    about the first body's frame. `make` makes a stepper of a mechanism and a start. In the engine,
    the loop's point of the first body is `misplacement` [m] from its place along each axis.
    """
    model = mujoco.MjModel.from_xml_string(PAIR_OF_BODIES.format(LOOPS_OF_PAIR[kind]))
    mechanism = compiled_mechanism(model)
    data = mujoco.MjData(model)
    (loop,) = mechanism.loops

    def gap_and_relative_attitude(qpos):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        first, second = (data.xmat[i].reshape(3, 3).copy() for i in (1, 2))
        ends = [data.xpos[1] + first @ loop.places[0], data.xpos[2] + second @ loop.places[1]]
        return ends[1] - ends[0], first.T @ second

    _, attitude = gap_and_relative_attitude(model.qpos0)
    frames = [data.xmat[i].reshape(3, 3) for i in (1, 2)]
    spins = [frame.T @ SPIN for frame in frames]
    moving = np.cross(SPIN, data.xpos[2] - data.xpos[1])
    start = State(model.qpos0, np.concatenate([np.zeros(3), spins[0], moving, spins[1]]))
    places = (loop.places[0] + misplacement, loop.places[1])
    made = make(replace(mechanism, loops=(replace(loop, places=places),)), start)
    made.put(start)
    made.advance(None, 500)
    gap, attitude_after = gap_and_relative_attitude(made.state().qpos)
    return np.abs(gap).max(), np.abs(attitude_after - attitude).max()
