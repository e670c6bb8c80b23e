"""Derivatives of a run by Drake's AutoDiffXd, a type of numbers that carry their derivatives. The
discrete plant is stepped from a context whose state and parameters are such numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.analysis import Simulator_

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.drake.stepper import DrakeStepper, advance
from plumbob.engines.adapters.joints import ONE_AXIS
from plumbob.engines.controlled_steps import controls_at
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.sampling import step_count
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
    if method.control == "tolerance":
        raise Unsupported("derivatives by AutoDiffXd need a discrete plant")
    steps = step_count(duration, step)
    steppers, constants = zip(
        *(_start(scene, method, step, steps) for scene in scenes), strict=True
    )
    _require_equal(constants[0], constants[2])
    end = _end_state(steppers, difference, steps, step)
    stepper = steppers[1]
    values = np.array([number.value() for number in end])
    slopes = np.array([float(number.derivatives()[0]) for number in end])
    qpos, qvel = _by_joints(stepper, values)
    by_qpos, by_qvel = _by_joints(stepper, slopes)
    reference = np.concatenate([joint.reference for joint in stepper.mechanism.joints])
    return EndDerivatives(qpos + reference, by_qpos, qvel, by_qvel)


def _require_equal(constants: Mapping[str, Array], others: Mapping[str, Array]) -> None:
    """Raises Unsupported, with the name of the constant, if a constant differs from the other."""
    for name, value in constants.items():
        if not np.array_equal(value, others[name]):
            raise Unsupported(f"{name} is no parameter in a context of Drake")


def _end_state(
    steppers: Sequence[DrakeStepper], difference: float, steps: int, step: float
) -> Any:
    """The state after `steps` steps of `step` [s] from the start of the middle one of three
    steppers, with its derivatives by the scene's number. That number differs by `difference`
    between the outer two steppers."""
    low, middle, high = (stepper.simulator.get_context() for stepper in steppers)
    diagram = steppers[1].built.diagram.ToAutoDiffXd()
    context = diagram.CreateDefaultContext()
    context.SetTimeStateAndParametersFrom(middle)
    _set_derivatives(context, [low, high], difference)
    simulator = Simulator_[AutoDiffXd](diagram, context)
    simulator.Initialize()
    advance(simulator, steps, step)
    return simulator.get_context().get_discrete_state_vector().CopyToVector()


def _by_joints(stepper: DrakeStepper, values: Array) -> tuple[Array, Array]:
    """Splits values in the order of Drake's state into the values of the coordinates and the values
    of their rates, in the order of the joints. Each joint is a hinge or a slide."""
    joints = stepper.built.joints
    first_rate = stepper.built.plant.num_positions()
    coordinates = values[[joint.position_start() for joint in joints]]
    rates = values[[first_rate + joint.velocity_start() for joint in joints]]
    return coordinates, rates


def _start(
    scene: SceneMechanism, method: Method, step: float, steps: int
) -> tuple[DrakeStepper, Mapping[str, Array]]:
    """Returns a stepper at the start of a scene, whose source has the forces of `steps` steps, and
    the numbers of the diagram that no context contains, by their names: gravity, the gains of
    actuators, and the forces of the source. Raises Unsupported if the mechanism is no tree of
    hinges and slides."""
    mechanism = scene.mechanism
    kinds = {joint.kind for joint in mechanism.joints}
    if mechanism.touching or mechanism.loops or kinds - set(ONE_AXIS):
        raise Unsupported("derivatives by AutoDiffXd need a tree of hinges and slides")
    stepper = DrakeStepper(mechanism, {**method.settings, "time_step": step}, step)
    stepper.put(scene.start)
    times = step * np.arange(steps + 1, dtype=np.float64)
    controls = controls_at(scene.controls, times[:-1])
    stepper.drive(controls, steps)
    motors = stepper.built.motors
    actuators = mechanism.actuators
    gears = np.array([actuator.gear for actuator in actuators] + [1.0] * len(motors.held))
    gains = [actuator.gear**2 * np.array(actuator.bias[1:]) for actuator in actuators]
    forces = gears * motors.forces(controls, times)
    constants = {
        "gravity": mechanism.gravity,
        "an actuator's gain": np.ravel(gains),
        "a motor's force": forces,
    }
    return stepper, constants


def _set_derivatives(context: Any, sides: Sequence[Any], difference: float) -> None:
    """Gives the parameters and the state of a context their derivatives: the differences between
    the two contexts `sides`, divided by the `difference` of the scene's number."""
    for number in range(context.num_numeric_parameter_groups()):
        group = context.get_mutable_numeric_parameter(number)
        low, high = (side.get_numeric_parameter(number).CopyToVector() for side in sides)
        slopes = (high - low) / difference
        group.SetFromVector(_with_derivatives(group.CopyToVector(), slopes))
    state = context.get_discrete_state_vector().CopyToVector()
    low, high = (side.get_discrete_state_vector().CopyToVector() for side in sides)
    context.SetDiscreteState(_with_derivatives(state, (high - low) / difference))


def _with_derivatives(numbers: Any, slopes: Array) -> Any:
    """The numbers, shape (n,), with these derivatives, shape (n,)."""
    return np.array(
        [
            AutoDiffXd(number.value(), np.array([slope]))
            for number, slope in zip(numbers, slopes, strict=True)
        ]
    )
