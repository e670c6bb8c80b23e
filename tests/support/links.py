"""Cranks of uniform links: when they pass an angle, by an integral of the energy in mpmath's
digits, and how their soft loops pull, beside MuJoCo's."""

import mujoco
import numpy as np
from mpmath import mp

from plumbob.engines.adapters.mujoco.slider_crank import LOOP
from plumbob.engines.registry import engine_of, method


def passed(places, masses, lengths, gravity, ends, rate):
    """Time [s] from one of two angles [rad] to the other, of a crank that begins at a `rate`
    [rad/s]; `places` are x, y and the angle of each link by the crank's, and speeds their
    differences."""

    def energies(t):
        half = mp.mpf(0)
        height = mp.mpf(0)
        for i, (mass, length) in enumerate(zip(masses, lengths, strict=True)):
            x, y, turn = (mp.diff(lambda s, k=k, i=i: places(s)[i][k], t) for k in range(3))
            half += mass * (x**2 + y**2 + length**2 / 12 * turn**2) / 2
            height += mass * gravity * places(t)[i][1]
        return half, height

    half, height = energies(ends[0])
    total = half * rate**2 + height

    def slowness(t):
        half, height = energies(t)
        return mp.sqrt(half / (total - height))

    return mp.quad(slowness, mp.linspace(*ends, 3))


def error_at(time, problem, passed):
    """Error of a crank's angle [rad] at a `time` [s], by the time at which it has `passed` it, with
    40 digits; and its uncertainty."""
    exact, doubt = (
        f(np.array([time])) for f in (problem.motion.observe, problem.motion.uncertainty)
    )
    with mp.workdps(40):
        late = passed(problem, mp.mpf(float(exact["angle"][0]))) - mp.mpf(time)
    return abs(float(late)) * exact["angle_dot"][0], doubt["angle"][0]


def loop_accelerations(case, gap):
    """Accelerations of the joints in MuJoCo, and of the coordinates of the soft system, at the
    start with the third coordinate off by `gap`."""
    how = method("mujoco/rk4")
    simulation = engine_of(how).prepare(case, how, 1e-3)
    model = simulation.model
    data = simulation.data
    system = case.problem.soft(LOOP, 1e-3)
    state = system.start
    state[2] += gap
    data.qpos[:] = simulation.translation.qpos
    data.qvel[:] = simulation.translation.qvel
    data.qpos[2] += gap
    mujoco.mj_forward(model, data)
    return data.qacc.copy(), np.asarray(system.slope(0.0, state))[3:]
