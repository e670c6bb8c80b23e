"""Forces on the joints of an Exudyn tree. Springs, dampers and unlimited servos are parameters of
the tree. The forces of other actuators come from a function, which the solver calls in each
stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.joints import ONE_AXIS
from plumbob.engines.joint_forces import (
    JointForce,
    actuator_force,
    actuators_of,
    idle_controls,
)
from plumbob.engines.mechanism import Mechanism

Motor = tuple[int, JointForce]
"""The number of a coordinate of the tree, and the force of the actuators on its joint."""
Force = Callable[[Any, float, int, Array, Array], list[float]]
"""System, time [s], number of the tree, coordinates of the tree, their rates -> the forces on all
coordinates of the tree [N m] or [N]."""


def joint_forces(
    mechanism: Mechanism,
    places: Sequence[slice],
    size: int,
    controls: Callable[[float], Sequence[float]] | None,
) -> dict[str, Any]:
    """The keyword arguments of Exudyn's kinematic tree that describe the forces on its joints.

    The tree has `size` coordinates, and `places` has the place of each joint's coordinates among
    them. `controls` returns the controls at a time [s]; None stands for controls that stay
    zero.
    """
    constant, stiffness, damping = np.zeros((3, size))
    motors = list[Motor]()
    for number, joint in enumerate(mechanism.joints):
        actuators = actuators_of(mechanism, number)
        coordinate = places[number].start
        if joint.kind in ONE_AXIS:
            stiffness[coordinate] += joint.stiffness
            constant[coordinate] += joint.stiffness * float(joint.rest[0])
            damping[coordinate] += joint.damping[0]
        clamped = joint.force_range or any(
            actuator.control_range or actuator.force_range for actuator in actuators
        )
        if actuators and (clamped or controls is not None):
            motors.append((coordinate, actuator_force(joint, actuators)))
            continue
        for actuator in actuators:
            force, force_per_length, force_per_rate = actuator.bias
            constant[coordinate] += actuator.gear * force
            stiffness[coordinate] -= actuator.gear**2 * force_per_length
            damping[coordinate] -= actuator.gear**2 * force_per_rate
    idle = idle_controls(mechanism)
    force_function = _force_function(motors, size, controls or (lambda now: idle))
    return {
        "jointForceVector": constant,
        "jointPControlVector": stiffness,
        "jointDControlVector": damping,
        "jointPositionOffsetVector": np.zeros(size),
        "jointVelocityOffsetVector": np.zeros(size),
        "forceUserFunction": force_function if motors else 0,
    }


def _force_function(
    motors: Sequence[Motor], size: int, controls: Callable[[float], Sequence[float]]
) -> Force:
    """A function that returns the forces of motors on all coordinates; `controls` returns the
    controls at a time [s]."""

    def forces_at(
        system: Any, now: float, tree: int, coordinates: Array, rates: Array
    ) -> list[float]:
        """The forces at a time [s]. The system and the number of the tree have no effect."""
        forces = [0.0] * size
        row = controls(now)
        for number, exerted in motors:
            forces[number] += exerted(float(coordinates[number]), float(rates[number]), row)
        return forces

    return forces_at
