"""Forces on the joints of an Exudyn tree. Springs, dampers and unlimited servos are parameters of
the tree. The forces of other actuators come from a function, which the solver calls in each
stage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.exudyn.tables import Tabulated
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
    mechanism: Mechanism, places: Sequence[slice], size: int, controls: Tabulated | None
) -> dict[str, Any]:
    """The keyword arguments of Exudyn's kinematic tree that describe the forces on its joints.

    The tree has `size` coordinates, and `places` has the place of each joint's coordinates among
    them. `controls` is a function of the time; None stands for controls that stay zero.
    """
    constant, stiffness, damping = np.zeros((3, size))
    motors = list[Motor]()
    none = idle_controls(mechanism)
    for number, joint in enumerate(mechanism.joints):
        own = actuators_of(mechanism, number)
        at = places[number].start
        if joint.kind in ("hinge", "slide"):
            stiffness[at] += joint.stiffness
            constant[at] += joint.stiffness * float(joint.rest[0])
            damping[at] += joint.damping[0]
        limited = joint.force_range or any(x.control_range or x.force_range for x in own)
        if own and (limited or controls is not None):
            motors.append((at, actuator_force(joint, own)))
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
        "forceUserFunction": _pushing(motors, size, controls or (lambda now: none))
        if motors
        else 0,
    }


def _pushing(
    motors: Sequence[Motor], size: int, controls: Callable[[float], Sequence[float]]
) -> Force:
    """A function that returns the forces of motors on all coordinates; `controls` returns the
    controls at a time [s]."""

    def push(system: Any, now: float, tree: int, place: Array, rate: Array) -> list[float]:
        forces = [0.0] * size
        row = controls(now)
        for at, exerted in motors:
            forces[at] += exerted(float(place[at]), float(rate[at]), row)
        return forces

    return push
