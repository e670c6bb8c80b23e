"""Whether a turning platform makes rotation more uniform, by three measures."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.pendulums.uniformity import from_below, of_motion, of_samples
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.request import Changes
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum.hamiltonian import MUJOCO, MUJOCO_STEP, ROTATING
from plumbob.reports.analyses.measurements import in_double

Start = tuple[float, float, float]  # pivot_y [m], platform rate [rad/s], theta_dot [rad/s]
POINTS: tuple[Start, ...] = (  # each turning platform beside one at rest
    (0.0, 0.0, 13.0),
    (0.0, 8.0, 13.0),
    (0.09, 0.0, 37.0),
    (0.09, 10.0, 37.0),
    (0.09, 26.0, 37.0),
)
RATES = np.linspace(0.0, 30.0, 41)  # [rad/s] of the platform
SPEEDS = np.geomspace(12.75, 60.0, 36)  # [rad/s]
PIVOTS = (0.0, 0.09)  # [m]


@cache
def problem(start: Start) -> ConePendulum:
    """The source's cone from a start."""
    return case_of(find_scene(ROTATING, dict(_changes(start)))).problem  # type: ignore[no-any-return]


def _changes(start: Start) -> Changes:
    return tuple(zip(("pivot_y", "platform_rate", "theta_dot"), start, strict=True))


def _request(start: Start) -> ExtraRun:
    period = problem(start).motion.period
    return ExtraRun(ROTATING, MUJOCO, MUJOCO_STEP, period, _changes(start))


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """A turn of MuJoCo's full model at each of a few points."""
    return tuple(_request(start) for start in POINTS)


def numbers(study: Study) -> Record:
    """Three measures at a few points and over two maps."""
    points = []
    for start in POINTS:
        run = study.answer(_request(start))
        measured = None if run is None else of_samples(run.times, run.observables["theta_dot"])
        pivot, platform_rate, speed = start
        exact = of_motion(problem(start).motion)
        points.append(
            Record(
                pivot=pivot,  # [m]
                platform_rate=platform_rate,  # [rad/s]
                speed=speed,  # [rad/s]
                exact=exact,
                measured=measured,  # of MuJoCo's full model
            )
        )
    maps = tuple(over_rates(pivot) for pivot in PIVOTS)
    lowest = min(float(np.nanmin(each.spread)) for each in maps)
    return Record(
        points=points,
        maps=maps,
        rates=RATES,  # [rad/s] of the maps
        speeds=SPEEDS,  # [rad/s]
        lowest=lowest,  # spread over that at rest, on the maps
        shrinks=lowest <= 1.0 - 1e-9,  # the range of speeds is smaller than at rest anywhere
    )


def over_rates(pivot: float) -> Record:
    """The measures over platform rates, shape (speeds, rates), against those at rest."""
    slow = problem((pivot, 1.0, float(SPEEDS[0])))
    inertia, speeds, squares = slow.body.inertia_x, SPEEDS[:, None], RATES**2
    unit = in_double(slow.potential)  # its a and b grow with the square of the rate
    potential = TrigonometricPotential(unit.a * squares, unit.b * squares, unit.c + 0 * squares)
    turning = from_below(potential, inertia, speeds + 0 * squares)
    resting = from_below(TrigonometricPotential(0.0, 0.0, unit.c), inertia, speeds)
    deviation, time = turning.deviation / resting.deviation, resting.near - turning.near
    return Record(
        pivot=pivot,  # [m]
        deviation=deviation,  # over that at rest: below 1 the rotation is more uniform
        time=time,  # near the initial speed, as a part: that at rest less that on the platform
        spread=turning.spread / resting.spread,  # over that at rest
        # parts of the map with a smaller deviation, and with more time near the initial speed
        steadier=np.mean(deviation < 1.0),
        nearer=np.mean(time < 0.0),
    )


UNIFORMITY = Analysis("cone_pendulum/uniformity", numbers, requests)
