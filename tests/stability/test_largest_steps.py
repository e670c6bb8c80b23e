"""The largest step of a linear system against closed forms, 40-digit numbers and other code."""

import math

import mpmath
import numpy as np
import pytest

from plumbob.analytic.errors.smooth_motion.stepped_rotor import many_steps
from plumbob.analytic.errors.stability.adaptive_cost import stability_function
from plumbob.analytic.errors.stability.largest_step import jacobians, largest_step
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.schemes import EULER, LEAPFROG, RK4, Scheme
from plumbob.analytic.tableau import CLASSICAL, order_8

PLAIN = (
    Scheme(EULER),
    Scheme(EULER, implicit_damping=True),
    Scheme(EULER, implicit_damping=True, implicit_spring=True),
    Scheme(EULER, position_first=True),
    Scheme(LEAPFROG),
    Scheme(RK4),
)
OMEGA = 3.0  # [rad/s]
SHARP = 1.0 + 1e-5  # growth in 10^4 steps: what is left of the margin is 1e-9 a step
# |R| of RK4 on the negative axis is 1 at the real root of 1 + z/2 + z^2/6 + z^3/24 = 0
REAL_AXIS = 2.785293563405282


def oscillator(scheme, damping, stiffness=OMEGA**2):
    """The step as a matrix by its size, and the rates of the motion."""
    rotor = DrivenRotor(damping_rate=damping, stiffness=stiffness)

    def matrices(steps):
        return jacobians(*many_steps(rotor, (0.0, 0.0), scheme, steps), len(steps))

    return matrices, np.roots([1.0, damping, stiffness]).astype(complex)


def closed_form(scheme, damping):
    """The limit of each scheme by Jury's conditions on trace and determinant (eq. 13.2)."""
    if scheme.implicit_spring:
        return math.inf
    if scheme.integrator == LEAPFROG:
        return 2.0 / OMEGA
    if scheme.integrator == RK4:
        fast = damping / 2.0 + math.sqrt(damping**2 / 4.0 - OMEGA**2) if damping else OMEGA
        return (REAL_AXIS if damping else 2.0 * math.sqrt(2.0)) / fast
    sign = 1.0 if scheme.implicit_damping else -1.0  # h^2 omega^2 = 4 + sign 2 h xi
    root = math.sqrt(damping**2 + 4.0 * OMEGA**2)
    return (sign * damping + root) / OMEGA**2


@pytest.mark.parametrize("damping", [0.0, 20.0])
@pytest.mark.parametrize("scheme", PLAIN, ids=str)
def test_limits_of_an_oscillator(scheme, damping):
    system = oscillator(scheme, damping)
    wanted = closed_form(scheme, damping)
    # eq. 13.2 is exact; a margin of 1e-9 a step moves a root of slope one by as much
    assert largest_step(*system, factor=SHARP) == pytest.approx(wanted, rel=1e-6)
    # the margin of the runs, 7e-4 a step, moves it by less than half of a bracket of 1 %
    assert largest_step(*system) == pytest.approx(wanted, rel=4e-3)


@pytest.mark.parametrize("tableau", [CLASSICAL, order_8()], ids=["4", "8"])
@pytest.mark.parametrize("z", [-2.5 + 0.0j, 2.0j, -1.0 + 3.0j])
def test_the_stability_function_by_its_definition_in_40_digits(tableau, z):
    stages = len(tableau.weights)
    with mpmath.workdps(40):
        number = mpmath.mpc(z)
        matrix = mpmath.zeros(stages)
        ones = mpmath.ones(stages, 1)
        for i, row in enumerate(tableau.matrix):
            for j, value in enumerate(row):
                matrix[i, j] = mpmath.mpf(value)
        stage = mpmath.lu_solve(mpmath.eye(stages) - number * matrix, ones)
        weights = mpmath.matrix([mpmath.mpf(w) / tableau.divisor for w in tableau.weights])
        wanted = complex(1 + number * (weights.T * stage)[0])
    found = complex(stability_function(tableau, np.array(z)))
    assert found == pytest.approx(wanted, rel=1e-13)  # 12 stages, 4.8 at most a weight: 100 ulp


def test_a_stiff_mode_is_seen_beside_a_growing_one():
    growing, stiff = (oscillator(Scheme(EULER), 0.0, stiffness) for stiffness in (-9.8, 1e4))

    def matrices(steps):
        both = np.zeros((len(steps), 4, 4))
        both[:, :2, :2], both[:, 2:, 2:] = growing[0](steps), stiff[0](steps)
        return both

    limit = largest_step(matrices, np.concatenate([growing[1], stiff[1]]), factor=SHARP)
    assert limit == pytest.approx(0.02, rel=1e-6)
