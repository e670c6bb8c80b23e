"""Errors of a fixed step where a motion's acceleration jumps inside a step."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from plumbob.analytic.reference import Array

# Where the velocities at grid times are exact and a position advances by their trapezoid sum, the
# error of the position comes from jumps of the acceleration alone: a jump J at a fraction p of a
# step leaves J p (1 - p) dt^2/2 behind (THEORY.md, section 4).

Jump = tuple[float, float]  # time [s], and by what the acceleration jumps there [m/s^2 or rad/s^2]
GRID = 1e-6  # of a step: how near to a grid time a switch is taken to be on it
DECAYED = 64  # steps after which 0.375^n has left the range of a double's rounding


def trapezoid_error(jump: float | Array, steps: Array) -> Array:
    """Error of the trapezoid sum over dt^2, of a jump of the acceleration by `jump` at a time of so
    many `steps`; shape of `steps`."""
    part = steps - np.floor(steps)
    return 0.5 * jump * part * (1.0 - part)


def trapezoid_errors(jumps: Iterable[Jump], step: float, times: Array) -> Array:
    """Error of a position at grid `times` [s], shape (n,), from all `jumps` that came before, the
    velocity at grid times being exact; `step` [s]."""
    total = np.zeros_like(np.asarray(times, dtype=np.float64))
    for time, jump in jumps:
        size = trapezoid_error(jump, np.array(time / step)) * step**2
        total = total + np.where(times >= time, size, 0.0)
    return total


def rk4_stop(
    stop: float, deceleration: float, step: float, times: Array, since: float = 0.0
) -> tuple[Array, Array]:
    """Errors of way [m or rad] and speed, both along the motion, at grid `times` [s], shape (n,),
    of RK4 with Coulomb friction that may stop the body within a step; the exact motion comes to
    rest at `stop` [s] under `deceleration`, which acts from `since` on, a grid time.

    The scheme follows v' = -min(a, v/dt): its last a dt decays in a geometric series, and it goes
    about a dt^2/2 too far.
    """
    begin = max(math.floor(stop / step) - 2, round(since / step))
    ways, speeds = _rk4_errors(max(stop / step - begin, 0.0))
    after = np.rint(np.asarray(times, dtype=np.float64) / step) - begin
    place = np.clip(after, 0, DECAYED).astype(np.int64)
    return deceleration * step**2 * ways[place], deceleration * step * speeds[place]


def _rk4_errors(left: float) -> tuple[Array, Array]:
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
        remaining = max(left - n, 0.0)
        ways.append(way - 0.5 * (left**2 - remaining**2))
        speeds.append(speed - remaining)
    return np.array(ways), np.array(speeds)
