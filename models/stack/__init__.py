"""Cubes one on another: stack."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from plumbob.analytic.systems.stack import Stack
from plumbob.models.field_systems import contact_system, field_values
from plumbob.models.scene import Case, Observable, Quantity, Scene, step_sizes


def facts(stack: Stack) -> Mapping[str, Any]:
    """Masses [kg] and normal forces [N], from the lowest cube to the top one, and the slope [rad]
    on which it tips."""
    forces = stack.normal_forces.tolist()
    return {"masses": stack.masses.tolist(), "normal_forces": forces, "topples": stack.topples}


def interest(case: Case) -> tuple[Quantity, ...]:
    """The height of the top, relative to an edge."""
    return (Quantity("top", case.problem.size),)


def _scene(case: str, summary: str, count: int, ratio: float, **more: Any) -> Scene:
    return Scene(
        f"stack/{case}",
        summary,
        field_values(Stack, (count, 0.2, 1.0, ratio, 9.81)),
        1.0,
        step_sizes(5e-3, 5e-4),
        "statics; the numbers are ours",
        **more,
    )


SYSTEM = contact_system(
    Stack,
    Path(__file__).parent / "stack.xml",
    "errors.contact_models.stack_steps.StackErrors",
    name="stack",
    title="Stack of cubes",
    observables=(Observable("top", "m"),),
    scenes=(
        _scene("equal", "five equal cubes", 5, 1.0, profile="quick"),
        _scene("tall", "twenty equal cubes", 20, 1.0),
        _scene("light-top", "a ten-thousandth on top", 2, 1e-4),
        _scene("heavy-top-100", "a hundred times as much on top", 2, 100.0),
        _scene(
            "heavy-top",
            "ten thousand times as much on top",
            2,
            1e4,
            hard="a contact pushes as if it carried the lighter cube alone",
        ),
    ),
    default="equal",
    facts=facts,
    interest=interest,
)
SYSTEMS = (SYSTEM,)
