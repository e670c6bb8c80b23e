"""Errors of fixed steps on any smooth system: the scheme stepped, less the certified motion."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from plumbob.analytic.errors.smooth_motion.scheme_steps import (
    Advance,
    Equations,
    Parts,
    advance,
    states_after,
    steps_until,
)
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.schemes import EULER, STEPPED, Scheme, SoftLoop
from plumbob.analytic.systems.servo import Servo
from plumbob.analytic.theory import StepErrors, apart

MOST_STEPS = 200_000  # of a run: some ten seconds
Implicit = Callable[[Scheme, Parts], tuple[float, float]]
"""A scheme and a state -> damping [1/s] and stiffness [1/s^2]."""


def smooth_errors(
    motion: CertifiedMotion | Servo,
    soft: Callable[[SoftLoop, float], SmoothSystem] | None = None,
    implicit: Implicit | None = None,
) -> StepErrors:
    """The errors of semi-implicit Euler, leapfrog and the TABLEAUX on `motion`, or with a loop that
    is closed softly, of which `soft` gives the equations at a step [s], or with what is `implicit`
    of one coordinate; empty for others, for other damping or springs that act on the state after a
    step, for more than MOST_STEPS steps, for times that are no multiples of the step, and where the
    steps diverge."""

    def error(scheme: Scheme, step: float, times: Array) -> Signals:
        marks = steps_until(times, step, MOST_STEPS)
        system = motion.system
        if scheme.loop is not None and soft is not None:
            system = soft(scheme.loop, step)
        take = advance_of(scheme, system, step, implicit)
        if take is None or marks is None:
            return {}
        try:
            with np.errstate(all="ignore"):  # of steps that diverge
                states: Array = np.array(
                    states_after(take, system.start.tolist(), step, marks.tolist())
                )
        except (ArithmeticError, ValueError):  # math and numbers, of infinity
            return {}
        if not np.isfinite(states).all():
            return {}
        return apart(system.observed(states.T), motion.observe(times))

    return StepErrors(error)


def advance_of(
    scheme: Scheme, system: SmoothSystem, step: Any, implicit: Implicit | None = None
) -> Advance | None:
    """The step of `scheme` on `system`, of a number or an array of sizes [s]; None for others, and
    where a part of the forces is implicit of which nothing is known."""
    values = system.values
    at_end = None
    if implicit is not None and scheme.integrator == EULER:
        at_end = partial(implicit, scheme)
    damped = scheme.implicit_damping > 0.0 and system.damped
    jointed = scheme.joint_closing_rate is not None or scheme.control == "mean"
    unknown = at_end is None and (scheme.implicit_spring or damped)
    if scheme.integrator not in STEPPED or jointed or unknown:
        return None
    equations = Equations(
        lambda time, q, v: system.acceleration(time, q, v, values), len(system.rates), at_end
    )
    return advance(scheme, equations, step)
