"""What contacts that yield do to the capsule's motion: bounds.

A contact that yields by c N lets the common centre of mass ride at z = -c sum N_i^2 / W, so the
weight on the plane is off by (M + m) z'', the velocity of a sliding body by f z' and its place by
f (z - z0). What it takes to move body and slider as the sags change is missing from the N_i; and
friction takes hold at the depth of the sag. While the body tilts by a, the moment of
friction about C is off by f I a'', so it turns by f I a/J, I its inertia across.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import ROUNDOFF, load_shares, normal_forces
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.manoeuvres.repeated_line import RepeatedLine
from plumbob.analytic.systems.manoeuvres.residual_motion import ResidualMotion
from plumbob.engines.adapters.mujoco.capsule_model import armature, tilt_inertia
from plumbob.engines.adapters.mujoco.contact_profiles import STIFFNESS

DEPTH_ROUNDINGS = 16  # of the place of a support, turned and moved
LAG = 3.0  # contacts of finite damping lag behind statics, and swing: by this much of it in all
SWING = 6.0  # of what their inertia takes: a tilt that is hardly damped swings that far
POINTS = 4001  # of the motion that is looked at; its forces are piecewise smooth


def sag_bounds(
    problem: CapsuleProblem,
    duration: float,
    compliance: float,
    step: float,
    count: int,
    over: float,
) -> Mapping[str, float]:
    """Contacts that sag by `compliance` [m/N] times their normal force, C being `over`
    the plane [m]."""
    capsule, motion = problem.setup.capsule, problem.motion
    grip = capsule.friction
    end = min(duration, motion.period) if isinstance(motion, RepeatedLine) else duration
    times, loads, slid = _loads(problem, end)
    height = -compliance * np.sum(loads**2, axis=0) / capsule.weight
    # Friction that takes hold, or lets go, below C tips the body, and within some steps all is at
    # rest again: nothing is left of a tipping but the tilt, and a turn by f I/J of what of it is
    # across the motion.
    line, slopes = problem.setup.direction, share_slopes(problem)
    along, rate = np.array([math.cos(line), math.sin(line)]), 2 * STIFFNESS / step
    moment = grip * capsule.weight * (compliance * float(loads.max()) + over)
    lever = moment * np.abs(slopes @ along)
    tipped = compliance * moment * slopes.T @ slopes @ along
    tilts = compliance * slopes.T @ (loads - loads[:, :1])
    tilt = float(np.hypot(*tilts).max() + np.hypot(*tipped))
    cross = np.array([-along[1], along[0]])
    across = float(np.abs(cross @ tilts).max() + abs(cross @ tipped))
    ride = float(np.abs(height - height[0]).max()) + 2 * compliance * float(lever.max())
    rise = np.gradient(height, times)
    speed = float(np.abs(rise).max()) + 2 * compliance * float(lever.max()) * rate
    unsteady = float(np.abs(np.gradient(rise, times)).max())
    lost = SWING * _lost(problem, times, compliance * loads, slid) + lever
    way = float(np.abs(slid).max())
    both, inertia = capsule.body_mass + capsule.slider_mass, tilt_inertia(problem)
    turn = LAG * grip * inertia / capsule.inertia * across
    if over and isinstance(motion, LineManoeuvre):
        # Supports far below C slip aside while the body tips, and friction goes along with them.
        aside = over * across * rate / motion.closed.backward
        turn += grip * capsule.weight * over / capsule.inertia * aside * motion.t_star
    pace, gone = LAG * grip * speed + over * tilt * rate, LAG * grip * ride + over * tilt
    if isinstance(motion, ResidualMotion) and motion.centre is not None:
        # A tilted body that spins is out of balance, for its inertias differ.
        leaning = compliance * float(np.hypot(*(slopes.T @ loads[:, 0])))
        wobble = abs(inertia - capsule.inertia) * motion.coasting.rate**2 * leaning
        push = grip * wobble * float(np.abs(slopes).sum()) / both
        pace, gone = pace + push * motion.duration, gone + 0.5 * push * motion.duration**2
    # The slider's own weight pulls it down its tilted track.
    lean = float(np.hypot(*(compliance * slopes.T @ loads)).max())
    drift = capsule.slider_mass / armature(problem.setup) * capsule.gravity * lean
    lost = lost + 0.5 * drift * duration**2 * np.abs(slopes @ along) * capsule.weight
    return {
        "stroke": 0.5 * drift * duration**2,
        "stroke_rate": drift * duration,
        **dict.fromkeys(("velocity", "velocity_x", "velocity_y"), pace),
        **dict.fromkeys(("displacement", "x", "y"), gone * count),
        "friction_force": SWING * grip * both * unsteady + both * pace / step,
        **{f"normal_force_{i + 1}": float(lost[i]) for i in range(3)},
        "heading": turn * count,
        "heading_rate": turn * rate + pace / shortest(problem),
        "sideways": (gone + turn * way) * count,
    }


def coupling_bounds(
    problem: CapsuleProblem, coupling: float, compliance: float, step: float
) -> Mapping[str, float]:
    """A normal force that slip changing by a [m/s^2] alters by `coupling` f a [N], until contacts
    that yield by `compliance` [m/N] have taken it up; and that is known as far as double precision
    has their depth."""
    setup, capsule = problem.setup, problem.setup.capsule
    arms = np.hypot(*np.asarray(capsule.supports).T)
    line = getattr(problem.motion, "manoeuvre", problem.motion)
    quick, slip = capsule.gravity * capsule.friction, 0.0
    if isinstance(line, LineManoeuvre):
        quick = max(line.closed.backward, line.closed.braking)
        slip = line.closed.backward * line.t1
    speed = math.hypot(*setup.velocity) + abs(setup.heading_rate) * float(arms.max())
    grip, both = capsule.friction, capsule.body_mass + capsule.slider_mass
    steady, sudden = coupling * grip * quick, coupling * grip * speed / step
    off = SWING * steady + DEPTH_ROUNDINGS * ROUNDOFF * float(arms.max()) / compliance
    ride, rate = compliance * (sudden + steady), 2 * STIFFNESS / step
    pace = LAG * grip * (ride * rate + compliance * steady / step)
    gone = LAG * grip * (ride + compliance * coupling * grip * slip / step)
    lean = tilt_inertia(problem) * float(np.abs(share_slopes(problem)).sum())
    turn = LAG * grip * ride * (lean + both * float(arms.max())) / capsule.inertia
    return {
        **dict.fromkeys([f"normal_force_{i}" for i in (1, 2, 3)], off + sudden),
        "friction_force": 3 * grip * off + both * pace / step,
        **dict.fromkeys(("displacement", "sideways", "x", "y"), gone),
        **dict.fromkeys(("velocity", "velocity_x", "velocity_y"), pace),
        "heading": turn,
        "heading_rate": turn * rate,
    }


def height_bounds(problem: CapsuleProblem, over: float) -> Mapping[str, float]:
    """What the source leaves out: friction has a moment about a centre of mass `over` the plane
    [m], and shifts load along its line; not sideways, so the motion on a line is the same."""
    capsule = problem.setup.capsule
    if not over:
        return {}
    line = problem.setup.direction
    shift = share_slopes(problem) @ np.array([math.cos(line), math.sin(line)])
    shift = over * capsule.friction * capsule.weight * np.abs(shift)
    return {f"normal_force_{i + 1}": float(shift[i]) for i in range(3)}


def _loads(problem: CapsuleProblem, end: float) -> tuple[Array, Array, Array]:
    """Times until `end` [s], shape (n,), normal forces there [N], shape (3, n), and the way of the
    slider in the body [m], shape (n,)."""
    times = np.linspace(0.0, end, POINTS)
    if isinstance(problem.motion, ResidualMotion):
        still = normal_forces(problem.setup.capsule, np.array([problem.setup.slider]))
        return times, np.repeat(still.T, POINTS, axis=1), np.zeros(POINTS)
    seen = problem.reference.observe(times)
    return times, np.stack([seen[f"normal_force_{i}"] for i in (1, 2, 3)]), seen["stroke"]


def _lost(problem: CapsuleProblem, times: Array, sags: Array, slid: Array) -> Array:
    """Largest change of each normal force [N], shape (3,), by the inertia of body and slider riding
    on contacts with these `sags` [m], shape (3, n), the slider having `slid` so far, shape (n,)."""
    setup, capsule, across = problem.setup, problem.setup.capsule, tilt_inertia(problem)
    corners = np.asarray(capsule.supports)
    lift = np.column_stack([np.ones(3), corners[:, 1], -corners[:, 0]])
    inverse = np.linalg.inv(lift)
    seen = inverse.T @ np.diag([capsule.body_mass, across, across]) @ inverse
    line = np.array([math.cos(setup.direction), math.sin(setup.direction)])
    parts = load_shares(capsule, np.asarray(setup.slider) + slid[:, None] * line).T
    body = seen @ _second(sags, times)
    slider = capsule.slider_mass * _second(np.sum(parts * sags, axis=0), times)
    return np.asarray((np.abs(body) + np.abs(parts * slider)).max(axis=1))


def _second(values: Array, times: Array) -> Array:
    """Second derivative along the last axis."""
    return np.asarray(np.gradient(np.gradient(values, times, axis=-1), times, axis=-1))


def share_slopes(problem: CapsuleProblem) -> Array:
    """Change of each support's share of the load with the centre of pressure [1/m], (3, 2)."""
    here, x, y = load_shares(problem.setup.capsule, np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    return np.column_stack([x - here, y - here])


def shortest(problem: CapsuleProblem) -> float:
    """Distance from C to the nearest support [m]."""
    return min(math.hypot(*support) for support in problem.setup.capsule.supports)
