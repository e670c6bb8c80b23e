"""The bodies of a mechanism in the reference pose, in which every joint has its reference
coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.mechanism import Joint, Mechanism
from plumbob.engines.peer_model import rotation


@dataclass(frozen=True)
class ReferencePose:
    """The frames of the bodies in the world."""

    places: list[Array]  # place of each body [m], shape (3,) each
    turns: list[Array]  # rotation matrix of each body, shape (3, 3) each

    def point(self, body: int, place: Array) -> Array:
        """A point of a body in the world [m], shape (3,)."""
        return np.asarray(self.places[body] + self.turns[body] @ place)

    def axis(self, joint: Joint) -> Array:
        """The axis of a joint in the world, shape (3,)."""
        return np.asarray(self.turns[joint.body] @ joint.axis)


def reference_pose(mechanism: Mechanism) -> ReferencePose:
    """The reference pose of a mechanism."""
    pose = ReferencePose([np.zeros(3)], [np.eye(3)])
    for body in mechanism.bodies[1:]:
        pose.places.append(pose.point(body.parent, body.place))
        pose.turns.append(pose.turns[body.parent] @ rotation(body.attitude))
    return pose
