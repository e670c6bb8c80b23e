"""Pages and numbers are the same for any number of processes that work them out."""

from __future__ import annotations

from dataclasses import replace

import pytest

from plumbob import reports
from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses import analyses_of, requests
from plumbob.reports.view.site import drawing
from plumbob.reports.view.site.writing import content, one_file
from plumbob.tests.support.declared import made, measured
from plumbob.tests.support.studies import SCENE


@pytest.mark.long
def test_two_processes_work_out_the_same_pages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawing, "MANY", 1)
    monkeypatch.setattr(reports.analyses, "MANY", 1)
    studies = [
        measured(scene, ("ode/rk4", "ode/leapfrog"), 1e-2)
        for scene in ("linear-pendulum/overdamped", "simple-pendulum/free-small", SCENE)
    ]
    scenes = tuple(scene for study in studies for scene in study.scenes)
    convergence = tuple(c for study in studies for c in study.convergence)
    plan = StudyPlan("quick", scenes, studies[0].methods)
    extras = {request: made(request) for request in requests(plan)}
    study = replace(studies[0], scenes=scenes, convergence=convergence, extras=extras)
    one, two = (analyses_of(study, jobs) for jobs in (1, 2))
    assert one
    assert _page(replace(study, analyses=two), 2) == _page(replace(study, analyses=one), 1)


def _page(study: Study, jobs: int) -> str:
    return one_file(content(study, jobs=jobs))
