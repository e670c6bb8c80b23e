"""Forces on the joints of an Exudyn tree: springs, dampers and servos without limits, which the
tree has, and forces of actuators that a function gives whenever a solver asks for them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.exudyn.tables import Tabulated
from plumbob.engines.mechanism import Actuator, Joint, Mechanism

Motor = tuple[int, Joint, list[Actuator]]
"""A coordinate of a tree, the joint that it is of, and the actuators of that joint."""
Force = Callable[[Any, float, int, Array, Array], list[float]]
"""The forces on all coordinates of a tree [N m] or [N], by its system, the time [s], the number of
the tree, its coordinates and their rates."""


def joint_forces(
    mechanism: Mechanism, places: Sequence[slice], size: int, controls: Tabulated | None
) -> dict[str, Any]:
    """The keyword arguments of Exudyn's kinematic tree that describe the forces on its joints.

    The tree has `size` coordinates, and each joint those at its place among `places`. Controls
    follow the time; None stands for controls that stay zero.
    """
    constant, stiffness, damping = np.zeros((3, size))
    motors = list[Motor]()
    for number, joint in enumerate(mechanism.joints):
        own = [actuator for actuator in mechanism.actuators if actuator.joint == number]
        at = places[number].start
        if joint.kind in ("hinge", "slide"):
            stiffness[at] += joint.stiffness
            constant[at] += joint.stiffness * float(joint.rest[0])
            damping[at] += joint.damping[0]
        limited = joint.force_range or any(x.control_range or x.force_range for x in own)
        if own and (limited or controls is not None):
            motors.append((at, joint, own))
            continue
        for actuator in own:
            gear, bias = actuator.gear, actuator.bias
            constant[at] += gear * bias[0]
            stiffness[at] -= gear**2 * bias[1]
            damping[at] -= gear**2 * bias[2]
    return {
        "jointForceVector": constant,
        "jointPControlVector": stiffness,
        "jointDControlVector": damping,
        "jointPositionOffsetVector": np.zeros(size),
        "jointVelocityOffsetVector": np.zeros(size),
        "forceUserFunction": _pushing(motors, size, controls) if motors else 0,
    }


def _pushing(motors: Iterable[Motor], size: int, controls: Tabulated | None) -> Force:
    """The function that gives the forces of motors."""

    def push(system: Any, now: float, tree: int, place: Array, rate: Array) -> list[float]:
        forces = [0.0] * size
        row = None if controls is None else controls(now)
        for at, joint, actuators in motors:
            q, v = float(place[at]), float(rate[at])
            for x in actuators:
                control = 0.0 if row is None else _within(row[x.control], x.control_range)
                force = x.gain * control + x.bias[0] + x.gear * (x.bias[1] * q + x.bias[2] * v)
                forces[at] += x.gear * _within(force, x.force_range)
            forces[at] = _within(forces[at], joint.force_range)
        return forces

    return push


def _within(value: float, limits: tuple[float, float] | None) -> float:
    return value if limits is None else min(max(value, limits[0]), limits[1])
