"""Conversion between MuJoCo's and Newton's coordinates of joints.

Newton's coordinates are 0 in the drawing, and its quaternions have the scalar last. The velocities
of a free body are the velocity of its centre of mass and its angular velocity, both along the
world's axes. The angular velocity of a ball is along the axes of the body that carries the ball.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.mechanism import Joint
from plumbob.engines.peer_model import rotation
from plumbob.engines.stepper import State

TURNING = ("ball", "free")  # kinds of joint whose coordinates include a quaternion


class Coordinates:
    """Converts the coordinates of joints between MuJoCo and Newton. `centres` has the centre of
    mass of the body that each joint moves [m]."""

    def __init__(self, joints: Sequence[Joint], centres: Sequence[Array]) -> None:
        turning = np.concatenate([[x.kind in TURNING] * len(x.reference) for x in joints])
        hinges = np.concatenate([[x.kind == "hinge"] * len(x.reference) for x in joints])
        drawn = np.concatenate([joint.reference for joint in joints])
        self._drawn = np.where(turning, 0.0, drawn)
        self._hinges = np.flatnonzero(hinges)
        # for each joint with a quaternion: the number after its last coordinate, the number after
        # its last rate, and the centre of mass if the joint is free
        self._turning = list[tuple[int, int, Array | None]]()
        place = degree = 0
        for joint, centre in zip(joints, centres, strict=True):
            place, degree = place + len(joint.reference), degree + len(joint.damping)
            if joint.kind in TURNING:
                of_free = centre if joint.kind == "free" else None
                self._turning.append((place, degree, of_free))
        self._degrees = degree

    def to_newton(self, state: State) -> tuple[Array, Array]:
        """Newton's coordinates and rates in a state."""
        places, rates = state.qpos - self._drawn, np.array(state.qvel, float)
        for place, degree, centre in self._turning:
            q, v = places[place - 4 : place], rates[degree - 3 : degree]
            turn = rotation(q)
            v[:] = turn @ v
            if centre is not None:
                rates[degree - 6 : degree - 3] += np.cross(v, turn @ centre)
            q[:] = np.roll(q, -1)
        return places, rates

    def from_newton(self, found: tuple[Array, Array], latest: State) -> State:
        """The state from Newton's coordinates and rates, `found`. The sign of each quaternion, and
        the number of whole turns of each hinge, are those that are nearest to the `latest`
        state."""
        places, rates = found[0][: len(self._drawn)] + self._drawn, found[1][: self._degrees]
        apart = latest.qpos[self._hinges] - places[self._hinges]
        places[self._hinges] += 2.0 * math.pi * np.round(apart / (2.0 * math.pi))
        rates = rates.copy()
        for place, degree, centre in self._turning:
            q, v = places[place - 4 : place], rates[degree - 3 : degree]
            q[:] = np.roll(q, 1)
            before = latest.qpos[place - 4 : place]
            q *= math.copysign(1.0, q @ before) / math.sqrt(q @ q)
            turn = rotation(q)
            if centre is not None:
                rates[degree - 6 : degree - 3] -= np.cross(v, turn @ centre)
            v[:] = turn.T @ v
        return State(places, rates)
