"""Response of an exact pendulum motion to errors: of its inputs, of a rounding, of a scheme."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Protocol

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.elliptic.motion import EllipticMotion, solve
from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.quad import Quad, double, quad
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.reference import Array


class ExactMotion(Protocol):
    """The properties of an exact motion that its errors depend on."""

    @property
    def inertia(self) -> float: ...
    @property
    def exact_potential(self) -> TrigonometricPotential: ...
    @property
    def energy(self) -> Quad: ...
    @property
    def barriers(self) -> Quad: ...
    @property
    def period(self) -> float: ...
    @property
    def neighbours(self) -> EllipticMotion: ...
    @property
    def rotor(self) -> DrivenRotor: ...
    def __hash__(self) -> int: ...
    def state(self, times: Array) -> tuple[Array, Array]: ...


def uncertainty(motion: ExactMotion, times: Array) -> Mapping[str, Array]:
    """Change of theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,), for one unit in the
    last place of every input, the times included, and of the state where the motion is fastest: a
    start next to a saddle is small and so are its roundings, but later ones are not."""
    times = np.asarray(times, dtype=float)
    names = ("theta", "theta_dot")
    theta, rate = motion.state(times)
    period = motion.period if np.isfinite(motion.period) else 0.0
    late = ULP * (np.abs(times) + 2 * period)  # time is rounded four times in the closed form
    bend = np.asarray(motion.rotor.acceleration(times, theta, rate))
    moved = [ULP * np.abs(x) + ULP + late * np.abs(v) for x, v in ((theta, rate), (rate, bend))]
    for values, total in zip(motion.neighbours.state(times[None, :]), moved, strict=True):
        total += np.abs(values[1:] - values[:1]).sum(axis=0)
    if np.isfinite(motion.period):
        for change, total in zip(_rounded_where_fastest(motion, times, theta), moved, strict=True):
            total += change
    return dict(zip(names, moved, strict=True))


def _rounded_where_fastest(motion: ExactMotion, times: Array, angles: Array) -> tuple[Array, Array]:
    """Change of theta and theta_dot, theta being `angles` [rad], by a rounding of both where the
    motion is fastest."""
    time, theta, _ = _fastest(motion)
    # The rounding of an angle grows with the number of turns, and the force's with it; late
    # roundings have less time to act, so that half of the last angle represents all of them.
    wound = max(abs(theta), 0.5 * float(np.abs(angles).max(initial=0.0)))
    rows = _rounded(motion, wound)
    after = np.maximum(times - time, 0.0)[None, :]
    x, v = (np.abs(values[1:] - values[:1]).sum(axis=0) for values in rows.state(after))
    return x, v


@lru_cache(maxsize=16)
def _fastest(motion: ExactMotion) -> tuple[float, float, float]:
    """When in its first period a motion is fastest [s], with theta [rad] and theta_dot [rad/s]."""
    first = np.linspace(0.0, motion.period, 128)
    angles, rates = motion.state(first)
    at = int(np.abs(rates).argmax())
    return float(first[at]), float(angles[at]), float(rates[at])


@lru_cache(maxsize=32)  # the largest angle is that of one end of the run or of the other
def _rounded(motion: ExactMotion, wound: float) -> EllipticMotion:
    """The motion from where it is fastest, then with theta changed by the rounding of an angle
    `wound` [rad], then with theta_dot by that of its own."""
    (_, theta, rate), ulp = _fastest(motion), quad(ULP)
    starts = quad(theta) + np.array([[quad(0.0)], [wound * ulp], [quad(0.0)]])
    speeds = quad(rate) + np.array([[quad(0.0)], [quad(0.0)], [rate * ulp]])
    return solve(motion.exact_potential, motion.inertia, starts, speeds)


def nonlinearity(motion: ExactMotion, times: Array, errors: Mapping[str, Array]) -> float:
    """Nonlinearity of the response to errors of theta and theta_dot, shape (n,) each: the larger of
    the angle's error, and of the energy's error over the kinetic energy plus the distance from the
    nearest barrier."""
    theta, rate = motion.state(times)
    torque = np.asarray(motion.rotor.acceleration(times, theta, rate)) * motion.inertia
    drift = motion.inertia * rate * errors["theta_dot"] - torque * errors["theta"]
    barriers = motion.barriers
    margin = double(np.abs(motion.energy - barriers)).min() if barriers.size else np.inf
    ratio = np.abs(drift) / (motion.inertia * rate**2 / 2 + margin)
    return float(max(np.abs(errors["theta"]).max(), ratio.max()))
