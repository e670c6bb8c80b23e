"""Errors of fixed steps on pendulums: of the angle, its rate, and a rod's tension."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.errors.smooth_motion.rotor_errors import RotorErrors
from plumbob.analytic.errors.smooth_motion.stepped_rotor import Rod, stepped_errors
from plumbob.analytic.numerics.power_series import constant
from plumbob.analytic.numerics.rotor.orbit import ANGLE
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.analytic.systems.pendulums.rod_tension import tension
from plumbob.analytic.systems.simple_pendulum import SimplePendulum
from plumbob.analytic.theory import Coefficients, ErrorTheory, SteppedErrors


def pendulum_errors(motion: PendulumMotion) -> RotorErrors:
    """The theory of an undamped pendulum's `motion`."""
    theta, theta_dot = motion.closed_form.state(np.zeros(1))
    return RotorErrors(motion.rotor, float(theta[0]), float(theta_dot[0]), motion)


@dataclass(frozen=True)
class RodErrors:
    """Errors of fixed steps on a simple pendulum whose rod's tension is observed, `angle` those of
    its angle; an `ErrorTheory`."""

    pendulum: SimplePendulum
    angle: ErrorTheory

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """Coefficients of the error of each observable at `times` [s], shape (n,): of the tension
        [N], by its power series in those of theta and theta_dot. Empty where a joint holds the
        bob."""
        terms = self.angle.series(scheme, times)
        return self._with_tension(terms, times) if terms else {}

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """The scheme stepped, less the exact motion, with the tension, see `stepped_errors`."""
        pendulum = self.pendulum.started
        start = pendulum.theta, pendulum.theta_dot
        rod = Rod(pendulum.length, pendulum.gravity, pendulum.mass)
        exact = self.pendulum.motion
        return stepped_errors(pendulum.rotor, start, scheme, step, times, exact, rod)

    def _with_tension(self, terms: Coefficients, times: Array) -> Coefficients:
        observed, rod = self.pendulum.motion.observe(times), self.pendulum
        state = {name: constant(observed[name], max(terms)) for name in ANGLE}
        for power, coefficients in terms.items():
            for name, part in state.items():
                part.terms[power] = coefficients[name]
        pull = tension(rod.length, rod.gravity, state["theta"], state["theta_dot"], rod.mass)
        return {
            power: {**coefficients, "tension": pull.terms[power]}
            for power, coefficients in terms.items()
        }


def simple_pendulum_errors(pendulum: SimplePendulum) -> ErrorTheory:
    """The theory of a simple pendulum, or of its linear companion."""
    start, elliptic = pendulum.started, pendulum.elliptic
    if elliptic is None:
        angle = RotorErrors(pendulum.rotor, start.theta, start.theta_dot)
    else:
        angle = pendulum_errors(elliptic)
    return angle if pendulum.linear else RodErrors(pendulum, angle)
