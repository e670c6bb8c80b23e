"""The page's section on the simple pendulum: the notebook's cases, orders, energy, references."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.extra_runs import Request, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.findings.simple_pendulum import (
    bob,
    claims,
    energy,
    exactness,
    notebook,
    orders,
    tension,
)
from plumbob.reports.view.content import Figure, Finding, Section, Table


def requests(plan: StudyPlan) -> Sequence[Request]:
    """The runs that the findings and figures look up."""
    return (
        *notebook.requests(plan),
        *orders.requests(plan),
        *energy.requests(plan),
        *tension.requests(plan),
    )


def findings(study: Study) -> Sequence[Finding]:
    """What comparing the notebook and the engines showed."""
    found = (
        claims.finding(study),
        bob.finding(study),
        notebook.finding(study),
        orders.orders(study),
        orders.held_control(study),
        energy.finding(study),
        tension.finding(study),
        exactness.references(study),
        exactness.near_top(),
    )
    return [one for one in found if one is not None]


def hard(study: Study, scene: Scene) -> Sequence[Figure | Table]:
    """Growth of errors at the top; energy over a million steps."""
    if scene.name == energy.MILLION:
        return energy.hard(study)
    if "near-top" in scene.name:
        return exactness.hard(study, scene)
    return ()


SECTION = Section(findings, notebook.galleries, hard, requests)
