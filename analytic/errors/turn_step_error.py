"""What a step of semi-implicit Euler does to the body angle of a turn manoeuvre, to leading order.

Let r_{n+1} = r_n + h v_{n+1} for the slider, with its relative velocity v right at grid times, and
let the body's rate follow eq. 23 with everything taken at the start of a step,

    I_n (w_{n+1} - w_n) = -mu M [r_n x (v_{n+1} - v_n) + 2 h (r_n . v_n) w_n],

with I_n = J + mu M r_n^2. Since r_n x v_{n+1} = r_{n+1} x v_{n+1} and
I_n = I_{n-1} + mu M (2 h r_n . v_n - h^2 v_n^2), this is

    I_n w_{n+1} + mu M r_{n+1} x v_{n+1} = I_{n-1} w_n + mu M r_n x v_n - mu M h^2 v_n^2 w_n:

angular momentum leaks at the rate -mu M h v^2 w, as if a damper held the body. Along the turn's
leading-order motion, v = a Omega and w = -mu_1 Omega, it gains mu M a^2 mu_1 h times the integral
of Omega^3, which integrated once more over I = J + mu M a^2 gives, at 2 tau,

    error of psi = mu_1^2 Z^3 tau^5 h/2,

which is (delta psi)^3/(2 mu_1) times h/tau, opposite to the turn, whatever epsilon: friction has no
part in it. It holds for every engine of that kind that moves the slider by components in the body
(Chernousko 2020, eqs. 23-32).
"""

from __future__ import annotations

from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre


def euler_lead(turn: TurnManoeuvre) -> float:
    """Coefficient of the step in the error of psi(2 tau) [rad/s], to leading order in epsilon."""
    drive, tau = turn.angular_acceleration, turn.half_time
    return 0.5 * turn.inertia_ratio**2 * drive**3 * tau**5
