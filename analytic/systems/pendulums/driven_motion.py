"""The exact motion of a driven rotor with an error bar from two independent methods."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.rotor import gauss_collocation
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.linear_oscillator import LinearOscillator
from plumbob.analytic.numerics.rotor.taylor_series import Orbit, integrate
from plumbob.analytic.numerics.rotor.variational import TangentFlow, weighted_response
from plumbob.analytic.parameters import finite, positive
from plumbob.analytic.reference import Array


@dataclass(frozen=True)
class DrivenMotion:
    """Motion of `rotor` from `theta` [rad], `theta_dot` [rad/s] for `duration` [s]; a `Reference`.
    By the closed form when the equation is linear, by Taylor series when not. Raises
    ParameterError. Results are computed when first needed."""

    rotor: DrivenRotor
    theta: float
    theta_dot: float
    duration: float

    def __post_init__(self) -> None:
        finite("theta", self.theta), finite("theta_dot", self.theta_dot)
        positive("duration", self.duration)

    @cached_property
    def orbit(self) -> Orbit:
        """The motion by Taylor series."""
        return integrate(self.rotor, self.theta, self.theta_dot, self.duration)

    @cached_property
    def flow(self) -> TangentFlow:
        """The linearisation along the motion."""
        return TangentFlow(self.rotor, self.orbit)

    @cached_property
    def closed_form(self) -> LinearOscillator | None:
        """The equation as a linear oscillator; None when it is not one."""
        r = self.rotor
        if not r.linear:
            return None
        return LinearOscillator(
            r.stiffness,
            r.damping_rate,
            r.forcing_amplitude,
            r.forcing_frequency,
            r.forcing_phase,
        )

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,), from 0 to the duration.
        Raises ParameterError."""
        if self.closed_form is None:
            theta, theta_dot = self.orbit.at(times)
        else:
            self.orbit.locate(times)
            theta, theta_dot = self.closed_form.motion(self.theta, self.theta_dot, times)
        return {"theta": theta, "theta_dot": theta_dot}

    @cached_property
    def disagreement(self) -> tuple[Array, Mapping[str, Array]]:
        """Times [s], shape (n,), and the largest difference of the two methods up to each: Taylor
        series against Gauss collocation, or the closed form against Taylor series."""
        if self.closed_form is None:
            second = gauss_collocation.integrate(
                self.rotor, self.theta, self.theta_dot, self.duration
            )
            times, theta, theta_dot = second.times, second.theta, second.theta_dot
        else:
            times, theta, theta_dot = self.orbit.breakpoints, self.orbit.theta, self.orbit.theta_dot
        first = self.observe(times)
        gaps = {"theta": first["theta"] - theta, "theta_dot": first["theta_dot"] - theta_dot}
        return times, {name: np.maximum.accumulate(np.abs(gap)) for name, gap in gaps.items()}

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """The larger of the methods' disagreement and the effect of inputs rounded to double, for
        theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,). Raises ParameterError."""
        nodes, gaps = self.disagreement
        at = np.minimum(np.searchsorted(nodes, times), len(nodes) - 1)
        step = self.orbit.locate(times)
        return {
            name: np.maximum(gaps[name][at], ULP * self.condition[name][step])
            for name in ("theta", "theta_dot")
        }

    @cached_property
    def condition(self) -> Mapping[str, Array]:
        """Change of theta and theta_dot for a relative change of one in every input, summed in
        magnitude: the largest within each step, shape (steps,)."""
        response = weighted_response(self.flow)
        ends = np.concatenate([response.starts[1:], response.end[None]])[:, None]
        values = np.concatenate([response.starts[:, None], response.at_nodes(), ends], axis=1)
        edges = self.orbit.breakpoints
        times = np.column_stack([edges[:-1], self.flow.times, edges[1:]])
        x, v = self.orbit.at(times)
        a = self.rotor.acceleration(times, x, v)
        total = np.abs(values).sum(axis=-1)
        # a rounded time shifts the state along the motion, and the result is rounded as well
        theta = total[..., 0] + np.abs(times * v) + np.abs(x)
        theta_dot = total[..., 1] + np.abs(times * a) + np.abs(v)
        return {"theta": theta.max(axis=1), "theta_dot": theta_dot.max(axis=1)}

    def horizon(self, tolerance: float) -> float:
        """Time [s] up to which double precision determines theta to `tolerance` [rad]; infinite
        where that is the end. Raises ParameterError."""
        positive("tolerance", tolerance)
        edges = self.orbit.breakpoints
        beyond = np.flatnonzero(self.uncertainty(edges)["theta"] > tolerance)
        return float(edges[beyond[0]]) if beyond.size else math.inf
