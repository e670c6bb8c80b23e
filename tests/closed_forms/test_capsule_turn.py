"""Turns and spins as scenes: exact answers, repeated turns, errors of a fixed step."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.errors.sliding_motion.sliding_errors import plane_errors
from plumbob.analytic.schemes import EULER as SEMI_IMPLICIT
from plumbob.analytic.schemes import RK4, Scheme
from plumbob.analytic.systems.capsule_setup import InWorld
from plumbob.analytic.systems.manoeuvres.repeated_turn import RepeatedTurn
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import turn_of
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.analytic.systems.three_points.reference import PlaneReference
from plumbob.models.registry import scene, system_of
from plumbob.models.tripod_capsule.turn import EPSILONS
from plumbob.tests.support.random_capsules import CHECK

RATIO = turn_of(CHECK, 0.12, 1.0).inertia_ratio
EULER = Scheme(SEMI_IMPLICIT)
POSITION_FIRST = Scheme(SEMI_IMPLICIT, position_first=True)
WHOLE = replace(turn_of(CHECK, 0.12, 0.1, -RATIO * 2.0 * math.pi), capsule=CHECK)


def exact(case):
    """The exact answer to a scene, in the axes of its start."""
    found = system_of(case).reference(system_of(case).problem(case.parameters))
    assert isinstance(found, InWorld)
    assert isinstance(found.in_start_axes, PlaneReference)
    return found.in_start_axes


@pytest.mark.parametrize("epsilon", EPSILONS)
def test_a_turn_says_its_angles(epsilon):
    """The source's angle, also corrected: the error is 0.888 epsilon^4 and, at rest, 2.37 epsilon^4
    ln(1/epsilon) with a remainder of the same power; below 1e-10 nothing is predicted."""
    case = scene(f"capsule-turn/{epsilon}")
    facts = system_of(case).facts(system_of(case).problem(case.parameters))
    assert facts["epsilon"] == pytest.approx(epsilon, rel=1e-14)
    assert facts["body_angle_formula"] == pytest.approx(-1.0, rel=1e-14)
    off = facts["body_angle"] - facts["body_angle_corrected"]
    assert off == pytest.approx(-0.888 * epsilon**4, rel=0.1, abs=1e-10)
    at_rest = facts["body_angle_at_rest"] - facts["body_angle_corrected_at_rest"]
    assert abs(at_rest) <= 2.6 * epsilon**4 * (1.0 + math.log(1.0 / epsilon)) + 1e-10
    assert case.parameters["half_time"] * 2.0 < facts["rest_time"] <= case.duration


def test_consecutive_turns_are_the_whole_motion():
    """Against the same turns followed as one path; the difference is the error of both motions."""
    repeated = RepeatedTurn(WHOLE, 3, 3.0 * WHOLE.half_time)
    motion = three_point_motion(CHECK, repeated.path)
    assert repeated.duration == pytest.approx(motion.rest_time, rel=1e-12)
    times = np.linspace(0.0, 1.05 * repeated.duration, 200)
    for name in ("position", "heading", "velocity", "angular_velocity"):
        turns, path = (getattr(m.at(times), name) for m in (repeated, motion))
        np.testing.assert_allclose(turns, path, rtol=0, atol=1e-11 * np.abs(path).max())
    assert repeated.error.heading[0] >= 3 * repeated.single.error.heading[0]


@pytest.mark.parametrize(
    ("name", "scheme", "observable", "coefficient"),
    [
        # error at rest over the step: [rad/s], and [m/s]
        ("capsule-coast/spin", POSITION_FIRST, "heading", 3.184),
        ("capsule-coast/spin", POSITION_FIRST, "x", 0.07423),
        ("capsule-coast/spin", EULER, "heading", -2.183),
        ("capsule-coast/spin", Scheme(RK4), "heading", 0.3962),
        ("capsule-turn/0.3", POSITION_FIRST, "heading", -1.377),
        ("capsule-turn/0.3", EULER, "heading", 121.6),
    ],
)
def test_the_error_of_steps_is_of_first_order(name, scheme, observable, coefficient):
    """Coefficients, from halved steps: the remainder is of second order, and a sawtooth."""
    case = scene(name)
    reference = exact(case)
    steps = [case.duration / n for n in (1000, 2000)]
    grid = np.array([0.0, case.duration])
    ends = [plane_errors(reference, scheme, h, grid)[observable][-1] / h for h in steps]
    assert 2.0 * ends[1] - ends[0] == pytest.approx(coefficient, rel=0.03)
