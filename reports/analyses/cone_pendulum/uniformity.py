"""Whether a turning platform makes rotation more uniform, by three measures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.pendulums.uniformity import (
    Uniformity,
    from_below,
    of_motion,
    of_samples,
)
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.request import Changes
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.cone_pendulum.hamiltonian import MUJOCO, MUJOCO_STEP, ROTATING
from plumbob.reports.analyses.energy_drift import in_double

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


@dataclass(frozen=True)
class Point:
    """The measures of a rotation: of the closed form, and of MuJoCo's full model."""

    pivot: float  # [m]
    platform_rate: float  # [rad/s]
    speed: float  # [rad/s]
    exact: Uniformity
    measured: Uniformity | None


@dataclass(frozen=True)
class Map:
    """The measures over platform rates, shape (speeds, rates), against those at rest."""

    pivot: float  # [m]
    deviation: Array  # over that at rest: below 1 the platform makes the rotation more uniform
    time: Array  # near the initial speed, as a part: that at rest less that on the platform
    spread: Array  # over that at rest

    @property
    def steadier(self) -> float:
        """Part of the map with a smaller deviation than at rest."""
        return float(np.mean(self.deviation < 1.0))

    @property
    def nearer(self) -> float:
        """Part of the map with more time near the initial speed than at rest."""
        return float(np.mean(self.time < 0.0))


@dataclass(frozen=True)
class Measures:
    """Three measures at a few points and over two maps."""

    points: tuple[Point, ...]
    maps: tuple[Map, ...]
    rates: Array  # [rad/s] of the maps
    speeds: Array  # [rad/s]
    lowest: float  # spread over that at rest, on the maps

    @property
    def shrinks(self) -> bool:
        """Whether the range of speeds is smaller than at rest anywhere on the maps."""
        return self.lowest <= 1.0 - 1e-9


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


def numbers(study: Study) -> Measures:
    """Three measures at a few points and over two maps."""
    points = []
    for start in POINTS:
        run = study.answer(_request(start))
        measured = None if run is None else of_samples(run.times, run.observables["theta_dot"])
        points.append(Point(*start, of_motion(problem(start).motion), measured))
    maps = tuple(over_rates(pivot) for pivot in PIVOTS)
    lowest = min(float(np.nanmin(each.spread)) for each in maps)
    return Measures(tuple(points), maps, RATES, SPEEDS, lowest)


def over_rates(pivot: float) -> Map:
    """The map of a pivot [m]."""
    slow = problem((pivot, 1.0, float(SPEEDS[0])))
    inertia, speeds, squares = slow.body.inertia_x, SPEEDS[:, None], RATES**2
    unit = in_double(slow.potential)  # its a and b grow with the square of the rate
    potential = TrigonometricPotential(unit.a * squares, unit.b * squares, unit.c + 0 * squares)
    turning = from_below(potential, inertia, speeds + 0 * squares)
    resting = from_below(TrigonometricPotential(0.0, 0.0, unit.c), inertia, speeds)
    return Map(
        pivot,
        turning.deviation / resting.deviation,
        resting.near - turning.near,
        turning.spread / resting.spread,
    )


UNIFORMITY = Analysis("cone_pendulum/uniformity", numbers, requests)
