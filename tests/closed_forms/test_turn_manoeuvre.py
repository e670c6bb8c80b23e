"""The turn manoeuvre's formulas, leading and second order, against the exact motion."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plumbob.analytic.systems.capsule import validity
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import (
    TurnManoeuvre,
    leading_friction,
    turn_of,
)
from plumbob.analytic.systems.slider_path import fixed
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.tests.support.random_capsules import CHECK

EPSILONS = (0.1, 0.03, 0.01, 0.003)
# The check manoeuvre; one that turns by half a radian in the other sense from another place;
# another.
TURNS = [
    lambda epsilon: turn_of(CHECK, 0.12, epsilon),
    lambda epsilon: turn_of(CHECK, 0.05, epsilon, 0.5, 1.0),
    lambda epsilon: turn_of(replace(CHECK, slider_mass=2.0), 0.08, epsilon, -0.8, 4.0),
]


def exact(turn):
    """(x, y, psi) at 2 tau and at rest, each of shape (3,)."""
    motion = three_point_motion(turn.capsule, turn.path)
    at = motion.at(np.array([2 * turn.half_time, motion.rest_time]))
    stop, rest = np.column_stack([at.position, at.heading])
    return stop, rest


@pytest.mark.parametrize(
    ("epsilon", "printed"),
    [
        (0.3, -0.9068671274),
        (0.1, -0.9888885424),
        (0.03, -0.9989925407),
        (0.01, -0.9998879884),
    ],
)
def test_the_exact_motion_turns_by_the_check_values(epsilon, printed):
    """To the ten digits given; the motion's own error is 1e-14."""
    assert exact(turn_of(CHECK, 0.12, epsilon))[0][2] == pytest.approx(printed, abs=2e-10)


def test_the_parameters_are_the_sources():
    turn = turn_of(CHECK, 0.12, 0.1)
    reduced = 0.3 / 1.3 * 0.12**2
    bound = (0.2 + 0.3 / 1.3 * 0.12) * 0.3 * 9.81 * 1.3 / (0.02 + reduced)
    wanted = {
        "inertia_ratio": reduced / (0.02 + reduced),
        "friction_bound": bound,
        "characteristic_time": bound**-0.5,
        "epsilon": 0.1,
        "body_angle": -1.0,
        "drive_ratio": 0.1**2 * turn.inertia_ratio * turn.angular_acceleration / bound,
    }
    assert {name: getattr(turn, name) for name in wanted} == pytest.approx(wanted, rel=1e-14)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("number", range(len(TURNS)))
def test_the_error_of_the_corrected_pose_is_of_higher_order(number):
    """Formulas: order 2; corrected: 4 at 2 tau, and at rest 4 with a logarithm, which takes up to
    0.25 off a slope in this range."""
    errors = []
    for epsilon in EPSILONS:
        turn = TURNS[number](epsilon)
        stop, rest = exact(turn)
        leading = turn.leading_pose
        corrected = turn.corrected_pose, turn.corrected_pose_at_rest
        errors.append(
            [stop - leading, rest - leading, stop - corrected[0], rest - corrected[1]]
        )
    sizes = np.log(np.linalg.norm(errors, axis=2))
    slopes = np.polyfit(np.log(EPSILONS), sizes, 1)[0]
    np.testing.assert_allclose(slopes[:2], 2.0, atol=0.08)
    assert slopes[2] == pytest.approx(4.0, abs=0.1)
    assert 3.5 < slopes[3] < 4.1


@pytest.mark.parametrize("number", range(len(TURNS)))
def test_every_coefficient_of_the_pose_is_right(number):
    """Each of x, y and psi, up to the remaining fourth order at epsilon = 0.003: 1e-5 relative,
    times a logarithm and a factor of ten."""
    turn = TURNS[number](0.003)
    for found, coefficients in zip(
        exact(turn), (turn.correction.at_stop, turn.correction.at_rest), strict=True
    ):
        seen = (found - turn.leading_pose) / turn.half_time**2
        size = np.abs(coefficients).max()
        np.testing.assert_allclose(seen, coefficients, rtol=0, atol=1e-3 * size)


def test_without_friction_the_formula_is_exact():
    """Eq. 31 at every time, and C circling the combined centre."""
    turn = TurnManoeuvre(replace(CHECK, friction=1e-14), 0.12, 900.0, 0.05, 0.3)
    motion = three_point_motion(turn.capsule, turn.path)
    times = np.linspace(0.0, 0.12, 25)
    at = motion.at(times)
    np.testing.assert_allclose(at.heading, turn.body_angles(times), rtol=0, atol=1e-13)
    pose = turn.leading_pose
    np.testing.assert_allclose([*at.position[-1], at.heading[-1]], pose, rtol=0, atol=1e-13)


