"""The secular energy drift of a fixed-step scheme on an undamped periodic motion, by averaging.

The modified equation that a scheme of order p solves exactly changes the energy at the rate
r = h^p r_p + h^{p+1} r_{p+1} + ...; one step changes it by G(y) = integral of r over the step. On
the scheme's own orbit, which is the exact one but for h^p, G/h averaged over the exact orbit is the
drift up to h^{2p}: so powers p to 2p - 1 follow from G alone. By time symmetry the even powers of
RK4 vanish on a motion that retraces itself or is equal in both directions, and h^5 dominates.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from plumbob.analytic.errors.smooth_motion.rotor_steps import rotor_step
from plumbob.analytic.numerics.collocation import gauss_collocation
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.variational import STAGES, tangent_flow
from plumbob.analytic.numerics.truncated_series import constant, product, sine_cosine
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import Scheme

NEGLIGIBLE = 1e-10  # of the mean size of the energy error: what quadrature and round-off leave


def energy_drift_rate(
    rotor: DrivenRotor, theta: float, theta_dot: float, period: float, scheme: Scheme
) -> Mapping[int, float]:
    """Coefficients D_p of the mean rate sum_p D_p step^p at which `scheme` changes the energy per
    moment of inertia [rad^2/s^3 over s^p] on the motion of `period` [s] from `theta` [rad],
    `theta_dot` [rad/s]; zero where nothing drifts, empty for a scheme unknown to `rotor_step`.
    Raises ParameterError."""
    if not rotor.conservative:
        raise ParameterError("rotor", rotor, "without damping and forcing")
    if (rotor_scheme := rotor_step(scheme)) is None:
        return {}
    flow = tangent_flow(rotor, theta, theta_dot, period)
    last = 2 * rotor_scheme.order
    start = [constant(values, last) for values in flow.states]
    gained = _energy(rotor, *rotor_scheme.advance(rotor, flow.times, *start))
    lengths = np.diff(flow.orbit.breakpoints)
    weights = lengths[:, None] * gauss_collocation(STAGES).weights / period
    rates = {}
    for power in range(rotor_scheme.order, last):
        terms = weights * gained[power + 1]
        total = float(terms.sum())
        rates[power] = total if abs(total) > NEGLIGIBLE * np.abs(terms).sum() else 0.0
    return rates


def _energy(rotor: DrivenRotor, theta: Array, theta_dot: Array) -> Array:
    """Series of the energy (`DrivenRotor.energy`)."""
    sine, cosine = sine_cosine(theta)
    well = -rotor.sin2 * product(sine, sine) - rotor.cos * sine - rotor.sin * cosine
    spring = 0.5 * rotor.stiffness * product(theta, theta)
    return 0.5 * product(theta_dot, theta_dot) + well + spring
