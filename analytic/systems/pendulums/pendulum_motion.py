"""The exact motion of an undamped pendulum: its regime, period, action and phase, and its state.

It is the reference for every potential V = -a sin^2 - b sin - c cos (Sudakov 2015). The simple
pendulum has a = b = 0.
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
# A table is used for at least this many times: the closed form then takes 0.2 s, the table 0.02 s.
TABLE_FROM = 50_000


@dataclass(frozen=True)
class PendulumMotion:
    """The motion from theta [rad] and theta_dot [rad/s] of a pendulum with a moment of inertia [kg
    m^2] in a potential [J]. Raises ParameterError.

    Near a separatrix a double has too few digits for the start. It may then be given by `excess`
    [J], the energy above the highest barrier, in place of the magnitude of theta_dot. Or it may be
    given by `theta_from_top` [rad], the angle from that barrier, in place of theta, which then only
    selects the turn. The observed angle is theta - `tilt` [rad]: a product of inertia turns the
    principal axes out of the plane in which the angle is measured.
    """

    potential: TrigonometricPotential  # coefficients as floats or with 34 digits
    inertia: float
    theta: float
    theta_dot: float
    excess: float | None = None
    theta_from_top: float | None = None
    tilt: float = 0.0
    # uncertainty of the potential's a in units in the last place: more than 1 if a is a difference
    cancelled: float = 1.0
    inertia_roundings: float = 1.0  # uncertainty of the inertia in units in the last place

    def __post_init__(self) -> None:
        positive("inertia", self.inertia)
        for name in ("theta", "theta_dot", "excess", "theta_from_top"):
            value = getattr(self, name)
            if value is not None:
                finite(name, value)
        if self.excess is not None:
            least = -1e-30 * (self.closed_form.potential.scale + abs(self.excess))
            if not self.closed_form.kinetic >= least:
                raise ParameterError("excess", self.excess, "enough to reach theta")

    @cached_property
    def barriers(self) -> Quad:
        """Maxima of V [J], highest first, with 34 digits."""
        return self.closed_form.potential.value(crests(self.closed_form.potential))

    @cached_property
    def energy(self) -> Quad:
        """The Jacobi integral H [J] with 34 digits; the energy if nothing turns the pendulum."""
        start = self.closed_form
        return start.kinetic + start.potential.value(start.theta0)

    @cached_property
    def closed_form(self) -> EllipticMotion:
        """The motion in closed form."""
        return self._solve(0.0)

    def _solve(self, change: float) -> EllipticMotion:
        """Returns the closed form of the motion if the `change` is 0, else of changed motions.

        In each of these motions one input has a relative `change`: a, b, c, the inertia, the number
        that gives the start's angle (`theta_from_top`, or else `theta`), or the number that gives
        its speed (`excess`, or else `theta_dot`). Inputs that are zero are left out. The change of
        a is `cancelled` times as large, the change of the inertia `inertia_roundings` times.
        """
        v = self.potential
        angle = self.theta if self.theta_from_top is None else self.theta_from_top
        speed = self.theta_dot if self.excess is None else self.excess
        inputs = v.a, v.b, v.c, self.inertia, angle, speed
        nonzero = np.flatnonzero([double(value) for value in inputs])
        # one row for each input, one column for each changed motion
        factors = np.diag([self.cancelled, 1, 1, self.inertia_roundings, 1, 1])[:, nonzero]
        changes = quad(change * factors)[..., None] if change else [0.0] * 6
        changed_inputs = []
        for value, relative_change in zip(inputs, changes, strict=True):
            changed_inputs.append(quad(value) * (1 + quad(relative_change)))
        return self._closed_form_for(*changed_inputs)

    def _closed_form_for(
        self, a: Quad, b: Quad, c: Quad, inertia: Quad, angle: Quad, speed: Quad
    ) -> EllipticMotion:
        """Returns the closed form for a potential with the coefficients a, b and c, an inertia, and
        a start. `angle` stands for `theta_from_top` if that is given, else for `theta`; `speed`
        stands for `excess` if that is given, else for `theta_dot`."""
        theta, theta_from_top = angle, None
        if self.theta_from_top is not None:
            theta, theta_from_top = self.theta, angle
        theta_dot, excess = speed, None
        if self.excess is not None:
            theta_dot, excess = self.theta_dot, speed
        return solve(
            TrigonometricPotential(a, b, c),
            inertia,
            theta=theta,
            theta_dot=theta_dot,
            excess=excess,
            theta_from_top=theta_from_top,
        )

    @cached_property
    def neighbours(self) -> EllipticMotion:
        """Motions in each of which one input that is not zero is changed by a unit in the last
        place."""
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
        """The well, or wells, in which a libration takes place; empty for other regimes."""
        if self.regime != "libration":
            return ""
        if bool(self.closed_form.two_pairs):
            return "one of two wells"
        if self.barriers.size < 2:
            return "the only well"
        return "both wells" if bool(self.energy > self.barriers[1]) else "the deeper well"

    @property
    def period(self) -> float:
        """Time of a whole turn or swing [s], Sudakov 2015, eq. 16; infinite on a separatrix."""
        return float(double(self.closed_form.period))

    @property
    def mean_rate(self) -> float:
        """Omega = dH/dI = 2 pi / period [rad/s], Sudakov 2015, eq. 12."""
        return 2 * np.pi / self.period

    @cached_property
    def action(self) -> float:
        """I = (1/2 pi) closed integral of p dtheta [J s], Sudakov 2015, eq. 10. The integral is
        over a turn of a rotation, or over the closed orbit of a libration. NaN on a separatrix."""
        if self.regime == "rest":
            return 0.0
        if self.regime == "separatrix":
            return float("nan")
        return float(self.closed_form.action)

    @property
    def period_condition(self) -> float:
        """Condition number of the period: the sum of its relative changes over the relative change
        of each of a, b, c, inertia, theta and speed (or excess), changed alone. Infinite on a
        separatrix."""
        if self.regime == "separatrix":
            return np.inf
        changes = self.neighbours.period / self.closed_form.period - 1
        return float(double(np.abs(changes)).sum() / ULP)

    @cached_property
    def table(self) -> OrbitTable | None:
        """Table of one period, for fast evaluation at many times. None at rest, on the separatrix,
        and if the period is too long for a table."""
        if self.regime in ("rest", "separatrix"):
            return None
        fastest = self.rotor.rate() + abs(self._fastest_state[2])
        return orbit_table(self.closed_form, self.rotor.acceleration, fastest)

    @remembered
    def _closed_form_state(self, times: Array) -> Signals:
        """Returns theta ("x") and theta_dot ("v") at `times` [s] by the closed form; the last
        answers are stored."""
        return dict(zip("xv", self.closed_form.state(times), strict=True))

    def _raw_state(self, times: Array) -> Sequence[Array]:
        """Returns theta [rad], before the tilt is subtracted, and theta_dot [rad/s] at `times` [s],
        shape (n,) each."""
        times = np.asarray(times, dtype=float)
        table = self.table if times.size >= TABLE_FROM else None
        if table:
            return table.state(times)
        return tuple(self._closed_form_state(times).values())

    def state(self, times: Array) -> tuple[Array, Array]:
        """Returns the observed theta [rad] and theta_dot [rad/s] at `times` [s], shape
        (n,) each."""
        theta, rate = self._raw_state(times)
        return theta - self.tilt, rate

    def phase(self, times: Array) -> Array:
        """Returns the phase Phi = Omega t [rad] at `times` [s], Sudakov 2015, eqs. 11 and 13."""
        return self.mean_rate * np.asarray(times)

    def momentum(self, theta: Array) -> Array:
        """Returns p(H, theta) = sqrt(2 I (H - V)) [kg m^2 rad/s], Sudakov 2015, eq. 15, with the
        sign of the initial theta_dot; NaN for angles that the motion does not reach."""
        angle = quad(np.asarray(theta) + self.tilt)
        with np.errstate(invalid="ignore"):
            kinetic = double(self.energy - self.closed_form.potential.value(angle))
            size: Array = np.sqrt(2 * self.inertia * kinetic)
            return np.copysign(size, self.theta_dot)

    def time_at(self, theta: Array) -> Array:
        """Returns t(H, theta) [s], Sudakov 2015, eq. 16: the first time after the start at which
        the motion reaches `theta` [rad]; NaN if it never does."""
        return self.closed_form.time_at(np.asarray(theta, dtype=float) + self.tilt)

    def observe(self, times: Array) -> Signals:
        """Exact theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,)."""
        theta, theta_dot = self.state(times)
        return {"theta": theta, "theta_dot": theta_dot}

    def uncertainty(self, times: Array) -> Signals:
        """Change of theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,), by rounding: by
        one unit in the last place of every input, of the times, and of the state where the motion
        is fastest. The rounding of that state is needed near a saddle: the start is small there and
        so are its roundings, but later roundings are larger.

        If the start is given by `theta_from_top`, an engine starts at this angle rounded to double.
        The result is then the uncertainty of the rounded motion, plus the distance between the two
        motions.
        """
        times = np.asarray(times, dtype=float)
        if self.theta_from_top is not None:
            return self._uncertainty_of_rounded_start(times)
        theta, rate = self._raw_state(times)
        has_period = np.isfinite(self.period)
        # The closed form rounds the time four times.
        time_error = ULP * (np.abs(times) + (2 * self.period if has_period else 0.0))
        slopes = np.array([rate, self.rotor.acceleration(times, theta, rate)])
        errors = ULP * np.abs([theta, rate]) + ULP + time_error * np.abs(slopes)
        neighbours = np.swapaxes(self.neighbours.state(times[None, :]), 0, 1)
        errors += np.abs(neighbours - [theta, rate]).sum(axis=0)
        if has_period:
            errors += self._rounding_effect(times, theta)
        return {"theta": errors[0] + 2 * ULP * abs(self.tilt), "theta_dot": errors[1]}

    def _uncertainty_of_rounded_start(self, times: Array) -> Signals:
        """Returns the uncertainty of the motion that starts at the angle rounded to double, plus
        its distance from this motion, at `times` [s]."""
        start = float(double(self.closed_form.theta0))
        rounded = replace(self, theta=start, theta_from_top=None)
        exact_values = self.observe(times)
        rounded_values = rounded.observe(times)
        errors = rounded.uncertainty(times).items()
        return {
            name: error + np.abs(rounded_values[name] - exact_values[name])
            for name, error in errors
        }

    @cached_property
    def _fastest_state(self) -> tuple[float, float, float]:
        """Time in the first period at which the motion is fastest [s], and theta [rad] and
        theta_dot [rad/s] at that time."""
        times = np.linspace(0.0, self.period, 128)
        angles, rates = self.closed_form.state(times)
        index = int(np.abs(rates).argmax())
        return float(times[index]), float(angles[index]), float(rates[index])

    def _rounding_effect(self, times: Array, angles: Array) -> Array:
        """Returns the changes of theta and theta_dot at `times` [s], shape (2, n), by a rounding of
        theta and a rounding of theta_dot when the motion is fastest. `angles` [rad], shape (n,),
        are theta at `times`."""
        time, theta, rate = self._fastest_state
        # The rounding of an angle, and so of the force, grows with the number of turns. The later
        # a rounding is, the less time it has to act: half of the last angle stands for all.
        largest_angle = max(abs(theta), 0.5 * float(np.abs(angles).max(initial=0.0)))
        # three motions: unchanged, with a changed angle, with a changed rate
        changes = ULP * np.array([[0.0, largest_angle, 0.0], [0.0, 0.0, rate]])
        angle_changes, rate_changes = quad(changes)[..., None]
        motions = solve(
            self.closed_form.potential,
            self.inertia,
            theta + angle_changes,
            rate + rate_changes,
        )
        states = motions.state(np.maximum(times - time, 0.0)[None, :])
        unchanged, *changed = np.swapaxes(states, 0, 1)
        return np.asarray(np.abs(np.subtract(changed, unchanged)).sum(axis=0))

    def nonlinearity(self, times: Array, errors: Signals) -> float:
        """Nonlinearity of the response to errors of theta and theta_dot, shape (n,) each.

        It is the largest error of the angle, plus the largest error of the energy over the sum of
        the kinetic energy and the distance from the nearest barrier. Both effects are of second
        order and move the state along its orbit, so they are added: by the curvature of the orbit,
        and by the period, which the energy changes.
        """
        theta, rate = self._raw_state(times)
        torque = np.asarray(self.rotor.acceleration(times, theta, rate)) * self.inertia
        energy_error = self.inertia * rate * errors["theta_dot"] - torque * errors["theta"]
        gaps = double(np.abs(self.energy - self.barriers))
        ratio = np.abs(energy_error) / (self.inertia * rate**2 / 2 + gaps.min(initial=np.inf))
        return float(np.abs(errors["theta"]).max() + ratio.max())

    @property
    def rotor(self) -> DrivenRotor:
        """The equation of motion as an angular acceleration."""
        v = self.potential
        return DrivenRotor(*(float(double(part)) / self.inertia for part in (v.a, v.b, v.c)))
