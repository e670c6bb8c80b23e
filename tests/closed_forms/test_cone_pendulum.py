"""The cone pendulum's mass properties, potential, equilibria and motion: the numbers that Sudakov
2015 prints, recomputed to 17 digits, and the restrictions on the arguments of its formulas."""

import math
from dataclasses import replace

import gmpy2
import numpy as np
import pytest
from gmpy2 import mpfr

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.cone_pendulum import ConePendulum, solid_cone
from plumbob.tests.support.high_precision import orbit_of
from plumbob.tests.support.random_pendulums import pendulums

STEEL_APEX = math.radians(30.0)
STEEL = solid_cone(8000.0, 0.3, STEEL_APEX)
RESTING = ConePendulum(STEEL, 0.0, 0.09, 0.0, 9.8, 0.0, 13.0)
TURNING = ConePendulum(STEEL, 0.0, 0.09, 26.0, 9.8, 0.0, 37.0)
PRINTED = TURNING.printed_motion()
AT_REST = TURNING.equilibria
SEVENTEEN = 1e-14  # relative: rounding of the arguments, and of some printed digits


def at(pendulum, time, which):
    return float(pendulum.motion.state(np.array([time]))[which][0])


NUMBERS = {
    "mass": (STEEL.mass, 16.240046710891569),
    "I_x": (STEEL.inertia_x, 0.89270329145737231),
    "I_y": (STEEL.inertia_y, 0.89270329145737231),
    "I_z": (STEEL.inertia_z, 0.031481538138455129),
    "arm": (STEEL.com_distance, 0.225),
    "printed: barrier": (TURNING.printed_barrier[0], 514.19980544461671),
    "printed: its angle": (TURNING.printed_barrier[1], 1.6153103126001704),
    "printed: energy": (double(PRINTED.energy), 575.24610000505543),
    "printed: period": (PRINTED.period, 0.23698083024728754),
    "printed: action": (PRINTED.action, 26.71078315215131),
    "action": (TURNING.motion.action, 35.583008374026574),
    "lower barrier": (double(TURNING.motion.barriers[1]), 9.5533057926638596),
    "theta(0.5)": (at(TURNING, 0.5, 0), 19.655093168749575),
    "theta_dot(0.5)": (at(TURNING, 0.5, 1), 45.196918078698202),
    "pitchfork rate": (TURNING.pitchfork_rate, 6.4482287920129893),
}
EQUILIBRIA = (
    (-2.7751978203905742, 75.715281665569441, "saddle", 24.727000667905373),
    (-1.4708157898939431, -70.567302987382008, "centre", 19.884245862268769),
    (-0.42186138429489885, 9.5533057926638596, "saddle", 22.335022726083818),
    (1.5262823409896228, -514.19980544461671, "centre", 30.002437081566505),
)


@pytest.mark.parametrize("name", NUMBERS)
def test_number_of_the_source(name):
    found, expected = NUMBERS[name]
    assert found == pytest.approx(expected, rel=SEVENTEEN)


@pytest.mark.parametrize(("found", "expected"), list(zip(AT_REST, EQUILIBRIA, strict=True)))
def test_equilibrium_of_the_source(found, expected):
    theta, potential, kind, rate = expected
    assert found.theta == pytest.approx(theta, rel=SEVENTEEN)
    assert found.potential == pytest.approx(potential, rel=SEVENTEEN)
    assert found.kind == kind
    assert found.rate == pytest.approx(rate, rel=SEVENTEEN)


def test_printed_hamiltonian_is_another_problem():
    """Eq. 9 departs from the motion of its Lagrangian, eq. 7, by radians in 0.5 s."""
    theta = PRINTED.state(np.array([0.5]))[0][0]
    assert abs(theta - NUMBERS["theta(0.5)"][1]) > 6.0
    still = RESTING.printed_motion().state(np.array([0.5]))[0][0]
    assert still == pytest.approx(at(RESTING, 0.5, 0), rel=1e-15)  # the same without rotation


def test_general_body_turns_by_its_i_y():
    """The source's I_x in place of I_y is correct for a symmetric body only."""
    moments = {"inertia_y": STEEL.inertia_y + 0.03}
    pendulum = replace(TURNING, body=replace(STEEL, **moments))
    assert at(pendulum, 0.5, 0) == pytest.approx(19.729448, abs=5e-7)
    assert at(TURNING, 0.5, 0) == pytest.approx(19.655093, abs=5e-7)


def test_coefficients_are_those_of_the_independent_derivation():
    """The closed form and 40-digit quadrature start from the same doubles."""
    for _, pendulum in pendulums(110, seed=7):
        v = pendulum.potential
        orbit = orbit_of(pendulum)
        for found, expected in ((v.a, orbit.a), (v.b, orbit.b), (v.c, orbit.c)):
            exact = mpfr(str(found))
            assert abs(exact - expected) <= abs(expected) * mpfr(2) ** -109


def test_equilibria_against_40_digits():
    for _, pendulum in pendulums(110, seed=8):
        orbit = orbit_of(pendulum)
        turn = 2 * gmpy2.const_pi()
        within = [float(x - turn * gmpy2.ceil(x / turn - 0.5 - 1e-30)) for x in orbit.critical]
        found = [e.theta for e in pendulum.equilibria]
        assert found == pytest.approx(sorted(within), rel=2e-16, abs=1e-20)
        for equilibrium in pendulum.equilibria:
            value = float(orbit.potential(mpfr(equilibrium.theta)))
            assert equilibrium.potential == pytest.approx(value, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("rate", "kinds"),
    [
        (0.99, ["centre", "saddle"]),
        (1.01, ["centre", "saddle", "centre", "saddle"]),
    ],
)
def test_pitchfork(rate, kinds):
    level = replace(TURNING, pivot_y=0.0, platform_rate=rate * TURNING.pitchfork_rate)
    assert [e.kind for e in level.equilibria] == kinds
