"""The source's claims about the turning base, and the numbers that it prints."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.systems.pendulums.harmonics import harmonics_needed
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum import series
from plumbob.reports.analyses.cone_pendulum.hamiltonian import RESTING, ROTATING, forms
from plumbob.reports.analyses.cone_pendulum.source_text import NEAR, rotations
from plumbob.reports.analyses.measurements import TURN, in_double

ANGLES = 300  # at which the source's worksheet has V


def numbers(study: Study) -> Record:
    """Numbers that the claims are judged by, of the sources and the exact motions alone."""
    turning = forms(ROTATING)
    return Record(
        body=turning.problem.body,
        rotations=rotations(),
        sampled=sampled_top(),  # the largest of the printed V at the source's angles [J]
        # lowest point of the correct V on the turning platform [J]
        deepest=min(equilibrium.potential for equilibrium in turning.problem.equilibria),
        harmonics=harmonics_needed(turning.correct, series.ACCURACIES)[
            -1
        ],  # needed for the motion of Fig. 3
        harmonics_near=series.counts(1e-9 * series.barrier())[-1],  # and just above the barrier
        near=NEAR,
        angles=ANGLES,
        scene=ROTATING,
        at_rest=RESTING,
    )


def sampled_top() -> float:
    """The largest of the printed V [J] at ANGLES equally spaced angles, as the source finds the
    lower bound of the energy."""
    theta = np.arange(ANGLES) * TURN / ANGLES
    return float(in_double(forms(ROTATING).printed.potential).value(theta).max())


CLAIMS = Analysis("cone_pendulum/claims", numbers)
