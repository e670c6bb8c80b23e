"""Errors of fixed steps on a capsule: on coasting, on motions along a line that friction brings to
rest (THEORY.md, section 4), and in the plane (section 7). The steps are taken."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np

from plumbob.analytic.errors.sliding_motion.plane_steps import COLUMNS, trajectory
from plumbob.analytic.errors.sliding_motion.position_first import position_first_trajectory
from plumbob.analytic.errors.smooth_motion.scheme_steps import whole_steps
from plumbob.analytic.reference import KEPT, Array, Reference, Signals
from plumbob.analytic.schemes import RK4, Scheme
from plumbob.analytic.systems.capsule import (
    NORMAL_FORCES,
    by_support,
    load_slopes,
    normal_forces,
)
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.manoeuvres.driving_force import driving_force
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.manoeuvres.residual_motion import ResidualMotion
from plumbob.analytic.systems.three_points.reference import PlaneReference
from plumbob.analytic.tableau import CLASSICAL
from plumbob.analytic.theory import Predicted, StepErrors, SteppedErrors, apart

MOST_STEPS = 2_000_000  # of a run: some ten seconds
MOST_PLANE_STEPS = 200_000  # each takes some tens of microseconds
JUMPING = ("friction_force", "driving_force")  # they jump when w jumps, or when the body stops
# RK4 leaves this fraction of a velocity that friction stops after each step (THEORY.md, section 4).
TAIL = 0.375
LASTS = 40  # steps after which double precision shows nothing of that velocity


def capsule_errors(problem: CapsuleProblem) -> StepErrors:
    """Theory of the errors of fixed steps on a motion of the capsule."""
    motion = problem.motion
    reference = problem.reference
    if isinstance(reference, PlaneReference):
        return StepErrors(partial(plane_errors, reference))
    if motion.kind == "coasting":
        return StepErrors(partial(coasting_errors, motion))
    if motion.kind == "hold":  # nothing moves
        return StepErrors(
            lambda scheme, step, times: (
                {}
                if scheme.position_lead is None
                else {
                    name: np.zeros_like(value) for name, value in motion.observe(times).items()
                }
            )
        )
    return StepErrors(partial(line_errors, motion, reference))


def stepped(
    scheme: Scheme, step: float, rate: float, pushes: Sequence[float], limit: float
) -> Array:
    """Way, rate and friction at the start and after each step of `step` [s], shape (3, n + 1), of
    what begins at `rate` [m/s or rad/s] under `pushes`, shape (n,), and friction up to `limit`,
    accelerations both: friction aims at rest within a step, by semi-implicit Euler or RK4 in each
    stage. The friction is that of the first stage of the step that follows, of the last one NaN."""
    way = 0.0
    rows = list[tuple[float, float, float]]()
    push = 0.0

    def slopes(_: float, state: Sequence[float]) -> tuple[float, float]:
        return state[1], push + min(max(-state[1] / step - push, -limit), limit)

    for push in pushes:
        gained = slopes(0.0, (way, rate))[1]
        rows.append((way, rate, gained - push))
        if scheme.integrator == RK4:
            way, rate = CLASSICAL.advanced(slopes, (way, rate), step)
        else:
            before = rate
            rate = rate + step * gained
            way += step * (before if scheme.position_first else rate)
    return np.array([*rows, (way, rate, math.nan)]).T


def ways(speeds: Array, lead: float, step: float) -> Array:
    """States passed at the start and after each step of `step` [s], shape (n + 1, ...), at
    `speeds` of that shape that are right at these times: each step has the part 1/2 + `lead` of
    that at its end."""
    mean = (0.5 - lead) * speeds[:-1] + (0.5 + lead) * speeds[1:]
    return step * np.cumsum(np.concatenate([0.0 * speeds[:1], mean]), axis=0)


@lru_cache(maxsize=KEPT)  # the same for all methods of one scene
def _body(motion: Any, scheme: Scheme, step: float, steps: int) -> Array:
    """`stepped` of the body under the mean reaction of the slider in each step."""
    capsule = motion.single.capsule
    gained = np.diff(motion.relative_velocity(step * np.arange(steps + 2.0)))
    pushes = (-capsule.mass_ratio / step * gained).tolist()
    return stepped(scheme, step, 0.0, pushes, capsule.friction * capsule.gravity)


def line_errors(
    motion: Any, reference: Reference, scheme: Scheme, step: float, times: Array
) -> Predicted:
    """Error of semi-implicit Euler and of RK4 with `step` [s] at grid `times` [s], shape (n,), by
    observable of `reference`, on a line, lines that repeat, or a slow stroke: friction stops the
    body within a step, and w is its mean over each step. Empty for other schemes, and for more than
    MOST_STEPS steps."""
    marks = whole_steps(times, step)
    if scheme.position_lead is None or marks[-1] > MOST_STEPS:
        return {}
    line_run = _line_run(motion, scheme, scheme.position_lead, step, marks)
    errors = apart(line_run, reference.observe(times))
    single = motion.single
    loads = np.outer(load_slopes(single.capsule, single.direction), errors["stroke"])
    still = dict.fromkeys(("stroke_rate", "heading", "sideways"), np.zeros(len(marks)))
    every = {**errors, **still, **dict(zip(NORMAL_FORCES, loads, strict=True))}
    return SteppedErrors(every, lasting=jumps(reference, scheme, step, times))


def _line_run(
    motion: Any, scheme: Scheme, lead: float, step: float, marks: Array
) -> dict[str, Array]:
    """Signals of a run with `step` [s] along a line, after as many steps as each of `marks` says,
    shape (n,). `lead` is the scheme's `position_lead`."""
    kind = Scheme(scheme.integrator, position_first=scheme.position_first)
    way, rate, deceleration = _body(motion, kind, step, int(marks[-1]))[:, marks]
    capsule = motion.single.capsule
    friction = (capsule.body_mass + capsule.slider_mass) * deceleration
    slider_rates = motion.relative_velocity(step * np.arange(marks[-1] + 2.0))
    slider_accelerations = (np.diff(slider_rates) / step)[marks]
    return {
        "displacement": way,
        "velocity": rate,
        "stroke": ways(slider_rates, lead, step)[marks],
        "friction_force": friction,
        "driving_force": driving_force(capsule, friction, slider_accelerations),
    }


