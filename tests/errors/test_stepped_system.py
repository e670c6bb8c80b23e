"""Steps on any smooth system beside those on the driven rotor in plain numbers."""

from dataclasses import asdict

import numpy as np
import pytest

from plumbob.analytic.errors.smooth_motion.stepped_system import smooth_errors
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.schemes import EULER, LEAPFROG, RK4, Scheme
from plumbob.tests.support import fixed_step

ROTOR = DrivenRotor(3.0, 1.0, 9.0, 0.3, 1.2, 2.1, 0.4, 0.7)  # every coefficient at once
START = (0.7, 1.3)
STEPPED = (
    Scheme(EULER),
    Scheme(EULER, "start"),
    Scheme(EULER, "midpoint"),
    Scheme(EULER, position_first=True),
    Scheme(LEAPFROG),
    Scheme(LEAPFROG, "midpoint"),
    Scheme(RK4),
    Scheme(RK4, "start"),
    Scheme(RK4, "midpoint"),
)


def system(rotor=ROTOR, moment=0.4):
    """The rotor by its moment of inertia and its moments."""

    def moments(p, t, q, v):
        (x,), (u,) = q, v
        pull = p.sin2 * np.sin(2 * x) + p.cos * np.cos(x) - p.sin * np.sin(x) - p.stiffness * x
        push = p.forcing_amplitude * np.sin(p.forcing_frequency * t + p.forcing_phase)
        return (p.moment * (pull + push - p.damping_rate * u),)

    parameters = {**asdict(rotor), "moment": moment}
    names, inertia = (("theta",), ("theta_dot",)), lambda p, q: ((p.moment,),)
    return SmoothSystem(*names, inertia, moments, parameters, START[:1], START[1:], damped=True)


@pytest.mark.parametrize("scheme", STEPPED, ids=str)
def test_errors_are_those_of_the_rotor(scheme):
    # Both step the same equation in their own arithmetic: 200 steps differ by some roundings.
    times = np.arange(0, 201, 4).astype(float) * 1e-2
    step = 1e-2
    motion = CertifiedMotion(system())
    ours = smooth_errors(motion).at_step(scheme, step, times).errors
    exact = motion.observe(times)
    theirs = fixed_step.run(ROTOR, *START, step, 200, scheme)
    for name, values in zip(("theta", "theta_dot"), theirs, strict=True):
        np.testing.assert_allclose(ours[name], values[::4] - exact[name], rtol=0.0, atol=2e-13)
        assert np.abs(ours[name]).max() > 1e-9
