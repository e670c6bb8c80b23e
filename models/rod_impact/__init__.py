"""A rod that falls at an angle onto a rough floor: rod-impact."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from plumbob.analytic.numerics.point_impact import LAWS
from plumbob.analytic.systems.rod_impact import RodImpact
from plumbob.models.field_systems import contact_system, field_values
from plumbob.models.scene import Case, Observable, Quantity, Scene, step_sizes

NEWTON, POISSON, ENERGETIC = LAWS


def facts(rod: RodImpact) -> Mapping[str, Any]:
    """Time of the impact [s], its outcome, whether the rod is Painleve's, normal and friction
    impulse [N s], and when an end strikes again [s]."""
    _, normal, along = rod.impact.impulses
    return {
        "impact_time": rod.fall,
        "outcome": rod.impact.outcome,
        "jams": rod.impact.jams,
        "normal_impulse": normal,
        "friction_impulse": along,
        "next_impact": rod.until,
    }


def interest(case: Case) -> tuple[Quantity, ...]:
    """The place of the centre, relative to the rod's length, and the angle in radians."""
    size = case.problem.length
    return Quantity("z", size), Quantity("x", size), Quantity("angle", 1.0)


def _scene(
    case: str, summary: str, start: tuple[float, float, float, float], law: str, **more: Any
) -> Scene:
    angle, height, speed, friction = start
    return Scene(
        f"rod-impact/{case}",
        summary,
        field_values(RodImpact, (1.0, 1.0, angle, height, speed, friction, 0.5, law, 9.81)),
        0.4 if height else 0.06,
        step_sizes(1e-3, 1e-4),
        "Routh 1905, Dynamics of a System of Rigid Bodies, 187-193; the numbers are ours",
        **more,
    )


_BACK = (0.7, 0.5, 1.0, 0.3)
SYSTEM = contact_system(
    RodImpact,
    Path(__file__).parent / "rod_impact.xml",
    "errors.contact_models.rod_steps.RodErrors",
    name="rod-impact",
    title="Rod that strikes the floor",
    observables=(Observable("x", "m"), Observable("z", "m"), Observable("angle", "rad")),
    scenes=(
        _scene("sticks", "friction ends the slip", (0.7, 0.5, 0.5, 1.0), NEWTON, profile="quick"),
        _scene("slides", "it slides all through the impact", (1.1, 0.5, -2.0, 0.3), NEWTON),
        _scene("reverses", "its slip turns round in the impact", _BACK, NEWTON, profile="quick"),
        _scene("reverses-poisson", "as reverses, by Poisson's law", _BACK, POISSON),
        _scene("reverses-energetic", "as reverses, by Stronge's law", _BACK, ENERGETIC),
        _scene(
            "painleve",
            "a rod that slides towards its lower end, with a friction of 3",
            (1.1, 0.0, -2.0, 3.0),
            ENERGETIC,
            hard="no force of the floor carries it: an impact without a collision",
        ),
    ),
    default="sticks",
    facts=facts,
    interest=interest,
)
SYSTEMS = (SYSTEM,)
