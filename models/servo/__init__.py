"""A position servo on a hinge: its scenes as data; its theory is the linear pendulum's."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from itertools import islice
from typing import Any

from plumbob.analytic.systems.servo import Servo
from plumbob.analytic.theory import ErrorTheory
from plumbob.models import simple_pendulum as linear
from plumbob.models.field_systems import field_system, field_values
from plumbob.models.quantities import swing_quantities
from plumbob.models.scene import ONE_SMOOTH, Observable, from_analytic, scene_of, step_sizes


def facts(servo: Servo) -> Mapping[str, Any]:
    """Returns natural frequency [rad/s] and damping ratio below the force limit, the largest force
    before the gear [N m], and the first six times [s] at which the motor reaches or leaves its
    limit."""
    # A servo is a linear pendulum of length 1, whose gravity is the stiffness over the inertia.
    natural = math.sqrt(servo.started.gravity)
    return {
        "natural_frequency": natural,
        "damping_ratio": servo.started.damping_rate / (2 * natural),
        "peak_force": servo.peak_force,
        "switches": [piece.begin for piece in islice(servo.pieces(), 1, 7)],
    }


def errors(servo: Servo) -> ErrorTheory:
    """Returns the theory of the errors of fixed steps on the motion."""
    if not servo.saturates:
        theory: ErrorTheory = linear.errors(servo.started)
    else:
        smooth_errors = from_analytic("errors.smooth_motion.stepped_system.smooth_errors")
        theory = smooth_errors(servo, None, servo.implicit)
    return theory


_scene = partial(
    scene_of,
    duration=0.5,
    system="servo",
    base=field_values(Servo, (0.05, 0.15, 10.0, 0.8, 0.056, 0.0, 6.0, -0.5, 0.0)),
    steps=step_sizes(1e-2, 1e-3),
    source="MuJoCo's documentation, Computation, Actuation model; the numbers are ours",
)
_light = partial(_scene, duration=2.0, kv=1.2e-3, damping=0.12)
_direct = partial(_scene, inertia=1.0, armature=0.0, gear=1.0, steps=step_sizes(5e-4, 5e-6))
SYSTEMS = (
    field_system(
        Servo,
        model_module=f"{__name__}.model",
        name="servo",
        title="Servo",
        observables=(Observable("theta", "rad"), Observable("theta_dot", "rad/s")),
        scenes=(
            _scene(
                "motor-damped",
                "a step of half a radian, damped by the motor's kv at 0.7 of critical",
                profile="quick",
            ),
            _scene(
                "joint-damped",
                "the same motion with all damping in the joint",
                profile="quick",
                kv=0.0,
                damping=5.6,
            ),
            _light(
                "lightly-damped",
                "three hundredths of critical damping, half in the motor and half in the joint",
                steps=step_sizes(1e-2, 1e-4),
            ),
            _direct(
                "stiff",
                "kp = 10^6 without armature, from a blow",
                duration=0.1,
                hard="omega = 1000 rad/s, a tenth of critical damping: "
                "explicit steps of 2 ms diverge",
                kp=1e6,
                kv=200.0,
                force_limit=1e4,
                theta=0.0,
                theta_dot=5.0,
            ),
            _direct(
                "overdamped",
                "kv of 10^4/s in the motor, where kp alone would turn at 50 rad/s",
                duration=0.2,
                hard="rates of 10^4/s and 0.25/s: "
                "implicit steps of 1 ms hold, explicit ones diverge",
                kp=2500.0,
                kv=1e4,
                force_limit=1e5,
                theta_dot=5.0,
            ),
            _scene(
                "saturated",
                "motor-damped with an eighth of the force, the limit at the start and in braking",
                force_limit=0.5,
            ),
            _light(
                "saturated-swings",
                "lightly-damped with a quarter of the force, the limit in every swing",
                force_limit=1.0,
            ),
        ),
        default="motor-damped",
        reference=lambda servo: servo if servo.saturates else servo.started.motion,
        errors=errors,
        stability=lambda servo: None if servo.saturates else linear.stability(servo.started),
        invariants=lambda servo, observed: (
            {} if servo.saturates else linear.invariants(servo.started, observed)
        ),
        facts=facts,
        kind=ONE_SMOOTH,
        start=("theta", "theta_dot"),
        interest=swing_quantities,
    ),
)
