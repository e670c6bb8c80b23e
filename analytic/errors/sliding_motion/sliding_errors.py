"""Errors of fixed steps on a capsule, by taking the steps.

The motions are coasting, motions along a line that friction brings to rest (THEORY.md, section 4),
and motions in the plane (section 7).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np

from plumbob.analytic.errors.sliding_motion.plane_steps import COLUMNS, trajectory
from plumbob.analytic.errors.sliding_motion.position_first import position_first_trajectory
from plumbob.analytic.errors.smooth_motion.scheme_steps import whole_steps
from plumbob.analytic.reference import CACHED_RESULTS, Array, Reference, Signals
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
from plumbob.analytic.theory import Predicted, StepErrors, SteppedErrors, signal_differences

MAX_SLIDING_STEPS = 2_000_000  # steps in a run along a line, which take some ten seconds
MOST_PLANE_STEPS = 200_000  # steps in a run in the plane, some tens of microseconds each
# forces that jump when the slider's acceleration w jumps, or when the body stops
JUMPING_FORCES = ("friction_force", "driving_force")
# RK4 leaves this fraction of a velocity that friction stops after each step (THEORY.md, section 4).
RK4_REMAINDER = 0.375
RK4_REMAINDER_STEPS = 40  # steps after which that remainder is below double precision


def capsule_errors(problem: CapsuleProblem) -> StepErrors:
    """Returns the theory of fixed-step errors on a motion of the capsule."""
    motion = problem.motion
    reference = problem.reference
    if isinstance(reference, PlaneReference):
        return StepErrors(partial(plane_errors, reference))
    if motion.kind == "coasting":
        return StepErrors(partial(coasting_errors, motion))
    if motion.kind == "hold":
        return StepErrors(partial(hold_errors, motion))
    return StepErrors(partial(line_errors, motion, reference))


def hold_errors(motion: Any, scheme: Scheme, step: float, times: Array) -> Signals:
    """Returns zero errors at `times` [s] for a body that does not move; empty for schemes without
    theory."""
    if scheme.position_lead is None:
        return {}
    return {name: np.zeros_like(value) for name, value in motion.observe(times).items()}


def stepped_motion(
    scheme: Scheme, step: float, rate: float, pushes: Sequence[float], limit: float
) -> Array:
    """Returns distance, rate and friction at the start and after each step, shape (3, n + 1).

    A body begins at `rate` [m/s or rad/s]. In each step of `step` [s] one of the `pushes`, shape
    (n,), acts, and friction up to `limit`, all as accelerations. Friction aims at rest within a
    step, once in a step of semi-implicit Euler and in each stage of RK4. The friction in a column
    acts in the first stage of the following step; in the last column it is NaN.
    """
    distance = 0.0
    rows = list[tuple[float, float, float]]()
    for push in pushes:
        slopes = partial(_slopes_with_friction, push, limit, step)
        _, acceleration = slopes(0.0, (distance, rate))
        rows.append((distance, rate, acceleration - push))
        if scheme.integrator == RK4:
            distance, rate = CLASSICAL.advanced(slopes, (distance, rate), step)
        else:
            rate_before = rate
            rate = rate + step * acceleration
            distance += step * (rate_before if scheme.position_first else rate)
    return np.array([*rows, (distance, rate, math.nan)]).T


def _slopes_with_friction(
    push: float, limit: float, step: float, fraction: float, state: Sequence[float]
) -> tuple[float, float]:
    """Returns the rate of a body in the `state` (distance, rate), and its acceleration: by a `push`
    and by friction, which is at most `limit` and aims at rest within a `step` [s]. No acceleration
    depends on the `fraction` of the step."""
    _, rate = state
    friction = min(max(-rate / step - push, -limit), limit)
    return rate, push + friction


def positions(speeds: Array, lead: float, step: float) -> Array:
    """Returns positions at the start and after each step of `step` [s], shape (n + 1, ...).

    `speeds` are exact at these times and have the same shape. In each step the speed at its end has
    the weight 1/2 + `lead`, and the speed at its start the rest.
    """
    mean = (0.5 - lead) * speeds[:-1] + (0.5 + lead) * speeds[1:]
    return step * np.cumsum(np.concatenate([0.0 * speeds[:1], mean]), axis=0)


@lru_cache(maxsize=CACHED_RESULTS)  # all methods of one scene share the result
def _body_motion(motion: Any, scheme: Scheme, step: float, steps: int) -> Array:
    """Returns `stepped_motion` of the body. In each step the reaction of the slider pushes it, at
    the mean over the step."""
    capsule = motion.single.capsule
    velocity_changes = np.diff(motion.relative_velocity(step * np.arange(steps + 2.0)))
    pushes = (-capsule.mass_ratio / step * velocity_changes).tolist()
    return stepped_motion(scheme, step, 0.0, pushes, capsule.friction * capsule.gravity)


def line_errors(
    motion: Any, reference: Reference, scheme: Scheme, step: float, times: Array
) -> Predicted:
    """Returns the errors of Euler or RK4 steps on a line, repeated lines or a slow stroke.

    The errors are at grid `times` [s], shape (n,), by observable of `reference`, for a `step` [s].
    Friction stops the body within a step, and w is the mean over each step. The errors are empty
    for other schemes, and for more than MAX_SLIDING_STEPS steps.
    """
    marks = whole_steps(times, step)
    if scheme.position_lead is None or marks[-1] > MAX_SLIDING_STEPS:
        return {}
    line_run = _line_run(motion, scheme, scheme.position_lead, step, marks)
    errors = signal_differences(line_run, reference.observe(times))
    single = motion.single
    loads = np.outer(load_slopes(single.capsule, single.direction), errors["stroke"])
    exact = dict.fromkeys(("stroke_rate", "heading", "sideways"), np.zeros(len(marks)))
    all_errors = {**errors, **exact, **dict(zip(NORMAL_FORCES, loads, strict=True))}
    return SteppedErrors(all_errors, lasting=largest_jumps(reference, scheme, step, times))


def _line_run(
    motion: Any, scheme: Scheme, lead: float, step: float, marks: Array
) -> dict[str, Array]:
    """Returns the observables of a run along a line after each of the numbers of steps `marks`,
    shape (n,); `step` is in [s], `lead` is the scheme's `position_lead`."""
    reduced_scheme = Scheme(scheme.integrator, position_first=scheme.position_first)
    body_motion = _body_motion(motion, reduced_scheme, step, int(marks[-1]))
    distance, rate, deceleration = body_motion[:, marks]
    capsule = motion.single.capsule
    friction = (capsule.body_mass + capsule.slider_mass) * deceleration
    slider_rates = motion.relative_velocity(step * np.arange(marks[-1] + 2.0))
    slider_accelerations = (np.diff(slider_rates) / step)[marks]
    return {
        "displacement": distance,
        "velocity": rate,
        "stroke": positions(slider_rates, lead, step)[marks],
        "friction_force": friction,
        "driving_force": driving_force(capsule, friction, slider_accelerations),
    }


