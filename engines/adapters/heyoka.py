"""heyoka as an engine: Taylor series of an order that the tolerance chooses, compiled for a scene.

An optional, independent method: it solves the same equation of motion as the reference's own Taylor
series, by other code, and shows what a smooth scene can cost. It translates the pendulums' equation
in one angle, a free body's of its angular velocity and attitude, and any mass matrix with forces.
"""

from __future__ import annotations

import operator
import time
from collections.abc import Callable
from functools import partial
from typing import Any, cast

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import ADAPTIVE, Scheme
from plumbob.engines.abilities import SecondRun
from plumbob.engines.adapters.chain import Vector
from plumbob.engines.adapters.stepping import (
    Followed,
    FollowedSimulation,
    Named,
    no_error,
    relative_tolerance,
)
from plumbob.engines.method import Engine, Method, Simulation, Unsupported
from plumbob.engines.sampling import SAMPLES
from plumbob.models.scene import FREE_ROTATION, ONE_SMOOTH, SMOOTH, Case

SMALLEST = ULP
TOLERANCES = tuple(float(f"1e-{digits}") for digits in range(3, 17, 2))
KINDS = (ONE_SMOOTH, SMOOTH, FREE_ROTATION)
METHODS = (
    Method("heyoka/taylor", Scheme(ADAPTIVE), None, "tolerance", {}, TOLERANCES, kinds=KINDS),
)


Observe = Callable[[Array], Named]
Translated = tuple[list[tuple[Any, Any]], tuple[float, ...], Observe]
"""Equations of motion, the start, and what observes states, shape (d, m)."""


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Compile `case` at the relative tolerance `step`; raises Unsupported and ParameterError."""
    relative_tolerance(step, SMALLEST)
    begin = time.perf_counter()
    if case.system.name == "free-body":
        equations, start, observe = _turning(case.problem)
    elif case.system.kind == SMOOTH:
        equations, start, observe = _smooth(case.problem.motion.system)
    else:
        equations, start, observe = _pendulum(case)
    import heyoka

    # Loops in place of long straight code: compiled in a fraction of the time, and half as fast.
    compact = case.system.kind == SMOOTH
    integrator = cast(Any, heyoka.taylor_adaptive)(
        equations, list(start), tol=step, compact_mode=compact
    )
    seconds = time.perf_counter() - begin
    follow = partial(_follow, integrator, start)
    return FollowedSimulation(follow, observe, case.scene.duration, seconds)


def _follow(integrator: Any, start: tuple[float, ...], duration: float, samples: int) -> Followed:
    integrator.time, integrator.state[:] = 0.0, start
    times = np.linspace(0.0, duration, SAMPLES + 1)
    outcome, _, _, steps, *_, states = integrator.propagate_grid(times)
    good = np.isfinite(states).all(axis=1)
    ended = "time_limit" in str(outcome) and bool(good.all())
    # A step counts as many right-hand sides as its order.
    evaluations, why = int(steps) * int(integrator.order), () if ended else (str(outcome),)
    return Followed(times[good], states[good].T, evaluations, ended, why)


def _pendulum(case: Case) -> Translated:
    problem = getattr(case.problem, "started", case.problem)
    rotor = getattr(getattr(problem, "motion", None), "rotor", None)
    if rotor is None or getattr(case.problem, "saturates", False):
        raise Unsupported(
            f"heyoka has no builder for {case.system.name}: no driven rotor in one angle"
        )
    tilt = getattr(problem, "tilt", 0.0)
    start = (problem.theta + tilt, problem.theta_dot)
    return (
        _equations(rotor),
        start,
        lambda states: {
            "theta": states[0] - tilt,
            "theta_dot": states[1],
        },
    )


def _turning(body: Any) -> Translated:
    """A free body: Euler's equations, and a quaternion."""
    from plumbob.analytic.systems.free_body.rotation import ATTITUDE, RATES

    start = (1.0, 0.0, 0.0, 0.0, *body.angular_velocity)
    names = (*ATTITUDE, *RATES)
    return _free_body(body.inertia), start, lambda states: dict(zip(names, states, strict=True))


def _free_body(inertia: Vector) -> list[tuple[Any, Any]]:
    """Rates of the quaternion and of the angular velocity, in the body's axes."""
    import heyoka

    w, x, y, z, *rates = heyoka.make_vars("w", "x", "y", "z", "u", "v", "r")
    u, v, r = rates
    first, second, third = inertia
    halves = (
        -x * u - y * v - z * r,
        w * u + y * r - z * v,
        w * v - x * r + z * u,
        w * r + x * v - y * u,
    )
    return [
        *((name, 0.5 * slope) for name, slope in zip((w, x, y, z), halves, strict=True)),
        (u, (second - third) / first * (v * r)),
        (v, (third - first) / second * (r * u)),
        (r, (first - second) / third * (u * v)),
    ]


class _Term(NDArrayOperatorsMixin):
    """An expression that numpy's operators and functions take."""

    def __init__(self, expression: Any) -> None:
        self.expression = expression

    def __array_ufunc__(self, function: Any, method: str, *inputs: Any, **options: Any) -> _Term:
        import heyoka

        short = {"subtract": "sub", "multiply": "mul", "divide": "truediv", "power": "pow"}
        short["negative"] = "neg"
        name, values = function.__name__, [getattr(x, "expression", x) for x in inputs]
        apply = getattr(operator, short.get(name, name), None) or getattr(heyoka, name)
        return _Term(apply(*values))


def _smooth(system: SmoothSystem) -> Translated:
    """Any smooth system: its own functions, of expressions."""
    import heyoka

    variables: Any = heyoka.make_vars(*system.coordinates, *system.rates)
    terms, half = [_Term(variable) for variable in variables], len(system.rates)
    q, v = terms[:half], terms[half:]
    slopes = (*v, *system.acceleration(_Term(heyoka.time), q, v, system.values))
    equations = [(x, getattr(y, "expression", y)) for x, y in zip(variables, slopes, strict=True)]
    return equations, tuple(system.start.tolist()), system.observed


def confirming(method: Method) -> tuple[Method, float]:
    """The method itself at its smallest tolerance."""
    return method, SMALLEST


def _equations(rotor: DrivenRotor) -> list[tuple[Any, Any]]:
    """The rotor's equation in heyoka's terms, which drops what is zero in it."""
    import heyoka

    terms: Any = heyoka
    theta, theta_dot = terms.make_vars("theta", "theta_dot")
    phase = rotor.forcing_frequency * terms.time + rotor.forcing_phase
    pull = rotor.sin2 * terms.sin(2.0 * theta) + rotor.cos * terms.cos(theta)
    pull += -rotor.sin * terms.sin(theta) - rotor.stiffness * theta
    pull += rotor.forcing_amplitude * terms.sin(phase) - rotor.damping_rate * theta_dot
    return [(theta, theta_dot), (theta_dot, pull)]


ENGINE = Engine(
    "heyoka",
    "heyoka",
    METHODS,
    prepare,
    no_error,
    optional=True,
    abilities=(SecondRun(confirming),),
)
