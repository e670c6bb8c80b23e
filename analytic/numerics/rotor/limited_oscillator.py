"""A damped oscillator whose spring and damper, together, have a limited force, piece by piece.

    J x'' = T - c x',   T = -(k x + d x'), at most T_max in magnitude                           (1)

is a linear oscillator, or at the limit a damped body under a constant force. The unlimited T obeys
in the first the equation of x, so that its peaks fall from one to the next, and turns at most once
in the second. T does not jump from piece to piece: what an end is late by moves the motion in
second order only.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.linear_oscillator import linear_motion
from plumbob.analytic.reference import Array


@dataclass(frozen=True)
class LimitedOscillator:
    """Moment of inertia J [kg m^2], stiffness k [N m/rad], damping d, without a limit c
    [N m s/rad], and the limit [N m]."""

    inertia: float
    stiffness: float
    damping: float
    free_damping: float
    limit: float

    def unlimited(self, x: float, v: float) -> float:
        """T without its limit [N m]."""
        return -self.stiffness * x - self.damping * v

    def motion(self, side: float) -> DrivenRotor:
        """Eq. 1 below the limit, `side` 0, or at it, of a T of this sign."""
        drag, push = self.free_damping / self.inertia, side * self.limit / self.inertia
        if side:
            constant = math.pi / 2.0  # the phase of a frequency of 0
            return DrivenRotor(damping_rate=drag, forcing_amplitude=push, forcing_phase=constant)
        damping = drag + self.damping / self.inertia
        return DrivenRotor(damping_rate=damping, stiffness=self.stiffness / self.inertia)

    def pieces(self, x: float, v: float) -> Iterator[Piece]:
        """The parts of the motion from x and x', one after another."""
        torque = self.unlimited(x, v)
        side = math.copysign(1.0, torque) if abs(torque) > self.limit else 0.0
        piece: Piece | None = Piece(self, 0.0, x, v, side)
        while piece is not None:
            yield piece
            piece = piece.following

    def states(self, x: float, v: float, times: Array) -> Array:
        """x and x' at `times` [s], shape (n,), of the motion from x and x'; shape (2, n)."""
        states = np.zeros((2, len(times)))
        for piece in self.pieces(x, v):
            if not (later := times >= piece.begin).any():
                break
            states[:, later] = piece.states(times[later] - piece.begin)
        return states


@dataclass(frozen=True)
class Piece:
    """A part of the motion from `begin` [s], x and x' there, and the `side` on which T is at its
    limit, 1 or -1, or 0."""

    oscillator: LimitedOscillator
    begin: float
    x: float
    v: float
    side: float

    @cached_property
    def motion(self) -> DrivenRotor:
        """Its equation."""
        return self.oscillator.motion(self.side)

    def states(self, since: Array | float) -> tuple[Array, Array]:
        """x and x' so long after its begin [s], shape (n,)."""
        return linear_motion(self.motion, self.x, self.v, np.asarray(since))

    def torque(self, since: float) -> float:
        """T without its limit [N m]."""
        return self.oscillator.unlimited(*map(float, self.states(since)))

    def slope(self, since: float) -> float:
        """Of that [N m/s]."""
        (x, v), of = map(float, self.states(since)), self.motion
        gained = of.forcing_amplitude - of.damping_rate * v - of.stiffness * x
        return self.oscillator.unlimited(v, gained)

    @property
    def peak(self) -> float:
        """The first peak of |T| below the limit [s]; 0 where it falls."""
        pull, damping = self.motion.stiffness, self.motion.damping_rate
        torque, slope = self.torque(0.0), self.slope(0.0)
        # T' falls as e^(-damping t/2) (slope c + bend s), with c and s/root cosine and sine
        bend, root = -pull * torque - damping / 2 * slope, math.sqrt(abs(pull - damping**2 / 4))
        late = 0.0
        if pull > damping**2 / 4:
            late = math.atan2(-root * slope, bend) % math.pi / root
        elif root * abs(slope) < abs(bend):
            late = math.atanh(-root * slope / bend) / root if root else -slope / bend
        return max(late, 0.0)

    @property
    def following(self) -> Piece | None:
        """The next one; None after the last."""
        from scipy.optimize import brentq

        scale = math.sqrt(self.oscillator.inertia / self.oscillator.stiffness)
        first, last = 0.0, scale if self.side else self.peak
        side = self.side or math.copysign(1.0, self.torque(last))

        def beyond(since: float) -> float:
            return side * self.torque(since) - self.oscillator.limit

        if not self.side:
            if not last or beyond(last) <= 0.0:
                return None
            last = brentq(beyond, 0.0, last) if beyond(0.0) < 0.0 else 0.0
        else:
            while beyond(last) > 0.0:
                last *= 2.0
            if side * self.slope(0.0) > 0.0:
                first = brentq(self.slope, 0.0, last)
            last = brentq(beyond, first, last)
        x, v = map(float, self.states(last))
        return replace(self, begin=self.begin + last, x=x, v=v, side=0.0 if self.side else side)
