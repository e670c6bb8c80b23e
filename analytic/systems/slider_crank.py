"""The slider-crank: a uniform crank and rod, and a slider on a line through the crank's axis.

With crank a, rod l, the crank's angle t from the line, and u = sqrt(l^2 - a^2 sin^2 t), the slider
is at x = a cos t + u. The rod is at the angle b from the line, l sin b = -a sin t, so its
derivatives by t are b' = -a cos t/u and b'' = a sin t (1 - b'^2)/u (Uicker, Pennock and Shigley
2017, Theory of Machines and Mechanisms, 2.8). If the rod is as long as the crank, u = 0 at t =
pi/2: the slider can then leave the axis or stay on it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import cos, sin, sqrt
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.numerics.smooth.smooth_system import SmoothSystem
from plumbob.analytic.numerics.smooth.soft_loop import softened
from plumbob.analytic.parameters import ParameterError, check_fields
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.schemes import SoftLoop
from plumbob.analytic.systems.crank_links import CrankLink, crank_motion, reaction
from plumbob.analytic.systems.n_pendulum import NPendulum

SLIDER_CRANK_LENGTHS = ("crank", "rod")
MASSES = ("crank_mass", "rod_mass", "slider_mass")
SLIDER_CRANK_CONSTANTS = (*SLIDER_CRANK_LENGTHS, *MASSES, "gravity")


@dataclass(frozen=True)
class SliderCrank:
    """Lengths [m] and masses [kg] of the links under `gravity` [m/s^2], with the crank's `angle`
    [rad] and its rate [rad/s] at time 0. Raises ParameterError.

    >>> crank = SliderCrank(0.2, 0.5, 1.0, 1.0, 1.0, 9.81, 1.0, 10.0)
    >>> round(float(crank.motion.observe(np.array([0.5]))["slider"][0]), 6)
    0.441343
    """

    crank: float
    rod: float
    crank_mass: float
    rod_mass: float
    slider_mass: float
    gravity: float
    angle: float
    angular_velocity: float

    def __post_init__(self) -> None:
        check_fields(self, SLIDER_CRANK_CONSTANTS[:-1], SLIDER_CRANK_CONSTANTS[-1:])
        if self.rod <= self.crank:
            raise ParameterError("rod", self.rod, f"longer than the crank, {self.crank:g} m")

    @cached_property
    def motion(self) -> CertifiedMotion:
        """The exact motion."""
        return crank_motion(
            self,
            SLIDER_CRANK_CONSTANTS,
            _moving_links,
            lambda p, q, v: {"slider": _slider_distance(p, q[0])},
        )

    @property
    def open_chain(self) -> SmoothSystem:
        """The equations of crank, rod and a separate slider, with the angles of both links, from
        the same start."""
        _, rod, _ = _moving_links(self, self.angle)
        angles = self.angle, math.atan2(rod.vector[1], rod.vector[0])
        by_angle = rod.vector[1] * (1.0 - rod.turn)  # [m] derivative of the slider's position
        masses = (self.crank_mass, self.rod_mass)
        lengths = (self.crank, self.rod)
        chain = NPendulum(masses, lengths, self.gravity, angles).motion.system

        def matrix(p: Any, q: Any) -> tuple[tuple[Any, ...], ...]:
            """Returns the mass matrix of the separate parts."""
            upper, lower = chain.mass_matrix(chain.values, q[:2])
            return (*upper, 0.0), (*lower, 0.0), (0.0, 0.0, p.slider_mass)

        def forces(p: Any, time: Any, q: Any, v: Any) -> tuple[Any, ...]:
            """Returns the generalised forces on the two rods; none acts on the slider along its
            line."""
            hanging = [angle + math.pi / 2 for angle in q[:2]]
            return (*chain.forces(chain.values, time, hanging, v[:2]), 0.0)

        return SmoothSystem(
            coordinates=("angle", "rod_angle", "slider"),
            rates=("angle_dot", "rod_angle_dot", "slider_dot"),
            mass_matrix=matrix,
            forces=forces,
            parameters=self.motion.system.parameters,
            position=(*angles, _slider_distance(self, self.angle)),
            rate=tuple(self.angular_velocity * float(x) for x in (1.0, rod.turn, by_angle)),
        )

    def soft(self, loop: SoftLoop, step: float) -> SmoothSystem:
        """Returns the equations of the mechanism with its rod tied to the slider by a soft
        constraint. The time constant of the constraint is at least two engine steps of size `step`
        [s]."""
        mass_matrix = self.open_chain.mass_matrix(self, (0.0, 0.0, 0.0))
        inverse_matrix = np.linalg.inv(mass_matrix)[:2, :2]
        # arms [m] of the rod's centre in the stretched chain
        lever = np.array([self.crank, self.rod / 2])
        # The inverse mass is a mean over three directions; the stretched chain moves in one.
        inverse_mass = lever @ inverse_matrix @ lever / 3 + 1 / self.slider_mass
        return softened(self.open_chain, _gap_terms, loop, step, inverse_mass)

    def reaction(self, times: Array) -> Array:
        """Returns the force of the slider's pin on the rod [N], along the line and up, at `times`
        [s], shape (n,): shape (2, n)."""
        return reaction(self, _gap_terms, times)

    @property
    def lift(self) -> float:
        """Potential energy [J] of crank and rod with the crank upright; it is 0 on the line."""
        return self.gravity * self.crank * (self.crank_mass + self.rod_mass) / 2

    def potential(self, observed: Signals) -> Any:
        """Returns the potential energy [J], 0 on the line."""
        return self.lift * sin(observed["angle"])


def _moving_links(p: Any, t: Any) -> tuple[CrankLink, CrankLink, CrankLink]:
    """Returns crank, rod, and the slider as a link without length, at the crank's angle t."""
    sine = p.crank * sin(t)
    cosine = p.crank * cos(t)
    root = sqrt((p.rod - p.crank) * (p.rod + p.crank) + cosine**2)
    turn = -cosine / root
    return (
        CrankLink(p.crank_mass, (cosine, sine), 1.0),
        CrankLink(p.rod_mass, (root, -sine), turn, sine / root * (1 - turn**2)),
        CrankLink(p.slider_mass, (0.0 * root, 0.0 * root)),
    )


def _slider_distance(p: Any, t: Any) -> Any:
    """Returns the slider's distance from the crank's axis [m]."""
    crank, rod, _ = _moving_links(p, t)
    return crank.vector[0] + rod.vector[0]


def _gap_terms(p: Any, q: Any, v: Any) -> tuple[Any, Any, Any]:
    """Returns the gap from the slider to the rod's end [m], along and across the line, its
    derivatives J, and J' q'."""
    across = sin(q[:2]) * (p.crank, p.rod)
    along = cos(q[:2]) * (p.crank, p.rod)
    gap = along.sum() - q[2], across.sum()
    square = np.square(v[:2])
    return gap, ((*-across, -1.0), (*along, 0.0)), (-along @ square, -across @ square)
