"""The source's claims about the turning base, and the numbers that it prints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.systems.cone_pendulum import Body
from plumbob.analytic.systems.pendulums.harmonics import needed
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.cone_pendulum import series
from plumbob.reports.analyses.cone_pendulum.hamiltonian import RESTING, ROTATING, forms
from plumbob.reports.analyses.cone_pendulum.source_text import NEAR, Rotation, rotations
from plumbob.reports.analyses.energy_drift import in_double
from plumbob.reports.analyses.measurements import TURN

ANGLES = 300  # at which the source's worksheet has V


@dataclass(frozen=True)
class SourceClaims:
    """Numbers that the source's claims are judged by."""

    body: Body
    rotations: Mapping[str, Rotation]
    sampled: float  # the largest of the printed V at the source's angles [J]
    deepest: float  # lowest point of the correct V on the turning platform [J]
    harmonics: int  # needed for the motion of Fig. 3
    harmonics_near: int  # and just above the barrier
    near: tuple[float, ...] = NEAR
    angles: int = ANGLES
    scene: str = ROTATING
    at_rest: str = RESTING


def numbers(study: Study) -> SourceClaims:
    """Numbers that the claims are judged by, of the sources and the exact motions alone."""
    turning = forms(ROTATING)
    return SourceClaims(
        turning.problem.body,
        rotations(),
        sampled_top(),
        min(equilibrium.potential for equilibrium in turning.problem.equilibria),
        needed(turning.correct, series.ACCURACIES)[-1],
        series.counts(1e-9 * series.barrier())[-1],
    )


def sampled_top() -> float:
    """The largest of the printed V [J] at ANGLES equally spaced angles, as the source finds the
    lower bound of the energy."""
    theta = np.arange(ANGLES) * TURN / ANGLES
    return float(in_double(forms(ROTATING).printed.potential).value(theta).max())


CLAIMS = Analysis("cone_pendulum/claims", numbers)