def jumps(reference: Reference, scheme: Scheme, step: float, times: Array) -> Signals:
    """Returns the largest jump of each force within one `step` [s] before or after each of the grid
    `times` [s], shape (n,). If a force jumps within a step, the run shows one of its two values, or
    their mean, however small the step. RK4 keeps the fraction TAIL of that error in each step that
    follows."""
    later = reference.observe(times + step)
    largest = {name: np.zeros(len(times)) for name in JUMPING if name in later}
    for k in range(LASTS if scheme.integrator == RK4 else 2):
        earlier = reference.observe(np.maximum(times - k * step, 0.0))
        for name, jump in largest.items():
            left = TAIL ** max(k - 1, 0) * np.abs(later[name] - earlier[name])
            largest[name] = np.maximum(jump, left)
        later = earlier
    return largest


def coasting_errors(
    motion: ResidualMotion, scheme: Scheme, step: float, times: Array
) -> Signals:
    """Error of semi-implicit Euler and of RK4 with `step` [s] at grid `times` [s], shape (n,), with
    friction that stops the body within a step; the coordinates of C only where its path is no
    circle. Empty for other schemes."""
    if scheme.position_lead is None:
        return {}
    still = np.zeros(len(times))
    loads = by_support(np.zeros((len(times), 3)))
    marks = whole_steps(times, step)
    nothing = [0.0] * int(marks[-1])
    way, rate, _ = stepped(scheme, step, motion.rate, nothing, motion.deceleration)[:, marks]
    way, rate = np.stack([way, rate]) - motion.distance_and_rate(times)
    if motion.centre is None:
        cos = math.cos(motion.direction)
        sin = math.sin(motion.direction)
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


def plane_errors(
    reference: PlaneReference, scheme: Scheme, step: float, times: Array
) -> Signals:
    """Error that steps of `step` [s] make of the motion at grid `times` [s], shape (n,), by
    observable of `PlaneReference`, found by taking them (`errors.plane_steps`,
    `errors.position_first`); empty for other schemes, or more than MOST_PLANE_STEPS steps."""
    marks = whole_steps(times, step)
    steps = int(marks.max())
    motion = reference.motion
    if steps > MOST_PLANE_STEPS or scheme.position_lead is None:
        return {}
    driven = (motion.capsule, motion.path, reference.start)
    if scheme.position_first:
        rows = position_first_trajectory(*driven, step, steps)[marks]
    else:
        rows = trajectory(*driven, scheme.integrator, step, steps)[marks]
    stepped = dict(zip(COLUMNS, rows.T, strict=True))
    stepped["body_angle"] = stepped["heading"]
    if not scheme.position_first:
        places, speeds, _ = motion.path.kinematics(
            np.arange(steps + 1, dtype=np.float64) * step
        )
        places = places[0] + ways(speeds, scheme.position_lead, step)[marks]
        stepped |= by_support(normal_forces(motion.capsule, places))
    return apart(stepped, reference.observe(times))


# The line manoeuvre's end, for any step. The scheme
#     u = v - mu w dt,  v+ = sgn(u) max(|u| - f g dt, 0),  x+ = x + v+ dt
# with w averaged over the step has the exact velocity at t_k, and x is the trapezoid sum of v(t_k)
# because the body starts and ends at rest (so it does not matter whether v or x is advanced first).


def step_error(line: LineManoeuvre, step: float | Array) -> Array:
    """Error of the final displacement [m], simulated minus exact, of semi-implicit Euler with
    Coulomb friction resolved within the step and w averaged over it, shape of `step` [s]: with t1
    on the grid -p (1 - p)(mu w2 + f g) dt^2/2, p the fraction in t_star/dt, a sawtooth in dt; off
    it with the trapezoid error at t1, too."""
    steps = np.asarray(step, dtype=np.float64)
    a1 = line.closed.backward
    a2 = line.closed.braking

    def trapezoid(jump: float, time: float) -> Array:
        part = time / steps - np.floor(time / steps)
        return np.asarray(0.5 * jump * part * (1.0 - part))

    return (trapezoid(a1 + a2, line.t1) - trapezoid(a2, line.t_star)) * steps**2
