"""Coordinates of joints, MuJoCo's and Newton's.

Newton's are 0 in the drawing, its quaternions have the scalar last. Velocities of a free body are
those of its centre of mass and its angular velocity in the world; a ball's is along the axes of the
body that carries it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.mechanism import Joint
from plumbob.engines.peer_model import rotation
from plumbob.engines.stepper import State

TURNING = ("ball", "free")  # kinds of joint with an attitude, a quaternion


def to_newton(
    joints: Sequence[Joint], centres: Sequence[Array], state: State
) -> tuple[Array, Array]:
    """Newton's coordinates and rates of a state, by the centre of mass of the body that each joint
    moves [m]."""
    places, rates = np.array(state.qpos, float), np.array(state.qvel, float)
    first = degree = 0
    for joint, centre in zip(joints, centres, strict=True):
        q = places[first : first + len(joint.reference)]
        v = rates[degree : degree + len(joint.damping)]
        first, degree = first + len(q), degree + len(v)
        if joint.kind not in TURNING:
            q -= joint.reference
            continue
        turn = rotation(q[-4:])
        v[-3:] = turn @ v[-3:]
        if joint.kind == "free":
            v[:3] += np.cross(v[3:], turn @ centre)
        q[-4:] = np.roll(q[-4:], -1)
    return places, rates


def from_newton(
    joints: Sequence[Joint], centres: Sequence[Array], found: tuple[Array, Array], latest: State
) -> State:
    """The state that Newton's coordinates and rates show: of each quaternion the sign that is
    nearer to the latest state's, of each angle the whole turns."""
    places, rates = (values.copy() for values in found)
    first = degree = 0
    for joint, centre in zip(joints, centres, strict=True):
        count = len(joint.reference)
        q, before = places[first : first + count], latest.qpos[first : first + count]
        v = rates[degree : degree + len(joint.damping)]
        first, degree = first + count, degree + len(v)
        if joint.kind not in TURNING:
            q += joint.reference
            if joint.kind == "hinge":
                q += 2.0 * math.pi * np.round((before - q) / (2.0 * math.pi))
            continue
        q[-4:] = np.roll(q[-4:], 1)
        q[-4:] *= math.copysign(1.0, q[-4:] @ before[-4:]) / math.sqrt(q[-4:] @ q[-4:])
        turn = rotation(q[-4:])
        if joint.kind == "free":
            v[:3] -= np.cross(v[3:], turn @ centre)
        v[-3:] = turn.T @ v[-3:]
    return State(places[:first], rates[:degree])
