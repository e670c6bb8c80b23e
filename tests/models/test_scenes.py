"""Scenes have the parameters that their names, their summaries and their sources state."""

import math

import numpy as np
import pytest

from plumbob.models.registry import case_of, matching_scenes, scene, system_of
from plumbob.models.scene import SMOOTH as KIND
from plumbob.models.scene import step_sizes

CASES = {  # of the notebook: start [deg], speed there [deg/s], damping [1/s]
    "free-small": (-10, 0, 0.0),
    "free-large": (-120, 0, 0.0),
    "rotating-slow": (-120, 200, 0.0),
    "rotating-fast": (-120, 500, 0.0),
    "damped-small": (-10, 0, 0.08),
    "damped-large": (-120, 0, 0.08),
    "damped-rotating": (-120, 500, 0.2),
}


def test_steps_are_one_two_and_five_times_powers_of_ten():
    assert step_sizes(1e-2, 1e-3) == (1e-2, 5e-3, 2e-3, 1e-3)
    assert step_sizes(2e-3, 2e-5) == (2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("system", ["simple-pendulum", "linear-pendulum"])
def test_cases_of_the_notebook(system, name):
    problem = case_of(scene(f"{system}/{name}")).problem
    theta, theta_dot, damping = CASES[name]
    assert problem.theta == pytest.approx(math.radians(theta), rel=1e-15)
    assert problem.theta_dot == pytest.approx(math.radians(theta_dot), rel=1e-15)
    assert problem.damping_rate == damping
    assert problem.forcing_amplitude == 0.0


@pytest.mark.parametrize("system", ["simple-pendulum", "linear-pendulum"])
def test_the_chaotic_pendulum_is_the_textbooks(system):
    # g = L, damping 1/2, amplitude 3/2, frequency 2/3: Baker and Gollub, Chaotic Dynamics
    problem = case_of(scene(f"{system}/forced-chaotic")).problem
    assert problem.gravity == problem.length
    given = (problem.damping_rate, problem.forcing_amplitude, problem.forcing_frequency)
    assert given == (0.5, 1.5, 2 / 3)


def test_headings_are_those_of_their_names():
    found = matching_scenes("capsule-line/heading-*")
    assert [s.name.partition("heading-")[2] for s in found] == [
        f"{angle:03d}" for angle in range(0, 360, 15)
    ]
    for one in found:
        angle = float(one.name.partition("heading-")[2])
        assert one.parameters["heading"] == pytest.approx(math.radians(angle), rel=1e-15)


@pytest.mark.parametrize(
    ("name", "x"), [("near-edge", -0.1), ("near-vertex", 0.2)], ids=["edge", "vertex"]
)
def test_the_combined_centre_ends_a_tenth_of_a_millimetre_inside(name, x):
    line = case_of(scene(f"capsule-line/{name}")).problem.motion
    centre = line.capsule.mass_ratio * (line.start + line.stroke) * line.unit
    assert centre == pytest.approx([math.copysign(abs(x) - 1e-4, x), 0.0], abs=1e-12)


@pytest.mark.parametrize("name", ["pitchfork", "pitchfork-small"])
def test_the_platform_turns_at_the_pitchfork_s_rate(name):
    problem = case_of(scene(f"cone-pendulum/{name}")).problem
    assert problem.platform_rate == pytest.approx(problem.pitchfork_rate, rel=1e-14)


@pytest.mark.parametrize("fraction", [0.5, 0.999])
def test_the_force_in_the_facts_is_the_one_that_friction_holds(fraction):
    case = case_of(scene(f"capsule-hold/{fraction}"))
    facts = case.system.facts(case.problem)
    held = case.reference.observe(np.zeros(1))
    assert facts["force"] == pytest.approx(-held["friction_force"][0], rel=1e-14)
    pressed = sum(held[f"normal_force_{i}"][0] for i in (1, 2, 3))
    assert facts["force"] / pressed == pytest.approx(0.3 * fraction, rel=1e-12)


SMOOTH = (
    "cone-pendulum/rotating-base",
    "cone-pendulum/both-wells",
    "simple-pendulum/free-large",
    "linear-pendulum/free-large",
    "capsule-line/ca1",
    "capsule-line/frictionless",
    "capsule-coast/translation",
    "capsule-coast/rotation",
    *(
        s.name
        for s in matching_scenes("*")
        if s.system == "free-body" or system_of(s).kind == KIND
    ),
)


@pytest.mark.long(keep=12)
@pytest.mark.parametrize("name", dict.fromkeys(SMOOTH))
def test_invariants_hold_on_the_exact_motion(name):
    case = case_of(scene(name))
    seen = case.reference.observe(np.linspace(0.0, case.scene.duration, 501))
    drifts = case.system.invariants(case.problem, seen)
    assert drifts
    assert all(np.abs(drift).max() < 1e-11 for drift in drifts.values())


def test_a_free_body_neither_gains_nor_loses_energy():
    # The combined centre moves straight on, and C goes round it, with the slider at (x, y) from C.
    x = 0.03
    y = 0.06
    rate = 6.0
    angle = np.linspace(0.0, 5.0, 101)
    case = case_of(scene("capsule-coast/spin", {"slider": (x, y)}))
    lever = rate * case.problem.setup.capsule.mass_ratio
    seen = {
        "velocity_x": 0.4 + lever * (x * np.sin(angle) + y * np.cos(angle)),
        "velocity_y": 0.2 - lever * (x * np.cos(angle) - y * np.sin(angle)),
        "heading": angle,
        "heading_rate": np.full(101, rate),
    }
    for sign in (1, -1):  # what is lost forwards is gained backwards
        course = {name: values[::sign] for name, values in seen.items()}
        (gained,) = case.system.invariants(case.problem, course).values()
        assert np.abs(gained).max() < 1e-14


@pytest.mark.parametrize(
    ("name", "wells"), [("deep-well", 1), ("shallow-well", 1), ("both-wells", 2)]
)
def test_a_libration_is_over_as_many_wells_as_it_says(name, wells):
    case = case_of(scene(f"cone-pendulum/{name}"))
    theta = case.reference.observe(np.linspace(0.0, case.problem.motion.period, 1001))["theta"]
    stable = sorted(
        (e for e in case.problem.equilibria if e.kind == "centre"), key=lambda e: e.potential
    )
    within = [theta.min() < e.theta < theta.max() for e in stable]
    assert sum(within) == wells
    assert within[1 if name == "shallow-well" else 0]
