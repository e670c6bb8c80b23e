"""Special functions and Fourier series: the source's statements on both, measured."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.pendulums.harmonics import needed
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum.action_phase import SHALLOW, started
from plumbob.reports.analyses.cone_pendulum.hamiltonian import RESTING, ROTATING, forms

ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-12)
NEAR = (1e-3, 1e-6, 1e-9)  # of the deepest well's depth above the barrier
DRAWN = np.geomspace(1e-9, 10.0, 41)  # the same, of the figure
EXACT, STEPPED, ADAPTIVE = "exact/closed-form", "mujoco/rk4", "ode/dop853"
Counts = tuple[int, ...]  # of harmonics, for ACCURACIES


def counts(above: float) -> Counts:
    """Harmonics for ACCURACIES of a rotation of the source's cone on its turning platform, with an
    energy `above` the barrier [J]."""
    problem = started(SHALLOW, 1.0)
    motion = PendulumMotion(
        problem.potential, problem.body.inertia_x, problem.theta, 1.0, excess=above
    )
    return needed(motion, ACCURACIES)


def barrier() -> float:
    """The height of the barrier [J] over the deepest well, a scale of energies."""
    problem = started(SHALLOW, 1.0)
    lowest = min(e.potential for e in problem.equilibria)
    return float(double(problem.motion.barriers[0])) - lowest


def numbers(study: Study) -> Record:
    """A closed form that the source says does not exist, and the series that it recommends."""
    motions = {scene: forms(scene).correct for scene in (RESTING, ROTATING)}
    depth = barrier()
    drawn = [counts(float(part) * depth) for part in DRAWN]
    return Record(
        periods={scene: motion.period for scene, motion in motions.items()},  # [s], by scene
        scenes={scene: needed(motion, ACCURACIES) for scene, motion in motions.items()},
        near=[(part, counts(part * depth)) for part in NEAR],
        depth=depth,  # [J]
        drawn=DRAWN,  # parts of the depth above the barrier
        curves=tuple(zip(*drawn, strict=True)),  # harmonics at them, by accuracy
        # [s] a step, by scene and method
        costs={
            scene: {name: _spent(study, scene, name) for name in (EXACT, STEPPED, ADAPTIVE)}
            for scene in motions
        },
        accuracies=ACCURACIES,
    )


def _spent(study: Study, scene: str, method: str) -> float | None:
    """Measured time of a step [s]."""
    cost = study.costs.get((scene, method))
    return None if cost is None else cost.ns_per_step * 1e-9


SPECIAL_FUNCTIONS = Analysis("cone_pendulum/special_functions", numbers)
