"""Pages and numbers are the same for any number of processes that work them out."""

from dataclasses import replace

import pytest

from plumbob import reports
from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.reports.analyses import analyses_of, requests
from plumbob.reports.view.site.writing import render
from plumbob.tests.support.declared import made, measured
from plumbob.tests.support.studies import SCENE


@pytest.mark.long
def test_two_processes_work_out_the_same_pages(monkeypatch):
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
    pages = [render(replace(study, analyses=analyses)) for analyses in (one, two)]
    assert pages[0] == pages[1]
