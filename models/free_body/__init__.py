"""The free rigid body (Euler-Poinsot): its scenes as data, its facts and quantities."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array
from plumbob.analytic.stability import StabilityTheory
from plumbob.analytic.systems.free_body.problem import FreeBody
from plumbob.analytic.systems.free_body.rotation import ANGULAR_VELOCITY_NAMES, ATTITUDE
from plumbob.analytic.theory import ErrorTheory
from plumbob.models.field_systems import field_system, field_values
from plumbob.models.scene import (
    FREE_ROTATION,
    Case,
    Observable,
    Quantity,
    Scene,
    make_scene,
    step_sizes,
)

if TYPE_CHECKING:
    from plumbob.analytic.sensitivities.neighbours import Neighbours, Sensitivity

QUATERNION_ERROR = 0.5  # error of the quaternion for an error of 1 rad of the attitude


def facts(body: FreeBody) -> Mapping[str, Any]:
    """Returns the kind of motion; half the period of the angular velocity [s], None if the angular
    velocity is constant or never returns; energy [J]; and angular momentum [kg m^2/s] in the
    world."""
    moments = body.inertia
    rates = body.angular_velocity
    return {
        "kind": body.kind,
        "half_period": body.half_period if math.isfinite(body.half_period) else None,
        "energy": sum(i * w * w for i, w in zip(moments, rates, strict=True)) / 2,
        "angular_momentum": double(body.rotation.momentum).tolist(),
    }


def interest(case: Case) -> tuple[Quantity, ...]:
    """Returns the attitude, with one radian as its scale, and the angular velocity, with its
    magnitude."""
    size = case.problem.speed or 1.0
    return (
        *(Quantity(name, QUATERNION_ERROR) for name in ATTITUDE),
        *(Quantity(name, size) for name in ANGULAR_VELOCITY_NAMES),
    )


def errors(body: FreeBody) -> ErrorTheory:
    """Returns the theory of the errors of fixed steps on the motion."""
    from plumbob.analytic.errors.smooth_motion.free_body_errors import free_body_errors

    return free_body_errors(body)


def stability(body: FreeBody) -> StabilityTheory:
    """Returns the theory of the largest steps on the motion."""
    from plumbob.analytic.errors.stability.free_rotation import free_rotation_stability

    return free_rotation_stability(body)


def gradients(problems: Sequence[Neighbours[FreeBody]], times: Array) -> list[Sensitivity]:
    """Returns the sensitivities at `times` [s], shape (n,), by each parameter; `problems` has the
    neighbours by one parameter each."""
    from plumbob.analytic.sensitivities.smooth_systems import free_body_gradients

    return free_body_gradients(problems, times)


_scene = partial(
    make_scene,
    duration=10.0,
    system="free-body",
    base=field_values(FreeBody, (1.0, 2.0, 2.25, (0.02, 4.0, 0.0))),
    steps=step_sizes(5e-2, 2e-4),
    source="Whittaker 1937, Analytical Dynamics, 69; the numbers are ours",
)


def _near_separatrix(k: int) -> Scene:
    """Returns the scene that starts a relative 10^-k off the separatrix."""
    return _scene(
        f"separatrix-1e-{k}",
        f"10^-{k} off the separatrix, relatively, and over to the other side",
        angular_velocity=(3.0 * (1.0 + float(f"1e-{k}")), 0.0, 4.0),
        duration=float(math.ceil(2.5 + 1.9 * k)),
        hard=f"errors grow as e^(1.6 t) next to the unstable axis, by up to 10^{k} in all",
    )


_SCENES = (
    _scene(
        "flip",
        "next to the unstable axis: the body turns over within ten seconds",
        profile="quick",
        hard="errors grow as e^(1.3 t) next to the unstable axis, before each flip",
    ),
    _scene(
        "symmetric",
        "a symmetric body: the axis goes round the angular momentum evenly",
        angular_velocity=(0.4, 0.0, 2.0),
        inertia_y=1.0,
        inertia_z=1.75,
        profile="quick",
    ),
    _scene(
        "about-largest",
        "about the axis of the largest moment, with some nutation",
        angular_velocity=(0.3, 0.2, 2.0),
    ),
    _scene(
        "about-smallest",
        "about the axis of the smallest moment, with some nutation",
        angular_velocity=(2.0, 0.2, 0.3),
    ),
    _scene(
        "spherical",
        "equal moments: a uniform rotation about an axis off the body's",
        angular_velocity=(1.0, -1.0, 1.5),
        inertia_x=2.0,
        inertia_z=2.0,
    ),
    _scene(
        "separatrix",
        "on the separatrix itself: ends on the unstable axis, never to turn over",
        angular_velocity=(3.0, 0.0, 4.0),
        duration=6.0,
        hard="errors grow as e^(1.6 t) next to the unstable axis, to no end",
    ),
    *(_near_separatrix(k) for k in (3, 6, 9)),
    _scene(
        "flip-1e-3",
        "a flip of a body whose moments differ by 10^-3: it turns a thousand times meanwhile",
        angular_velocity=(0.5, 10.0, 0.0),
        inertia_y=1.001,
        inertia_z=1.002,
        duration=500.0,
        steps=step_sizes(2e-2, 1e-3),
        hard="moments within 10^-3: an error of a moment weighs 10^3 times as much in the flip",
    ),
    _scene(
        "million-steps",
        "about the axis of the largest moment, for 318 turns",
        angular_velocity=(0.3, 0.2, 2.0),
        duration=1000.0,
        steps=(8e-3, 4e-3, 2e-3, 1e-3),
        hard="10^6 steps of 1 ms: an error of the rate becomes one of the attitude",
    ),
)

SYSTEMS = (
    field_system(
        FreeBody,
        Path(__file__).parent / "free_body.xml",
        model_module=f"{__name__}.model",
        name="free-body",
        title="Free rigid body",
        observables=(
            *(Observable(name, "1") for name in ATTITUDE),
            *(Observable(name, "rad/s") for name in ANGULAR_VELOCITY_NAMES),
        ),
        scenes=_SCENES,
        default="flip",
        reference=lambda body: body,
        errors=errors,
        stability=stability,
        start=("angular_velocity",),
        invariants=FreeBody.invariants,
        facts=facts,
        kind=FREE_ROTATION,
        interest=interest,
        sensitivity=gradients,
        weight=2.0,
    ),
)
