"""A study of chosen pairs makes no runs of other scenes or methods for its findings."""

import pytest

from plumbob.engines.registry import methods
from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.request import RunRequest
from plumbob.models.registry import matching_scenes
from plumbob.reports.analyses import requests

CHOSEN = (
    ("capsule-line/ca1", "mujoco/euler,mujoco/euler+coulomb"),
    ("simple-pendulum/free-small", "mujoco/euler,mujoco/rk4"),
)


@pytest.mark.parametrize(("scene", "chosen"), CHOSEN)
def test_findings_that_need_other_runs_are_left_out(scene, chosen):
    plan = StudyPlan("quick", matching_scenes(scene), methods(chosen))
    every, needed = requests(plan), requests(plan, pairs_alone=True)
    others = [
        run
        for run in every
        if isinstance(run, RunRequest) and not plan.has(run.scene, run.method)
    ]
    assert others
    assert not set(others) & set(needed)
    assert set(needed) < set(every)
    # A finding of the pairs alone stays: friction identified with both methods, and replays.
    assert {"DrawingRequest"} <= {type(run).__name__ for run in needed}
    assert (scene == "capsule-line/ca1") == any(
        type(run).__name__ == "ParameterFit" for run in needed
    )
