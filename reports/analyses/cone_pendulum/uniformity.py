"""Whether a turning platform makes rotation more uniform, by three measures."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.systems.pendulums.uniformity import (
    uniformity_from_bottom,
    uniformity_of_motion,
)
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.cone_pendulum.hamiltonian import cone
from plumbob.reports.analyses.measurements import in_double

CHANGED = ("pivot_y", "platform_rate", "theta_dot")  # [m], [rad/s], [rad/s]
POINTS = (  # of these; each turning platform beside one at rest
    (0.0, 0.0, 13.0),
    (0.0, 8.0, 13.0),
    (0.09, 0.0, 37.0),
    (0.09, 10.0, 37.0),
    (0.09, 26.0, 37.0),
)
RATES = np.linspace(0.0, 30.0, 41)  # [rad/s] of the platform
SPEEDS = np.geomspace(12.75, 60.0, 36)  # [rad/s]
PIVOTS = (0.0, 0.09)  # [m]


def numbers(study: Study) -> Record:
    """Three measures at a few points and over two maps."""
    points = []
    for start in POINTS:
        motion = cone(**dict(zip(CHANGED, start, strict=True))).motion
        pivot, platform_rate, speed = start[:3]
        exact = uniformity_of_motion(motion)
        points.append(
            Record(pivot=pivot, platform_rate=platform_rate, speed=speed, exact=exact)
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
    slow = cone(pivot_y=pivot, platform_rate=1.0, theta_dot=float(SPEEDS[0]))
    inertia = slow.body.inertia_x
    speeds = SPEEDS[:, None]
    squares = RATES**2
    unit = in_double(slow.potential)  # its a and b grow with the square of the rate
    potential = TrigonometricPotential(unit.a * squares, unit.b * squares, unit.c + 0 * squares)
    turning = uniformity_from_bottom(potential, inertia, speeds + 0 * squares)
    resting = uniformity_from_bottom(TrigonometricPotential(0.0, 0.0, unit.c), inertia, speeds)
    deviation = turning.deviation / resting.deviation
    time = resting.near - turning.near
    return Record(
        pivot=pivot,  # [m]
        deviation=deviation,  # over that at rest: below 1 the rotation is more uniform
        time=time,  # near the initial speed, as a part: that at rest less that on the platform
        spread=turning.spread / resting.spread,  # over that at rest
        # parts of the map with a smaller deviation, and with more time near the initial speed
        steadier=np.mean(deviation < 1.0),
        nearer=np.mean(time < 0.0),
    )


UNIFORMITY = Analysis("cone_pendulum/uniformity", numbers)
