"""Action, phase, equilibria and the source's parametric form, against 40 digits."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from gmpy2 import mpfr

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.cone_pendulum import ConePendulum, solid_cone
from plumbob.analytic.systems.pendulums.action_curves import branches
from plumbob.models.cone_pendulum.answers import over_angle
from plumbob.tests.support.high_precision import Orbit, orbit_of

STEEL = solid_cone(8000.0, 0.3, math.radians(30.0))
TURNING = ConePendulum(STEEL, 0.0, 0.09, 26.0, 9.8, 0.0, 37.0)
INERTIA = STEEL.inertia_x
NAMES = ("in the deeper well", "in the shallower well", "over both wells", "rotation")


def potential(pendulum):
    v = pendulum.potential
    return TrigonometricPotential(*(float(double(x)) for x in (v.a, v.b, v.c)))


@cache
def found(points=60):
    return {b.name: b for b in branches(potential(TURNING), INERTIA, 1100.0, points)}


@pytest.mark.parametrize("name", NAMES)
def test_period_and_action_against_40_digits(name):
    branch = found()[name]
    v = potential(TURNING)
    wells = {e.theta for e in TURNING.equilibria if e.kind == "centre"}
    bottom = min(wells) if "shallower" in name else max(wells)
    for i in (3, 20, 30, 45, len(branch.energies) - 4):
        a, b, c = (mpfr(x) for x in (v.a, v.b, v.c))
        start = Orbit(a, b, c, mpfr(INERTIA), mpfr(bottom), mpfr(0))
        kinetic = mpfr(branch.energies[i]) - start.potential(start.theta)
        speed = (2 * kinetic / start.inertia) ** mpfr("0.5")
        period, action, _ = replace(start, theta_dot=speed).follow()
        # an energy is known to some 1e-16 of 500 J, and the branch's ends are 1e-6 of it away
        nearest = min(abs(branch.energies[i] - e.potential) for e in TURNING.equilibria)
        allowed = 4e-16 * 600.0 / nearest + 1e-13
        assert branch.periods[i] == pytest.approx(float(period), rel=allowed)
        assert branch.actions[i] == pytest.approx(float(action), rel=allowed)
    assert branch.rates == pytest.approx(2 * np.pi / branch.periods)


def test_one_well_and_a_simple_pendulum():
    rest = branches(TrigonometricPotential(0.0, 0.0, 9.8), 1.0, 40.0)
    assert [b.name for b in rest] == ["in the well", "rotation"]
    assert rest[0].periods[0] == pytest.approx(2 * math.pi / math.sqrt(9.8), rel=1e-5)


@pytest.mark.parametrize("theta", [0.1, 1.5, 3.0, 6.0])
def test_time_over_angle_against_40_digits(theta):
    tilted = replace(TURNING, body=replace(STEEL, inertia_yz=0.02))
    for pendulum in (TURNING, tilted):
        orbit = orbit_of(pendulum)
        time, _ = orbit.over(mpfr(0), mpfr(theta))
        answers = {o.name: v[0] for o, v in over_angle(pendulum, np.array([theta])).items()}
        assert answers["t"] == pytest.approx(float(time), rel=1e-13)
        rate = float(orbit.speed(mpfr(theta)))
        assert answers["theta_dot"] == pytest.approx(rate, rel=1e-13)
        assert answers["momentum"] == pytest.approx(rate * INERTIA, rel=1e-13)
        period = float(orbit.follow()[0])
        assert answers["phase"] == pytest.approx(2 * math.pi * float(time) / period, rel=1e-13)
