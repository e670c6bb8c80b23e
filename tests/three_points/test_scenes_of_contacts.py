"""Scenes that tell contact models apart: their exact answers against an independent integration, or
against the same scene in other axes."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.models.registry import case_of, scene
from plumbob.tests.support.smoothed_friction import smoothed_pose

ROUND = 1e-13  # of places, angles and their rates: sums of some hundred terms of order 1
WIDTH = 1e-7  # of the largest speed: over which friction is smoothed
GRADUAL = 0.8  # power of the width in the error where a load grows through the friction limit
AGREES = 1e-6  # relative: measured 1e-7 and 6e-11; ten times the width has nine times the error
QUICK = ("capsule-turn/light-slider", "capsule-turn/heavy-slider")
SMOOTHED = (*QUICK, "capsule-plan/light-slider")
LATE = 0.9  # of the motion: what it is compared at


def motion(name):
    """The exact motion of a scene."""
    found = case_of(scene(name)).problem.reference.motion
    assert isinstance(found.single, ThreePointMotion)
    return found.single


def pose(of, time):
    """x, y [m] and psi [rad] at `time` [s]."""
    at = of.at(np.array([time]))
    return np.array([*at.position[0], at.heading[0]])


def apart(of, friction=1.0):
    """By how much the exact pose differs from that with smoothed friction, of a coefficient times
    `friction`, relative to its largest coordinate."""
    time = LATE * of.rest_time
    largest = float(np.abs(of.at(np.linspace(0.0, time, 200)).velocity).max())
    body = replace(of.capsule, friction=friction * of.capsule.friction)
    found = smoothed_pose(body, of.path, np.zeros(6), time, WIDTH * largest, GRADUAL).pose
    exact = pose(of, time)
    return float(np.abs(found - exact).max() / np.abs(exact).max())


@pytest.mark.long
def test_smoothed_friction_finds_the_same_pose(request):
    """And with `--profile full` no other where friction is 0.1 % off."""
    full = request.config.getoption("--profile") == "full"
    for name in SMOOTHED if full else QUICK:
        of = motion(name)
        assert apart(of) <= AGREES, name
        assert not full or apart(of, 1.001) > 3.0 * AGREES, name


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("angle", [30, 45])
@pytest.mark.parametrize(("system", "usual"), [("turn", "0.3"), ("plan", "")])
def test_a_heading_at_the_start_changes_itself_alone(system, usual, angle):
    turned = case_of(scene(f"capsule-{system}/heading-{angle:03d}"))
    straight = case_of(
        scene(f"capsule-turn/{usual}")
        if usual
        else scene("capsule-plan/heading-030", {"start": (0.0, 0.0, 0.0), "to": (0.01, 0.01, 0.1)})
    )
    assert turned.problem.setup.heading == pytest.approx(np.radians(angle), rel=1e-15)
    assert straight.problem.setup.heading == 0.0
    times = np.linspace(0.0, turned.scene.duration, 101)
    one, other = (case.reference.observe(times) for case in (turned, straight))
    path = turned.problem.reference.motion.path
    push = np.abs(path.kinematics(np.linspace(0.0, path.duration, 1000))[2]).max()
    late = 4.0 * ULP * path.duration * push  # velocity, as times of manoeuvres are sums
    for name, values in one.items():
        bound = ROUND * max(1.0, float(np.abs(values).max())) + late * name.startswith("velocity")
        turn = np.radians(angle) * (name == "heading")
        np.testing.assert_allclose(values - turn, other[name], rtol=0, atol=bound, err_msg=name)
