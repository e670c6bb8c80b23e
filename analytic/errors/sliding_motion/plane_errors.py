"""Errors of fixed steps on plane motions, by taking the steps; of a turn, to leading order.

Let r_{n+1} = r_n + h v_{n+1} for the slider, with its relative velocity v right at grid times, and
let the body's rate follow eq. 23 with everything taken at the start of a step,

    I_n (w_{n+1} - w_n) = -mu M [r_n x (v_{n+1} - v_n) + 2 h (r_n . v_n) w_n],

with I_n = J + mu M r_n^2. Since r_n x v_{n+1} = r_{n+1} x v_{n+1} and
I_n = I_{n-1} + mu M (2 h r_n . v_n - h^2 v_n^2), this is

    I_n w_{n+1} + mu M r_{n+1} x v_{n+1} = I_{n-1} w_n + mu M r_n x v_n - mu M h^2 v_n^2 w_n:

angular momentum leaks at the rate -mu M h v^2 w, as if a damper acted on the body. Along the turn's
leading-order motion, v = a Omega and w = -mu_1 Omega, it gains mu M a^2 mu_1 h times the integral
of Omega^3, which integrated once more over I = J + mu M a^2 gives, at 2 tau,

    error of psi = mu_1^2 Z^3 tau^5 h/2,

which is (delta psi)^3/(2 mu_1) times h/tau, opposite to the turn, for every epsilon: friction does
not affect it. It holds for every engine of that kind that moves the slider by components in the
body (Chernousko 2020, eqs. 23-32).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from plumbob.analytic.errors.sliding_motion.plane_steps import COLUMNS, trajectory
from plumbob.analytic.errors.sliding_motion.position_first import position_first_trajectory
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.systems.capsule import by_support, normal_forces
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.analytic.systems.slider_path import SliderPath
from plumbob.analytic.systems.three_points.reference import PlaneReference

MOST_STEPS = 200_000  # each takes some tens of microseconds


def plane_errors(
    reference: PlaneReference, scheme: Scheme, step: float, times: Array
) -> Mapping[str, Array]:
    """Error that steps of `step` [s] make of the motion at grid `times` [s], shape (n,), by
    observable of `PlaneReference`, found by taking them (`errors.plane_steps`,
    `errors.position_first`); empty for other schemes, or more than MOST_STEPS steps."""
    times = np.asarray(times, dtype=np.float64)
    marks = np.rint(times / step).astype(np.int64)
    steps, motion = int(marks.max()), reference.motion
    if steps > MOST_STEPS or scheme.position_lead is None:
        return {}
    driven = (motion.capsule, motion.path, reference.begun)
    if scheme.position_first:
        rows = position_first_trajectory(*driven, step, steps)[marks]
    else:
        rows = trajectory(*driven, scheme.integrator, step, steps)[marks]
    stepped, exact = dict(zip(COLUMNS, rows.T, strict=True)), reference.observe(times)
    stepped["body_angle"] = stepped["heading"]
    if not scheme.position_first:
        places = held_places(motion.path, float(scheme.position_lead), step, steps)[marks]
        stepped |= by_support(normal_forces(motion.capsule, places))
    return {name: stepped[name] - values for name, values in exact.items() if name in stepped}


def held_places(path: SliderPath, lead: float, step: float, steps: int) -> Array:
    """Places of the slider [m], shape (steps + 1, 2), whose velocity is right at grid times: sums
    of it, each step of `step` [s] with the part 1/2 + `lead` of that at its end."""
    places, speeds, _ = path.kinematics(np.arange(steps + 1, dtype=np.float64) * step)
    mean = (0.5 - lead) * speeds[:-1] + (0.5 + lead) * speeds[1:]
    return np.vstack([places[:1], places[0] + step * np.cumsum(mean, axis=0)])


def euler_lead(turn: TurnManoeuvre) -> float:
    """Coefficient of the step in the error of psi(2 tau) [rad/s], to leading order in epsilon."""
    drive, tau = turn.angular_acceleration, turn.half_time
    return 0.5 * turn.inertia_ratio**2 * drive**3 * tau**5
