"""Steps of a fixed size in the plane: against closed forms of lines and turns, and as a minimum."""

import math

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from plumbob.analytic.errors.sliding_motion.plane_steps import COLUMNS, trajectory
from plumbob.analytic.schemes import EULER
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import turn_of
from plumbob.analytic.systems.three_points.friction import InitialVelocities
from plumbob.analytic.systems.three_points.implicit_friction import (
    FrictionProblem,
    after_friction,
)
from plumbob.tests.support.random_capsules import CHECK

HEADING = COLUMNS.index("heading")


@pytest.mark.parametrize("angle", [-1.0, 0.4])
def test_a_turn_leaks_angular_momentum(angle):
    # Of first order to 0.5 % at tau/1600; extrapolated, up to h^2 and friction of epsilon^2 = 1e-5.
    turn = turn_of(CHECK, 0.12, 0.003, angle)
    drive = turn.angular_acceleration
    tau = turn.half_time
    lead = 0.5 * turn.inertia_ratio**2 * drive**3 * tau**5
    assert lead * angle < 0.0  # opposite to the turn
    found = []
    for parts in (400, 800, 1600):
        step = turn.half_time / parts
        end = trajectory(CHECK, turn.path, InitialVelocities(), EULER, step, 2 * parts)[-1]
        found.append((end[HEADING] - turn.corrected_pose[2]) / step)
    assert abs(found[-1] / lead - 1.0) < 0.005
    assert abs((2.0 * found[-1] - found[-2]) / lead - 1.0) < 1e-4  # epsilon^2 is 1e-5


SIZE = st.floats(-1.0, 1.0)
POINT = st.builds(complex, SIZE, SIZE)


@example(1.0, 1.0, (0.25, 0.125, 0.25), (0j, 1j, 1 + 0j), (0.5j, 0.0), 0.0)  # off their centre
@example(  # hardly moves, from a slip that is of a lower value than rest
    1.3,
    0.0233240075,
    (0.00162850943, 0.00109860247, 0.0010987881),
    (0.172303816 + 0j, -0.127696184 + 0.15j, -0.127696184 - 0.15j),
    (0.00102177956 - 0.00277859563j, -0.00842938709),
    4e-8,
)
@given(
    st.floats(0.1, 10.0),
    st.floats(0.01, 1.0),
    st.tuples(*[st.floats(1e-3, 1.0)] * 3),
    st.tuples(POINT, POINT, POINT),
    st.tuples(POINT, SIZE),
    st.floats(0.0, 1e-7),
)
def test_friction_finds_the_minimum(mass, inertia, limits, arms, free, opened):
    # corners of the value included: with limits as large as the momenta most of these bodies end at
    # rest or on one support; no neighbour at any distance has a smaller value, apart from rounding
    a, b, c = arms
    assume(abs(((b - a).conjugate() * (c - a)).imag) >= 1e-2)
    problem = FrictionProblem(mass, inertia, limits, arms, [-opened * arm for arm in arms])
    point, rate = after_friction(problem, free, free)
    least = problem.value(free, (point, rate))
    rounding = 1e-13 * (problem.value(free, (0j, 0.0)) + 1e-3) + 4 * opened * sum(limits)
    for size in (1e-1, 1e-3, 1e-5):
        for k in range(16):
            other = (point + size * np.exp(0.7j * k), rate + size * math.sin(2.3 * k))
            assert problem.value(free, other) >= least - rounding
