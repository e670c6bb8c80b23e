"""What a fixed step does to the line manoeuvre: the exact error of semi-implicit Euler in the final
displacement."""

from __future__ import annotations

from typing import Literal

import numpy as np

from plumbob.analytic.errors.discontinuities import bend
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre

Sampling = Literal["middle", "mean"]

# The scheme:  u = v - mu w dt,  v+ = sgn(u) max(|u| - f g dt, 0),  x+ = x + v+ dt,  with one w held
# over the step. Its v(t_k) is the exact velocity for the control as held, and x is the trapezoid
# sum of v(t_k) because the body starts and ends at rest (so it matters not whether v or x is
# advanced first). The trapezoid rule errs only where v bends inside a step: a bend by J [m/s^2] at
# a fraction p of the step adds J p (1 - p) dt^2/2.


def _pushing_steps(time: float, step: Array) -> Array:
    """Number of steps whose middle comes before `time`."""
    return np.maximum(np.ceil(time / step - 0.5), 0.0)


def step_error(
    manoeuvre: LineManoeuvre, step: float | Array, sampling: Sampling = "middle"
) -> Array:
    """Error of the final displacement [m], simulated minus exact, of semi-implicit Euler with
    Coulomb friction resolved within the step, shape of `step` [s].

    sampling: "middle", w is taken at mid-step; "mean", w is averaged over the step. With t1 on the
    grid both give -p (1 - p)(mu w2 + f g) dt^2/2, p the fraction in t_star/dt: a sawtooth in dt.
    Off the grid, "mean" adds the bend at t1 and stays second order; "middle" does the manoeuvre
    of the nearest t1 on the grid, which is first order. Raises ParameterError for "middle" without
    friction, where the speed left at t2 never dies.
    """
    steps, line = np.asarray(step, dtype=np.float64), manoeuvre
    if not np.all(steps > 0.0):
        raise ParameterError("step", step, "greater than 0")
    a1, a2 = line.closed.backward, line.closed.braking
    if sampling == "mean":
        bends = bend(a1 + a2, line.t1 / steps) - bend(a2, line.t_star / steps)
        return np.asarray(bends * steps**2)
    grip = line.capsule.friction * line.capsule.gravity
    if not grip > 0.0:
        raise ParameterError("friction", line.capsule.friction, "above 0 with w taken at mid-step")
    pushing, until = _pushing_steps(line.t1, steps), _pushing_steps(line.t2, steps)
    pulling = until - pushing
    stop = pushing * (a1 + a2) / a2
    # A coarse step may end the pull before the body rests; friction alone then stops it.
    left = np.maximum(a1 * pushing - a2 * pulling, 0.0)
    pulled = a1 * pushing**2 * (a1 + a2) / a2
    cut = a1 * pushing**2 + (a1 * pushing + left) * pulling + left**2 / grip
    early = left > 0.0
    distance = 0.5 * np.where(early, cut, pulled)
    last = np.where(early, bend(grip, until + left / grip), bend(a2, stop))
    return np.asarray(-(distance + last) * steps**2 - line.displacement)


def step_error_envelope(manoeuvre: LineManoeuvre, step: float | Array) -> Array:
    """Largest |error| of the final displacement [m] over the places that t_star may take in its
    step, with t1 on the grid: (mu w2 + f g) dt^2/8, shape of `step` [s]."""
    return np.asarray(manoeuvre.closed.braking * np.asarray(step, dtype=np.float64) ** 2 / 8)


def leftover_stroke_rate(manoeuvre: LineManoeuvre, step: float | Array) -> Array:
    """Velocity in the body that the slider keeps after t2 [m/s], shape of `step` [s], when w is
    taken at mid-step and t1 or t2 is off the grid; averaged over the step, w leaves none."""
    steps = np.asarray(step, dtype=np.float64)
    pushing, until = _pushing_steps(manoeuvre.t1, steps), _pushing_steps(manoeuvre.t2, steps)
    return np.asarray((manoeuvre.w1 * pushing - manoeuvre.w2 * (until - pushing)) * steps)
