"""Conversion between MuJoCo's and Newton's coordinates of joints.

Newton's coordinates are 0 in the reference pose, and its quaternions have the scalar last. The
velocities of a free body are the velocity of its centre of mass and its angular velocity, both
along the world's axes. The angular velocity of a ball is along the axes of the body that carries
the ball.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.joints import TURNING, joint_places
from plumbob.engines.mechanism import Joint
from plumbob.engines.peer_model import rotation
from plumbob.engines.stepper import State


class Coordinates:
    """Converts the coordinates of joints between MuJoCo and Newton. `centres` has the centre of
    mass of the body that each joint moves [m]. If a solver is `maximal`, its state has bodies,
    which give the angle of a hinge up to whole turns; other solvers have the angle itself."""

    def __init__(
        self, joints: Sequence[Joint], centres: Sequence[Array], *, maximal: bool
    ) -> None:
        places = list(joint_places(joints))
        self._reference = np.concatenate(
            [
                0.0 * joint.reference if joint.kind in TURNING else joint.reference
                for joint in joints
            ]
        )
        self._without_turns = [  # places of the angles whose whole turns are unknown
            place.start
            for joint, (place, _) in zip(joints, places, strict=True)
            if maximal and joint.kind == "hinge"
        ]
        # For each joint with a quaternion: the number after its last coordinate, the number after
        # its last rate, and the centre of mass if the joint is free
        self._turning = list[tuple[int, int, Array | None]]()
        for joint, centre, (place, rates) in zip(joints, centres, places, strict=True):
            if joint.kind in TURNING:
                centre_if_free = centre if joint.kind == "free" else None
                self._turning.append((place.stop, rates.stop, centre_if_free))
        self._degrees = sum(len(joint.damping) for joint in joints)

    def to_newton(self, state: State) -> tuple[Array, Array]:
        """Newton's coordinates and rates in a state."""
        positions = state.qpos - self._reference
        rates = np.array(state.qvel, float)
        for end, end_of_rates, centre in self._turning:
            attitude = positions[end - 4 : end]
            spin = rates[end_of_rates - 3 : end_of_rates]
            turn = rotation(attitude)
            spin[:] = turn @ spin
            if centre is not None:
                velocity = rates[end_of_rates - 6 : end_of_rates - 3]
                velocity += np.cross(spin, turn @ centre)
            attitude[:] = np.roll(attitude, -1)
        return positions, rates

    def from_newton(self, joint_q: Array, joint_qd: Array, latest: State) -> State:
        """The state from Newton's coordinates and rates. The sign of each quaternion, and the
        number of whole turns of a hinge if it is unknown, are those that are nearest to the
        `latest` state."""
        positions = joint_q[: len(self._reference)] + self._reference
        rates = joint_qd[: self._degrees].copy()
        hinges = self._without_turns
        difference = latest.qpos[hinges] - positions[hinges]
        positions[hinges] += 2.0 * math.pi * np.round(difference / (2.0 * math.pi))
        for end, end_of_rates, centre in self._turning:
            attitude = positions[end - 4 : end]
            spin = rates[end_of_rates - 3 : end_of_rates]
            attitude[:] = np.roll(attitude, 1)
            sign = math.copysign(1.0, attitude @ latest.qpos[end - 4 : end])
            attitude *= sign / math.sqrt(attitude @ attitude)
            turn = rotation(attitude)
            if centre is not None:
                velocity = rates[end_of_rates - 6 : end_of_rates - 3]
                velocity -= np.cross(spin, turn @ centre)
            spin[:] = turn.T @ spin
        return State(positions, rates)
