"""A pendulum with a weakly damped axle, by averaging: the exact motion as a generating solution.

With a torque -xi I theta_dot on the axle, dH/dt = -xi I theta_dot^2. The mean of I theta_dot^2
over a period T is 2 pi J/T, J being the action (Sudakov 2015, eq. 10), and dH/dJ = 2 pi/T (12).
Averaged,

    dJ/dt = -xi J,     dPhi/dt = Omega(J),

in every regime: the action of a weakly damped pendulum falls as e^(-xi t) whatever its potential.
With the energy as the parameter both are closed: Omega dJ = dH gives

    t = ln(J_0/J(H))/xi,     Phi = (1/xi) * integral from H to H_0 of dH'/J(H').

The error is of the order xi T in J, relative, and of the order 1 in Phi after a time 1/xi, while
Phi itself is of the order 1/(xi T). It holds between separatrices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.parameters import ParameterError, positive
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion

NODES = 24  # of the Gauss rule in H: 1/J is smooth away from a separatrix


@dataclass(frozen=True)
class DampedRotation:
    """A rotation from theta = 0 with `theta_dot` [rad/s] in a potential [J] whose axle is damped at
    a rate `xi` [1/s], averaged. Raises ParameterError."""

    potential: TrigonometricPotential
    inertia: float
    theta_dot: float
    xi: float

    def __post_init__(self) -> None:
        positive("xi", self.xi), positive("theta_dot", self.theta_dot)
        if self.exact(0.0).regime != "rotation":
            raise ParameterError("theta_dot", self.theta_dot, "enough to turn over")

    def exact(self, loss: float) -> PendulumMotion:
        """The undamped rotation with an energy lower by `loss` [J], from theta = 0."""
        square = self.theta_dot**2 - 2 * loss / self.inertia
        speed = float(np.sqrt(max(square, 0.0)))
        return PendulumMotion(self.potential, self.inertia, 0.0, speed)

    def loss(self, time: float) -> float:
        """Energy [J] lost after `time` [s]: where the action is e^(-xi t) of the first. Raises
        ParameterError where the motion has then come to a separatrix."""
        from scipy.optimize import brentq

        wanted = self.exact(0.0).action * np.exp(-self.xi * time)
        barrier = float(np.max(np.asarray(self.exact(0.0).barriers, dtype=float)))
        above = float(np.asarray(self.exact(0.0).energy, dtype=float)) - barrier
        highest = above * (1 - 1e-9)
        if self.exact(highest).action > wanted:
            raise ParameterError("time", time, "before the rotation ends at a separatrix")
        return float(
            brentq(lambda lost: self.exact(lost).action - wanted, 0.0, highest, xtol=1e-12)
        )

    def action(self, times: Array) -> Array:
        """Averaged action [J s] at `times` [s], shape (n,)."""
        return self.exact(0.0).action * np.exp(-self.xi * times)

    def phase(self, time: float) -> float:
        """Averaged phase [rad] at `time` [s]."""
        lost = self.loss(time)
        places, weights = np.polynomial.legendre.leggauss(NODES)
        actions = [self.exact(lost * (1 + float(x)) / 2).action for x in places]
        return float(lost / 2 * np.sum(weights / np.array(actions)) / self.xi)


def action_and_phase(
    potential: TrigonometricPotential, inertia: float, theta: float, theta_dot: float
) -> tuple[float, float]:
    """Action [J s] and phase [rad], whole turns included, of a state of a forward rotation, the
    phase counted from theta = 0."""
    turns = np.floor(theta / (2 * np.pi))
    within = theta - turns * 2 * np.pi
    square = theta_dot**2 + 2 * (potential.value(within) - potential.value(0.0)) / inertia
    motion = PendulumMotion(potential, inertia, 0.0, float(np.sqrt(square)))
    since = float(motion.time_at(np.array([within]))[0])
    return motion.action, float(2 * np.pi * turns + motion.mean_rate * since)
