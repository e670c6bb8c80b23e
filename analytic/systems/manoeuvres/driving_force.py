"""The actuator's force on the slider along a line, and the demand for which an actuator
is sized."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.capsule_motion import Demand


def driving_force(capsule: Capsule, friction: Array, acceleration: Array) -> Array:
    """Returns the force F of the actuator on the slider [N], from the `friction` on the body [N]
    and the slider's `acceleration` in the body [m/s^2], all of one shape. By eqs. 3 and 9
    (Chernousko 2020), without the body's acceleration, F = mu F_f + (1 - mu) m w. Gravity tilted
    along the line does not change it."""
    mu = capsule.mass_ratio
    reduced = mu * capsule.body_mass  # [kg] (1 - mu) m, without cancellation
    return mu * friction + reduced * acceleration


def demand(motion: Any, duration: float) -> Demand:
    """Returns the demand of one `motion` along a line over `duration` [s]. Between two switches the
    force is constant and the slider's velocity is linear in time.

    >>> corners = ((0.2, 0.0), (-0.1, 0.15), (-0.1, -0.15))
    >>> from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
    >>> capsule = Capsule(1.0, 0.3, 0.02, corners, friction=0.3, gravity=9.81)
    >>> line = LineManoeuvre(capsule, w1=40.0, w2=10.0, t1=0.05)
    >>> print(f"{demand(line, line.t2).peak:.4f} N")
    10.1137 N
    """
    starts = [phase.start for phase in motion.phases]
    edges = np.unique(np.clip([*starts, duration], 0.0, duration))
    middles = 0.5 * (edges[1:] + edges[:-1])
    lengths = np.diff(edges)
    forces = motion.driving_force(middles)
    state = motion.at(middles)
    # The force is constant and the velocity linear: the power is largest at an interval's end.
    speeds = np.abs(state.stroke_rate) + np.abs(0.5 * lengths * state.pull)
    return Demand(
        peak=float(np.abs(forces).max()),
        rms=math.sqrt(float(np.sum(forces**2 * lengths)) / duration),
        power=float(np.abs(forces * speeds).max()),
    )
