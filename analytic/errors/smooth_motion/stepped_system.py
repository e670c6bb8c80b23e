"""Errors of fixed steps on any smooth system: the stepped motion less the certified motion."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from plumbob.analytic.errors.smooth_motion.scheme_steps import (
    Equations,
    SchemeStep,
    StateParts,
    scheme_step,
    states_after,
    steps_until,
)
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.schemes import EULER, STEPPED_SCHEMES, Scheme, SoftLoop
from plumbob.analytic.systems.servo import Servo
from plumbob.analytic.theory import StepErrors, signal_differences

MAX_SYSTEM_STEPS = 200_000  # steps in a run, which take some ten seconds
Implicit = Callable[[Scheme, StateParts], tuple[float, float]]
"""Function from a scheme and a state to implicit damping [1/s] and stiffness [1/s^2]."""


def smooth_errors(
    motion: CertifiedMotion | Servo,
    soft: Callable[[SoftLoop, float], SmoothSystem] | None = None,
    implicit: Implicit | None = None,
) -> StepErrors:
    """Returns the errors of the schemes of STEPPED_SCHEMES on `motion`.

    `soft` gives the equations of a softly closed loop at a step [s]. `implicit` gives the damping
    and stiffness of one coordinate that act on the state after a step.

    The errors are empty for other schemes, for implicit damping or springs that `implicit` does not
    give, for more than MAX_SYSTEM_STEPS steps, for times that are no multiples of the step, and if
    the steps diverge.
    """

    def error(scheme: Scheme, step: float, times: Array) -> Signals:
        """Returns the error of each observable at `times` [s]."""
        marks = steps_until(times, step, MAX_SYSTEM_STEPS)
        system = motion.system
        if scheme.loop is not None and soft is not None:
            system = soft(scheme.loop, step)
        advance = system_step(scheme, system, step, implicit)
        if advance is None or marks is None:
            return {}
        start = system.start.tolist()
        try:
            with np.errstate(all="ignore"):  # diverging steps overflow
                states: Array = np.array(states_after(advance, start, step, marks.tolist()))
        except (ArithmeticError, ValueError):  # plain numbers raise if the steps diverge
            return {}
        if not np.isfinite(states).all():
            return {}
        return signal_differences(system.observed(states.T), motion.observe(times))

    return StepErrors(error)


def system_step(
    scheme: Scheme, system: SmoothSystem, step: Any, implicit: Implicit | None = None
) -> SchemeStep | None:
    """Returns the step of `scheme` on `system`; `step` is a size [s] or an array of sizes.

    Returns None for schemes that are not stepped here, and if the scheme treats a part of the
    forces implicitly that `implicit` does not give.
    """
    values = system.values
    implicit_at_end = None
    if implicit is not None and scheme.integrator == EULER:
        implicit_at_end = partial(implicit, scheme)
    damped = scheme.implicit_damping > 0.0 and system.damped
    jointed = scheme.joint_closing_rate is not None or scheme.control == "mean"
    unknown = implicit_at_end is None and (scheme.implicit_spring or damped)
    if scheme.integrator not in STEPPED_SCHEMES or jointed or unknown:
        return None

    def acceleration(time: Any, q: StateParts, v: StateParts) -> StateParts:
        """Returns the accelerations q'' of the system with its values."""
        return system.acceleration(time, q, v, values)

    equations = Equations(acceleration, len(system.rates), implicit_at_end)
    return scheme_step(scheme, equations, step)
