"""What a fixed step makes of the line manoeuvre at every grid time, not only at its end."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from plumbob.analytic.errors.discontinuities import bends, rk4_stop, scheme_lead
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import load_slopes
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre

GRID = 1e-6  # of a step: how near to a grid time a switch is taken to be on it

# With w averaged over the step the velocities at grid times are exact while the body slides, for
# every acceleration is constant between the switches; it stops in the step that has t_star in it.
# What is left of a place's error are its lead and the bends of the velocity.


def line_foretold(
    manoeuvre: LineManoeuvre, scheme: str, step: float, times: Array
) -> Mapping[str, Array]:
    """Error of semi-implicit Euler and of RK4 with `step` [s] at grid `times` [s], shape (n,), by
    observable of `LineReference`: friction asks for rest within a step, w is averaged over it.

    Euler: a place is ahead by half a step, and bends where the velocity does; friction is its mean
    over the step that follows. RK4: no lead, and it stops late. Empty for other schemes.
    """
    line, closed = manoeuvre, manoeuvre.closed
    if (lead := scheme_lead(scheme)) is None:
        return {}
    times = np.asarray(times, dtype=np.float64)
    still, rate = np.zeros_like(times), line.relative_velocity(times)
    slid = lead * step * rate
    slid = slid + bends([(line.t1, -(line.w1 + line.w2)), (line.t2, line.w2)], step, times)
    told = {"stroke": slid, "stroke_rate": still, "heading": still, "sideways": still}
    slopes = load_slopes(line.capsule, line.direction)
    told |= {f"normal_force_{i + 1}": slope * slid for i, slope in enumerate(slopes)}
    if scheme.partition("+")[0] == "rk4" and line.capsule.friction > 0.0:
        on_grid = abs(line.t1 / step - round(line.t1 / step)) < GRID
        if closed.braking_time < 3 * step and not on_grid:
            return told  # push and stop within the stages of one step, or of two
        late, fast = rk4_stop(closed.t_star, closed.braking, step, times, line.t1)
        pushed = bends([(line.t1, closed.backward + closed.braking)], step, times)
        return {**told, "displacement": pushed - late, "velocity": -fast}
    kinks = [(line.t1, closed.backward + closed.braking), (closed.t_star, -closed.braking)]
    moved = lead * step * line.body_velocity(times) + bends(kinks, step, times)
    mean = (line.momentum(times + step) - line.momentum(times)) / step
    told["friction_force"] = mean - line.friction_force(times)
    return {**told, "displacement": moved, "velocity": still}
