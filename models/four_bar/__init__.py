"""The four-bar linkage: its scenes as data, its facts and quantities."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from plumbob.analytic.systems.four_bar import FourBar
from plumbob.models.field_systems import energy_at_start, field_values, smooth_system
from plumbob.models.scene import Case, Observable, Quantity, scene_of, step_sizes

REACTION = tuple(Observable(f"rocker_axis_{x}", "N") for x in "xy")


def facts(bars: FourBar) -> Mapping[str, Any]:
    """Returns the energy [J], 0 at rest with all links on the line, and the transmission angle
    [rad]."""
    return {"energy": energy_at_start(bars), "transmission_angle": bars.transmission_angle}


def interest(case: Case) -> tuple[Quantity, ...]:
    """Returns the crank's angle, with one radian as its scale, and the coupler's place, with the
    crank's length."""
    return Quantity("angle", 1.0), *(Quantity(f"coupler_{x}", case.problem.crank) for x in "xy")


_scene = partial(
    scene_of,
    duration=0.5,
    system="four-bar",
    base=field_values(FourBar, (0.2, 0.5, 0.4, 0.5, 0.5, 1.0, 0.8, 9.81, 1.0, 10.0)),
    source="Uicker, Pennock and Shigley 2017, 3.8; the numbers are ours",
)
SYSTEMS = (
    smooth_system(
        FourBar,
        model_module=f"{__name__}.model",
        name="four-bar",
        title="Four-bar linkage",
        observables=(
            Observable("angle", "rad"),
            *(Observable(f"coupler_{x}", "m") for x in "xy"),
        ),
        scenes=(
            _scene(
                "crank-rocker",
                "the crank turns, the rocker swings",
                steps=step_sizes(1e-2, 1e-3),
                profile="quick",
            ),
            _scene(
                "near-change-point",
                "a rocker one part in a thousand longer than its crank, "
                "opposite links all but equal",
                rocker=0.2002,
                steps=step_sizes(2e-3, 2e-4),
                hard="nearly on one line, where for equal links the motion is not unique",
            ),
        ),
        default="crank-rocker",
        facts=facts,
        interest=interest,
        also=lambda bars, times: dict(zip(REACTION, bars.reaction(times), strict=True)),
        start=("angle", "angular_velocity"),
    ),
)
