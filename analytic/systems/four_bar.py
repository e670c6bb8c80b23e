"""The four-bar linkage: a uniform crank, coupler and rocker, and the ground between their axes.

The links are vectors: U from the crank's axis, V from the crank's end, W from the rocker's axis at
D to the coupler's end, so U + V = D + W. The coupler's angle f and the rocker's angle r are
functions of the crank's angle t, with the derivatives (Uicker, Pennock and Shigley 2017, Theory of
Machines and Mechanisms, 3.8 and 4.8)

    f' = -U x W/V x W,   r' = -U x V/V x W,   k = -U - f'^2 V + r'^2 W                          (1)
    f'' = -k W/V x W,    r'' = -k V/V x W                                                       (2)

The coupler's end is on the left of the line from the crank's end to D. At a change point, V x W =
0: a crank that turns fully has all links on one line there, and the rocker can turn either way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP, cos, sin, sqrt
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.numerics.smooth.soft_loop import softened
from plumbob.analytic.parameters import ParameterError, check_fields
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.schemes import SoftLoop
from plumbob.analytic.systems.crank_links import CrankLink, crank_motion, potential, reaction
from plumbob.analytic.systems.n_pendulum import NPendulum

FOUR_BAR_LENGTHS = ("crank", "coupler", "rocker", "ground")
FOUR_BAR_CONSTANTS = (*FOUR_BAR_LENGTHS, "crank_mass", "coupler_mass", "rocker_mass", "gravity")


@dataclass(frozen=True)
class FourBar:
    """Lengths [m] and masses [kg] of the links under `gravity` [m/s^2], with the crank's `angle`
    [rad] from the line to the rocker's axis, positive upwards, and its rate [rad/s] at time 0.
    Raises ParameterError.

    >>> bars = FourBar(0.2, 0.5, 0.4, 0.5, 0.5, 1.0, 0.8, 9.81, 1.0, 10.0)
    >>> round(float(bars.motion.observe(np.array([0.5]))["coupler_x"][0]), 6)
    0.354061
    """

    crank: float
    coupler: float
    rocker: float
    ground: float
    crank_mass: float
    coupler_mass: float
    rocker_mass: float
    gravity: float
    angle: float
    angular_velocity: float

    def __post_init__(self) -> None:
        check_fields(self, FOUR_BAR_CONSTANTS[:-1], FOUR_BAR_CONSTANTS[-1:])
        lengths = [getattr(self, name) for name in FOUR_BAR_LENGTHS]
        crank, coupler, rocker, ground = lengths
        folded_margin = abs(ground - crank) - abs(coupler - rocker)
        stretched_margin = coupler + rocker - ground - crank
        margin = min(folded_margin, stretched_margin)
        rounding = 4 * ULP * sum(lengths)
        if margin <= rounding:
            need = (
                "such that the crank turns fully: |ground - crank| > |coupler - rocker|, and "
                "ground + crank < coupler + rocker"
            )
            if abs(margin) <= rounding:
                need += (
                    "; where they are equal, the motion beyond the change point is not unique"
                )
            raise ParameterError(", ".join(FOUR_BAR_LENGTHS), lengths, need)

    @cached_property
    def motion(self) -> CertifiedMotion:
        """The exact motion."""
        return crank_motion(self, FOUR_BAR_CONSTANTS, _moving_links, _coupler_middle)

    @cached_property
    def chain(self) -> NPendulum:
        """Crank, coupler and rocker as an open chain of hanging rods, with the same start. The end
        of the rocker is at its axis, but not tied to it."""
        (_, *links), rates, _ = _link_rates(self, self.angle)
        coupler_angle, rocker_angle = (math.atan2(y, x) for x, y in links)
        return NPendulum(
            masses=(self.crank_mass, self.coupler_mass, self.rocker_mass),
            lengths=(self.crank, self.coupler, self.rocker),
            gravity=self.gravity,
            # from hanging down; the chain runs along the rocker from its end to its axis
            angles=(
                self.angle + math.pi / 2,
                coupler_angle + math.pi / 2,
                rocker_angle - math.pi / 2,
            ),
            angular_velocities=tuple(
                self.angular_velocity * float(rate) for rate in (1.0, *rates)
            ),
        )

    @cached_property
    def open_chain(self) -> SmoothSystem:
        """The chain's equations with the linkage's observables."""
        a = self.crank
        half = self.coupler / 2

        def read(p: Any, q: Any, v: Any) -> dict[str, Any]:
            """Returns the observables. `q` are the angles of crank and coupler from the downward
            vertical; the observable "angle" is measured from the horizontal."""
            return {
                "angle": q[0] - math.pi / 2,
                "angle_dot": v[0],
                "coupler_x": a * sin(q[0]) + half * sin(q[1]),
                "coupler_y": -a * cos(q[0]) - half * cos(q[1]),
            }

        return replace(self.chain.motion.system, readings=read)

    def _gap_terms(self, p: Any, q: Any, v: Any) -> tuple[Any, Any, Any]:
        """Returns the gap between the chain's end and the rocker's axis [m], along the line of the
        axes and up, its derivatives J by the angles, and J' q'."""
        lengths = np.array(self.chain.lengths)
        along = lengths * sin(q)
        up = -lengths * cos(q)
        square = np.square(v)
        gap = along.sum() - self.ground, up.sum()
        return gap, (-up, along), (-along @ square, -up @ square)

    def soft(self, loop: SoftLoop, step: float) -> SmoothSystem:
        """Returns the equations of the linkage with its rocker tied to the axis by a soft
        constraint. The time constant of the constraint is at least two engine steps of size `step`
        [s]."""
        lengths = np.array(self.chain.lengths)
        mass_matrix: Array = np.array(
            self.open_chain.mass_matrix(self.open_chain.values, np.zeros(3))
        )
        lever = lengths * (1, 1, 0.5)  # arms [m] of the rocker's centre in the stretched chain
        # The inverse mass is a mean over three directions; the stretched chain moves in one.
        inverse_mass = float(lever @ np.linalg.solve(mass_matrix, lever)) / 3
        return softened(self.open_chain, self._gap_terms, loop, step, inverse_mass)

    def reaction(self, times: Array) -> Array:
        """Returns the force of its axis on the rocker [N], along the line of the axes and up, at
        `times` [s], shape (n,): shape (2, n)."""
        return reaction(self, self._gap_terms, times)

    @property
    def transmission_angle(self) -> float:
        """The smallest angle [rad] between coupler and rocker, 0 at the change point."""
        b = self.coupler
        c = self.rocker
        differences = (b**2 + c**2 - (self.ground + sign * self.crank) ** 2 for sign in (-1, 1))
        largest_cosine = max(abs(difference) / (2 * b * c) for difference in differences)
        return math.acos(largest_cosine)

    @property
    def lift(self) -> Any:
        """A bound on the links' potential energy [J]; it is 0 with all links on the line of the
        axes."""
        crank, coupler, rocker = self.chain.each("lengths")
        crank_mass, coupler_mass, rocker_mass = self.chain.each("masses")
        moment = (
            crank_mass * crank + coupler_mass * (2 * crank + coupler) + rocker_mass * rocker
        )
        return self.gravity * moment / 2

    def potential(self, observed: Signals) -> Any:
        """Returns the potential energy [J], 0 with all links on the line of the axes."""
        return potential(self.gravity, _moving_links(self, observed["angle"]))


def _vectors(p: Any, t: Any) -> tuple[Any, Any, Any]:
    """Returns U, V and W of the module's docstring at the crank's angle t."""
    b = p.coupler
    c = p.rocker
    u = (p.crank * cos(t), p.crank * sin(t))
    # The vector (x, y) from the crank's end to D has the length `line`.
    x = p.ground - u[0]
    y = -u[1]
    square = (p.ground - p.crank) ** 2 + 4 * p.ground * p.crank * sin(t / 2) ** 2
    line = sqrt(square)
    # V has a part along this vector and a part across it. Both are divided by `line`. The part
    # across is the height of the triangle with coupler and rocker, by Heron's formula.
    along = (square + (b - c) * (b + c)) / (2 * square)
    area = (b + c - line) * (b + c + line) * (line + b - c) * (line - b + c)
    across = sqrt(area) / (2 * square)
    v = along * x - across * y, along * y + across * x
    return u, v, (v[0] - x, v[1] - y)


def _cross(a: Any, b: Any) -> Any:
    """Returns the vertical component of a x b."""
    return a[0] * b[1] - a[1] * b[0]


def _link_rates(p: Any, t: Any) -> tuple[Any, Any, Any]:
    """Returns (U, V, W), (f', r') of eq. 1 and (f'', r'') of eq. 2 at the crank's angle t."""
    u, v, w = _vectors(p, t)
    v_cross_w = _cross(v, w)
    turn = -_cross(u, w) / v_cross_w
    swing = -_cross(u, v) / v_cross_w
    k = [-x - turn**2 * y + swing**2 * z for x, y, z in zip(u, v, w, strict=True)]
    turning = -(k[0] * w[0] + k[1] * w[1]) / v_cross_w
    swinging = -(k[0] * v[0] + k[1] * v[1]) / v_cross_w
    return (u, v, w), (turn, swing), (turning, swinging)


def _moving_links(p: Any, t: Any) -> tuple[CrankLink, ...]:
    """Returns crank, coupler and rocker as links at the crank's angle t."""
    (u, v, w), (turn, swing), (turning, swinging) = _link_rates(p, t)
    return (
        CrankLink(p.crank_mass, u, 1.0),
        CrankLink(p.coupler_mass, v, turn, turning),
        CrankLink(p.rocker_mass, (-w[0], -w[1]), swing, swinging),
    )


def _coupler_middle(p: Any, q: Any, rates: Any) -> dict[str, Any]:
    """Returns the position of the coupler's middle, from the crank's axis [m], by observable."""
    u, v, _ = _vectors(p, q[0])
    return {"coupler_x": u[0] + v[0] / 2, "coupler_y": u[1] + v[1] / 2}
