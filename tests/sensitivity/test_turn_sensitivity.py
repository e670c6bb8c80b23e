"""Small mistakes in a turn manoeuvre are detected, in its formulas and in its exact motion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.manoeuvres import turn_correction as theory
from plumbob.analytic.systems.manoeuvres.turn_correction import leading_friction
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre, turn_of
from plumbob.analytic.systems.three_points import sliding as sliding_module
from plumbob.analytic.systems.three_points.equations import (
    Complex,
    Configuration,
    Mechanics,
    cross,
    sliding_rates,
    support_velocities,
)
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.tests.support.random_capsules import CHECK
from plumbob.tests.support.random_slides import moved_support, pose


def turned(turn: TurnManoeuvre) -> float:
    """The exact heading at 2 tau [rad]."""
    return float(pose(three_point_motion(turn.capsule, turn.path), 2 * turn.half_time)[2])


@pytest.mark.parametrize(
    "wrong",
    [replace(CHECK, friction=CHECK.friction * (1 + 1e-4)), moved_support(CHECK, 1e-4)],
)
def test_sensitivity_of_the_check_values(wrong: Capsule) -> None:
    """1e-4 of the friction, or of a support's arm, is detected at 1e-8."""
    turn = turn_of(CHECK, 0.12, 0.1)
    other = TurnManoeuvre(wrong, 0.12, turn.angular_acceleration, turn.half_time)
    assert abs(turned(other) - turned(turn)) > 1e-8
    coefficient = turn.correction.at_stop.heading
    assert abs(other.correction.at_stop.heading / coefficient - 1) > 5e-6


def test_sensitivity_to_the_moment_about_the_combined_centre(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With CA_i for CA_i - mu r in eq. 25 the coefficient changes."""
    turn = turn_of(CHECK, 0.12, 0.1)
    right = turn.characteristic_time**2 * turn.correction.at_stop.heading

    def about_com(
        capsule: Capsule, radius: float, slider_angles: Array, sense: float
    ) -> tuple[Complex, Array]:
        force, moment = leading_friction(capsule, radius, slider_angles, sense)
        r = radius * np.exp(1j * slider_angles)
        return force, moment + capsule.mass_ratio * (r.conjugate() * force).imag

    monkeypatch.setattr(theory, "leading_friction", about_com)
    wrong = theory.turn_correction(CHECK, 0.12, turn.slider_angle).at_stop.heading
    assert abs(turn.characteristic_time**2 * wrong - right) > 0.1


def test_sensitivity_to_the_moments_in_the_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same in eq. 23: the exact motion changes and no longer agrees with the formula."""
    turn = turn_of(CHECK, 0.12, 0.1)
    right = turned(turn)

    def about_com(
        body: Mechanics, at: Configuration, state: Array, *rest: Any
    ) -> tuple[Array, Array]:
        rates, derivative = sliding_rates(body, at, state, *rest)
        sliding = support_velocities(at, state[:, 0] + 1j * state[:, 1], state[:, 2])
        push = -(at.limits * sliding / np.abs(sliding)).sum(axis=1)
        extra = cross(body.mass_ratio * at.position, push) / at.inertia
        rates[:, 2] += extra * rates[:, 3]  # the last rate is that of time
        return rates, derivative

    monkeypatch.setattr(sliding_module, "sliding_rates", about_com)
    assert abs(turned(turn) - right) > 1e-4
