"""The page's section on the simple pendulum: the notebook's cases, orders, energy, references."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.extra_runs import Request, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.simple_pendulum import energy, exactness
from plumbob.reports.analyses.simple_pendulum.bob import BOB
from plumbob.reports.analyses.simple_pendulum.claims import CLAIMS
from plumbob.reports.analyses.simple_pendulum.notebook import CASE_MOTIONS, RK4
from plumbob.reports.analyses.simple_pendulum.orders import HELD_CONTROL, ORDERS
from plumbob.reports.analyses.simple_pendulum.tension import TENSION
from plumbob.reports.view.content import Figure, Table


def requests(plan: StudyPlan) -> Sequence[Request]:
    """The runs that the findings and figures look up."""
    return energy.requests(plan)


def hard(study: Study, scene: Scene) -> Sequence[Figure | Table]:
    """Growth of errors at the top; energy over a million steps."""
    if scene.name == energy.MILLION:
        return energy.hard(study)
    if "near-top" in scene.name:
        return exactness.hard(study, scene)
    return ()


FINDINGS = (
    CLAIMS,
    BOB,
    RK4,
    ORDERS,
    HELD_CONTROL,
    energy.finding,
    TENSION,
    exactness.references,
    exactness.near_top,
)
SECTION = Section(FINDINGS, (CASE_MOTIONS,), (hard,), requests)
