"""A driven rotor's exact motion up to any time, and the nonlinearity of its response to errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.linear_oscillator import LinearOscillator
from plumbob.analytic.parameters import finite
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.driven_motion import DrivenMotion

SLACK = 1.05  # of the time requested, because engines may end a few steps later


@dataclass(frozen=True)
class UnendingMotion:
    """Motion of `rotor` from `theta` [rad] and `theta_dot` [rad/s]; a `Reference`. Raises
    ParameterError. A computed motion is kept, and replaced only for later times."""

    rotor: DrivenRotor
    theta: float
    theta_dot: float
    _known: list[DrivenMotion] = field(default_factory=list, compare=False, repr=False)

    def __post_init__(self) -> None:
        finite("theta", self.theta), finite("theta_dot", self.theta_dot)

    def until(self, time: float) -> DrivenMotion:
        """The motion up to `time` [s] or later. Raises ParameterError where it overflows."""
        if not self._known or self._known[0].duration < time:
            duration = SLACK * time or 1.0
            self._known[:] = [DrivenMotion(self.rotor, self.theta, self.theta_dot, duration)]
        return self._known[0]

    @property
    def closed_form(self) -> LinearOscillator | None:
        """The closed form; None where there is none."""
        return self.until(0.0).closed_form

    def observe(self, times: Array) -> Mapping[str, Array]:
        """theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,)."""
        return self._at(times).observe(times)

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """Disagreement of two methods or the effect of rounded inputs, the larger, shape (n,)."""
        return self._at(times).uncertainty(times)

    def nonlinearity(self, times: Array, errors: Mapping[str, Array]) -> float:
        """The second-order response to errors of theta and theta_dot, shape (n,), over the errors:
        w'' = J w + a_theta_theta theta_error^2 / 2 along the motion, from rest."""
        largest = float(np.abs(errors["theta"]).max())
        motion = self._at(times)
        if largest == 0.0 or motion.closed_form is not None:
            return 0.0
        flow, rotor = motion.flow, self.rotor
        theta = flow.states[0]
        bend = rotor.sin * np.sin(theta) - rotor.cos * np.cos(theta)
        bend -= 4 * rotor.sin2 * np.sin(2 * theta)
        error = np.interp(flow.times, times, errors["theta"])
        forcing = np.zeros((*theta.shape, 2, 1))
        forcing[..., 1, 0] = bend * error**2 / 2
        second = flow.respond(np.zeros((2, 1)), forcing).at(times)[:, 0, 0]
        return float(np.abs(second).max()) / largest

    def _at(self, times: Array) -> DrivenMotion:
        return self.until(float(np.max(times, initial=0.0)))
