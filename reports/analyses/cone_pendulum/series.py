"""Special functions and Fourier series: the source's statements on both, measured."""

from __future__ import annotations

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.pendulums.harmonics import harmonics_needed
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum.action_phase import SHALLOW
from plumbob.reports.analyses.cone_pendulum.hamiltonian import RESTING, ROTATING, cone, forms

ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-12)
NEAR = (1e-3, 1e-6, 1e-9)  # of the deepest well's depth above the barrier
Counts = tuple[int, ...]  # of harmonics, for ACCURACIES


def counts(above: float) -> Counts:
    """Harmonics for ACCURACIES of a rotation of the source's cone on its turning platform, with an
    energy `above` the barrier [J]."""
    problem = cone(theta=SHALLOW, theta_dot=1.0)
    motion = PendulumMotion(
        problem.potential, problem.body.inertia_x, problem.theta, 1.0, excess=above
    )
    return harmonics_needed(motion, ACCURACIES)


def barrier() -> float:
    """The height of the barrier [J] over the deepest well, a scale of energies."""
    problem = cone(theta=SHALLOW, theta_dot=1.0)
    lowest = min(e.potential for e in problem.equilibria)
    return float(double(problem.motion.barriers[0])) - lowest


def numbers(study: Study) -> Record:
    """A closed form that the source says does not exist, and the series that it recommends."""
    motions = {scene: forms(scene).correct for scene in (RESTING, ROTATING)}
    depth = barrier()
    return Record(
        periods={scene: motion.period for scene, motion in motions.items()},  # [s], by scene
        scenes={
            scene: harmonics_needed(motion, ACCURACIES) for scene, motion in motions.items()
        },
        near=[(part, counts(part * depth)) for part in NEAR],
        accuracies=ACCURACIES,
    )


SPECIAL_FUNCTIONS = Analysis("cone_pendulum/special_functions", numbers)
