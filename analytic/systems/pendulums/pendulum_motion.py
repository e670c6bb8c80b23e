"""The exact motion of an undamped pendulum: its regime, period, action and phase, and its state.

The reference for every potential V = -a sin^2 - b sin - c cos (Sudakov 2015; the simple pendulum
is a = b = 0).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.elliptic.motion import EllipticMotion, solve
from plumbob.analytic.numerics.elliptic.orbit_table import OrbitTable, orbit_table
from plumbob.analytic.numerics.elliptic.trigonometric_potential import (
    TrigonometricPotential,
    crests,
)
from plumbob.analytic.numerics.quad import Quad, double, quad
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.parameters import ParameterError, finite, positive
from plumbob.analytic.reference import Array, Signals, remembered

Regime = Literal["rest", "libration", "rotation", "separatrix"]
_MANY = 50_000  # times for which the closed form takes 0.2 s, and a table of it a tenth of that


@dataclass(frozen=True)
class PendulumMotion:
    """The motion from theta [rad] and theta_dot [rad/s] of a pendulum with a moment of inertia
    [kg m^2] in a potential [J]. Next to a separatrix, where a double has too few digits, the
    start may be given by `excess` [J], the energy above the highest barrier, in place of the
    magnitude of theta_dot; or by `theta_from_top` [rad], its angle from that barrier, in place of
    theta, which then only selects the turn. What is observed is the angle less `tilt` [rad]: a
    product of inertia turns the principal axes out of the plane in which it is measured. Raises
    ParameterError."""

    potential: TrigonometricPotential  # floats, or 34 digits
    inertia: float
    theta: float
    theta_dot: float
    excess: float | None = None
    theta_from_top: float | None = None
    tilt: float = 0.0
    # units in the last place by which a is uncertain: more than 1 if a is a difference
    cancelled: float = 1.0
    inertia_roundings: float = 1.0  # the same for the inertia

    def __post_init__(self) -> None:
        positive("inertia", self.inertia)
        for name in ("theta", "theta_dot", "excess", "theta_from_top"):
            if (value := getattr(self, name)) is not None:
                finite(name, value)
        if self.excess is not None:
            least = -1e-30 * (self.closed_form.potential.scale + abs(self.excess))
            if not self.closed_form.kinetic >= least:
                raise ParameterError("excess", self.excess, "enough to reach theta")

    @cached_property
    def barriers(self) -> Quad:
        """Maxima of V [J], highest first, in 34 digits."""
        return self.closed_form.potential.value(crests(self.closed_form.potential))

    @cached_property
    def energy(self) -> Quad:
        """The Jacobi integral H [J] (the energy, where nothing turns), in 34 digits."""
        start = self.closed_form
        return start.kinetic + start.potential.value(start.theta0)

    @cached_property
    def closed_form(self) -> EllipticMotion:
        """The constants of the closed form."""
        return self._solve(0.0)

    def _solve(self, change: float) -> EllipticMotion:
        """The closed form. With a relative `change`, one for each of a, b, c, the inertia, the
        angle, and the speed (or excess) that is not zero: this input alone is changed, a by
        `cancelled` and the inertia by `inertia_roundings` times as much."""
        v = self.potential
        from_top = self.theta_from_top
        angle = self.theta if from_top is None else from_top
        last = self.theta_dot if self.excess is None else self.excess
        given = v.a, v.b, v.c, self.inertia, angle, last
        kept = np.flatnonzero([double(x) for x in given])
        sizes = np.diag([self.cancelled, 1, 1, self.inertia_roundings, 1, 1])[:, kept]
        changes = quad(change * sizes)[..., None] if change else [0.0] * 6
        changed = zip(given, changes, strict=True)
        return self._solved(*(quad(x) * (1 + quad(part)) for x, part in changed))

    def _solved(
        self, a: Quad, b: Quad, c: Quad, inertia: Quad, angle: Quad, last: Quad
    ) -> EllipticMotion:
        """The closed form for a, b, c, the inertia, the angle (or that from the top), and the speed
        (or excess)."""
        from_top = self.theta_from_top is not None
        excess = self.excess is not None
        return solve(
            TrigonometricPotential(a, b, c),
            inertia,
            self.theta if from_top else angle,
            self.theta_dot if excess else last,
            last if excess else None,
            angle if from_top else None,
        )

    @cached_property
    def neighbours(self) -> EllipticMotion:
        """Motions with an input that is not zero changed by a unit in the last place."""
        return self._solve(ULP)

    @property
    def regime(self) -> Regime:
        """Regime of the motion."""
        if bool(self.closed_form.rest):
            return "rest"
        if not np.isfinite(self.period):
            return "separatrix"
        return "rotation" if bool(self.closed_form.rotation) else "libration"

    @property
    def well(self) -> str:
        """The well, or wells, of a libration; empty otherwise."""
        if self.regime != "libration":
            return ""
        if bool(self.closed_form.two_pairs):
            return "one of two wells"
        if self.barriers.size < 2:
            return "the only well"
        return "both wells" if bool(self.energy > self.barriers[1]) else "the deeper well"

    @property
    def period(self) -> float:
        """Time [s] of a whole turn or swing, Sudakov 2015, eq. 16; infinite on a separatrix."""
        return float(double(self.closed_form.period))

    @property
    def mean_rate(self) -> float:
        """Omega = dH/dI = 2 pi / period [rad/s], Sudakov 2015, eq. 12."""
        return 2 * np.pi / self.period

    @cached_property
    def action(self) -> float:
        """I = (1/2 pi) closed integral of p dtheta [J s], Sudakov 2015, eq. 10: over a turn when
        rotating, over the closed orbit when librating; NaN on a separatrix."""
        if self.regime == "rest":
            return 0.0
        if self.regime == "separatrix":
            return float("nan")
        return float(self.closed_form.action)

    @property
    def period_condition(self) -> float:
        """Relative change of the period over a relative change of the inputs: the sum over a, b,
        c, inertia, theta and speed (or excess), each alone; infinite on a separatrix."""
        if self.regime == "separatrix":
            return np.inf
        changes = self.neighbours.period / self.closed_form.period - 1
        return float(double(np.abs(changes)).sum() / ULP)

    @cached_property
    def table(self) -> OrbitTable | None:
        """One period, for many times; None where it is too long, or nothing moves."""
        if self.regime in ("rest", "separatrix"):
            return None
        fastest = self.rotor.rate() + abs(self._fastest[2])
        return orbit_table(self.closed_form, self.rotor.acceleration, fastest)

    @remembered
    def _remembered(self, times: Array) -> Signals:
        return dict(zip("xv", self.closed_form.state(times), strict=True))

    def _reached(self, times: Array) -> Sequence[Array]:
        times = np.asarray(times, dtype=float)
        if times.size >= _MANY and (table := self.table):
            return table.state(times)
        return tuple(self._remembered(times).values())

    def state(self, times: Array) -> tuple[Array, Array]:
        """theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,)."""
        theta, rate = self._reached(times)
        return theta - self.tilt, rate

    def phase(self, times: Array) -> Array:
        """Phase Phi = Omega t [rad], Sudakov 2015, eqs. 11 and 13, of `times` [s]."""
        return self.mean_rate * np.asarray(times)

    def momentum(self, theta: Array) -> Array:
        """p(H, theta) = sqrt(2 I (H - V)) [kg m^2 rad/s], Sudakov 2015, eq. 15, with the sign of
        the start; NaN where the motion does not reach."""
        angle = quad(np.asarray(theta) + self.tilt)
        with np.errstate(invalid="ignore"):
            kinetic = double(self.energy - self.closed_form.potential.value(angle))
            size: Array = np.sqrt(2 * self.inertia * kinetic)
            return np.copysign(size, self.theta_dot)

    def time_at(self, theta: Array) -> Array:
        """t(H, theta) [s], Sudakov 2015, eq. 16: when the motion first reaches `theta` [rad] after
        the start; NaN where it never does."""
        return self.closed_form.time_at(np.asarray(theta, dtype=float) + self.tilt)

    def observe(self, times: Array) -> Signals:
        """theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,)."""
        theta, theta_dot = self.state(times)
        return {"theta": theta, "theta_dot": theta_dot}

    def uncertainty(self, times: Array) -> Signals:
        """Change of theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,), for one unit in
        the last place of every input, the times included, and of the state where the motion is
        fastest: a start next to a saddle is small and so are its roundings, but later ones are
        not. With `theta_from_top` that of a motion from the start rounded to double, which is where
        an engine starts, and the distance of the two motions."""
        times = np.asarray(times, dtype=float)
        if self.theta_from_top is not None:
            return self._of_rounded_start(times)
        theta, rate = self._reached(times)
        finite = np.isfinite(self.period)
        # time is rounded four times in the closed form
        late = ULP * (np.abs(times) + (2 * self.period if finite else 0.0))
        slopes = np.array([rate, self.rotor.acceleration(times, theta, rate)])
        moved = ULP * np.abs([theta, rate]) + ULP + late * np.abs(slopes)
        near = np.swapaxes(self.neighbours.state(times[None, :]), 0, 1)
        moved += np.abs(near - [theta, rate]).sum(axis=0)
        if finite:
            moved += self._rounded(times, theta)
        return {"theta": moved[0] + 2 * ULP * abs(self.tilt), "theta_dot": moved[1]}

    def _of_rounded_start(self, times: Array) -> Signals:
        start = float(double(self.closed_form.theta0))
        rounded = replace(self, theta=start, theta_from_top=None)
        here = self.observe(times)
        there = rounded.observe(times)
        doubts = rounded.uncertainty(times).items()
        return {name: doubt + np.abs(there[name] - here[name]) for name, doubt in doubts}

    @cached_property
    def _fastest(self) -> tuple[float, float, float]:
        """When in its first period it is fastest [s], with theta [rad] and theta_dot [rad/s]."""
        first = np.linspace(0.0, self.period, 128)
        angles, rates = self.closed_form.state(first)
        at = int(np.abs(rates).argmax())
        return float(first[at]), float(angles[at]), float(rates[at])

    def _rounded(self, times: Array, angles: Array) -> Array:
        """Changes of the motion, which is at `angles` [rad] at `times` [s], shape (n,), by rounding
        of theta where it is fastest, and of theta_dot."""
        time, theta, rate = self._fastest
        # The rounding of an angle grows with the number of turns, and the force's with it; late
        # roundings have less time to act, so that half of the last angle represents all of them.
        wound = max(abs(theta), 0.5 * float(np.abs(angles).max(initial=0.0)))
        starts, speeds = quad(ULP * np.array([[0.0, wound, 0.0], [0.0, 0.0, rate]]))[..., None]
        later = solve(self.closed_form.potential, self.inertia, theta + starts, rate + speeds)
        begun, *changed = np.swapaxes(later.state(np.maximum(times - time, 0.0)[None, :]), 0, 1)
        return np.asarray(np.abs(np.subtract(changed, begun)).sum(axis=0))

    def nonlinearity(self, times: Array, errors: Signals) -> float:
        """Nonlinearity of the response to errors of theta and theta_dot, shape (n,) each: the
        larger of the angle's error, and of the energy's error over the kinetic energy plus the
        distance from the nearest barrier."""
        theta, rate = self._reached(times)
        torque = np.asarray(self.rotor.acceleration(times, theta, rate)) * self.inertia
        drift = self.inertia * rate * errors["theta_dot"] - torque * errors["theta"]
        gaps = double(np.abs(self.energy - self.barriers))
        ratio = np.abs(drift) / (self.inertia * rate**2 / 2 + gaps.min(initial=np.inf))
        return float(max(np.abs(errors["theta"]).max(), ratio.max()))

    @property
    def rotor(self) -> DrivenRotor:
        """The same equation of motion as an angular acceleration."""
        v = self.potential
        return DrivenRotor(*(float(double(part)) / self.inertia for part in (v.a, v.b, v.c)))
