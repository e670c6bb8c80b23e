"""incline: a cube on an inclined plane, at rest or sliding."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from plumbob.analytic.systems.incline import Incline
from plumbob.analytic.theory import ErrorTheory
from plumbob.models.field_systems import contact_system, field_values
from plumbob.models.scene import Case, Observable, Quantity, Scene, make_scene, step_sizes

INCLINE_FRICTION = 0.4


def facts(cube: Incline) -> Mapping[str, Any]:
    """Returns the slope [rad] up to which friction holds the cube, the acceleration [m/s^2] of
    downhill sliding, time [s] and place [m] of the first stop, None without a stop, and whether the
    cube stays at rest."""
    stops = math.isfinite(cube.stop_time)
    return {
        "threshold": math.atan(cube.friction),
        "acceleration": cube.acceleration(1.0),
        "stop_time": cube.stop_time if stops else None,
        "stop_place": cube.stop_place if stops else None,
        "stays": cube.holds,
    }


def interest(case: Case) -> tuple[Quantity, ...]:
    """Returns the place; its scale is the largest distance, or the edge if the cube rests."""
    times = np.linspace(0.0, case.scene.duration, 101)
    largest_distance = float(np.abs(case.reference.observe(times)["x"]).max())
    return (Quantity("x", largest_distance or case.problem.size),)


def errors(incline: Incline) -> ErrorTheory:
    """Returns the theory of the errors of fixed steps on the motion."""
    from plumbob.analytic.errors.contact_models.held_bodies import incline_errors

    return incline_errors(incline)


def _scene(
    case: str, summary: str, part: float, speed: float, heading: float = 0.0, **more: Any
) -> Scene:
    """Returns a scene at the slope `part` times the friction's, with the initial `speed` [m/s] and
    the `heading` [rad] of the cube."""
    return make_scene(
        case,
        summary,
        1.0,
        system="incline",
        base=field_values(
            Incline,
            (
                math.atan(part * INCLINE_FRICTION),
                INCLINE_FRICTION,
                1.0,
                0.1,
                speed,
                9.81,
                heading,
            ),
        ),
        steps=step_sizes(5e-3, 5e-4),
        source="Coulomb 1785, Mem. Math. Phys. 10, 161; the numbers are ours",
        **more,
    )


SYSTEMS = (
    contact_system(
        Incline,
        errors=errors,
        model_module=f"{__name__}.model",
        name="incline",
        phenomenon=2,
        title="Cube on an incline",
        observables=(Observable("x", "m"), Observable("speed", "m/s")),
        scenes=(
            _scene(
                "rest", "at 0.9 of the slope that friction holds", 0.9, 0.0, profile="quick"
            ),
            _scene(
                "just-held", "at 0.999 of it", 0.999, 0.0, hard="friction used up but for 1e-3"
            ),
            _scene(
                "just-slides", "at 1.001 of it", 1.001, 0.0, hard="the motion is a difference"
            ),
            _scene("stops", "thrown downhill, it stops and stays", 0.5, 1.0, profile="quick"),
            _scene("returns", "thrown uphill, it stops and slides back", 1.5, -2.0),
            _scene(
                "heading-045",
                "at 0.9 of the slope, across the edges of a friction pyramid",
                0.9,
                0.0,
                math.pi / 4,
                hard="a pyramid has 0.71 of the friction there",
            ),
        ),
        default="stops",
        facts=facts,
        interest=interest,
    ),
)
