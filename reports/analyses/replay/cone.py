"""Replays of the cone on its turning platform, in three dimensions."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.models.scene import Case
from plumbob.reports.analyses.replay.pendulums import (
    ANGLES,
    CHANNELS,
    apart,
    largest,
    phase,
)
from plumbob.reports.analyses.replay.picture import (
    Box,
    Chart,
    Picture,
    around,
    observed,
)
from plumbob.reports.view.notation import number

# Where the camera stands: its direction from the cone, round the vertical and above the horizontal.
AZIMUTH, ELEVATION = math.radians(25.0), math.radians(20.0)
HALF_ANGLE = math.radians(15.0)  # of the cone that stands for a general body: the source's own
CLEAR = 1.15  # of the cone's reach: how far below its pivot the platform is


def cone(case: Case, seconds: float) -> Picture:
    """The replay of a cone on its turning platform over `seconds` [s]."""
    problem, rate, shape = case.problem, case.problem.platform_rate, _shape(case)
    exact = case.reference.observe(np.linspace(0.0, seconds, 2001))
    turns = f"turns at ω = {number(abs(rate))} rad/s" if rate else "is at rest"
    text = (
        "The cone swings about its axle by θ, measured from hanging down, while the platform "
        f"{turns}; S is its centre of mass. Beside it the phase plane, θ̇ over θ, and θ̇ over time."
    )
    if "apex_angle" not in case.scene.parameters:
        text += " The general body of this scene is drawn as a cone with the same centre of mass."

    return Picture(
        "cone",
        text,
        _box(shape),
        {
            **vars(shape),
            "rate": rate,
            "camera": camera().tolist(),
            "trail": seconds / 12.0,
            "com": problem.body.com_distance,
        },
        (
            phase(exact),
            Chart("θ̇ [rad/s]", "t", ("theta_dot",), (0.0, seconds, *around(exact["theta_dot"]))),
        ),
        ANGLES,
        frozenset(CHANNELS),
        1.0,
        *observed(case.reference.observe, CHANNELS),
        apart,
        largest,
    )


def camera() -> Array:
    """Directions in the world that the picture shows to the right, upwards and towards the viewer,
    shape (3, 3): an orthographic projection."""
    ca, sa = math.cos(AZIMUTH), math.sin(AZIMUTH)
    ce, se = math.cos(ELEVATION), math.sin(ELEVATION)
    return np.array([[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]])


def _shape(case: Case) -> SimpleNamespace:
    """Sizes of the cone and of what it hangs on, in the platform's axes [m, rad]."""
    problem, parameters = case.problem, case.scene.parameters
    com = problem.body.com_distance
    half = 0.5 * parameters["apex_angle"] if "apex_angle" in parameters else HALF_ANGLE
    pivot = (problem.pivot_x, problem.pivot_y, problem.pivot_z)
    slant, arm = com / 0.75 / math.cos(half), math.hypot(*pivot[:2])
    return SimpleNamespace(
        pivot=pivot,
        height=com / 0.75,
        half=half,  # of the apex angle
        com=com,  # distance of the centre of mass from the pivot
        radius=max(1.2 * arm, 0.75 * slant),  # of the platform's disc
        floor=pivot[2] - CLEAR * slant,  # its height
        slant=slant,  # distance of the rim from the pivot
        arm=arm,  # distance of the pivot from the platform's axis
    )


def _box(shape: SimpleNamespace) -> Box:
    """The box that holds the picture, whichever way platform and cone are turned."""
    reach = max(shape.arm + shape.slant, shape.radius)
    rise, tilt = math.cos(ELEVATION), math.sin(ELEVATION)
    top = (shape.pivot[2] + shape.slant) * rise + shape.arm * tilt
    bottom = shape.floor * rise - shape.radius * tilt
    pad = 0.04 * reach  # and below the platform the ruler
    return -reach - pad, reach + pad, bottom - 4.0 * pad, top + pad
