"""Small changes of a mechanism's state: a rotation vector stands for the change of an attitude."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.peer_model import Layout
from plumbob.engines.stepper import State

# Factors of a quaternion's numbers in its conjugate
CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


@dataclass(frozen=True)
class TangentSpace:
    """The space of small changes of the states of joints, in the order of their velocities.

    States are rows of numbers: qpos, qvel and activations. A change has a number for each degree of
    freedom, each velocity and each activation. An attitude changes by a rotation vector [rad] in
    the axes of the body that turns."""

    # Degrees of freedom of each joint: 1, 3 of a ball, 6 of a free body
    degrees: tuple[int, ...]

    @property
    def positions(self) -> int:
        """The number of coordinates in qpos."""
        return self.velocities + len(self.attitudes)

    @property
    def velocities(self) -> int:
        """The number of coordinates in qvel."""
        return sum(self.degrees)

    @cached_property
    def attitudes(self) -> tuple[tuple[int, int], ...]:
        """For each attitude, the index of the first number of its quaternion in qpos, and the index
        of the first number of its rotation vector in a change."""
        ends = zip(self.degrees, accumulate(self.degrees), strict=True)
        turns = [end - 3 for degrees, end in ends if degrees > 1]
        # A quaternion has one number more than a rotation vector.
        return tuple((turn + before, turn) for before, turn in enumerate(turns))

    def size(self, state: Array) -> int:
        """Returns the number of numbers in a change of a state, shape (n,)."""
        return len(state) - len(self.attitudes)

    def shifted(self, states: Array, changes: Array) -> Array:
        """Returns states, shape (..., n), moved by changes, shape (..., m)."""
        # The inserted zeros are places for the quaternions' fourth numbers.
        moved = states + np.insert(changes, [turn for _, turn in self.attitudes], 0.0, axis=-1)
        for first, turn in self.attitudes:
            turned = exponential(changes[..., turn : turn + 3])
            moved[..., first : first + 4] = product(states[..., first : first + 4], turned)
        return np.asarray(moved)

    def differences(self, states: Array, others: Array) -> Array:
        """Returns the changes that move `others` to `states`, shape (..., n) each: shape (...,
        m)."""
        changes = states - others
        for first, _ in self.attitudes:
            back = CONJUGATE * others[..., first : first + 4]
            turned = product(back, states[..., first : first + 4])
            changes[..., first + 1 : first + 4] = logarithm(turned)
        return np.delete(changes, [first for first, _ in self.attitudes], axis=-1)

    def state_of(self, numbers: Array) -> State:
        """Returns the numbers of one state in the form of a stepper."""
        first = self.positions
        last = first + self.velocities
        return State(numbers[:first], numbers[first:last], numbers[last:])


def tangent_space(mechanism: Mechanism) -> TangentSpace:
    """Returns the tangent space of the states of a mechanism."""
    return TangentSpace(tuple(len(joint.damping) for joint in mechanism.joints))


def space_of_layout(layout: Layout) -> TangentSpace:
    """Returns the tangent space of the states of a model with this layout."""
    return TangentSpace(tuple(joint.size for joint in layout.joints))


def state_row(state: State) -> Array:
    """Returns the numbers of a state in one row."""
    return np.concatenate([state.qpos, state.qvel, state.act])


def product(first: Array, second: Array) -> Array:
    """Returns the products of quaternions, scalar first, shape (..., 4)."""
    a, b = first[..., :1], first[..., 1:]
    c, d = second[..., :1], second[..., 1:]
    real = a * c - (b * d).sum(axis=-1, keepdims=True)
    return np.concatenate([real, a * d + c * b + np.cross(b, d)], axis=-1)


def exponential(turns: Array) -> Array:
    """Returns the quaternions, scalar first, of rotation vectors [rad], shape (..., 3)."""
    angle = np.linalg.norm(turns, axis=-1, keepdims=True)
    scale = 0.5 * np.sinc(angle / (2.0 * np.pi))  # sin(angle / 2) / angle
    return np.concatenate([np.cos(angle / 2.0), scale * turns], axis=-1)


def logarithm(attitudes: Array) -> Array:
    """Returns the rotation vectors [rad] of quaternions, scalar first, shape (..., 4); their length
    is at most pi."""
    attitudes = np.where(attitudes[..., :1] < 0.0, -attitudes, attitudes)
    real = attitudes[..., :1]
    imaginary = attitudes[..., 1:]
    size = np.linalg.norm(imaginary, axis=-1, keepdims=True)
    turning = size > 0.0
    angle = np.where(turning, 2.0 * np.arctan2(size, real), 2.0)
    return np.asarray(angle / np.where(turning, size, 1.0) * imaginary)
