"""The slider-crank: its scenes as data, its facts and quantities."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from plumbob.analytic.systems.slider_crank import SliderCrank
from plumbob.models.field_systems import energy_at_start, field_values, smooth_system
from plumbob.models.scene import Case, Observable, Quantity, scene_of, step_sizes

REACTION = tuple(Observable(f"rod_pin_{x}", "N") for x in "xy")


def facts(crank: SliderCrank) -> Mapping[str, Any]:
    """Returns the energy [J], 0 at rest with all links on the line, and whether the crank turns
    over."""
    energy = energy_at_start(crank)
    return {"energy": energy, "turns over": energy > crank.lift}


def interest(case: Case) -> tuple[Quantity, ...]:
    """Returns the crank's angle, with one radian as its scale, and the slider's place, with the
    crank's length."""
    return Quantity("angle", 1.0), Quantity("slider", case.problem.crank)


_scene = partial(
    scene_of,
    system="slider-crank",
    base=field_values(SliderCrank, (0.2, 0.5, 1.0, 1.0, 0.5, 9.81, 1.0, 10.0)),
    source="Uicker, Pennock and Shigley 2017, 2.8; the numbers are ours",
)
SYSTEMS = (
    smooth_system(
        SliderCrank,
        model_module=f"{__name__}.model",
        name="slider-crank",
        title="Slider-crank",
        observables=(Observable("angle", "rad"), Observable("slider", "m")),
        scenes=(
            _scene(
                "turning",
                "the crank turns over, faster below than above",
                1.0,
                "quick",
                steps=step_sizes(1e-2, 1e-3),
            ),
            _scene(
                "nearly-singular",
                "a rod one part in a thousand longer than its crank",
                0.5,
                rod=0.2002,
                steps=step_sizes(2e-3, 2e-4),
                hard="upright, with slider on axis, "
                "where the motion is not unique for equal lengths",
            ),
        ),
        default="turning",
        facts=facts,
        interest=interest,
        also=lambda crank, times: dict(zip(REACTION, crank.reaction(times), strict=True)),
        start=("angle", "angular_velocity"),
    ),
)
