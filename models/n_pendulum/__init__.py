"""A chain of uniform rods: its scenes as data, and its quantities of interest."""

from __future__ import annotations

from functools import partial
from types import MappingProxyType

from plumbob.analytic.systems.n_pendulum import NPendulum
from plumbob.models.field_systems import energy_at_start, smooth_system
from plumbob.models.scene import Case, Observable, Quantity, scene_of, step_sizes


def interest(case: Case) -> tuple[Quantity, ...]:
    """Returns the place of the last rod's end; its scale is the length of the chain."""
    length = sum(case.problem.each("lengths"))
    return Quantity("tip_x", length), Quantity("tip_z", length)


_scene = partial(
    scene_of,
    system="n-pendulum",
    base=MappingProxyType({"masses": 1.0, "gravity": 9.81, "angular_velocities": 0.0}),
    steps=step_sizes(1e-2, 1e-3),
    source="Landau and Lifshitz 1976, Mechanics, 5, for rods; the numbers are ours",
)
_triple = partial(
    _scene, lengths=(0.5, 0.4, 0.3), masses=(1.0, 0.8, 0.6), angles=(1.5, 2.0, 2.5)
)
SYSTEMS = (
    smooth_system(
        NPendulum,
        model_module=f"{__name__}.model",
        name="n-pendulum",
        title="Pendulum of n rods",
        observables=(Observable("tip_x", "m"), Observable("tip_z", "m")),
        scenes=(
            _triple(
                "triple",
                "three rods, released above the axis: chaos within seconds",
                1.0,
                "quick",
            ),
            _scene(
                "small",
                "a small swing of three rods in all modes",
                2.0,
                lengths=0.4,
                angles=(0.02, 0.0, 0.01),
            ),
            _triple(
                "triple-long",
                "the same for longer",
                2.5,
                steps=step_sizes(1e-3, 2e-4),
                hard="chaotic: an error grows tenfold each half second",
            ),
            _scene(
                "stiff-chain",
                "six rods with a short, light one at the end",
                0.5,
                steps=step_sizes(2e-3, 2e-4),
                hard="a fast mode, nine times the slowest's rate, takes a small step",
                masses=(1.0, 1.0, 1.0, 1.0, 1.0, 0.01),
                lengths=(0.1, 0.1, 0.1, 0.1, 0.1, 0.01),
                angles=(0.5, 0.5, 0.5, 0.5, 0.5, 1.0),
            ),
        ),
        default="triple",
        facts=lambda chain: {"energy": energy_at_start(chain)},  # [J] energy above rest
        interest=interest,
        start=("angles", "angular_velocities"),
        weight=2.0,
    ),
)
