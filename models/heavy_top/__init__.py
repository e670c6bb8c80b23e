"""Lagrange's top: its scenes as data, its invariants, facts and quantities."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from plumbob.analytic.reference import Signals
from plumbob.analytic.systems.heavy_top import ANGLES, HeavyTop
from plumbob.models.field_systems import field_values, smooth_system
from plumbob.models.scene import Case, Observable, Quantity, scene_of, step_sizes


def invariants(top: HeavyTop, observed: Signals) -> Signals:
    """Returns the drifts of the energy and of two angular momenta, relative to their values at the
    start."""
    conserved = top.conserved(observed)
    return {name: (x - x[0]) / (abs(x[0]) or 1.0) for name, x in conserved.items()}


def facts(top: HeavyTop) -> Mapping[str, Any]:
    """Returns the energy [J], 0 with a level axis, and the angular momenta [kg m^2/s]."""
    start = top.motion.system.observed(top.motion.system.start[:, None])
    return {name: float(value[0]) for name, value in top.conserved(start).items()}


def interest(case: Case) -> tuple[Quantity, ...]:
    """Returns the angles, with one radian as their scale."""
    return tuple(Quantity(name, 1.0) for name in ANGLES)


_scene = partial(
    scene_of,
    system="heavy-top",
    base=field_values(HeavyTop, (0.5, 0.1, 2e-3, 1e-3, 9.81, 0.5, 1.0, 0.5, 200.0)),
    source="Landau and Lifshitz 1976, Mechanics, 35; the numbers are ours",
)
SYSTEMS = (
    smooth_system(
        HeavyTop,
        model_module=f"{__name__}.model",
        name="heavy-top",
        title="Heavy top",
        observables=tuple(Observable(name, "rad") for name in ANGLES),
        scenes=(
            _scene(
                "nutating",
                "the axis nods while it goes round",
                1.0,
                "quick",
                steps=step_sizes(5e-3, 5e-4),
            ),
            _scene(
                "nearly-sleeping",
                "almost upright, and spinning fast enough to stay so",
                0.5,
                steps=step_sizes(5e-4, 5e-5),
                tilt=0.02,
                precession_rate=0.0,
                tilt_rate=0.0,
                spin_rate=400.0,
                hard="next to the vertical, where Euler's angles end, precession and spin run fast",
            ),
        ),
        default="nutating",
        invariants=invariants,
        facts=facts,
        interest=interest,
        start=("tilt", "precession_rate", "tilt_rate", "spin_rate"),
    ),
)
