"""How a plan divides its heading into turns: any mass ratio, turns that miss, ties, refusals."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.planner.problem import Limits, RestPose
from plumbob.analytic.systems.planner.schedule import first_of_least, turns
from plumbob.analytic.systems.planner.search import plan
from plumbob.analytic.systems.planner.tracks import FreePlane
from plumbob.analytic.systems.planner.turns import Outcome, outcome, quickest_drive
from plumbob.analytic.systems.three_points.equations import Complex
from plumbob.tests.support.random_capsules import CHECK

REACHED = 1e-11  # the plan is exact: the errors of the reference remain
HEAVY = 1e3  # m/M
# m/M: the largest |w| [m/s^2], and a heading [rad] of a few turns.
RATIOS = {
    1e-3: (2e4, 1e-4), 1e-2: (1e4, 2e-3), 0.1: (1e3, 0.02), 1.0: (1e3, 0.1), 10.0: (1e3, 0.1),
    100.0: (1e3, 0.02), HEAVY: (1e3, 0.005),
}  # fmt: skip


@pytest.mark.long
def test_a_pose_is_reached_whatever_the_mass_ratio(request: pytest.FixtureRequest) -> None:
    """With `--profile full` at all of these, and where a slider a thousand times as heavy as the
    body turns it the wrong way with one of twenty turns, which depends on where a turn begins."""
    full = request.config.getoption("--profile") == "full"
    for ratio, (acceleration, heading) in RATIOS.items():
        if full or ratio == HEAVY:
            limits = Limits(acceleration=acceleration, radius=0.05)
            made = plan(replace(CHECK, slider_mass=ratio), RestPose(0.0, 0.0, heading), limits)
            assert max(made.error) <= REACHED, ratio
    if full:
        body = replace(CHECK, slider_mass=HEAVY)
        made = plan(body, RestPose(0.01, 0.01, 0.1), Limits(radius=0.05))
        assert max(made.error) <= REACHED
        headings = made.motion.at(np.append(0.0, made.ends)).heading
        assert np.diff(headings).min() < -1e-3


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_turn_the_wrong_way_is_made_up_for(sense: float, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Outcome] = []

    def mirrored(*given: Any) -> Outcome:
        """What is asked for, but the first turn goes the other way."""
        *where, swing, drive = given
        asked.append(outcome(*where, swing if asked else -swing, drive))
        return asked[-1]

    monkeypatch.setattr("plumbob.analytic.systems.planner.schedule.outcome", mirrored)
    limits, wanted = Limits(stroke=0.06), 0.2
    circle = FreePlane(CHECK, limits).circle(sense, returning=False)

    def no_time(displacements: Complex) -> Array:
        return np.zeros(displacements.size)

    drive = quickest_drive(limits)
    made = tuple(turns(CHECK, limits, circle, drive, wanted, 0j, no_time))
    assert made[0].heading * sense > 0.05
    assert -sense * sum(one.heading for one in made) == pytest.approx(wanted, abs=1e-12)


def test_turns_that_do_not_end_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(capsule: Capsule, radius: float, start: float, swing: float, drive: float) -> Outcome:
        return replace(outcome(capsule, radius, start, swing, drive), heading=0.0)

    monkeypatch.setattr("plumbob.analytic.systems.planner.schedule.outcome", none)
    with pytest.raises(ParameterError, match=r"^manoeuvres = 5: "):
        plan(CHECK, RestPose(0.0, 0.0, 0.2), Limits(stroke=0.06, manoeuvres=5))


@pytest.mark.long
def test_a_plan_that_misses_its_pose_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here nothing is near enough."""
    monkeypatch.setattr("plumbob.analytic.systems.planner.search.CLOSED", 1e-25)
    with pytest.raises(ParameterError, match=r"to = .* a pose that a plan reaches: .* rad away"):
        plan(CHECK, RestPose(0.001, 0.0, 0.01))


@pytest.mark.parametrize("times", [(2.0, 1.0 + 1e-15, 1.0), (2.0, 1.0, 1.0 + 1e-15)])
def test_rounding_decides_between_no_choices(times: tuple[float, ...]) -> None:
    """As two turns, the second of no size, take the time of one."""
    assert times.index(first_of_least(times, lambda time: time)) == 1
    assert first_of_least((1.0 + 1e-9, 1.0), lambda time: time) == 1.0