def largest_jumps(reference: Reference, scheme: Scheme, step: float, times: Array) -> Signals:
    """Returns the largest jump of each force within one `step` [s] before or after each of the grid
    `times` [s], shape (n,).

    If a force jumps within a step, the run shows one of its two values, or their mean, however
    small the step is. RK4 keeps the fraction RK4_REMAINDER of that error in each step that follows.
    """
    later = reference.observe(times + step)
    largest = {name: np.zeros(len(times)) for name in JUMPING_FORCES if name in later}
    for steps_ago in range(RK4_REMAINDER_STEPS if scheme.integrator == RK4 else 2):
        earlier = reference.observe(np.maximum(times - steps_ago * step, 0.0))
        for name, jump in largest.items():
            remainder = RK4_REMAINDER ** max(steps_ago - 1, 0) * np.abs(
                later[name] - earlier[name]
            )
            largest[name] = np.maximum(jump, remainder)
        later = earlier
    return largest


def coasting_errors(
    motion: ResidualMotion, scheme: Scheme, step: float, times: Array
) -> Signals:
    """Returns the errors of Euler or RK4 steps on a coasting body, by observable.

    The errors are at grid `times` [s], shape (n,), for a `step` [s]. Friction stops the body within
    a step. The coordinates of C are left out if C moves on a circle. The errors are empty for other
    schemes.
    """
    if scheme.position_lead is None:
        return {}
    zeros = np.zeros(len(times))
    loads = by_support(np.zeros((len(times), 3)))
    marks = whole_steps(times, step)
    pushes = [0.0] * int(marks[-1])
    run = stepped_motion(scheme, step, motion.rate, pushes, motion.deceleration)
    distance, rate = run[:2, marks] - motion.distance_and_rate(times)
    if motion.centre is None:
        cosine = math.cos(motion.direction)
        sine = math.sin(motion.direction)
        errors = {
            "x": distance * cosine,
            "y": distance * sine,
            "velocity_x": rate * cosine,
            "velocity_y": rate * sine,
        }
        return {**errors, **loads, **dict.fromkeys(("heading", "heading_rate"), zeros)}
    rotation = {"heading": distance, "heading_rate": rate}
    if motion.centre == (0.0, 0.0):
        resting_centre = dict.fromkeys(("x", "y", "velocity_x", "velocity_y"), zeros)
        return {**resting_centre, **rotation, **loads}
    return {**rotation, **loads}


