"""A driven rotor's exact motion: in closed form if it is linear, otherwise certified."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP, rounded_inputs
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.linear_oscillator import linear_motion
from plumbob.analytic.numerics.rotor.orbit import rotor_system
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.parameters import finite
from plumbob.analytic.reference import Array, Signals, remembered

# [rad, rad/s] uncertainty if double precision does not determine the motion
LOST_MOTION_UNCERTAINTY = 1e6


@dataclass(frozen=True)
class DrivenMotion:
    """The motion of `rotor` from `theta` [rad] and `theta_dot` [rad/s], as a `Reference`. Raises
    ParameterError."""

    rotor: DrivenRotor
    theta: float
    theta_dot: float

    def __post_init__(self) -> None:
        finite("theta", self.theta)
        finite("theta_dot", self.theta_dot)

    @cached_property
    def closed_form(self) -> Callable[[Array], tuple[Array, Array]] | None:
        """A function from times [s] to theta and theta_dot, or None if there is no closed form."""
        if not self.rotor.linear:
            return None
        return partial(linear_motion, self.rotor, self.theta, self.theta_dot)

    @cached_property
    def certified(self) -> CertifiedMotion:
        """The motion, integrated by two independent methods."""
        return CertifiedMotion(rotor_system(self.rotor, self.theta, self.theta_dot))

    def certify(self, last: float, watch: Callable[[float], None]) -> None:
        """Integrates the motion up to `last` [s] if it has no closed form (see
        `CertifiedMotion`)."""
        if self.closed_form is None:
            self.certified.certify(last, watch)

    @remembered
    def observe(self, times: Array) -> Signals:
        """Exact theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,)."""
        if self.closed_form is None:
            return self.certified.observe(np.minimum(times, self._known_until(times)))
        theta, theta_dot = self.closed_form(times)
        return {"theta": theta, "theta_dot": theta_dot}

    def uncertainty(self, times: Array) -> Signals:
        """Error of each observable by double precision, shape (n,).

        With a closed form it is the effect of rounded inputs and times, plus the rounding of the
        result. Without one it is the difference of the two methods, and LOST_MOTION_UNCERTAINTY
        beyond the certified time.
        """
        if self.closed_form is None:
            known_until = self._known_until(times)
            errors = self.certified.uncertainty(np.minimum(times, known_until))
            lost = times > known_until
            return {
                name: np.where(lost, LOST_MOTION_UNCERTAINTY, error)
                for name, error in errors.items()
            }
        observed = self.observe(times)
        theta = observed["theta"]
        rate = observed["theta_dot"]
        acceleration = self.rotor.acceleration(times, theta, rate)
        time_effect = {"theta": np.abs(times * rate), "theta_dot": np.abs(times * acceleration)}
        input_effect = rounded_inputs(self, lambda near: near.observe(times), 1.0)
        return {
            name: np.maximum.accumulate(size + ULP * time_effect[name])
            for name, size in input_effect.items()
        }

    def _known_until(self, times: Array) -> float:
        """Returns the time [s], up to the last of `times`, until which the motion is certified."""
        return self.certified.known_until(float(np.max(times, initial=0.0)))

    def nonlinearity(self, times: Array, errors: Signals) -> float:
        """Nonlinearity of the rates' response to errors of theta and theta_dot, shape (n,) each,
        over the linear response (see `CertifiedMotion`)."""
        if self.closed_form is not None or not np.abs(errors["theta"]).max():
            return 0.0
        known_until = self._known_until(times)
        return self.certified.nonlinearity(np.minimum(times, known_until), errors)
