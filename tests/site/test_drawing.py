"""The pages of a study are the same for any number of processes that draw them."""

from __future__ import annotations

import multiprocessing
import os
from dataclasses import replace

import pytest

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.results import Study
from plumbob.reports.findings import section
from plumbob.reports.view.content import Finding, Section
from plumbob.reports.view.site import drawing
from plumbob.reports.view.site.views import Sections
from plumbob.reports.view.site.writing import content, one_file
from plumbob.tests.support.declared import measured
from plumbob.tests.support.studies import SCENE, made_up


def other_in_workers(system: str) -> Section | None:
    """What there is to say of a system, and nothing in a process that another one began."""
    return None if multiprocessing.parent_process() else section(system)


def sums(system: str) -> Section:
    """A finding about a system that reads its runs."""

    def finding(study: Study) -> Finding:
        own = [c for c in study.convergence if c.scene.startswith(f"{system}/")]
        steps = sum(m.steps for c in own for m in c.measurements)
        return Finding(f"steps-of-{system}", "Steps", "measured", f"{steps} steps.")

    return Section((finding,))


def deadly(system: str) -> Section | None:
    """Nothing to say, and the end of a process that another one began."""
    if multiprocessing.parent_process():
        os._exit(1)
    return None


@pytest.fixture(autouse=True)
def _few_are_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawing, "MANY", 1)


@pytest.mark.long
def test_two_processes_draw_the_same_bytes() -> None:
    one, two, three = (
        measured(scene, ("ode/rk4", "ode/leapfrog"), 1e-2)
        for scene in ("linear-pendulum/overdamped", "simple-pendulum/free-small", SCENE)
    )
    study = replace(
        one,
        scenes=one.scenes + two.scenes + three.scenes,
        convergence=one.convergence + two.convergence + three.convergence,
    )
    page = _page(study, sums, 2)
    assert page == _page(study, sums, 1)
    assert "steps-of-cone-pendulum" in page


@pytest.mark.long
def test_sensitivity_to_who_draws() -> None:
    """A process that says something else makes other pages: it is the workers that draw."""
    study = made_up([(find_method("ode/rk4"), (1e-3, 1e-4), lambda h: h)])
    assert _page(study, other_in_workers, 2) == _page(study, lambda name: None, 1)


@pytest.mark.long
def test_what_a_process_does_not_draw_another_does() -> None:
    study = made_up([(find_method("ode/rk4"), (1e-3, 1e-4), lambda h: h)])
    assert _page(study, deadly, 2) == _page(study, lambda name: None, 1)


def _page(study: Study, says: Sections, jobs: int) -> str:
    return one_file(content(study, says, jobs=jobs))
