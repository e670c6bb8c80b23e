"""The page's section on the simple pendulum: the notebook's cases, orders, energy, references."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.extra_runs import Request, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.simple_pendulum import (
    bob,
    claims,
    energy,
    exactness,
    notebook,
    orders,
    tension,
)
from plumbob.reports.view.content import Figure, Table


def requests(plan: StudyPlan) -> Sequence[Request]:
    """The runs that the findings and figures look up."""
    return (
        *notebook.requests(plan),
        *orders.requests(plan),
        *energy.requests(plan),
        *tension.requests(plan),
    )


def hard(study: Study, scene: Scene) -> Sequence[Figure | Table]:
    """Growth of errors at the top; energy over a million steps."""
    if scene.name == energy.MILLION:
        return energy.hard(study)
    if "near-top" in scene.name:
        return exactness.hard(study, scene)
    return ()


FINDINGS = (
    claims.finding,
    bob.finding,
    notebook.finding,
    orders.orders,
    orders.held_control,
    energy.finding,
    tension.finding,
    exactness.references,
    exactness.near_top,
)
SECTION = Section(FINDINGS, (notebook.galleries,), (hard,), requests)
