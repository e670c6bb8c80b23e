"""The parts of pymunk's capsule: feet and their pins, solver iterations, a driven slider."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.errors.contact_models.sequential_impulse import (
    MOST_ITERATIONS,
    TARGET,
    feet_factor,
    iterations_needed,
)
from plumbob.analytic.systems.capsule import Capsule, Point
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.analytic.systems.slider_path import arc_stroke, fixed
from plumbob.analytic.systems.three_points.friction import Start, three_point_motion
from plumbob.engines.adapters.pymunk.assembly import Assembly, settle
from plumbob.engines.adapters.pymunk.capsule_above import (
    foot_mass,
    friction_limits,
    in_the_plane,
    on_feet,
)
from plumbob.engines.adapters.pymunk.slider_drive import driven, driven_along, velocity_targets
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of
from plumbob.tests.support.random_capsules import CHECK

ITERATIONS = 50
CIRCLE = 0.12  # [m]


def step_on(assembly: Assembly, step: float, count: int) -> Assembly:
    """The capsule after so many steps of `step` [s] with nothing driven."""
    assembly.space.iterations = ITERATIONS
    for _ in range(count):
        assembly.space.step(step)
    return assembly


BESIDE = ((0.2, 0.01), (0.21, -0.01), (0.19, 0.0))  # all on one side of C
AROUND = ((0.2, 0.0), (-0.05, 0.15), (-0.12, -0.1))  # their centroid is not C


@pytest.mark.parametrize("corners", [AROUND, BESIDE])
@pytest.mark.parametrize("fraction", [2.0, 1.0, 0.75, 0.5, 0.05])
def test_feet_leave_the_body_a_quarter_of_its_inertia(
    corners: tuple[Point, Point, Point], fraction: float
) -> None:
    body = replace(CHECK, supports=corners, inertia=CHECK.inertia * fraction)
    mass, places = foot_mass(body), [complex(*corner) for corner in corners]
    rest = body.body_mass - 3 * mass
    feet = mass * sum(abs(place) ** 2 for place in places) + abs(mass * sum(places)) ** 2 / rest
    assert 0.0 < feet <= 0.75 * body.inertia * (1 + 1e-12)


@pytest.mark.parametrize(
    ("corners", "fraction"), [(AROUND, 1.0), (AROUND, 0.05), (AROUND, 0.001), (BESIDE, 0.75)]
)
def test_feet_and_body_have_the_mass_and_inertia_of_the_capsule(
    corners: tuple[Point, Point, Point], fraction: float
) -> None:
    body = replace(CHECK, supports=corners, inertia=CHECK.inertia * fraction)
    found = on_feet(CapsuleSetup(body), 1e-3, turning=True)
    mass = sum(part.mass for part in found.parts)
    assert mass == pytest.approx(body.body_mass + body.slider_mass, rel=1e-14)
    parts = [part for part in found.parts if part is not found.slider]
    centre = sum((p.mass * complex(*p.position) for p in parts), 0j)
    assert abs(centre) < 1e-15
    inertia = sum(p.mass * abs(complex(*p.position)) ** 2 for p in parts) + found.body.moment
    assert inertia == pytest.approx(body.inertia, rel=1e-13)
    assert found.body.moment > 0.24 * body.inertia
    assert foot_mass(body) == parts[-1].mass


def test_pins_that_close_strain_the_feet_they_pin() -> None:
    # Closing pins strain sticking feet: an unsettled start leaves gaps of 1e-8 m, the pins pull at
    # them in every step, and the body drifts by 0.1 mm where friction is nearly used up. Pins that
    # do not close only keep the gaps of the start.
    scene = find_scene("capsule-hold/0.999")
    setup = system_of(scene).problem(scene.parameters).setup
    drifted = {}
    for turning in (True, False):
        assembly = on_feet(setup, 1e-3, turning)
        friction_limits(setup, assembly.friction_joints)
        assembly.space.iterations = 50
        for _ in range(10_000):
            assembly.space.step(1e-3)
        drifted[turning] = abs(assembly.motion_of_centre[0])
    assert drifted[True] > 5e-5
    assert drifted[False] < 1e-6


def test_normal_forces_at_the_wrong_feet() -> None:
    # translation needs the moments of friction to balance; with the loads at the wrong supports
    # they do not, and the body turns
    setup = CapsuleSetup(CHECK, (0.08, 0.05), velocity=(0.3, 0.1), press=CHECK.gravity)
    turned = []
    for order in ((0, 1, 2), (1, 2, 0)):
        assembly = on_feet(setup, 1e-3, turning=False)
        a, b, c = (assembly.friction_joints[i] for i in order)
        friction_limits(setup, (a, b, c))
        turned.append(abs(step_on(assembly, 1e-3, 150).body.angle))
    assert turned[0] < 1e-6 < 1e-3 < turned[1]


def test_solver_iterations() -> None:
    bodies = [replace(CHECK, slider_mass=m) for m in (1.0, 1e2, 1e4)]
    left = [feet_factor(body, foot_mass(body), np.zeros(2)) for body in bodies]
    # the heavier the slider, the larger the residual of an iteration, its limit
    # 1 - feet/slider
    assert left == sorted(left)
    assert 1 - left[-1] == pytest.approx((1 - left[-2]) / 100, rel=0.05)
    count = iterations_needed(left[0], 1)
    assert left[0] ** count <= TARGET < left[0] ** (count - 1)
    assert iterations_needed(left[0], 500) == 500
    assert iterations_needed(left[-1], 1) == iterations_needed(1.0, 1) == MOST_ITERATIONS
    assert iterations_needed(0.0, 1) == 1


def turn(
    body: Capsule, epsilon: float, steps: int, shortcut: bool = False
) -> tuple[Assembly, float, float]:
    """A turn manoeuvre in twice so many steps: the capsule after it, its heading in the reference
    [rad], and what a sum of momenta may be compared with [kg m/s]."""
    mu, weight = CHECK.mass_ratio, CHECK.weight
    turning = CHECK.inertia + mu * CHECK.body_mass * CIRCLE**2
    half = epsilon * math.sqrt(turning / ((0.2 + mu * CIRCLE) * CHECK.friction * weight))
    path = arc_stroke(CIRCLE, 0.0, turning / (mu * CHECK.body_mass * (CIRCLE * half) ** 2), half)
    setup, step = CapsuleSetup(body, (CIRCLE, 0.0), press=body.gravity), half / steps
    assembly = on_feet(setup, step, turning=True)
    set_limits = friction_limits(setup, assembly.friction_joints)
    targets = velocity_targets(lambda times: path.kinematics(times)[1], (CIRCLE, 0.0), step)
    if shortcut:
        act = driven_along(assembly, targets, 0.0, set_limits)
    else:
        act = driven(assembly, targets, step, set_limits)
    assembly.space.iterations = ITERATIONS
    for n in range(2 * steps):
        act(n * step)
        assembly.space.step(step)
    exact = float(
        three_point_motion(body, path, until=2 * half).at(np.array([2 * half])).heading[0]
    )
    return assembly, exact, body.slider_mass * CIRCLE / half


def test_turn_manoeuvre() -> None:
    # small epsilon: friction has little time, and the error of the step is of second order; 1e-4
    # rad is required at tau/800; 1.6e-4 at tau/200 becomes a sixteenth of that
    errors = []
    for steps in (50, 100, 200):
        assembly, exact, _ = turn(CHECK, 0.03, steps)
        errors.append(assembly.body.angle - exact)
    assert exact == pytest.approx(-0.9989925407, abs=1e-9)
    assert errors[-1] < 2e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.02)
    # epsilon 0.3: friction takes the direction of a velocity half a step later, at first order
    assembly, exact, _ = turn(CHECK, 0.3, 400)
    assert abs(assembly.body.angle - exact) < 1e-4


def test_the_lines_shortcut_is_wrong_on_a_turn() -> None:
    right, exact, _ = turn(CHECK, 0.03, 200)
    wrong, _, _ = turn(CHECK, 0.03, 200, shortcut=True)
    assert abs(wrong.body.angle - exact) > 20 * abs(right.body.angle - exact)


def test_a_turn_without_friction_makes_no_momentum() -> None:
    assembly, _, scale = turn(replace(CHECK, friction=0.0), 0.03, 200)
    both = sum(part.mass for part in assembly.parts)
    centre = sum((part.mass * complex(*part.position) for part in assembly.parts), 0j) / both
    assert abs(centre - CHECK.mass_ratio * CIRCLE) < 1e-14
    assert abs(assembly.momentum) < 1e-12 * scale


def test_spin_and_translation() -> None:
    # first order: half a step of turning and its consequences; positions are those of half a step
    # before, except at the start
    start = Start(velocity=(0.4, 0.2), angular_velocity=6.0)
    exact = three_point_motion(CHECK, fixed((CIRCLE, 0.0)), start).at(np.array([0.2]))
    errors = []
    for step in (1e-3, 5e-4, 2.5e-4):
        setup = CapsuleSetup(
            CHECK, (CIRCLE, 0.0), velocity=(0.4, 0.2), heading_rate=6.0, press=CHECK.gravity
        )
        assembly = on_feet(setup, step, turning=True)
        friction_limits(setup, assembly.friction_joints)
        settle(assembly, step)
        seen = in_the_plane(setup, step_on(assembly, step, round(0.2 / step)))()
        errors.append((seen["heading"] - exact.heading[0]) / step)
    assert errors == pytest.approx([2.73] * 3, rel=0.01)
    assert errors[1] - errors[2] == pytest.approx((errors[0] - errors[1]) / 2, rel=0.2)


def test_a_start_in_the_middle_of_a_turn_has_no_jerk() -> None:
    scene = find_scene("capsule-coast/rotation")
    setup = system_of(scene).problem(scene.parameters).setup
    assembly = on_feet(setup, 1e-3, turning=True)
    friction_limits(setup, assembly.friction_joints)
    settle(assembly, 1e-3)
    rates, speeds = [], []
    for _ in range(5):
        step_on(assembly, 1e-3, 1)
        rates.append(assembly.body.angular_velocity)
        speeds.append(abs(assembly.motion_of_centre[1]))
    # a foot started where it is pinned would put 1e-4 rad/s and 1e-4 m/s into the first steps
    assert np.ptp(np.diff(rates)) < 5e-7
    assert max(speeds) < 5e-6
    assert cmath.isfinite(assembly.momentum)
