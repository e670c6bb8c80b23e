"""The parts of pymunk's capsule: feet and their pins, solver iterations, a driven slider."""

import cmath
from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.errors.contact_models.sequential_impulse import (
    MOST_ITERATIONS,
    TARGET,
    feet_factor,
    iterations_needed,
)
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.pymunk.assembly import settle
from plumbob.engines.adapters.pymunk.capsule_above import (
    foot_mass,
    friction_limits,
    on_feet,
)
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of
from plumbob.tests.support.random_capsules import CHECK

ITERATIONS = 50


def step_on(assembly, step, count):
    """The capsule after so many steps of `step` [s] with nothing driven."""
    assembly.space.iterations = ITERATIONS
    for _ in range(count):
        assembly.space.step(step)
    return assembly


BESIDE = ((0.2, 0.01), (0.21, -0.01), (0.19, 0.0))  # all on one side of C
AROUND = ((0.2, 0.0), (-0.05, 0.15), (-0.12, -0.1))  # their centroid is not C


@pytest.mark.parametrize("corners", [AROUND, BESIDE])
@pytest.mark.parametrize("fraction", [2.0, 1.0, 0.75, 0.5, 0.05])
def test_feet_leave_the_body_a_quarter_of_its_inertia(corners, fraction):
    body = replace(CHECK, supports=corners, inertia=CHECK.inertia * fraction)
    mass, places = foot_mass(body), np.array(corners) @ [1.0, 1j]
    counter = abs(mass * places.sum()) ** 2 / (body.body_mass - 3 * mass)
    feet = mass * (np.abs(places) ** 2).sum() + counter
    assert 0.0 < feet <= 0.75 * body.inertia * (1 + 1e-12)


@pytest.mark.parametrize(
    ("corners", "fraction"), [(AROUND, 1.0), (AROUND, 0.05), (AROUND, 0.001), (BESIDE, 0.75)]
)
def test_feet_and_body_have_the_mass_and_inertia_of_the_capsule(corners, fraction):
    body = replace(CHECK, supports=corners, inertia=CHECK.inertia * fraction)
    found = on_feet(CapsuleSetup(body), 1e-3, turning=True)
    parts = [part for part in found.parts if part is not found.slider]
    masses, places = np.array([(p.mass, complex(*p.position)) for p in parts]).T
    assert masses.sum() == pytest.approx(body.body_mass, rel=1e-14)
    assert found.slider.mass == body.slider_mass
    assert abs(masses @ places) < 1e-15
    inertia = (masses * np.abs(places) ** 2).sum() + found.body.moment
    assert inertia == pytest.approx(body.inertia, rel=1e-13)
    assert found.body.moment > 0.24 * body.inertia
    assert foot_mass(body) == parts[-1].mass


def test_solver_iterations():
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


def test_a_start_in_the_middle_of_a_turn_has_no_jerk():
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
