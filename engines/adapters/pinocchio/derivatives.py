"""Derivatives of a run. The derivatives of Pinocchio's inverse dynamics give the variational
equation of the motion, which is stepped together with the motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.equation import Equation
from plumbob.engines.adapters.integrators import fixed_steps
from plumbob.engines.adapters.joints import ONE_AXIS
from plumbob.engines.adapters.pinocchio.builder import Dynamics
from plumbob.engines.controlled_steps import given_controls
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.stepper import EndDerivatives, SceneMechanism


def derivatives(
    scenes: Sequence[SceneMechanism],
    difference: float,
    method: Method,
    step: float,
    duration: float,
) -> EndDerivatives:
    """The end of a run of the middle one of three scenes over a duration [s], with its derivatives
    by a number that differs by `difference` between the outer two scenes; raises Unsupported."""
    low, middle, high = (scene.start for scene in scenes)
    count = len(middle.qpos)
    equation = Equation(
        acceleration=Variation(scenes, difference).acceleration,
        position=np.concatenate([middle.qpos, (high.qpos - low.qpos) / difference]),
        rate=np.concatenate([middle.qvel, (high.qvel - low.qvel) / difference]),
        speed=1.0,
        names=tuple(f"q{number}" for number in range(2 * count)),
        rate_names=tuple(f"v{number}" for number in range(2 * count)),
    )
    run = fixed_steps(equation, method.scheme.integrator, duration, step).run()
    names = (*equation.names, *equation.rate_names)
    end = np.array([run.observables[name][-1] for name in names])
    return EndDerivatives(*np.split(end, 4))


class Variation:
    """Computes the acceleration of a mechanism and the derivative of that acceleration by a number.
    It takes three scenes: with the number a little smaller, unchanged, and a little larger. The
    number differs by `difference` between the outer two."""

    def __init__(self, scenes: Sequence[SceneMechanism], difference: float) -> None:
        mechanism = scenes[1].mechanism
        kinds = {joint.kind for joint in mechanism.joints}
        if mechanism.loops or kinds - set(ONE_AXIS):
            raise Unsupported("derivatives by Pinocchio need a tree of hinges and slides")
        limits = [joint.force_range for joint in mechanism.joints]
        limits += [actuator.force_range for actuator in mechanism.actuators]
        limits += [actuator.control_range for actuator in mechanism.actuators]
        if any(limits):
            raise Unsupported("a motor's limit is not differentiated")
        self.sides = [
            (Dynamics(scene.mechanism), given_controls(scene.controls)) for scene in scenes
        ]
        self.difference = difference
        self.stiffness = np.array([joint.stiffness for joint in mechanism.joints])
        self.damping = np.concatenate([joint.damping for joint in mechanism.joints])
        for motor in mechanism.actuators:
            self.stiffness[motor.joint] -= motor.gear**2 * motor.bias[1]
            self.damping[motor.joint] -= motor.gear**2 * motor.bias[2]

    def acceleration(self, time: float, position: Array, rate: Array) -> Array:
        """The acceleration at a time [s], followed by its derivative. `position` are the
        coordinates followed by their derivatives, `rate` the rates followed by theirs. The
        derivative follows from an identity: inverse dynamics returns the forces that act, so the
        derivatives of both are equal."""
        qpos, by_qpos = np.split(position, 2)
        qvel, by_qvel = np.split(rate, 2)
        low, acceleration, high = (
            self._acceleration_in_scene(number, time, qpos, qvel) for number in range(3)
        )
        slope = (high - low) / self.difference
        forces = self._forces_of_change(qpos, qvel, acceleration, (by_qpos, by_qvel))
        dynamics, _ = self.sides[1]
        inertia = dynamics.inertia(dynamics.configured(qpos))
        slope[dynamics.free] += np.linalg.solve(inertia, forces[dynamics.free])
        return np.concatenate([acceleration, slope])

    def _forces_of_change(
        self, qpos: Array, qvel: Array, acceleration: Array, change: tuple[Array, Array]
    ) -> Any:
        """The right-hand side f of M da = f, the linearised equation of motion: da is the
        derivative of the acceleration if coordinates and rates have the derivatives `change`."""
        by_qpos, by_qvel = change
        dynamics, _ = self.sides[1]
        data = dynamics.data
        q = dynamics.configured(qpos)
        pinocchio.computeRNEADerivatives(dynamics.model, data, q, qvel, acceleration)
        stiffness = data.dtau_dq + np.diag(self.stiffness)
        damping = data.dtau_dv + np.diag(self.damping)
        return -stiffness @ by_qpos - damping @ by_qvel

    def _acceleration_in_scene(self, number: int, time: float, qpos: Array, qvel: Array) -> Any:
        """The acceleration in the first, the middle or the last scene, by its number."""
        dynamics, controls_at = self.sides[number]
        controls = dynamics.idle
        if controls_at is not None:
            controls = controls_at(np.array([time]))[0].tolist()
        return dynamics.acceleration(time, qpos, qvel, controls)
