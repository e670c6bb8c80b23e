"""The page's section on the cone pendulum: the source's figures and claims, and its hard cases."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.cone_pendulum import (
    action_phase,
    drive_work,
    energy,
    equilibria,
    euler_order,
    generating_solution,
    hamiltonian,
    plane_engine,
    series,
    source_claims,
    source_figures,
    source_text,
    symmetry,
    uniformity,
)


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The runs that the findings, the figures and the hard cases look up."""
    return (
        *uniformity.requests(plan),
        *action_phase.requests(plan),
        *drive_work.requests(plan),
        *generating_solution.requests(plan),
        *energy.requests(plan),
    )


FINDINGS = (
    hamiltonian.PRINTED,
    symmetry.INERTIA,
    symmetry.PRODUCT_OF_INERTIA,
    source_claims.CLAIMS,
    source_text.SOURCE_TEXT,
    uniformity.finding,
    action_phase.finding,
    equilibria.EQUILIBRIA,
    drive_work.finding,
    series.finding,
    generating_solution.finding,
    plane_engine.PYMUNK_TORQUE,
    euler_order.EULER_ORDER,
    energy.finding,
)
SECTION = Section(
    FINDINGS, (source_figures.GALLERIES,), (energy.hard,), requests, source_figures.SOLVED
)
