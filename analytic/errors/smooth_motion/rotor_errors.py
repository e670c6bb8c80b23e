"""Errors of fixed steps on the driven rotor, and the drift of its energy."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.errors.smooth_motion.error_series import ErrorSeries, Step
from plumbob.analytic.errors.smooth_motion.scheme_steps import (
    StepNumbers,
    scheme_step,
    steps_until,
)
from plumbob.analytic.errors.smooth_motion.stepped_rotor import (
    error_orders,
    has_series,
    rotor_equations,
    simplest_scheme,
    stepped_orbit,
)
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.power_series import constant
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.orbit import ANGLE_AND_RATE, rotor_motion, rotor_system
from plumbob.analytic.numerics.smooth.smooth_motion import SmoothMotion
from plumbob.analytic.numerics.smooth.smooth_system import IMAGINARY_STEP, SmoothSystem
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Reference, Signals
from plumbob.analytic.schemes import EULER, STEPPED_SCHEMES, Scheme
from plumbob.analytic.systems.pendulums.driven_motion import DrivenMotion
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.analytic.systems.pendulums.rod_tension import RodMotion
from plumbob.analytic.systems.simple_pendulum import SimplePendulum
from plumbob.analytic.theory import Coefficients, SteppedErrors, signal_differences

ERROR_SAMPLES_PER_PERIOD = 65  # samples in a period, among which the largest error is sought
# Chosen: fraction of the largest rate, from which a sample counts as fast. At 0.9 a rounding of the
# rate changes the energy by 90 % of the largest change.
FAST_RATE_FRACTION = 0.9
NEGLIGIBLE = 1e-10  # relative energy change in a period, below which it is numerical noise


@dataclass(frozen=True, eq=False)
class RotorErrors:
    """The `ErrorTheory` of the motion of a `rotor` from `theta` [rad] and `theta_dot` [rad/s].

    `known` is the exact motion; if it is None, the motion is integrated. If it is a `RodMotion`,
    the errors include the rod's tension. `terms` is the number of terms in the series.
    """

    rotor: DrivenRotor
    theta: float
    theta_dot: float
    known: Reference | None = None
    terms: int = 4

    @cached_property
    def exact(self) -> Reference:
        """The exact motion."""
        return self.known or DrivenMotion(self.rotor, self.theta, self.theta_dot)

    @property
    def rod(self) -> SmoothSystem | None:
        """System whose readings give a rod's tension; None without a rod."""
        return self.known.system if isinstance(self.known, RodMotion) else None

    @cached_property
    def motion(self) -> SmoothMotion:
        """The exact motion with its equation."""
        system = rotor_system(self.rotor, self.theta, self.theta_dot)
        return rotor_motion(self.rotor, system, self.exact)

    @cached_property
    def _series(self) -> ErrorSeries:
        """Error series of theta and theta_dot."""
        equations = rotor_equations(self.rotor, Scheme(EULER), 0.0)

        def slope(time: Any, state: Any) -> tuple[Any, Any]:
            """Returns theta' and theta'' of a state."""
            return state[1], *equations.acceleration(time, state[:1], state[1:])

        return ErrorSeries(self.motion, ANGLE_AND_RATE, slope, self._step_and_orders)

    def _step_and_orders(self, scheme: Scheme) -> tuple[Step, range] | None:
        """Returns the step of a scheme and the orders of its error; None without a series."""
        if not has_series(scheme):
            return None

        def step(times: Any, length: Any, state: Any) -> Any:
            """Returns the state after a step of this `length` [s] from `times` [s]."""
            equations = rotor_equations(self.rotor, scheme, length)
            return scheme_step(scheme, equations, length)(times, state)

        return step, error_orders(scheme, self.rotor, self.terms)

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """Returns the first `terms` coefficients of the error at `times` [s], see `ErrorSeries`.

        The tension [N] is computed on the power series of theta and theta_dot.
        """
        coefficients = self._series.series(simplest_scheme(scheme, self.rotor), times)
        if self.rod is None or not coefficients:
            return coefficients
        observed = self.exact.observe(times)
        theta, theta_dot = (
            constant(observed[name], max(coefficients)) for name in ANGLE_AND_RATE
        )
        for power, errors in coefficients.items():
            theta.terms[power] = errors["theta"]
            theta_dot.terms[power] = errors["theta_dot"]
        readings = self.rod.readings(self.rod.values, (theta,), (theta_dot,))
        with_readings = {}
        for power, errors in coefficients.items():
            reading_errors = {name: part.terms[power] for name, part in readings.items()}
            with_readings[power] = {**errors, **reading_errors}
        return with_readings

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """Returns the stepped motion less the exact motion at `times` [s], shape (n,).

        The errors are empty for more than MOST_STEPS steps, for times that are no multiples of the
        step, and for an orbit that diverges.
        """
        marks = steps_until(times, step) if scheme.integrator in STEPPED_SCHEMES else None
        if marks is None:
            return SteppedErrors({})
        exact = self.exact.observe(times)
        states = self._stepped_states(scheme, step, marks, exact)
        if states is None:
            return SteppedErrors({})
        stepped = dict(zip(ANGLE_AND_RATE, states, strict=False))
        if self.rod is not None:
            stepped |= self._tension(states)
        values = {name: x.real for name, x in stepped.items()}
        doubts = {}
        for name, x in stepped.items():
            doubts[name] = np.abs(x.imag) / IMAGINARY_STEP + ULP * (1.0 + np.abs(x.real))
        if self.rod is not None:
            rod_doubts = self.rod.doubts(states[:2].real, np.zeros((2, len(times))))
            doubts["tension"] += rod_doubts["tension"]
        if not np.isfinite([*doubts.values()]).all():
            return SteppedErrors({})
        return SteppedErrors(signal_differences(values, exact), doubts)

    def _stepped_states(
        self, scheme: Scheme, step: float, marks: StepNumbers, exact: Signals
    ) -> Any:
        """Returns the `stepped_orbit` after the numbers of steps `marks`; None if it diverges.

        `exact` has the exact motion at the same times. A second rounding is put where this motion
        first is fast: at FAST_RATE_FRACTION of its largest rate.
        """
        sizes = tuple(float(np.abs(exact[name]).max()) for name in ANGLE_AND_RATE)
        rates = np.abs([self.theta_dot, *exact["theta_dot"]])
        slow_marks = int(np.argmax(rates >= FAST_RATE_FRACTION * rates.max()))
        return stepped_orbit(
            rotor=self.rotor,
            start=(self.theta, self.theta_dot),
            scheme=simplest_scheme(scheme, self.rotor),
            step=step,
            marks=marks.tobytes(),
            sizes=sizes,
            slow_marks=slow_marks,
        )

    def _tension(self, states: Any) -> Mapping[str, Any]:
        """Returns the rod's tension [N] in stepped states, shape (d, n), by name.

        If a joint holds the bob, the last number of a state is the joint's pull.
        """
        assert self.rod is not None
        parameters = self.rod.values
        theta, theta_dot, *joint = states
        if joint:
            return {"tension": parameters.mass * parameters.length * joint[-1]}
        return self.rod.readings(parameters, (theta,), (theta_dot,))

    def energy_drift_rate(self, period: float, scheme: Scheme) -> Mapping[int, float]:
        """Returns the coefficients D_p of the mean energy drift sum_p D_p step^p, as {p: D_p}.

        The energy is per moment of inertia; D_p is in rad^2/s^3 over s^p. The motion is undamped,
        with the `period` [s]. The drift follows from the error after one period. Powers p go up to
        twice the order of the scheme. Without drift the coefficients are zero; without a series the
        result is empty. Raises ParameterError for a rotor with damping or forcing.
        """
        if not self.rotor.conservative:
            raise ParameterError("rotor", self.rotor, "without damping and forcing")
        times = np.linspace(0.0, period, ERROR_SAMPLES_PER_PERIOD)
        rate = self.theta_dot
        pull = self.rotor.acceleration(0.0, self.theta, rate)
        fastest = np.abs(self.exact.observe(times)["theta_dot"]).max()
        drift_rates = {}
        for power, error in self.series(scheme, times).items():
            if power >= 2 * (scheme.order or 0):
                continue
            gain = float(rate * error["theta_dot"][-1] - pull * error["theta"][-1])
            size = np.abs(error["theta_dot"]).max() + fastest * (math.tau / period) ** power
            drifts = abs(gain) > NEGLIGIBLE * fastest * size
            drift_rates[power] = gain / period if drifts else 0.0
        return drift_rates


def pendulum_errors(motion: PendulumMotion) -> RotorErrors:
    """Returns the error theory of an undamped pendulum's `motion`."""
    theta, theta_dot = motion.closed_form.state(np.zeros(1))
    return RotorErrors(motion.rotor, float(theta[0]), float(theta_dot[0]), motion)


def simple_pendulum_errors(pendulum: SimplePendulum) -> RotorErrors:
    """Returns the theory that predicts the errors of methods on a simple or a linear pendulum. It
    includes the errors of the rod's tension if the pendulum's motion has a tension."""
    start = pendulum.started
    return RotorErrors(pendulum.rotor, start.theta, start.theta_dot, pendulum.motion)
