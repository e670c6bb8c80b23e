"""rolling-ball: a ball that slides until it rolls."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

from plumbob.analytic.systems.rolling_ball import RollingBall
from plumbob.models.field_systems import contact_system, field_values
from plumbob.models.scene import Observable, scene_of, step_sizes


def facts(ball: RollingBall) -> Mapping[str, Any]:
    """Returns time [s], place [m] and speed [m/s] at which rolling begins, and time and place of
    rest. A value is None if the ball never rolls, or never rests."""
    rolls = ball.rolling_begins
    stops = ball.rest_time if math.isfinite(ball.rest_time) else None
    return {
        "rolling_time": rolls and rolls.time,
        "rolling_place": rolls and rolls.x,
        "rolling_speed": rolls and rolls.v,
        "rest_time": stops,
        "rest_place": None if stops is None else ball.pieces[-1].x,
    }


_scene = partial(
    scene_of,
    duration=1.0,
    system="rolling-ball",
    base=field_values(RollingBall, (0.1, 1.0, 2.0, 0.0, 0.2, 9.81, 0.0, 0.0)),
    steps=step_sizes(5e-3, 5e-4),
    source="Hopkins and Patterson 1977, Am. J. Phys. 45, 263; the numbers are ours",
)
SYSTEMS = (
    contact_system(
        RollingBall,
        theory="errors.contact_models.slide_to_roll.rolling_errors",
        model_module=f"{__name__}.model",
        name="rolling-ball",
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
