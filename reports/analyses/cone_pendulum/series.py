"""Special functions and Fourier series: the source's statements on both, measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.harmonics import needed
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.cone_pendulum.action_phase import SHALLOW, started
from plumbob.reports.analyses.cone_pendulum.hamiltonian import RESTING, ROTATING, forms

ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-12)
NEAR = (1e-3, 1e-6, 1e-9)  # of the deepest well's depth above the barrier
DRAWN = np.geomspace(1e-9, 10.0, 41)  # the same, of the figure
EXACT, STEPPED, ADAPTIVE = "exact/closed-form", "mujoco/rk4", "ode/dop853"
Counts = tuple[int, ...]  # of harmonics, for ACCURACIES


@dataclass(frozen=True)
class Harmonics:
    """How many harmonics theta(t) needs, and what the closed form costs beside steps."""

    periods: Mapping[str, float]  # [s], by scene
    scenes: Mapping[str, Counts]
    near: tuple[tuple[float, Counts], ...]
    depth: float  # [J]
    drawn: Array  # parts of the depth above the barrier
    curves: tuple[Counts, ...]  # harmonics at them, by accuracy
    costs: Mapping[str, Mapping[str, float | None]]  # [s] a step, by scene and method
    accuracies: tuple[float, ...] = ACCURACIES


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


def numbers(study: Study) -> Harmonics:
    """A closed form that the source says does not exist, and the series that it recommends."""
    motions = {scene: forms(scene).correct for scene in (RESTING, ROTATING)}
    depth = barrier()
    drawn = [counts(float(part) * depth) for part in DRAWN]
    return Harmonics(
        {scene: motion.period for scene, motion in motions.items()},
        {scene: needed(motion, ACCURACIES) for scene, motion in motions.items()},
        tuple((part, counts(part * depth)) for part in NEAR),
        depth,
        DRAWN,
        tuple(zip(*drawn, strict=True)),
        {
            scene: {name: _spent(study, scene, name) for name in (EXACT, STEPPED, ADAPTIVE)}
            for scene in motions
        },
    )


def _spent(study: Study, scene: str, method: str) -> float | None:
    """Measured time of a step [s]."""
    cost = study.costs.get((scene, method))
    return None if cost is None else cost.ns_per_step * 1e-9


SPECIAL_FUNCTIONS = Analysis("cone_pendulum/special_functions", numbers)
