"""rolling-ball: a ball that slides until it rolls."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

from plumbob.analytic.systems.rolling_ball import RollingBall
from plumbob.analytic.theory import ErrorTheory
from plumbob.models.field_systems import contact_system, field_values
from plumbob.models.scene import Observable, make_scene, step_sizes


def facts(ball: RollingBall) -> Mapping[str, Any]:
    """Returns time [s], place [m] and speed [m/s] at which rolling begins, and time and place of
    rest. A value is None if the ball never rolls, or never rests."""
    rolling = ball.rolling_begins
    rests = math.isfinite(ball.rest_time)
    return {
        "rolling_time": rolling and rolling.time,
        "rolling_place": rolling and rolling.x,
        "rolling_speed": rolling and rolling.v,
        "rest_time": ball.rest_time if rests else None,
        "rest_place": ball.pieces[-1].x if rests else None,
    }


def errors(rolling_ball: RollingBall) -> ErrorTheory:
    """Returns the theory of the errors of fixed steps on the motion."""
    from plumbob.analytic.errors.contact_models.slide_to_roll import rolling_errors

    return rolling_errors(rolling_ball)


_scene = partial(
    make_scene,
    duration=1.0,
    system="rolling-ball",
    base=field_values(RollingBall, (0.1, 1.0, 2.0, 0.0, 0.2, 9.81, 0.0, 0.0)),
    steps=step_sizes(5e-3, 5e-4),
    source="Hopkins and Patterson 1977, Am. J. Phys. 45, 263; the numbers are ours",
)
SYSTEMS = (
    contact_system(
        RollingBall,
        errors=errors,
        model_module=f"{__name__}.model",
        name="rolling-ball",
        phenomenon=3,
        title="Rolling ball",
        observables=(
            Observable("x", "m"),
            Observable("speed", "m/s"),
            Observable("spin", "rad/s"),
        ),
        scenes=(
            _scene("slide-to-roll", "thrown without spin", profile="quick"),
            _scene("backspin", "thrown with backspin, it comes back", speed=1.0, spin=-40.0),
            _scene(
                "to-rest",
                "rolling friction stops it",
                duration=3.0,
                speed=0.5,
                rolling_friction=2e-3,
                hard="rolling friction acts while it slides too, and stops it for good",
            ),
        ),
        default="slide-to-roll",
        facts=facts,
    ),
)
