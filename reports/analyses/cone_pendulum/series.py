"""Special functions and Fourier series: the source's statements on both, checked."""

from __future__ import annotations

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.pendulums.harmonics import harmonics_needed
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum.action_phase import SHALLOW_WELL
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    RESTING,
    ROTATING,
    closed_forms,
    turning_cone,
)

ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-12)
# energies above the barrier, relative to the deepest well's depth
ENERGIES_ABOVE_BARRIER = (1e-3, 1e-6, 1e-9)
HarmonicCounts = tuple[int, ...]  # numbers of harmonics for each of ACCURACIES


def harmonics_near_barrier(above: float) -> HarmonicCounts:
    """Returns the numbers of harmonics that reach each of ACCURACIES, for a rotation of the
    source's cone on its turning platform with an energy `above` the barrier [J]."""
    problem = turning_cone(theta=SHALLOW_WELL, theta_dot=1.0)
    motion = PendulumMotion(
        problem.potential, problem.body.inertia_x, problem.theta, 1.0, excess=above
    )
    return harmonics_needed(motion, ACCURACIES)


def barrier_height() -> float:
    """Returns the height of the barrier above the deepest well [J], which scales energies."""
    problem = turning_cone(theta=SHALLOW_WELL, theta_dot=1.0)
    lowest = min(equilibrium.potential for equilibrium in problem.equilibria)
    return float(double(problem.motion.barriers[0])) - lowest


def numbers() -> Record:
    """Returns periods by a closed form that, according to the source, does not exist, and the
    numbers of harmonics of the series that the source recommends."""
    motions = {scene: closed_forms(scene).correct for scene in (RESTING, ROTATING)}
    depth = barrier_height()
    return Record(
        periods={scene: motion.period for scene, motion in motions.items()},  # [s], by scene
        scenes={
            scene: harmonics_needed(motion, ACCURACIES) for scene, motion in motions.items()
        },
        near=[
            (fraction, harmonics_near_barrier(fraction * depth))
            for fraction in ENERGIES_ABOVE_BARRIER
        ],
        accuracies=ACCURACIES,
    )


SPECIAL_FUNCTIONS = Analysis("cone_pendulum/special_functions", exact=numbers)
