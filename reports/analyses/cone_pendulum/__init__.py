"""The section on the cone pendulum: the source's figures and claims."""

from __future__ import annotations

from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.cone_pendulum import (
    action_phase,
    drive_work,
    equilibria,
    generating_solution,
    hamiltonian,
    series,
    source_claims,
    source_figures,
    source_text,
    symmetry,
    uniformity,
)

SECTION = Section(
    findings=(
        hamiltonian.PRINTED,
        symmetry.INERTIA,
        symmetry.PRODUCT_OF_INERTIA,
        source_claims.CLAIMS,
        source_text.SOURCE_TEXT,
        uniformity.UNIFORMITY,
        action_phase.ACTION_PHASE,
        equilibria.EQUILIBRIA,
        drive_work.DRIVE_WORK,
        series.SPECIAL_FUNCTIONS,
        generating_solution.GENERATING_SOLUTION,
    ),
    galleries=(source_figures.GALLERIES,),
)
