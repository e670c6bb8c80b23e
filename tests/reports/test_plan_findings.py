"""Plans reach their poses, exactly and in engines."""

import pytest

from plumbob.reports.analyses.capsule_plan import legs, open_loop, poses
from plumbob.reports.analyses.capsule_plan.plans import plan_of
from plumbob.tests.support.declared import declared, finding, measured, nothing

FEET, PLAN = "pymunk/feet", "capsule-plan/near-free"


@pytest.mark.long
def test_plans(monkeypatch):
    monkeypatch.setattr(open_loop, "QUICK", (FEET,))
    ran = declared(measured(PLAN, (FEET,)), open_loop.runs)
    reached = poses.numbers(ran)
    assert reached.worst < 1e-6
    ended = open_loop.numbers(ran)
    for run in ended.runs:
        assert run.end["distance"] < 2e-4
        assert run.parts["slow"]["distance"] < 1e-4 * run.end["distance"]
    assert "from turns [m]" in finding(open_loop.OPEN_LOOP, ran).tables[0].heads
    assert poses.POSES.numbers(nothing()) is None


@pytest.mark.long
def test_plans_along_any_two_lines():
    shown = legs.SCENES[1]
    ran = measured(shown, (FEET,))
    found = legs.numbers(ran)
    assert len({(along.plan.legs, along.plan.arc) for along in found.curves}) == 9
    assert found.worst < 1e-12
    command = finding(legs.LEGS, ran).commands[0]
    assert command.endswith("--track curve --set 'legs=[2, 3]' --arc longer")
    # the quick profile's curve is one of these
    assert plan_of(shown).duration == pytest.approx(legs.plans()[3].duration, rel=1e-12)
    assert legs.numbers(nothing()) is None
