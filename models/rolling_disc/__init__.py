"""rolling-disc: a thin disc that rolls without slipping."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

from plumbob.analytic.systems.heavy_top import ANGLES
from plumbob.analytic.systems.rolling_disc import RollingDisc
from plumbob.models.field_systems import field_values, smooth_system
from plumbob.models.heavy_top import interest
from plumbob.models.scene import Observable, from_analytic, scene_of, step_sizes


def facts(disc: RollingDisc) -> Mapping[str, Any]:
    """Returns the spin rate [rad/s] and the radius [m] of a steady circle with this tilt and
    precession, and the rate [rad/s] of small wobbles of an upright disc with this spin. A value is
    None if there is no such circle or wobble."""
    turn = disc.precession_rate
    spin = disc.steady_spin if disc.precession_rate else None
    return {
        "steady_spin": spin,
        "circle_radius": abs(spin / turn) * disc.radius if spin else None,
        "wobble_rate": math.sqrt(disc.wobble) if disc.wobble > 0.0 else None,
    }


_scene = partial(
    scene_of,
    duration=1.0,
    system="rolling-disc",
    base=field_values(RollingDisc, (0.1, 9.81, math.pi / 2, 0.0, 1.0, 30.0)),
    steps=step_sizes(2e-3, 2e-4),
    source="Routh 1905, Advanced Dynamics of a System of Rigid Bodies, 244; the numbers are ours",
)
_STEADY = RollingDisc(0.1, 9.81, 1.2, 4.0, 0.0, 0.0).steady_spin
SYSTEMS = (
    smooth_system(
        RollingDisc,
        model_module=f"{__name__}.model",
        name="rolling-disc",
        title="Rolling disc",
        observables=tuple(Observable(name, "rad") for name in ANGLES),
        scenes=(
            _scene(
                "wobbling",
                "upright and fast enough to stay so, it wobbles",
                duration=0.3,
                profile="quick",
            ),
            _scene(
                "circle",
                "leaning, round a circle of 0.19 m",
                tilt=1.2,
                precession_rate=4.0,
                tilt_rate=0.0,
                spin_rate=_STEADY,
            ),
            _scene(
                "falling",
                "upright and too slow to stay so, it falls and rises again",
                tilt_rate=0.5,
                spin_rate=4.0,
                hard="rolling upright is unstable below 5.7 rad/s",
            ),
        ),
        default="wobbling",
        errors=from_analytic("errors.contact_models.disc_steps.disc_errors"),
        facts=facts,
        interest=interest,
        start=("tilt", "precession_rate", "tilt_rate", "spin_rate"),
    ),
)
