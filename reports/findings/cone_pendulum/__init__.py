"""The page's section on the cone pendulum: the source's figures and claims, and its hard cases."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.findings.cone_pendulum import (
    action_phase,
    drive_work,
    energy,
    equilibria,
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
from plumbob.reports.view.content import Finding, Section


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The runs that the findings, the figures and the hard cases look up."""
    return (
        *source_figures.requests(plan),
        *hamiltonian.requests(plan),
        *source_claims.requests(plan),
        *symmetry.requests(plan),
        *uniformity.requests(plan),
        *action_phase.requests(plan),
        *equilibria.requests(plan),
        *drive_work.requests(plan),
        *generating_solution.requests(plan),
        *plane_engine.requests(plan),
        *energy.requests(plan),
    )


def findings(study: Study) -> Sequence[Finding]:
    """What comparing the source and the engines showed."""
    return (
        hamiltonian.finding(study),
        source_claims.inertia(study),
        symmetry.finding(study),
        source_claims.claims(),
        source_text.finding(),
        uniformity.finding(study),
        action_phase.finding(study),
        equilibria.finding(study),
        drive_work.finding(study),
        series.finding(study),
        generating_solution.finding(study),
        plane_engine.finding(study),
        source_claims.euler_order(study),
        energy.finding(study),
    )


SECTION = Section(findings, source_figures.galleries, energy.hard, requests, source_figures.solved)
