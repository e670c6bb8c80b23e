"""stack: cubes one on another."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from plumbob.analytic.systems.stack import Stack
from plumbob.models.field_systems import contact_system, field_values
from plumbob.models.scene import Observable, Quantity, scene_of, step_sizes


def facts(stack: Stack) -> Mapping[str, Any]:
    """Returns masses [kg] and normal forces [N], from the lowest cube to the top cube, and the
    slope [rad] at which the stack topples."""
    forces = stack.normal_forces.tolist()
    return {"masses": stack.masses.tolist(), "normal_forces": forces, "topples": stack.topples}


_scene = partial(
    scene_of,
    system="stack",
    base=field_values(Stack, (5, 0.2, 1.0, 1.0, 9.81)),
    duration=1.0,
    steps=step_sizes(5e-3, 5e-4),
    source="statics; the numbers are ours",
)
_two = partial(_scene, count=2)
SYSTEMS = (
    contact_system(
        Stack,
        theory="errors.contact_models.held_bodies.stack_errors",
        model_module=f"{__name__}.model",
        name="stack",
        title="Stack of cubes",
        observables=(Observable("top", "m"),),
        scenes=(
            _scene("equal", "five equal cubes", profile="quick"),
            _scene("tall", "twenty equal cubes", count=20),
            _two("light-top", "a ten-thousandth on top", mass_ratio=1e-4),
            _two("heavy-top-100", "a hundred times as much on top", mass_ratio=100.0),
            _two(
                "heavy-top",
                "ten thousand times as much on top",
                mass_ratio=1e4,
                hard="a contact pushes as if it carried the lighter cube alone",
            ),
        ),
        default="equal",
        facts=facts,
        # The scale is an edge of a cube.
        interest=lambda case: (Quantity("top", case.problem.size),),
    ),
)
