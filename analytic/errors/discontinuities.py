"""What a fixed step makes of a motion whose acceleration jumps inside a step."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from plumbob.analytic.reference import Array

# Where the velocities at grid times are exact and a place advances by their trapezoid sum, a place
# errs only by the bends of the velocity: a jump J of the acceleration at a fraction p of a step
# leaves J p (1 - p) dt^2/2 behind.

Kink = tuple[float, float]  # time [s], and the jump of the acceleration there [m/s^2 or rad/s^2]
DECAYED = 64  # steps after which 0.375^n has left the range of a double's rounding


def position_lead(scheme: str) -> float | None:
    """Steps by which `scheme` puts a position ahead while the velocity is exact: half of one for
    "semi-implicit-euler", half of one behind with "+position-first", where x advances before v
    (other options change nothing here); None for schemes that no theory here covers."""
    base, *options = scheme.split("+")
    if base != "semi-implicit-euler":
        return None
    return -0.5 if "position-first" in options else 0.5


def scheme_lead(scheme: str) -> float | None:
    """`position_lead`, and none for "rk4"; None for schemes that no theory here covers."""
    return 0.0 if scheme.partition("+")[0] == "rk4" else position_lead(scheme)


def bend(jump: float | Array, place: Array) -> Array:
    """Error of the trapezoid sum over dt^2, of a jump of the acceleration by `jump` at `place`, a
    time in units of a step; shape of `place`."""
    part = place - np.floor(place)
    return np.asarray(0.5 * jump * part * (1.0 - part))


def bends(kinks: Iterable[Kink], step: float, times: Array) -> Array:
    """Error of a place at grid `times` [s], shape (n,), from all `kinks` that came before, the
    velocity at grid times being exact; `step` [s]."""
    total = np.zeros_like(np.asarray(times, dtype=np.float64))
    for time, jump in kinks:
        size = bend(jump, np.array(time / step)) * step**2
        total = total + np.where(times >= time, size, 0.0)
    return total


def rk4_stop(
    stop: float, deceleration: float, step: float, times: Array, since: float = 0.0
) -> tuple[Array, Array]:
    """Errors of way [m or rad] and speed, both along the motion, at grid `times` [s], shape (n,),
    of RK4 with Coulomb friction that asks for rest within a step; the exact motion comes to rest
    at `stop` [s] under `deceleration`, which is on from `since`, a grid time.

    The scheme follows v' = -min(a, v/dt): its last a dt dies in a geometric series, and it goes
    about a dt^2/2 too far.
    """
    begin = max(math.floor(stop / step) - 2, round(since / step))
    ways, speeds = _rk4_course(max(stop / step - begin, 0.0))
    after = np.rint(np.asarray(times, dtype=np.float64) / step) - begin
    place = np.clip(after, 0, DECAYED).astype(np.int64)
    return deceleration * step**2 * ways[place], deceleration * step * speeds[place]


def _rk4_course(left: float) -> tuple[Array, Array]:
    """Errors of way and speed, in units of a dt^2 and a dt, at the grid times from `left` steps
    before the stop, shape (DECAYED + 1,)."""
    speed, way = left, 0.0
    ways, speeds = [0.0], [0.0]
    for n in range(1, DECAYED + 1):
        k1 = min(1.0, speed)
        v2 = speed - 0.5 * k1
        k2 = min(1.0, v2)
        v3 = speed - 0.5 * k2
        k3 = min(1.0, v3)
        v4 = speed - k3
        way += (speed + 2.0 * v2 + 2.0 * v3 + v4) / 6.0
        speed -= (k1 + 2.0 * k2 + 2.0 * k3 + min(1.0, v4)) / 6.0
        rest = max(left - n, 0.0)
        ways.append(way - 0.5 * (left**2 - rest**2))
        speeds.append(speed - rest)
    return np.array(ways), np.array(speeds)
