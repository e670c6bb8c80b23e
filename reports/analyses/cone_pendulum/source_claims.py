"""The source's claims about the turning base, and the numbers that it prints."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.cone_pendulum import Body
from plumbob.analytic.systems.pendulums.harmonics import needed
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.cone_pendulum import series
from plumbob.reports.analyses.cone_pendulum.hamiltonian import RESTING, ROTATING, forms
from plumbob.reports.analyses.energy_drift import in_double
from plumbob.reports.analyses.measurements import extremes

NEAR = (0.05, 0.10)  # of the initial speed
PARTS = 201  # of a period, among which every extreme of the speed has several
ANGLES = 300  # at which the source's worksheet has V
SAMPLES = 20_000  # over a period: fractions of it to four digits


@dataclass(frozen=True)
class Speeds:
    """How uniform a rotation is: its speeds over one period, relative to the initial one."""

    start: float  # [rad/s]
    lowest: float
    highest: float
    near: tuple[float, ...]  # fractions of the period within each of NEAR of the initial speed

    @property
    def spread(self) -> float:
        """Range of the speeds over the initial one."""
        return (self.highest - self.lowest) / abs(self.start)


@dataclass(frozen=True)
class Barriers:
    """Energies [J] of the motions of Figs. 2 and 3."""

    resting: float  # barrier on the platform at rest
    turning: float  # and on the turning one
    printed: float  # top of the printed V
    sampled: float  # the largest of it at the source's angles
    deepest: float  # lowest point of the correct V on the turning platform
    resting_start: float  # energy at the start
    turning_start: float


@dataclass(frozen=True)
class SourceClaims:
    """What the source's claims are judged by."""

    body: Body
    energies: Barriers
    resting: Speeds  # of Fig. 2
    turning: Speeds  # of Fig. 3
    printed: Speeds  # of Fig. 3, by the printed formulas
    level: Speeds  # from the start of Fig. 3, on a platform at rest
    period: float  # [s], of Fig. 3
    harmonics: int  # needed for the motion of Fig. 3
    harmonics_near: int  # and just above the barrier
    near: tuple[float, ...] = NEAR
    angles: int = ANGLES
    scene: str = ROTATING
    at_rest: str = RESTING

    @property
    def stays_near(self) -> bool:
        """Whether the speed stays near its initial value for about half of the period."""
        return self.turning.near[0] >= 0.4


def numbers(study: Study) -> SourceClaims:
    """What the claims are judged by, of the sources and the exact motions alone."""
    resting, turning = forms(RESTING), forms(ROTATING)
    level = replace(turning.problem, platform_rate=0.0)
    energies = Barriers(
        *(float(double(form.correct.barriers[0])) for form in (resting, turning)),
        turning.problem.printed_barrier[0],
        sampled_top(),
        min(equilibrium.potential for equilibrium in turning.problem.equilibria),
        *(float(double(form.correct.energy)) for form in (resting, turning)),
    )
    motions = (resting.correct, turning.correct, turning.printed, level.motion)
    return SourceClaims(
        resting.problem.body,
        energies,
        *map(speeds, motions),
        turning.correct.period,
        needed(turning.correct, series.ACCURACIES)[-1],
        series.counts(1e-9 * series.barrier())[-1],
    )


def speeds(motion: PendulumMotion) -> Speeds:
    """Speeds of a rotation over one period."""
    times = (np.arange(SAMPLES) + 0.5) * motion.period / SAMPLES
    deviation = np.abs(motion.state(times)[1] / motion.theta_dot - 1.0)
    extreme = extremes(lambda t: motion.state(t)[1], np.linspace(0.0, motion.period, PARTS))
    within = tuple(float((deviation <= near).mean()) for near in NEAR)
    return Speeds(motion.theta_dot, *extreme, within)


def sampled_top() -> float:
    """The largest of the printed V [J] at ANGLES equally spaced angles, as the source finds the
    lower bound of the energy."""
    theta = np.arange(ANGLES) * 2 * np.pi / ANGLES
    return float(in_double(forms(ROTATING).printed.potential).value(theta).max())


CLAIMS = Analysis("cone_pendulum/claims", numbers)
