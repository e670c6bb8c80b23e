"""A body that is thrown or dropped: its scenes as data, and its quantities of interest."""

from __future__ import annotations

from functools import partial

from plumbob.analytic.systems.projectile import Projectile
from plumbob.models.field_systems import field_values, smooth_system
from plumbob.models.scene import Case, Observable, Quantity, make_scene, step_sizes


def interest(case: Case) -> tuple[Quantity, ...]:
    """Returns the place, with the distance thrown or fallen as its scale, and the angle, with one
    radian."""
    body = case.problem
    duration = case.scene.duration
    distance = max(body.speed * duration, body.gravity * duration**2 / 2) or 1.0
    return Quantity("z", distance), Quantity("x", distance), Quantity("angle", 1.0)


_scene = partial(
    make_scene,
    system="projectile",
    base=field_values(Projectile, (10.0, 0.9, 20.0, 9.81)),
    steps=step_sizes(1e-2, 1e-3),
    source="Landau and Lifshitz 1976, Mechanics, 2; the numbers are ours",
)
SYSTEMS = (
    smooth_system(
        Projectile,
        model_module=f"{__name__}.model",
        name="projectile",
        phenomenon=1,
        title="Projectile",
        observables=(Observable("z", "m"), Observable("x", "m"), Observable("angle", "rad")),
        scenes=(
            _scene("thrown", "thrown upward, spinning", 1.5, "quick"),
            _scene("dropped", "free fall from rest", 1.0, speed=0.0, elevation=0.0, spin=0.0),
        ),
        default="thrown",
        facts=lambda body: {"apex": body.apex},  # [m] height
        stability=None,  # no force depends on the state: every step is stable
        interest=interest,
    ),
)
