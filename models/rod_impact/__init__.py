"""rod-impact: a rod that falls at an angle onto a rough floor."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from plumbob.analytic.numerics.point_impact import LAWS
from plumbob.analytic.systems.rod_impact import RodImpact
from plumbob.models.field_systems import contact_system, field_values
from plumbob.models.scene import Case, Observable, Quantity, scene_of, step_sizes

NEWTON, POISSON, ENERGETIC = LAWS


def facts(rod: RodImpact) -> Mapping[str, Any]:
    """Returns the time of the impact [s], its outcome, whether the rod jams as in Painlevé's
    paradox, the normal and the friction impulse [N s], and the time at which an end strikes again
    [s]."""
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
    """Returns the place of the centre, relative to the rod's length, and the angle in radians."""
    size = case.problem.length
    return Quantity("z", size), Quantity("x", size), Quantity("angle", 1.0)


_scene = partial(
    scene_of,
    duration=0.4,
    system="rod-impact",
    base=field_values(RodImpact, (1.0, 1.0, 0.7, 0.5, 1.0, 0.3, 0.5, NEWTON, 9.81)),
    steps=step_sizes(1e-3, 1e-4),
    source="Routh 1905, Dynamics of a System of Rigid Bodies, 187-193; the numbers are ours",
)
SYSTEMS = (
    contact_system(
        RodImpact,
        theory="errors.contact_models.rod_steps.rod_errors",
        model_module=f"{__name__}.model",
        name="rod-impact",
        title="Rod that strikes the floor",
        observables=(Observable("x", "m"), Observable("z", "m"), Observable("angle", "rad")),
        scenes=(
            _scene(
                "sticks", "friction ends the slip", profile="quick", speed=0.5, friction=1.0
            ),
            _scene("slides", "it slides all through the impact", angle=1.1, speed=-2.0),
            _scene("reverses", "its slip turns round in the impact", profile="quick"),
            _scene("reverses-poisson", "as reverses, by Poisson's law", law=POISSON),
            _scene("reverses-energetic", "as reverses, by Stronge's law", law=ENERGETIC),
            _scene(
                "painleve",
                "a rod that slides towards its lower end, with a friction of 3",
                duration=0.06,
                hard="no force of the floor carries it: an impact without a collision",
                angle=1.1,
                height=0.0,
                speed=-2.0,
                friction=3.0,
                law=ENERGETIC,
            ),
        ),
        default="sticks",
        facts=facts,
        interest=interest,
    ),
)
