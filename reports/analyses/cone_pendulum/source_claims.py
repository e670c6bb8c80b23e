"""The source's claims about the turning base, and the numbers that the source prints."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.systems.pendulums.harmonics import harmonics_needed
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum import series
from plumbob.reports.analyses.cone_pendulum.hamiltonian import RESTING, ROTATING, closed_forms
from plumbob.reports.analyses.cone_pendulum.source_text import NEAR, rotations
from plumbob.reports.analyses.measurements import TURN, in_double

ANGLES = 300  # number of angles at which the source's worksheet evaluates V


def numbers(study: Study) -> Record:
    """Returns the numbers that judge the claims. They follow from the source and the exact motions
    and need no runs."""
    turning = closed_forms(ROTATING)
    just_above = series.harmonics_near_barrier(1e-9 * series.barrier_height())
    return Record(
        body=turning.problem.body,
        rotations=rotations(),
        # [J] largest value of the printed V at the source's angles
        sampled=largest_sampled_potential(),
        # [J] minimum of the correct V on the turning platform
        deepest=min(equilibrium.potential for equilibrium in turning.problem.equilibria),
        # numbers of harmonics for the motion of Fig. 3, and just above the barrier
        harmonics=harmonics_needed(turning.correct, series.ACCURACIES)[-1],
        harmonics_near=just_above[-1],
        near=NEAR,
        angles=ANGLES,
        scene=ROTATING,
        at_rest=RESTING,
    )


def largest_sampled_potential() -> float:
    """Returns the largest value of the printed V [J] at ANGLES equally spaced angles. The source
    takes this value as the smallest energy with which the pendulum rotates."""
    theta = np.arange(ANGLES) * TURN / ANGLES
    return float(in_double(closed_forms(ROTATING).printed.potential).value(theta).max())


CLAIMS = Analysis("cone_pendulum/claims", numbers)
