"""The uniformity of rotation on a turning platform, by three measures."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.systems.pendulums.uniformity import (
    uniformity_from_bottom,
    uniformity_of_motion,
)
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum.hamiltonian import turning_cone
from plumbob.reports.analyses.measurements import in_double

# y of the pivot [m], platform rate [rad/s] and initial speed [rad/s]; each turning platform follows
# one at rest
COMPARED_STARTS = (
    (0.0, 0.0, 13.0),
    (0.0, 8.0, 13.0),
    (0.09, 0.0, 37.0),
    (0.09, 10.0, 37.0),
    (0.09, 26.0, 37.0),
)
UNIFORMITY_MAP_RATES = np.linspace(0.0, 30.0, 41)  # [rad/s] platform rates of the maps
SPEEDS = np.geomspace(12.75, 60.0, 36)  # [rad/s] initial speeds of the maps
MAP_PIVOTS = (0.0, 0.09)  # [m] y of the pivot, one for each map
# Largest rounding of a difference of two fractions of the period; on the maps it is 4e-16. Other
# differences are 1e-4 and more.
TIME_ROUNDING = 1e-12


def numbers() -> Record:
    """Returns the three measures at COMPARED_STARTS and over two maps."""
    points = []
    for pivot, platform_rate, speed in COMPARED_STARTS:
        motion = turning_cone(
            pivot_y=pivot, platform_rate=platform_rate, theta_dot=speed
        ).motion
        exact = uniformity_of_motion(motion)
        points.append(
            Record(pivot=pivot, platform_rate=platform_rate, speed=speed, exact=exact)
        )
    maps = tuple(uniformity_map(pivot) for pivot in MAP_PIVOTS)
    lowest = min(float(np.nanmin(measures.spread)) for measures in maps)
    return Record(
        points=points,
        maps=maps,
        rates=UNIFORMITY_MAP_RATES,  # [rad/s] of the maps
        speeds=SPEEDS,  # [rad/s]
        lowest=lowest,  # smallest spread on the maps, relative to a platform at rest
        shrinks=lowest <= 1.0 - 1e-9,  # whether the spread is anywhere smaller than at rest
    )


def uniformity_map(pivot: float) -> Record:
    """Returns maps of the three measures, shape (speeds, rates), relative to a platform at rest."""
    slow = turning_cone(pivot_y=pivot, platform_rate=1.0, theta_dot=float(SPEEDS[0]))
    inertia = slow.body.inertia_x
    speeds = SPEEDS[:, None]
    squares = UNIFORMITY_MAP_RATES**2
    unit = in_double(slow.potential)  # its a and b grow with the square of the rate
    potential = TrigonometricPotential(unit.a * squares, unit.b * squares, unit.c + 0 * squares)
    turning = uniformity_from_bottom(potential, inertia, speeds + 0 * squares)
    resting = uniformity_from_bottom(TrigonometricPotential(0.0, 0.0, unit.c), inertia, speeds)
    deviation = turning.deviation / resting.deviation
    time = resting.near - turning.near
    return Record(
        pivot=pivot,  # [m]
        deviation=deviation,  # relative to a platform at rest; below 1, rotation is more uniform
        # fraction of time near the initial speed: on a platform at rest minus on a turning one
        time=time,
        spread=turning.spread / resting.spread,  # relative to a platform at rest
        # fractions of the map with a smaller deviation, and with more time near the initial speed
        steadier=np.mean(deviation < 1.0),
        nearer=np.mean(time < -TIME_ROUNDING),
    )


UNIFORMITY = Analysis("cone_pendulum/uniformity", exact=numbers)
