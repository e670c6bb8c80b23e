"""Small changes of a mechanism's state: a rotation vector stands for the change of an attitude."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.stepper import State

POSITIONS = {1: 1, 3: 4, 6: 7}  # numbers in qpos of a joint, by its degrees of freedom


@dataclass(frozen=True)
class TangentSpace:
    """The space of small changes of the states of joints, in the order of their velocities.

    States are rows of numbers: qpos, qvel and activations. A change has a number for each degree of
    freedom, each velocity and each activation. An attitude changes by a rotation vector [rad] in
    the axes of the body that turns."""

    degrees: tuple[int, ...]  # of freedom of each joint: 1, 3 of a ball, 6 of a free body

    @property
    def positions(self) -> int:
        """How many numbers qpos has."""
        return sum(POSITIONS[degrees] for degrees in self.degrees)

    @property
    def velocities(self) -> int:
        """How many numbers qvel has."""
        return sum(self.degrees)

    @cached_property
    def attitudes(self) -> tuple[tuple[int, int], ...]:
        """For each attitude the first number of its quaternion in qpos, and the first number of its
        rotation vector in a change."""
        pairs = list[tuple[int, int]]()
        position = velocity = 0
        for degrees in self.degrees:
            position += POSITIONS[degrees]
            velocity += degrees
            if degrees > 1:
                pairs.append((position - 4, velocity - 3))
        return tuple(pairs)

    @cached_property
    def _plain(self) -> tuple[list[int], list[int]]:
        """Places of the numbers that are no attitude's, in a state and in a change."""
        turning = {first + k for first, _ in self.attitudes for k in range(4)}
        turns = {first + k for _, first in self.attitudes for k in range(3)}
        in_state = [k for k in range(self.positions) if k not in turning]
        in_change = [k for k in range(self.velocities) if k not in turns]
        return in_state, in_change

    def shifted(self, states: Array, changes: Array) -> Array:
        """States, shape (..., n), moved by changes, shape (..., m)."""
        if not self.attitudes:
            return np.asarray(states + changes)
        rows = np.broadcast_shapes(states.shape[:-1], changes.shape[:-1])
        moved = np.array(np.broadcast_to(states, (*rows, states.shape[-1])))
        in_state, in_change = self._plain
        moved[..., in_state] += changes[..., in_change]
        moved[..., self.positions :] += changes[..., self.velocities :]
        for first, turn in self.attitudes:
            attitudes = states[..., first : first + 4]
            moved[..., first : first + 4] = product(
                attitudes, exponential(changes[..., turn : turn + 3])
            )
        return moved

    def differences(self, states: Array, others: Array) -> Array:
        """The changes that move `others` to `states`, shape (..., n) each: shape (..., m)."""
        if not self.attitudes:
            return np.asarray(states - others)
        activations = states.shape[-1] - self.positions - self.velocities
        size = 2 * self.velocities + activations
        changes = np.empty((*states.shape[:-1], size))
        in_state, in_change = self._plain
        changes[..., in_change] = states[..., in_state] - others[..., in_state]
        rest = slice(self.positions, None)
        changes[..., self.velocities :] = states[..., rest] - others[..., rest]
        for first, turn in self.attitudes:
            here = states[..., first : first + 4]
            back = others[..., first : first + 4] * np.array([1.0, -1.0, -1.0, -1.0])
            changes[..., turn : turn + 3] = logarithm(product(back, here))
        return changes

    def state_of(self, numbers: Array) -> State:
        """The numbers of one state as a stepper takes them."""
        first = self.positions
        last = first + self.velocities
        return State(numbers[:first], numbers[first:last], numbers[last:])


def tangent_space(mechanism: Mechanism) -> TangentSpace:
    """The tangent space of the states of a mechanism."""
    return TangentSpace(tuple(len(joint.damping) for joint in mechanism.joints))


def numbers_of(state: State) -> Array:
    """The numbers of a state in one row."""
    return np.concatenate([state.qpos, state.qvel, state.act])


def product(first: Array, second: Array) -> Array:
    """The products of quaternions, scalar first, shape (..., 4)."""
    real = first[..., :1] * second[..., :1]
    real = real - (first[..., 1:] * second[..., 1:]).sum(axis=-1, keepdims=True)
    imaginary = first[..., :1] * second[..., 1:] + second[..., :1] * first[..., 1:]
    imaginary = imaginary + np.cross(first[..., 1:], second[..., 1:])
    return np.concatenate([real, imaginary], axis=-1)


def exponential(turns: Array) -> Array:
    """The quaternions, scalar first, of rotation vectors [rad], shape (..., 3)."""
    angle = np.linalg.norm(turns, axis=-1, keepdims=True)
    scale = 0.5 * np.sinc(angle / (2.0 * np.pi))  # sin(angle / 2) / angle
    return np.concatenate([np.cos(angle / 2.0), scale * turns], axis=-1)


def logarithm(attitudes: Array) -> Array:
    """The rotation vectors [rad] of quaternions, scalar first, shape (..., 4); their length is pi
    at most."""
    attitudes = np.where(attitudes[..., :1] < 0.0, -attitudes, attitudes)
    real = attitudes[..., :1]
    imaginary = attitudes[..., 1:]
    size = np.linalg.norm(imaginary, axis=-1, keepdims=True)
    turning = size > 0.0
    angle = np.where(turning, 2.0 * np.arctan2(size, real), 2.0)
    return np.asarray(angle / np.where(turning, size, 1.0) * imaginary)
