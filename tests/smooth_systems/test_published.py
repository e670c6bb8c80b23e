"""Values that others publish for the same problems, and who is right to how many digits."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from plumbob.analytic.errors.contact_models.impacts import hard_heights, soft_heights
from plumbob.analytic.errors.smooth_motion.stepped_system import smooth_errors
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.analytic.systems.bouncing_ball import BouncingBall
from plumbob.models.registry import case_of, scene

PUBLISHED = tomllib.loads(Path(__file__).with_name("published.toml").read_text("utf-8"))


@pytest.mark.parametrize("of", PUBLISHED["pendulum"], ids=lambda of: of["source"][:6])
def test_adams_is_right_to_its_last_digit(of):
    """Two microseconds later it is not."""
    named = {"length": of["length"], "gravity": of["gravity"], "theta": math.pi / 2}
    motion = case_of(scene("simple-pendulum/free-large", {**named, "theta_dot": 0.0})).reference
    times, *places = np.array(of["places"]).T

    def error(late):
        theta = motion.observe(times + late)["theta"]
        exact = of["radius"] * np.sin(theta), -of["radius"] * np.cos(theta)
        return np.abs(np.subtract(exact, places)).max()

    assert error(0.0) <= of["digit"] < error(2e-6)


def double_pendulum():
    """Angles from the level, downward negative, of two bodies of 1 kg, 1 m and 1 kg m^2."""

    def masses(p, q):
        coupling = np.cos(q[1] - q[0]) / 2
        return (2.25, coupling), (coupling, 1.25)

    def forces(p, time, q, v):
        turn = np.sin(q[1] - q[0]) / 2
        first = -1.5 * p.gravity * np.cos(q[0]) + turn * v[1] ** 2
        return first, -p.gravity / 2 * np.cos(q[1]) - turn * v[0] ** 2

    return masses, forces


def pendulum_on_a_slider():
    """The place of a slider of 1 kg on a spring of 10 N/m, and the angle of such a body on it."""

    def masses(p, q):
        coupling = -np.sin(q[1]) / 2
        return (2.0, coupling), (coupling, 1.25)

    def forces(p, time, q, v):
        return np.cos(q[1]) / 2 * v[1] ** 2 - p.stiffness * q[0], -p.gravity / 2 * np.cos(q[1])

    return masses, forces


@pytest.mark.long
@pytest.mark.parametrize("of", PUBLISHED["euler"], ids=lambda of: of["system"])
def test_what_chrono_takes_for_exact_has_the_error_of_its_steps(of):
    """Its tolerance is above that; the certified motion is known ten digits further."""
    masses, forces = globals()[of["system"].replace(" ", "_")]()
    names = ("a", "b"), ("a_dot", "b_dot")
    system = SmoothSystem(
        *names, masses, forces, {"gravity": 10.0, "stiffness": 10.0}, (0.0, 0.0), (0.0, 0.0)
    )
    motion = CertifiedMotion(system)
    times = np.linspace(0.0, of["duration"], 11)[1:]
    errors = smooth_errors(motion).at_step(Scheme(EULER), of["step"], times).errors
    largest = max(np.abs(errors[name]).max() for name in names[0])
    assert 0.02 * of["step"] < largest < min(of["tolerance"], 50 * of["step"])
    doubts = motion.uncertainty(times)
    assert max(doubts[name].max() for name in names[0]) < 1e-8 * largest


@pytest.mark.parametrize("of", PUBLISHED["rebound"], ids=lambda of: of["source"][:6])
def test_a_rebound_of_newton_is_less_wrong_than_mujoco_s_at_its_step(of):
    ball = BouncingBall(1.0, 0.5, 9.81)
    exact = float(ball.impacts(np.array([1.0]))[1][0])
    assert exact == of["exact"]
    marks = list(range(round(ball.fall / of["step"]) + 20, 700))
    mujoco = soft_heights(ball, Scheme(EULER), of["step"], marks).max() - exact
    pymunk = hard_heights(ball, of["step"], marks).max() - exact
    assert -0.004 < pymunk < 0.0 < of["measured"] - exact - of["digit"] < mujoco < 0.016
