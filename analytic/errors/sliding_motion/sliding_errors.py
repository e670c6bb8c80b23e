"""Errors of fixed steps on coasting, and on motions along a line that friction brings to rest."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from plumbob.analytic.errors.sliding_motion.discontinuities import (
    GRID,
    rk4_stop,
    trapezoid_error,
    trapezoid_errors,
)
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import RK4, Scheme
from plumbob.analytic.systems.capsule import NORMAL_FORCES, by_support, load_slopes
from plumbob.analytic.systems.manoeuvres.driving_force import driving_force
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.manoeuvres.repeated_line import RepeatedLine
from plumbob.analytic.systems.manoeuvres.residual_motion import Coasting, ResidualMotion
from plumbob.analytic.systems.manoeuvres.slow_motion import SlowStroke
from plumbob.analytic.systems.manoeuvres.tilted_hold import TiltedHold

# Of a step: a start nearer to a grid time is on it. Rounding leaves 1e-9 after a million steps, and
# the velocity that this costs, f g step, is then below 1e-10 m/s for steps of milliseconds.
STARTS = 1e-8

Errors = Mapping[str, Array]

# With w averaged over the step the velocities at grid times are exact while the body slides, for
# every acceleration is constant between the switches; it stops in the step that has t_star in it.
# What remains of a position's error is its lead (`Scheme.position_lead`) and the trapezoid error of
# the velocity's discontinuous slope (THEORY.md, section 4).


def line_errors(line: LineManoeuvre, scheme: Scheme, step: float, times: Array) -> Errors:
    """Error of semi-implicit Euler and of RK4 with `step` [s] at grid `times` [s], shape (n,), by
    observable of `LineReference`: friction stops it within a step, w is averaged over it.

    Euler: a position is ahead by half a step, and has a trapezoid error where the acceleration
    jumps; friction is its mean over the step that follows. RK4: no lead, and it stops late;
    friction is that of the first stage of the step that follows. Empty for other schemes.
    """
    closed = line.closed
    if (lead := scheme.position_lead) is None:
        return {}
    times = np.asarray(times, dtype=np.float64)
    still, rate = np.zeros_like(times), line.relative_velocity(times)
    slid = lead * step * rate
    jumps = [(line.t1, -(line.w1 + line.w2)), (line.t2, line.w2)]
    slid = slid + trapezoid_errors(jumps, step, times)
    errors = {"stroke": slid, "stroke_rate": still, "heading": still, "sideways": still}
    errors |= _normal_forces(line, slid)
    if scheme.integrator == RK4 and line.capsule.friction > 0.0:
        on_grid = abs(line.t1 / step - round(line.t1 / step)) < GRID
        if closed.braking_time < 3 * step and not on_grid:
            return errors  # push and stop within the stages of one step, or of two
        late, fast = rk4_stop(closed.t_star, closed.braking, step, times, line.t1)
        pushed = trapezoid_errors([(line.t1, closed.backward + closed.braking)], step, times)
        velocity = line.body_velocity(times) - fast
        errors |= {"displacement": pushed - late, "velocity": -fast}
        errors["friction_force"] = _first_stage(line, step, times, velocity)
        return errors | _driving_force(line, errors["friction_force"], step, times)
    jumps = [(line.t1, closed.backward + closed.braking), (closed.t_star, -closed.braking)]
    moved = lead * step * line.body_velocity(times) + trapezoid_errors(jumps, step, times)
    mean = (line.momentum(times + step) - line.momentum(times)) / step
    errors["friction_force"] = mean - line.friction_force(times)
    errors |= _driving_force(line, errors["friction_force"], step, times)
    return {**errors, "displacement": moved, "velocity": still}


def stroke_errors(
    stroke: SlowStroke, scheme: Scheme, step: float, times: Array, begun: float = 0.0
) -> Errors:
    """Error of semi-implicit Euler and of RK4 with `step` [s] at `times` [s], shape (n,), w
    averaged over each step: the slider's lead and trapezoid errors; the body does not move. With
    `begun` [s] added, the times are those of a grid. Empty for other schemes."""
    if (lead := scheme.position_lead) is None:
        return {}
    times = np.asarray(times, dtype=np.float64)
    rate = stroke.relative_velocity
    jumps = [(begun + time, jump) for time, jump in stroke.acceleration_jumps]
    slid = lead * step * rate(times) + trapezoid_errors(jumps, step, begun + times)
    mean = np.diff(rate(np.stack([times, times + step])), axis=0)[0] / step
    still = np.zeros_like(times)
    force = stroke.capsule.slider_mass * (mean - stroke.relative_acceleration(times))
    return {
        **dict.fromkeys(("displacement", "velocity", "heading", "sideways"), still),
        "stroke": slid,
        "stroke_rate": still,
        **_normal_forces(stroke, slid),
        "friction_force": force,
        "driving_force": force,
    }


def repeated_line_errors(motion: RepeatedLine, scheme: Scheme, step: float, times: Array) -> Errors:
    """Error of semi-implicit Euler and of RK4 with `step` [s] at grid `times` [s], shape (n,), w
    averaged over each step and every start on the grid: it adds up over the manoeuvres. Empty for
    other schemes, and where a start is off the grid: friction within a step is then held against
    a push that lasts for a part of it, which leaves a velocity of up to f g step."""
    if scheme.position_lead is None:
        return {}
    times = np.asarray(times, dtype=np.float64)
    done, local = motion.within(times)
    starts = np.unique(done) * motion.period / step
    if np.abs(starts - np.round(starts)).max() > STARTS:
        return {}
    line, end = motion.manoeuvre, np.array([motion.period])
    errors = dict(line_errors(line, scheme, step, local))
    after = stroke_errors(motion.returning, scheme, step, local - line.t2, line.t2)
    per_line = line_errors(line, scheme, step, end)
    per_return = stroke_errors(motion.returning, scheme, step, end - line.t2, line.t2)
    errors["displacement"] = errors["displacement"] + done * per_line["displacement"]
    errors["stroke"] = (
        errors["stroke"] + after["stroke"] + done * (per_line["stroke"] + per_return["stroke"])
    )
    errors |= _normal_forces(line, errors["stroke"])
    if scheme.integrator == RK4 and line.capsule.friction > 0.0:
        if (late := errors.get("velocity")) is not None:
            errors["friction_force"] = _first_stage(
                motion, step, times, line.body_velocity(local) + late
            )
    elif "friction_force" in errors:
        gained = np.diff(motion.momentum(np.stack([times, times + step])), axis=0)[0]
        errors["friction_force"] = gained / step - motion.friction_force(times)
    if "friction_force" in errors:
        errors |= _driving_force(motion, errors["friction_force"], step, times)
    return errors


def hold_errors(hold: TiltedHold, scheme: Scheme, step: float, times: Array) -> Errors:
    """Error of semi-implicit Euler and of RK4 at `times` [s], shape (n,): none. Empty for other
    schemes."""
    if scheme.position_lead is None:
        return {}
    return {name: np.zeros_like(value) for name, value in hold.observe(times).items()}


def coasting_errors(motion: ResidualMotion, scheme: Scheme, step: float, times: Array) -> Errors:
    """Error of semi-implicit Euler and of RK4 with `step` [s] at grid `times` [s], shape (n,), with
    friction that stops the body within a step; the coordinates of C only where its path is no
    circle. Empty for other schemes."""
    if (lead := scheme.position_lead) is None:
        return {}
    times = np.asarray(times, dtype=np.float64)
    still, loads = np.zeros_like(times), by_support(np.zeros((times.size, 3)))
    way, rate = _coasting(motion.coasting, scheme.integrator, lead * step, step, times)
    if motion.centre is None:
        cos, sin = math.cos(motion.direction), math.sin(motion.direction)
        errors = {
            "x": way * cos,
            "y": way * sin,
            "velocity_x": rate * cos,
            "velocity_y": rate * sin,
        }
        return {**errors, **loads, **dict.fromkeys(("heading", "heading_rate"), still)}
    central = dict.fromkeys(("x", "y", "velocity_x", "velocity_y"), still)
    turned = {"heading": way, "heading_rate": rate}
    return {**(central if motion.centre == (0.0, 0.0) else {}), **turned, **loads}


def _coasting(
    moving: Coasting, integrator: str, lead: float, step: float, times: Array
) -> tuple[Array, Array]:
    """Errors of the way, of positions `lead` [s] ahead, and of its rate."""
    sense = math.copysign(1.0, moving.rate)
    if integrator == RK4:
        late, fast = rk4_stop(moving.duration, moving.deceleration, step, times)
        return sense * late, sense * fast
    way = lead * (moving.rates(times) - moving.rate)
    jumps = [(moving.duration, sense * moving.deceleration)]
    return way + trapezoid_errors(jumps, step, times), np.zeros_like(times)


def _first_stage(
    motion: LineManoeuvre | RepeatedLine, step: float, times: Array, velocity: Array
) -> Array:
    """Errors of friction [N] in the first stage of RK4 steps of `step` [s] that begin at grid
    `times` [s], shape (n,), the body moving at `velocity` [m/s]: what would bring it to rest
    within the step against the mean control, at most the friction limit."""
    capsule = motion.single.capsule
    both, limit = capsule.body_mass + capsule.slider_mass, capsule.friction * capsule.weight
    gained = np.diff(motion.relative_velocity(np.stack([times, times + step])), axis=0)[0]
    asked = (capsule.slider_mass * gained - both * velocity) / step
    return np.asarray(np.clip(asked, -limit, limit) - motion.friction_force(times))


def _driving_force(
    motion: LineManoeuvre | RepeatedLine, friction: Array, step: float, times: Array
) -> dict[str, Array]:
    """Errors of the actuator's force [N] over steps of `step` [s] that begin at grid `times` [s],
    shape (n,): of `friction` [N], and of w, of which a step has the mean."""
    gained = np.diff(motion.relative_velocity(np.stack([times, times + step])), axis=0)[0]
    off = gained / step - motion.relative_acceleration(times)
    return {"driving_force": driving_force(motion.single.capsule, friction, off)}


def _normal_forces(motion: LineManoeuvre | SlowStroke, slid: Array) -> dict[str, Array]:
    """Errors of the normal forces [N], affine in the stroke, whose error is `slid` [m]."""
    slopes = load_slopes(motion.capsule, motion.direction)
    return dict(zip(NORMAL_FORCES, np.outer(slopes, slid), strict=True))


# The line manoeuvre's end, for any step. The scheme
#     u = v - mu w dt,  v+ = sgn(u) max(|u| - f g dt, 0),  x+ = x + v+ dt
# with w averaged over the step has the exact velocity at t_k, and x is the trapezoid sum of v(t_k)
# because the body starts and ends at rest (so it does not matter whether v or x is advanced first).


def step_error(line: LineManoeuvre, step: float | Array) -> Array:
    """Error of the final displacement [m], simulated minus exact, of semi-implicit Euler with
    Coulomb friction resolved within the step and w averaged over it, shape of `step` [s]: with t1
    on the grid -p (1 - p)(mu w2 + f g) dt^2/2, p the fraction in t_star/dt, a sawtooth in dt; off
    it with the trapezoid error at t1."""
    steps = np.asarray(step, dtype=np.float64)
    a1, a2 = line.closed.backward, line.closed.braking
    error = trapezoid_error(a1 + a2, line.t1 / steps) - trapezoid_error(a2, line.t_star / steps)
    return error * steps**2
