"""The joints of a mechanism, for adapters that build mechanisms: the joints of a body, their names,
the places of their coordinates in a state, and the signs of their quaternions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from plumbob.analytic.reference import Array
from plumbob.engines.mechanism import Joint, Mechanism

TURNING = ("ball", "free")  # kinds of joint whose coordinates include a quaternion
ONE_AXIS = ("hinge", "slide")  # kinds of joint with one coordinate


def joints_of_body(mechanism: Mechanism, body: int) -> list[int]:
    """The numbers of the joints between a body and its parent, in the order in which they act."""
    return [number for number, joint in enumerate(mechanism.joints) if joint.body == body]


def joint_name(mechanism: Mechanism, joint: Joint) -> str:
    """The name of a joint; without a name, "of body" and the name of its body."""
    return joint.name or f"of body {mechanism.bodies[joint.body].name}"


def joint_places(joints: Sequence[Joint]) -> Iterator[tuple[slice, slice]]:
    """For each joint, the place of its coordinates in `State.qpos` and the place of its rates in
    `State.qvel`."""
    first = first_rate = 0
    for joint in joints:
        end = first + len(joint.reference)
        end_of_rates = first_rate + len(joint.damping)
        yield slice(first, end), slice(first_rate, end_of_rates)
        first = end
        first_rate = end_of_rates


def with_latest_signs(joints: Sequence[Joint], qpos: Array, latest: Array) -> Array:
    """The coordinates `qpos` in which each quaternion has the sign that is nearer to the quaternion
    in the `latest` coordinates: a quaternion and its negative are the same attitude."""
    signed = qpos.copy()
    for joint, (place, _) in zip(joints, joint_places(joints), strict=True):
        if joint.kind in TURNING:
            quaternion = slice(place.stop - 4, place.stop)
            if qpos[quaternion] @ latest[quaternion] < 0.0:
                signed[quaternion] *= -1.0
    return signed
