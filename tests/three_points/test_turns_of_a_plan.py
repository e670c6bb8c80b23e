"""How a plan divides its heading into turns: any mass ratio, turns that miss, ties, refusals."""

import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.systems.planner import construction, turns
from plumbob.analytic.systems.planner.construction import plan
from plumbob.analytic.systems.planner.problem import FULL_CIRCLE, Limits, RestPose
from plumbob.analytic.systems.planner.tracks import CIRCLE_PLACES, Track
from plumbob.analytic.systems.planner.turns import compute_turn, turns_to
from plumbob.tests.support.random_capsules import CHECK


@pytest.mark.long
@pytest.mark.parametrize("wanted", [0.2, -0.2])
def test_a_turn_the_wrong_way_is_made_up_for(wanted, monkeypatch):
    """By turns from one place, where the turns after the first go the other way."""
    mirrored = []

    def mirror(track, start, swing):
        steps = start / FULL_CIRCLE * len(CIRCLE_PLACES)
        if abs(steps - round(steps)) > 1e-9:  # not the first turn, nor one tried for its size
            mirrored.append(compute_turn(track, start, -swing))
            return mirrored[-1]
        return compute_turn(track, start, swing)

    monkeypatch.setattr(turns, "compute_turn", mirror)
    limits = Limits(stroke=0.06)
    made = turns_to(Track(CHECK, limits), wanted, 0j)
    assert mirrored[0].heading * wanted < 0.0
    assert sum(one.heading for one in made) == pytest.approx(wanted, abs=1e-12)


@pytest.mark.long
def test_a_plan_that_misses_its_pose_is_refused_by_name(monkeypatch):
    """Here nothing is near enough."""
    monkeypatch.setattr("plumbob.analytic.systems.planner.construction.POSE_TOLERANCE", 1e-25)
    with pytest.raises(
        ParameterError, match=r"to = .* a pose that a plan reaches: .* rad away"
    ):
        plan(CHECK, RestPose(0.001, 0.0, 0.01))


@pytest.mark.parametrize(("off", "taken"), [(1e-7, False), (1e-10, True)])
def test_a_plan_that_ends_a_tenth_of_a_micrometre_off_is_refused(off, taken, monkeypatch):
    """An ångström off it is taken: the errors of the motion are below that."""
    arranged = construction._find_manoeuvres

    def beside(track, start, goal):
        return arranged(track, start, RestPose(goal.x + off, goal.y, goal.heading))

    monkeypatch.setattr(construction, "_find_manoeuvres", beside)
    goal = RestPose(0.001, 0.0, 0.0)
    if taken:
        assert plan(CHECK, goal).error[0] == pytest.approx(off, rel=1e-3)
        return
    with pytest.raises(ParameterError, match=r"the one found ends 1e-07 m and \S+ rad away"):
        plan(CHECK, goal)
