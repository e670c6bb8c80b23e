"""Plans reach their poses, exactly and in engines."""

from __future__ import annotations

import pytest

from plumbob.reports.analyses.capsule_plan import legs, open_loop, poses
from plumbob.reports.analyses.capsule_plan.plans import SHOWN, plan_of
from plumbob.tests.support.declared import declared, finding, measured, nothing

FEET = "pymunk/feet"


@pytest.mark.long
def test_plans(monkeypatch):
    monkeypatch.setattr(open_loop, "QUICK", (FEET,))
    ran = declared(measured(SHOWN, (FEET,)), open_loop.requests)
    reached = poses.numbers(ran)
    assert reached
    assert reached.worst < 1e-6
    ended = open_loop.numbers(ran)
    assert ended
    for run in ended.runs:
        assert run.end.distance < 2e-4
        assert run.parts["slow"].distance < 1e-4 * run.end.distance
    assert len(finding(open_loop.OPEN_LOOP, ran).figures) == 2
    assert poses.POSES.numbers(nothing()) is None


@pytest.mark.long
def test_plans_along_any_two_lines(monkeypatch):
    monkeypatch.setattr(open_loop, "QUICK", (FEET,))
    shown = legs.SCENES[1]
    ran = declared(measured(shown, (FEET,)), legs.requests)
    found = legs.numbers(ran)
    assert found
    assert len({(along.plan.legs, along.plan.arc) for along in found.curves}) == 9
    assert found.worst < 1e-12
    assert [run.method for run in found.runs] == [*legs.METHODS] * 3
    for run in found.runs:
        assert run.end.distance < 5e-4
        # Euler's leak in a turn
        assert abs(run.end.heading) < (5e-4 if run.method == FEET else 5e-3)
    command = finding(legs.LEGS, ran).commands[0]
    assert command.endswith("--track curve --set 'legs=[2, 3]' --arc longer")
    # the quick profile's curve is one of these
    assert plan_of(shown).duration == pytest.approx(legs.plans()[3].duration, rel=1e-12)
    assert legs.numbers(nothing()) is None
