"""The page's section on the cone pendulum: the source's figures and claims, and its hard cases."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.results import Study
from plumbob.reports.findings.cone_pendulum import (
    claims,
    energy,
    euler_order,
    hamiltonian,
    inertia,
    saddle,
    source_figures,
)
from plumbob.reports.view.content import Figure, Finding, Section


def findings(study: Study) -> Sequence[Finding]:
    """Everything that holding the source and the engines against each other showed."""
    return (
        hamiltonian.finding(),
        inertia.finding(),
        claims.finding(),
        euler_order.finding(study),
        energy.finding(),
    )


def figures(study: Study) -> Sequence[tuple[str, Sequence[Figure]]]:
    """The source's Figs. 2 and 3, each beside the corrected one."""
    return source_figures.galleries()


SECTION = Section(findings, figures, saddle.hard)
