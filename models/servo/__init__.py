"""A position servo on a hinge: its scenes as data. Its theory is the linear pendulum's; if its
controller is digital, the theory of a held loop."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from itertools import islice
from typing import Any

from plumbob.analytic.reference import Reference, Signals
from plumbob.analytic.stability import LOOP_QUANTITIES, LoopQuantity, StabilityTheory
from plumbob.analytic.systems.servo import Servo
from plumbob.analytic.theory import ErrorTheory
from plumbob.models import simple_pendulum as linear
from plumbob.models.field_systems import field_system, field_values
from plumbob.models.quantities import swing_quantities
from plumbob.models.scene import ONE_SMOOTH, Observable, Parameters, make_scene, step_sizes


def facts(servo: Servo) -> Mapping[str, Any]:
    """Returns natural frequency [rad/s] and damping ratio below the force limit. If the motor is
    continuous, returns the largest force before the gear [N m], and the first six times [s] at
    which the motor reaches or leaves its limit. If its controller is digital, returns the factor by
    which a period multiplies the motion in the end, and the hold [s], the delay [s] and the factor
    of the gains up to which the loop is stable."""
    # A servo is a linear pendulum of length 1, whose gravity is the stiffness over the inertia.
    natural = math.sqrt(servo.started.gravity)
    ratios = {
        "natural_frequency": natural,
        "damping_ratio": servo.started.damping_rate / (2 * natural),
    }
    if servo.loop is not None:
        # The eigenvalues, and so the limits, are known to a part of about 1e-13.
        limits = {
            f"largest_{name}": float(f"{servo.loop.limit(name):.10g}")
            for name in LOOP_QUANTITIES
        }
        return {**ratios, "multiplier": servo.loop.multiplier(), **limits}
    return {
        **ratios,
        "peak_force": servo.peak_force,
        "switches": [piece.begin for piece in islice(servo.pieces(), 1, 7)],
    }


def servo_errors(servo: Servo) -> ErrorTheory:
    """Returns the theory of the errors of fixed steps on the motion."""
    if servo.loop is not None:
        from plumbob.analytic.errors.smooth_motion.held_steps import held_errors

        return held_errors(servo.loop)
    if not servo.saturates:
        return linear.errors(servo.started)
    from plumbob.analytic.errors.smooth_motion.stepped_system import smooth_errors

    return smooth_errors(servo, None, servo.implicit)


def reference_of(servo: Servo) -> Reference:
    """Returns the exact motion."""
    if servo.loop is not None:
        return servo.loop
    return servo if servo.saturates else servo.started.motion


def loop_changes(servo: Servo, quantity: LoopQuantity, value: float) -> Parameters:
    """Returns the parameters of a digital controller with another hold [s], another delay [s], or
    both gains times a factor. With another hold the delay stays as many periods."""
    if quantity == "hold":
        return {"hold": value, "delay": servo.delay / servo.hold * value}
    if quantity == "delay":
        return {"delay": value}
    return {"kp": value * servo.kp, "kv": value * servo.kv}


def stability(servo: Servo) -> StabilityTheory | None:
    """Returns the theory of the largest steps; None for a motor with a limit, and for a digital
    controller, whose loop has limits of its own."""
    return None if servo.saturates or servo.loop else linear.stability(servo.started)


def invariants(servo: Servo, observed: Signals) -> Signals:
    """Returns the drift of a linear oscillator; nothing is conserved under a limit, or under a
    digital controller."""
    return {} if servo.saturates or servo.loop else linear.invariants(servo.started, observed)


_scene = partial(
    make_scene,
    duration=0.5,
    system="servo",
    base=field_values(Servo, (0.05, 0.15, 10.0, 0.8, 0.056, 0.0, 6.0, -0.5, 0.0, 0.0, 0.0)),
    steps=step_sizes(1e-2, 1e-3),
    source="MuJoCo's documentation, Computation, Actuation model; the numbers are ours",
)
_light = partial(_scene, duration=2.0, kv=1.2e-3, damping=0.12)
_direct = partial(_scene, inertia=1.0, armature=0.0, gear=1.0, steps=step_sizes(5e-4, 5e-6))
# Half of critical damping: samples up to 100 ms apart are stable.
_held = partial(
    _scene,
    kv=0.04,
    duration=1.0,
    steps=step_sizes(1e-2, 1e-4),
    source="Astrom and Wittenmark 1997, Computer-Controlled Systems, ch. 2; the numbers are ours",
)
SYSTEMS = (
    field_system(
        Servo,
        model_module=f"{__name__}.model",
        name="servo",
        phenomenon=11,
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
            _held(
                "held-half",
                "a digital controller that samples every 50 ms, half of what is stable",
                profile="quick",
                hold=0.05,
            ),
            _held(
                "held-near-limit",
                "samples every 90 ms, nine tenths of what is stable",
                hold=0.09,
            ),
            _held(
                "held-beyond-limit",
                "samples every 110 ms: the swings grow",
                hard="the loop is unstable, and errors grow with the motion",
                hold=0.11,
                duration=0.55,
            ),
            _held(
                "held-late",
                "samples every 12 ms, half of what is stable with forces a period late",
                hold=0.012,
                delay=0.012,
            ),
            _held(
                "held-half-late",
                "forces half a period of 36 ms late, nine tenths of what is stable, "
                "and part of the damping in the joint",
                kv=0.031,
                damping=0.9,
                hold=0.036,
                delay=0.018,
            ),
        ),
        default="motor-damped",
        reference=reference_of,
        errors=servo_errors,
        stability=stability,
        loop=lambda servo: servo.loop,
        loop_changes=loop_changes,
        invariants=invariants,
        facts=facts,
        kind=ONE_SMOOTH,
        start=("theta", "theta_dot"),
        interest=swing_quantities,
    ),
)