def test_a_small_turn_below_the_friction_limit_turns_nothing():
    """Where eq. 30 fails completely the body sticks, and the error of eq. 32 is 100 %."""
    turn = TurnManoeuvre(CHECK, 0.12, 5.0, 0.2)
    assert turn.epsilon > 1.0
    assert exact(turn)[1][2] == 0.0


@given(st.floats(0.02, 0.3), st.floats(-10.0, 10.0), st.sampled_from([-1.0, 1.0]))
def test_friction_stays_below_its_bound(radius, angle, sense):
    """|R| <= R_0 (eq. 28), wherever the equations hold."""
    place = (radius * math.cos(angle), radius * math.sin(angle))
    if validity(CHECK, fixed(place).track()):
        return
    turn = TurnManoeuvre(CHECK, radius, sense, 1e-9)
    force, moment = leading_friction(turn, np.array([angle]))
    arm = 0.2 + CHECK.mass_ratio * radius
    assert abs(moment[0]) <= arm * CHECK.friction * CHECK.weight
    assert abs(force[0]) <= CHECK.friction * CHECK.weight * (1 + 1e-14)


def rate_coefficients(turn):
    """(v_x, v_y, omega) of the exact motion at 2 tau over tau, shape (3,)."""
    at = three_point_motion(turn.capsule, turn.path).at(np.array([2 * turn.half_time]))
    rates = np.append(at.velocity[0], at.angular_velocity[0])
    return np.asarray(rates / turn.half_time)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("number", range(len(TURNS)))
def test_the_velocities_left_at_the_stop(number):
    """In proportion to epsilon, not zero as eq. 32 has it; what remains is epsilon^2 ln(1/epsilon)
    of it (analytic/README.md, eq. 7), whose slope in this range is 1.6 to 2."""
    errors = []
    for epsilon in EPSILONS:
        turn = TURNS[number](epsilon)
        formula = turn.correction.rate_coefficients
        errors.append(np.abs(rate_coefficients(turn) - formula).max() / np.abs(formula).max())
    assert 1.5 < np.polyfit(np.log(EPSILONS), np.log(errors), 1)[0] < 2.05
    assert errors[-1] < 1e-3
    # friction off by 1 % would be seen
    turn = TURNS[number](EPSILONS[-1])
    worse = replace(turn, capsule=replace(turn.capsule, friction=turn.capsule.friction * 1.01))
    wrong = worse.correction.rate_coefficients[2] / turn.correction.rate_coefficients[2] - 1.0
    assert abs(wrong) > 5 * errors[-1]


def second_order(turn, nodes=800):  # one slip is next to nothing on the way
    """What friction along the motion without it adds to the pose at 2 tau, over tau^2: Newton's and
    Euler's equations of body and slider, with the combined centre at rest, by Gauss's rule."""
    body = turn.capsule
    mass = body.body_mass + body.slider_mass
    mu = body.slider_mass / mass
    reduced = mu * body.body_mass * turn.radius**2
    part = reduced / (body.inertia + reduced)
    supports = np.array([complex(*corner) for corner in body.supports])
    whole = turn.angular_acceleration * turn.half_time**2
    balance = np.vstack([np.ones(3), supports.real, supports.imag])
    moved, turned = 0j, 0.0
    x, weights = np.polynomial.legendre.leggauss(nodes)
    for begin in (0.0, 1.0):
        for s, weight in zip(begin + (x + 1) / 2, weights / 2, strict=True):
            angle = whole * (s**2 / 2 - max(s - 1, 0.0) ** 2)
            r = turn.radius * np.exp(1j * (turn.start + angle))
            carried = body.slider_mass * body.gravity * r
            loads = np.linalg.solve(balance, [mass * body.gravity, carried.real, carried.imag])
            # of the supports in the body's axes, over the slider's rate
            slips = np.sign(whole) * (-1j * part * supports - 1j * mu * (1 - part) * r)
            forces = -body.friction * loads * slips / abs(slips)
            arms = supports - mu * r
            moment = (arms.conjugate() * forces).imag.sum()
            moved += weight * (2 - s) * np.exp(-1j * part * angle) * forces.sum() / mass
            turned += weight * (2 - s) * moment / (body.inertia + reduced)
    last = mu * turn.radius * np.exp(1j * (turn.start + whole - part * whole))
    place = moved - 1j * last * turned
    return np.array([place.real, place.imag, turned])


@pytest.mark.parametrize("number", range(len(TURNS)))
def test_the_second_order_is_an_integral_of_friction(number):
    """To ten digits; the formula's remainder hides a thousandth of it in the exact motion."""
    turn = TURNS[number](0.1)
    second = (turn.corrected_pose - turn.leading_pose) / turn.half_time**2
    np.testing.assert_allclose(second, second_order(turn), rtol=1e-10)
