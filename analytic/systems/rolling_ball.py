"""A uniform ball on a level plane that slides until it rolls: parabolas between switches.

Let u = R w, with slip s = v - u, Coulomb's friction coefficient f, and I = 2/5 m R^2. A rolling
moment of rolling_friction N acts against the spin at any slip; k = rolling_friction/R. Then
(Hopkins and Patterson 1977, Am. J. Phys. 45, 263; the unit of the rolling moment is that of
MuJoCo's documentation, "Computation")

    v' = -f g sign(s),   u' = 5/2 g (f sign(s) - k sign(u)),   rolling: v' = u' = -5/7 k g sign(v)

Rolling needs k <= 7/5 f: otherwise the moment keeps the ball sliding. If k >= f, a spin that ends
while the ball slides does not begin again.
"""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass
from functools import cached_property

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.parameters import check_fields
from plumbob.analytic.reference import Array, LinearResponse, Signals

# roundings of the speeds: a dozen operations a switch, and at most four switches
SPEED_ROUNDINGS = 16.0


@dataclass(frozen=True)
class BallPiece:
    """The time [s], the position [m], the speeds v and u = R w [m/s] as the piece begins, and the
    two constant accelerations [m/s^2]."""

    time: float
    x: float
    v: float
    u: float
    v_rate: float
    u_rate: float


@dataclass(frozen=True)
class RollingBall(LinearResponse):
    """A ball of `radius` [m] and `mass` [kg] that starts with a `speed` [m/s] and a `spin` [rad/s],
    positive for rolling forward, on a plane with a coefficient of `friction`, under `gravity`
    [m/s^2], with `rolling_friction` [m]. `torsional_friction` [m] has no effect: it acts on a spin
    about the vertical, which is 0. Raises ParameterError.

    >>> RollingBall(0.1, 1.0, 7.0, 0.0, 0.2, 9.81).rolling_begins.v
    5.0
    """

    radius: float
    mass: float
    speed: float
    spin: float
    friction: float
    gravity: float
    torsional_friction: float = 0.0
    rolling_friction: float = 0.0

    def __post_init__(self) -> None:
        frictions = "friction", "torsional_friction", "rolling_friction"
        check_fields(self, ("radius", "mass", "gravity"), frictions)

    @property
    def rolling_ratio(self) -> float:
        """The rolling moment over the moment of the weight at an arm of one radius."""
        return self.rolling_friction / self.radius

    @property
    def scale(self) -> float:
        """Size of the speeds [m/s]: the sum of the magnitudes of v and R w at the start."""
        return abs(self.speed) + self.radius * abs(self.spin)

    def rates(self, v: float, u: float) -> tuple[float, float]:
        """Returns the accelerations of the centre and of R w [m/s^2] at the speeds v and u = R w
        [m/s]."""
        f = self.friction
        k = self.rolling_ratio
        g = self.gravity
        if v == u and k <= 1.4 * f:
            rolling = -math.copysign(5.0 * k * g / 7.0, v) if v else 0.0
            return rolling, rolling
        slip_sign = float(np.sign(v - u or v))
        spin_sign = float(np.sign(u)) or slip_sign
        u_rate = 2.5 * g * (f * slip_sign - k * spin_sign) if u or k < f else 0.0
        v_rate = -f * g * slip_sign if v or u else 0.0
        return v_rate, u_rate

    @cached_property
    def pieces(self) -> tuple[BallPiece, ...]:
        """The motion between its switches. At a switch the slip or the spin ends."""
        time = 0.0
        x = 0.0
        v = float(self.speed)
        u = self.radius * self.spin
        pieces = []
        while True:
            v_rate, u_rate = self.rates(v, u)
            pieces.append(BallPiece(time=time, x=x, v=v, u=u, v_rate=v_rate, u_rate=u_rate))
            slip = v - u
            slip_rate = v_rate - u_rate
            slip_duration = -slip / slip_rate if slip * slip_rate < 0.0 else math.inf
            spin_duration = -u / u_rate if u * u_rate < 0.0 else math.inf
            duration = min(slip_duration, spin_duration)
            if math.isinf(duration):
                return tuple(pieces)
            time = time + duration
            x = x + duration * (v + duration * v_rate / 2.0)
            v = v + duration * v_rate
            u = u + duration * u_rate
            if slip_duration <= spin_duration:
                v = u = (5.0 * v + 2.0 * u) / 7.0
            else:
                u = 0.0
            if abs(v) + abs(u) <= 4.0 * ULP * self.scale:  # the ball rests, up to rounding
                v = u = 0.0

    @property
    def rolling_begins(self) -> BallPiece | None:
        """The first piece without slip; None if the ball slides for ever, or slides to rest."""
        if self.rolling_ratio > 1.4 * self.friction:
            return None
        return next((piece for piece in self.pieces if piece.v == piece.u), None)

    @property
    def rest_time(self) -> float:
        """Time [s] from which the ball is at rest; infinite if it never is."""
        last = self.pieces[-1]
        return math.inf if last.v or last.u else last.time

    def observe(self, times: Array) -> Signals:
        """Exact position x [m], speed [m/s] and spin [rad/s] at `times` [s], shape (n,)."""
        starts = np.array([piece.time for piece in self.pieces])
        rows = np.array([astuple(piece) for piece in self.pieces])
        present = rows[np.searchsorted(starts, times, "right") - 1]
        start, x, v, u, v_rate, u_rate = present.T
        since = times - start
        return {
            "x": x + since * (v + since * v_rate / 2.0),
            "speed": v + since * v_rate,
            "spin": (u + since * u_rate) / self.radius,
        }

    def uncertainty(self, times: Array) -> Signals:
        """Bound on the error of each observable, shape (n,).

        No speed grows beyond its size at the start. Rounding of a slip or spin delays its end by
        that rounding over the rate at which it falls. Meanwhile a speed changes by the delay times
        the jump of its acceleration. The jump is at most that rate, so that the error of the speed
        is at most the rounding."""
        speeds = np.full(len(times), SPEED_ROUNDINGS * ULP * self.scale)
        durations = np.minimum(times, self.rest_time)
        return {"x": speeds * durations, "speed": speeds, "spin": speeds / self.radius}
