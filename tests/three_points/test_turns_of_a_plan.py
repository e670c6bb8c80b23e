"""How a plan divides its heading into turns: any mass ratio, turns that miss, ties, refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.systems.planner import turns
from plumbob.analytic.systems.planner.construction import plan
from plumbob.analytic.systems.planner.problem import FULL_CIRCLE, Limits, RestPose
from plumbob.analytic.systems.planner.tracks import ROUND, Track
from plumbob.analytic.systems.planner.turns import computed_turn, turns_to
from plumbob.tests.support.random_capsules import CHECK

REACHED = 1e-11  # the plan is exact: the errors of the reference remain
HEAVY = 1e3  # m/M
# m/M: the largest |w| [m/s^2], and a heading [rad] of a few turns.
RATIOS = {
    1e-3: (2e4, 1e-4),
    1e-2: (1e4, 2e-3),
    0.1: (1e3, 0.02),
    1.0: (1e3, 0.1),
    10.0: (1e3, 0.1),
    100.0: (1e3, 0.02),
    HEAVY: (1e3, 0.005),
}


@pytest.mark.long
def test_a_pose_is_reached_whatever_the_mass_ratio(request):
    """With `--profile full` at all of these, and where a slider a thousand times as heavy as the
    body turns it the wrong way from some places: the turns then are all from one place."""
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
        begins = {one.parameters["angle"] for one in made.manoeuvres if one.kind == "turn"}
        assert made.turns > len(begins) == 1
        headings = made.motion.at(np.append(0.0, made.ends)).heading
        assert np.diff(headings).min() > -1e-3


@pytest.mark.long
@pytest.mark.parametrize("wanted", [0.2, -0.2])
def test_a_turn_the_wrong_way_is_made_up_for(wanted, monkeypatch):
    """By turns from one place, where the turns after the first go the other way."""
    mirrored = []

    def mirror(track, start, swing):
        steps = start / FULL_CIRCLE * len(ROUND)
        if abs(steps - round(steps)) > 1e-9:  # not the first turn, nor one tried for its size
            mirrored.append(computed_turn(track, start, -swing))
            return mirrored[-1]
        return computed_turn(track, start, swing)

    monkeypatch.setattr(turns, "computed_turn", mirror)
    limits = Limits(stroke=0.06)
    made = turns_to(Track(CHECK, limits), wanted, 0j)
    assert mirrored[0].heading * wanted < 0.0
    assert sum(one.heading for one in made) == pytest.approx(wanted, abs=1e-12)


@pytest.mark.long
def test_a_plan_that_misses_its_pose_is_refused_by_name(monkeypatch):
    """Here nothing is near enough."""
    monkeypatch.setattr("plumbob.analytic.systems.planner.construction.CLOSED", 1e-25)
    with pytest.raises(ParameterError, match=r"to = .* a pose that a plan reaches: .* rad away"):
        plan(CHECK, RestPose(0.001, 0.0, 0.01))
