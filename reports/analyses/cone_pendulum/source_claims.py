"""The source's claims about the turning base, and the numbers that the source prints."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.systems.pendulums.harmonics import harmonics_needed
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum import series
from plumbob.reports.analyses.cone_pendulum.hamiltonian import RESTING, ROTATING, closed_forms
from plumbob.reports.analyses.cone_pendulum.source_text import SPEED_DIFFERENCES, rotations
from plumbob.reports.analyses.measurements import FULL_TURN, in_double

WORKSHEET_ANGLES = 300  # number of angles at which the source's worksheet evaluates V


def numbers() -> Record:
    """Returns the numbers that judge the claims, by the source and by the exact motions."""
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
        near=SPEED_DIFFERENCES,
        angles=WORKSHEET_ANGLES,
        scene=ROTATING,
        at_rest=RESTING,
    )


def largest_sampled_potential() -> float:
    """Returns the largest value of the printed V [J] at WORKSHEET_ANGLES equally spaced angles. The
    source takes this value as the smallest energy with which the pendulum rotates."""
    theta = np.arange(WORKSHEET_ANGLES) * FULL_TURN / WORKSHEET_ANGLES
    return float(in_double(closed_forms(ROTATING).printed.potential).value(theta).max())


CONE_CLAIMS = Analysis("cone_pendulum/claims", exact=numbers)
