"""Replays of the simple and the linear pendulum, and of the cone on its turning platform."""

from __future__ import annotations

import math

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.models.scene import Case
from plumbob.reports.analyses.replay.picture import (
    ELEVATION,
    Picture,
    camera,
    channels_of_observables,
)

TRAIL = 12.0  # ratio of a replay's duration to the duration of its trail
HALF_ANGLE = math.radians(15.0)  # [rad] half apex angle of a general body's cone, the source's
CLEAR = 1.15  # distance of the platform below the pivot, relative to the cone's slant height


def pendulum(case: Case, seconds: float) -> Picture:
    """Returns the picture of a simple or linear pendulum over `seconds` [s]."""
    length = case.problem.length
    reach = 1.2 * length
    geometry = {"length": length, "trail": seconds / TRAIL}
    motion, deviations = channels_of_observables(case.reference.observe, ("theta",))
    return Picture(
        kind="pendulum",
        box=(-reach, reach, -reach, reach),
        geometry=geometry,
        sizes={"rad": 1.0},
        motion=motion,
        deviations=deviations,
        apart=_angle_between,
    )


def cone(case: Case, seconds: float) -> Picture:
    """Returns the picture of a cone on its turning platform over `seconds` [s]. A general body is
    drawn as a cone with the same centre of mass."""
    problem = case.problem
    parameters = case.scene.parameters
    com = problem.body.com_distance
    half = 0.5 * parameters["apex_angle"] if "apex_angle" in parameters else HALF_ANGLE
    pivot = (problem.pivot_x, problem.pivot_y, problem.pivot_z)
    # distance of the rim from the pivot, and distance of the pivot from the platform's axis
    slant = com / 0.75 / math.cos(half)
    arm = math.hypot(*pivot[:2])
    # radius and height of the platform's disc
    radius = max(1.2 * arm, 0.75 * slant)
    floor = pivot[2] - CLEAR * slant
    # The box of the picture holds platform and cone in any orientation.
    reach = max(arm + slant, radius)
    rise = math.cos(ELEVATION)
    tilt = math.sin(ELEVATION)
    pad = 0.04 * reach  # margin; the space below the platform also holds the ruler
    top = (pivot[2] + slant) * rise + arm * tilt
    bottom = floor * rise - radius * tilt
    motion, deviations = channels_of_observables(case.reference.observe, ("theta",))
    return Picture(
        kind="cone",
        box=(-reach - pad, reach + pad, bottom - 4.0 * pad, top + pad),
        geometry={
            "pivot": pivot,
            "height": com / 0.75,
            "half": half,  # half the apex angle
            "com": com,  # distance of the centre of mass from the pivot
            "radius": radius,
            "floor": floor,
            "rate": problem.platform_rate,
            "camera": camera(),
            "trail": seconds / TRAIL,
        },
        sizes={"rad": 1.0},
        motion=motion,
        deviations=deviations,
        apart=_angle_between,
    )


def _angle_between(deviations: Signals) -> dict[str, Array]:
    """Returns the angle [rad] between a run and the exact motion."""
    return {"rad": np.abs(deviations["theta"])}