def plane_errors(
    reference: PlaneReference, scheme: Scheme, step: float, times: Array
) -> Signals:
    """Returns the errors of steps on a motion in the plane, by observable of `PlaneReference`.

    The errors are at grid `times` [s], shape (n,), for a `step` [s], found by taking the steps
    (`plane_steps`, `position_first`). They are empty for other schemes, and for more than
    MOST_PLANE_STEPS steps.
    """
    marks = whole_steps(times, step)
    steps = int(marks.max())
    motion = reference.motion
    if steps > MOST_PLANE_STEPS or scheme.position_lead is None:
        return {}
    problem = (motion.capsule, motion.path, reference.start)
    if scheme.position_first:
        rows = position_first_trajectory(*problem, step, steps)[marks]
    else:
        rows = trajectory(*problem, scheme.integrator, step, steps)[marks]
    stepped = dict(zip(COLUMNS, rows.T, strict=True))
    stepped["body_angle"] = stepped["heading"]
    if not scheme.position_first:
        grid = np.arange(steps + 1, dtype=np.float64) * step
        places, speeds, _ = motion.path.kinematics(grid)
        stepped_places = places[0] + positions(speeds, scheme.position_lead, step)[marks]
        stepped |= by_support(normal_forces(motion.capsule, stepped_places))
    return signal_differences(stepped, reference.observe(times))


# The end of a line manoeuvre has a closed form for any step. The scheme
#     u = v - mu w dt,  v+ = sgn(u) max(|u| - f g dt, 0),  x+ = x + v+ dt
# averages w over the step, so that its velocity at t_k is exact. The body starts and ends at rest.
# Therefore x is the trapezoid sum of v(t_k), whether v or x is advanced first.


def step_error(line: LineManoeuvre, step: float | Array) -> Array:
    """Returns the error of the final displacement [m], simulated minus exact, shape of `step` [s].

    The scheme is semi-implicit Euler with Coulomb friction resolved within the step and w averaged
    over the step. If t1 is on the grid, the error is -p (1 - p)(mu w2 + f g) dt^2/2, with p the
    fractional part of t_star/dt: a sawtooth in dt. If t1 is off the grid, the trapezoid error at t1
    is added.
    """
    steps = np.asarray(step, dtype=np.float64)
    a1 = line.closed.backward
    a2 = line.closed.braking

    def trapezoid(jump: float, time: float) -> Array:
        """Returns the error of the trapezoid sum, over the squared step, by a `jump` at a `time`
        [s]."""
        fraction = time / steps - np.floor(time / steps)
        return np.asarray(0.5 * jump * fraction * (1.0 - fraction))

    return (trapezoid(a1 + a2, line.t1) - trapezoid(a2, line.t_star)) * steps**2
