"""A motion that is computed from one nearby is the same motion at less cost, whatever is near."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre, turn_of
from plumbob.analytic.systems.slider_path import SliderPath, fixed
from plumbob.analytic.systems.three_points import sliding
from plumbob.analytic.systems.three_points.equations import sliding_rates
from plumbob.analytic.systems.three_points.friction import Start, three_point_motion
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.tests.support.random_capsules import CHECK

NUDGED = replace(CHECK, friction=CHECK.friction * (1.0 + 1e-7))
TURN = turn_of(CHECK, 0.12, 0.3)
COAST = fixed((0.12, 0.0)), Start(velocity=(0.3, -0.2), angular_velocity=2.0)
CHEAPER = 0.5  # of the calls: measured 0.33 and 0.38
SAMPLES = 50


def turn(times_longer: float) -> SliderPath:
    """A turn with the same drive, for other times."""
    half = times_longer * TURN.half_time
    return TurnManoeuvre(CHECK, 0.12, TURN.angular_acceleration, half).path


def stretched(motion: ThreePointMotion, factor: float) -> ThreePointMotion:
    """A motion whose elements claim to be longer by a factor than they are."""
    segments = tuple(
        replace(one, solution=replace(one.solution, size=factor * one.solution.size))
        if one.solution is not None
        else one
        for one in motion.segments
    )
    return replace(motion, integrated=lambda _: segments)


def apart(one: ThreePointMotion, other: ThreePointMotion) -> float:
    """The largest difference of two motions before they rest, over the errors of the second."""
    times = np.linspace(0.0, other.rest_time, SAMPLES)[:-1]
    found, right, error = one.at(times), other.at(times), other.error
    names = ("position", "heading", "velocity", "angular_velocity")
    return max(
        float(
            np.abs(getattr(found, name) - getattr(right, name)).max() / getattr(error, name).max()
        )
        for name in names
    )


@pytest.mark.parametrize("path", [(turn(1.0), None), COAST])
def test_a_motion_from_one_nearby_costs_less(
    path: tuple[SliderPath, Start | None], monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[int] = []

    def counted(*given: Any) -> tuple[Array, Array]:
        calls.append(1)
        return sliding_rates(*given)

    monkeypatch.setattr(sliding, "sliding_rates", counted)
    near, right = (three_point_motion(body, *path) for body in (CHECK, NUDGED))
    assert near.segments
    calls.clear()
    assert right.segments
    alone = len(calls)
    beside = replace(right).beside(near)
    calls.clear()
    assert beside.segments
    assert len(calls) <= CHEAPER * alone
    assert apart(beside, right) <= 1.0
    assert apart(near, right) > 1e3


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("longer", [0.3, 1.2, 3.0])
def test_it_is_the_same_from_one_that_is_not_near(longer: float) -> None:
    right = three_point_motion(CHECK, turn(1.0))
    assert apart(right.beside(three_point_motion(CHECK, turn(longer))), right) <= 1.0


def test_elements_that_are_too_long_are_shortened(monkeypatch: pytest.MonkeyPatch) -> None:
    """And the motion is wrong where they are not."""
    right = three_point_motion(CHECK, turn(1.0))
    known = stretched(right, 1.5)
    assert apart(right.beside(known), right) <= 1.0
    monkeypatch.setattr(sliding, "LOOSER", np.inf)
    assert apart(right.beside(known), right) > 1e6
