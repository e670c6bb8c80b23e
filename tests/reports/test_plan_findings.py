"""Plans reach their poses, exactly and in engines."""

import pytest

from plumbob.reports.analyses.capsule_plan import open_loop, poses
from plumbob.reports.records.exact_numbers import exact_numbers_of
from plumbob.tests.support.declared import declared, finding, measured

FEET, PLAN = "pymunk/feet", "capsule-plan/near-free"


@pytest.mark.long
def test_plans(monkeypatch):
    monkeypatch.setattr(open_loop, "QUICK", (FEET,))
    ran = declared(measured(PLAN, (FEET,)), open_loop.runs)
    ended = open_loop.numbers(ran)
    for run in ended.runs:
        assert run.end["distance"] < 2e-4
        assert run.parts["slow"]["distance"] < 1e-4 * run.end["distance"]
    assert "from turns [m]" in finding(open_loop.OPEN_LOOP, ran).tables[0].heads
    reached = exact_numbers_of(poses.GOAL_POSES_FINDING.template).numbers
    assert PLAN in reached["plans"]
    assert reached["worst"] < 1e-6
