"""A position servo on a hinge: scenes as data; its theory is that of a linear pendulum."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from plumbob.analytic.systems.servo import Servo
from plumbob.analytic.theory import ErrorTheory
from plumbob.models import simple_pendulum as linear
from plumbob.models.field_systems import field_system, field_values
from plumbob.models.quantities import swing
from plumbob.models.scene import ONE_SMOOTH, Observable, Scene, from_analytic, step_sizes


def facts(servo: Servo) -> Mapping[str, Any]:
    """Natural frequency [rad/s] and damping ratio below the limit, the largest force before the
    gear [N m], and when the motor first comes to its limit or leaves it [s]."""
    natural = math.sqrt(servo.started.gravity)
    return {
        "natural_frequency": natural,
        "damping_ratio": servo.started.damping_rate / (2 * natural),
        "peak_force": servo.peak_force,
        "switches": [piece.begin for piece in islice(servo.pieces(), 1, 7)],
    }


def errors(servo: Servo) -> ErrorTheory:
    """Theory of the errors of fixed steps on the motion."""
    if not servo.saturates:
        theory: ErrorTheory = linear.errors(servo.started)
    else:
        smooth_errors = from_analytic("errors.smooth_motion.stepped_system.smooth_errors")
        theory = smooth_errors(servo, None, servo.implicit)
    return theory


def _scene(case: str, summary: str, values: tuple[float, ...], **more: Any) -> Scene:
    return Scene(
        f"servo/{case}",
        summary,
        field_values(Servo, values),
        source="MuJoCo's documentation, Computation, Actuation model; the numbers are ours",
        **more,
    )


_ARM = (0.05, 0.15, 10.0)  # inertia, armature, gear
SYSTEM = field_system(
    Servo,
    Path(__file__).parent / "servo.xml",
    name="servo",
    title="Servo",
    observables=(Observable("theta", "rad"), Observable("theta_dot", "rad/s")),
    scenes=(
        _scene(
            "motor-damped",
            "a step of half a radian, damped by the motor's kv at 0.7 of critical",
            (*_ARM, 0.8, 0.056, 0.0, 6.0, -0.5, 0.0),
            duration=0.5,
            steps=step_sizes(1e-2, 1e-3),
            profile="quick",
        ),
        _scene(
            "joint-damped",
            "the same motion with all damping in the joint",
            (*_ARM, 0.8, 0.0, 5.6, 6.0, -0.5, 0.0),
            duration=0.5,
            steps=step_sizes(1e-2, 1e-3),
            profile="quick",
        ),
        _scene(
            "lightly-damped",
            "three hundredths of critical damping, half in the motor and half in the joint",
            (*_ARM, 0.8, 1.2e-3, 0.12, 6.0, -0.5, 0.0),
            duration=2.0,
            steps=step_sizes(1e-2, 1e-4),
        ),
        _scene(
            "stiff",
            "kp = 10^6 without armature, from a blow",
            (1.0, 0.0, 1.0, 1e6, 200.0, 0.0, 1e4, 0.0, 5.0),
            duration=0.1,
            steps=step_sizes(5e-4, 5e-6),
            hard="omega = 1000 rad/s, a tenth of critical damping: explicit steps of 2 ms diverge",
        ),
        _scene(
            "overdamped",
            "kv of 10^4/s in the motor, where kp alone would turn at 50 rad/s",
            (1.0, 0.0, 1.0, 2500.0, 1e4, 0.0, 1e5, -0.5, 5.0),
            duration=0.2,
            steps=step_sizes(5e-4, 5e-6),
            hard="rates of 10^4/s and 0.25/s: implicit steps of 1 ms hold, explicit ones diverge",
        ),
        _scene(
            "saturated",
            "motor-damped with an eighth of the force, the limit at the start and in braking",
            (*_ARM, 0.8, 0.056, 0.0, 0.5, -0.5, 0.0),
            duration=0.5,
            steps=step_sizes(1e-2, 1e-3),
        ),
        _scene(
            "saturated-swings",
            "lightly-damped with a quarter of the force, the limit in every swing",
            (*_ARM, 0.8, 1.2e-3, 0.12, 1.0, -0.5, 0.0),
            duration=2.0,
            steps=step_sizes(1e-2, 1e-3),
        ),
    ),
    default="motor-damped",
    reference=lambda servo: servo if servo.saturates else linear.reference(servo.started),
    errors=errors,
    stability=lambda servo: None if servo.saturates else linear.stability(servo.started),
    invariants=lambda servo, observed: (
        {} if servo.saturates else linear.invariants(servo.started, observed)
    ),
    facts=facts,
    kind=ONE_SMOOTH,
    start=("theta", "theta_dot"),
    interest=swing,
)
SYSTEMS = (SYSTEM,)
