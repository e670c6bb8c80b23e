"""pinch: a cube that friction holds between two fingers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from plumbob.analytic.systems.pinch import Pinch
from plumbob.models.field_systems import contact_system, field_values
from plumbob.models.scene import Observable, Quantity, Scene, scene_of, step_sizes

MASS, FRICTION, GRAVITY = 0.2, 0.6, 9.81


def facts(pinch: Pinch) -> Mapping[str, Any]:
    """Returns the load on friction [N], its fraction of the largest load, and the least normal
    force [N]."""
    least = pinch.load / (2.0 * pinch.friction)
    return {"load": pinch.load, "fraction": pinch.fraction, "least_normal_force": least}


def _scene(
    case: str, summary: str, fraction: float, push: float = 0.0, lift: float = 0.0, **more: Any
) -> Scene:
    """Returns a scene whose two contacts carry the load at a `fraction` of the largest friction.
    `push` is a force to the side [N], `lift` the hand's acceleration upward [m/s^2]."""
    load = math.hypot(MASS * (GRAVITY + lift), push)
    normal_force = load / (2.0 * FRICTION * fraction)
    return scene_of(
        case,
        summary,
        1.0,
        system="pinch",
        base=field_values(
            Pinch, (MASS, 0.08, 0.5, FRICTION, normal_force, GRAVITY, push, lift)
        ),
        steps=step_sizes(5e-3, 5e-4),
        source="Coulomb 1785, Mem. Math. Phys. 10, 161; the numbers are ours",
        **more,
    )


_HARD = "friction used up but for a thousandth of it"
SYSTEMS = (
    contact_system(
        Pinch,
        theory="errors.contact_models.held_bodies.pinch_errors",
        model_module=f"{__name__}.model",
        name="pinch",
        title="Cube between two fingers",
        observables=(Observable("slip", "m"), Observable("speed", "m/s")),
        scenes=(
            _scene("0.5", "half of the friction holds it", 0.5, profile="quick"),
            _scene("0.9", "0.9 of the friction holds it", 0.9),
            _scene("0.999", "0.999 of the friction holds it", 0.999, hard=_HARD),
            _scene("lifted", "lifted with 5 m/s^2", 0.9, lift=5.0),
            _scene(
                "pushed",
                "pushed aside with its weight",
                0.9,
                push=MASS * GRAVITY,
                hard="a pyramid has 0.71 of the friction there",
            ),
        ),
        default="0.9",
        facts=facts,
        # The scale is an edge of the cube.
        interest=lambda case: (Quantity("slip", case.problem.size),),
    ),
)
