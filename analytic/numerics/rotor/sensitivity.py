"""Sensitivity of a motion to its start and coefficients, and the effect of rounded inputs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.taylor_series import integrate
from plumbob.analytic.numerics.rotor.variational import Response, TangentFlow
from plumbob.analytic.reference import Array


def sensitivity(rotor: DrivenRotor, theta: float, theta_dot: float, times: Array) -> Array:
    """Derivatives of (theta, theta_dot) at `times` [s], shape (n,), by the start `theta` [rad],
    `theta_dot` [rad/s], shape (n, 2, 2): rows by what changes, columns by what is varied. Raises
    ParameterError."""
    flow = TangentFlow(
        rotor, integrate(rotor, theta, theta_dot, float(np.max(times, initial=0.0)) or 1.0)
    )
    return start_response(flow).at(times)


def parameter_sensitivity(
    rotor: DrivenRotor, theta: float, theta_dot: float, times: Array
) -> Mapping[str, Array]:
    """Derivatives of (theta, theta_dot) at `times` [s], shape (n,), by each coefficient of the
    rotor, by the field's name, shape (n, 2). Raises ParameterError."""
    flow = TangentFlow(
        rotor, integrate(rotor, theta, theta_dot, float(np.max(times, initial=0.0)) or 1.0)
    )
    partials = rotor.partials(flow.times, *flow.states)
    values = _parameter_response(flow, list(partials.values())).at(times)
    return {name: values[:, :, column] for column, name in enumerate(partials)}


def condition(
    rotor: DrivenRotor, theta: float, theta_dot: float, times: Array
) -> Mapping[str, Array]:
    """Condition of theta [rad] and theta_dot [rad/s] at `times` [s], shape (n,): their change for a
    relative change of one in every input, summed in magnitude; times the machine epsilon, the
    effect of inputs rounded to double. Raises ParameterError."""
    orbit = integrate(rotor, theta, theta_dot, float(np.max(times, initial=0.0)) or 1.0)
    weighted = weighted_response(TangentFlow(rotor, orbit))
    x, v = orbit.at(times)
    total = np.abs(weighted.at(times)).sum(axis=2)
    return {
        "theta": total[:, 0] + np.abs(times * v),
        "theta_dot": total[:, 1] + np.abs(times * rotor.acceleration(times, x, v)),
    }


def start_response(flow: TangentFlow) -> Response:
    """Response to the start: columns by theta(0) and by theta_dot(0)."""
    return flow.respond(np.eye(2), np.zeros((*flow.times.shape, 2, 2)))


def weighted_response(flow: TangentFlow) -> Response:
    """Responses to a relative change of one in each input: theta(0), theta_dot(0), and each
    coefficient that is not zero."""
    x, v = flow.orbit.theta[0], flow.orbit.theta_dot[0]
    partials = flow.rotor.partials(flow.times, *flow.states)
    inputs = {name: getattr(flow.rotor, name) for name in partials}
    scaled = [value * partials[name] for name, value in inputs.items() if value != 0.0]
    forcing = np.zeros((*flow.times.shape, 2, 2 + len(scaled)))
    for column, source in enumerate(scaled, start=2):
        forcing[:, :, 1, column] = source
    start = np.zeros((2, forcing.shape[-1]))
    start[0, 0], start[1, 1] = x, v
    return flow.respond(start, forcing)


def _parameter_response(flow: TangentFlow, sources: list[Array]) -> Response:
    forcing = np.zeros((*flow.times.shape, 2, len(sources)))
    forcing[:, :, 1, :] = np.stack(sources, axis=-1)
    return flow.respond(np.zeros((2, len(sources))), forcing)
