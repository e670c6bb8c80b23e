"""The projectile against its parabola, and what steps add to it exactly."""

import numpy as np
import pytest
from mpmath import mp

from plumbob.engines.registry import engine_of, method
from plumbob.models.registry import case_of, scene

CASE = case_of(scene("projectile/thrown"))
TIMES = np.linspace(0.0, 1.5, 31)


def test_40_digits():
    observed, doubt = (f(TIMES) for f in (CASE.reference.observe, CASE.reference.uncertainty))
    body = CASE.problem
    with mp.workdps(40):
        for k, time in enumerate(map(mp.mpf, TIMES)):
            speed, elevation, spin, g = map(
                mp.mpf, (body.speed, body.elevation, body.spin, body.gravity)
            )
            flown = {
                "x": speed * mp.cos(elevation) * time,
                "z": speed * mp.sin(elevation) * time - g * time**2 / 2,
                "angle": spin * time,
            }
            for name, value in flown.items():
                assert abs(value - mp.mpf(float(observed[name][k]))) <= doubt[name][k] < 1e-13


@pytest.mark.parametrize(
    ("name", "added"),
    [("mujoco/euler", -0.5), ("ode/euler", -0.5), ("pymunk/contact", 0.5), ("ode/leapfrog", 0.0)],
)
def test_a_step_adds_half_of_g_h_t(name, added):
    how, step = method(name), 1e-2
    run = engine_of(how).prepare(CASE, how, step).run()
    exact = CASE.reference.observe(run.times)
    error = run.observables["z"] - exact["z"]
    # 150 steps round a height of some 3 m and a speed of 8 m/s: 1e-15 each
    np.testing.assert_allclose(error, added * 9.81 * step * run.times, 0.0, 2e-13)
    np.testing.assert_allclose(run.observables["x"], exact["x"], 0.0, 2e-13)
    np.testing.assert_allclose(run.observables["angle"], exact["angle"], 0.0, 1e-12)
