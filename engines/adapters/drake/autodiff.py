"""Derivatives of a run by Drake's AutoDiffXd: the discrete plant stepped with numbers that carry
their derivative, from a context in which state and parameters have it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.analysis import Simulator_

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.drake.stepper import DrakeStepper, advance
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.sampling import step_count
from plumbob.engines.stepper import EndDerivatives, SceneMechanism


def derivatives(
    scenes: Sequence[SceneMechanism],
    apart: float,
    method: Method,
    step: float,
    duration: float,
) -> EndDerivatives:
    """Derivatives of the end of the middle one of three scenes by a number that is `apart` in the
    outer ones; raises Unsupported."""
    if method.control == "tolerance":
        raise Unsupported("AutoDiffXd is stepped in discrete plants alone here")
    steps = step_count(duration, step)
    sides, fixed = zip(*(_started(each, method, step, steps) for each in scenes), strict=True)
    if not all(map(np.array_equal, fixed[0], fixed[2])):
        raise Unsupported("the number is no parameter in a context of Drake's")
    end = _end(sides, apart, steps, step)
    qpos, qvel = _of_joints(sides[1], np.array([x.value() for x in end]))
    by_qpos, by_qvel = _of_joints(sides[1], np.array([float(x.derivatives()[0]) for x in end]))
    drawn = np.concatenate([joint.reference for joint in sides[1].mechanism.joints])
    return EndDerivatives(qpos + drawn, by_qpos, qvel, by_qvel)


def _end(sides: Sequence[DrakeStepper], apart: float, steps: int, step: float) -> Any:
    """The state after so many steps of `step` [s] from the start of the middle one of three
    steppers, with its derivatives: numbers of the outer ones are `apart`."""
    low, here, high = (side.simulator.get_context() for side in sides)
    diagram = sides[1].built.diagram.ToAutoDiffXd()
    context = diagram.CreateDefaultContext()
    context.SetTimeStateAndParametersFrom(here)
    _move(context, [low, high], apart)
    simulator = Simulator_[AutoDiffXd](diagram, context)
    simulator.Initialize()
    advance(simulator, steps, step)
    return simulator.get_context().get_discrete_state_vector().CopyToVector()


def _of_joints(stepper: DrakeStepper, values: Array) -> tuple[Array, Array]:
    """Numbers of the coordinates and of the rates of a tree of hinges and slides, joint by joint,
    among those of Drake's state."""
    joints, first = stepper.built.joints, stepper.built.plant.num_positions()
    places = values[[joint.position_start() for joint in joints]]
    return places, values[[first + joint.velocity_start() for joint in joints]]


def _started(
    scene: SceneMechanism, method: Method, step: float, steps: int
) -> tuple[DrakeStepper, tuple[Array, ...]]:
    """A scene at its start, its source set for so many steps, and the numbers of its
    diagram that no context has: gravity, the gains of actuators, and what the source tells. Raises
    Unsupported if it is no tree of hinges and slides."""
    mechanism = scene.mechanism
    kinds = {joint.kind for joint in mechanism.joints}
    if mechanism.touching or mechanism.loops or kinds - {"hinge", "slide"}:
        raise Unsupported("AutoDiffXd is stepped in trees of hinges and slides alone here")
    stepper = DrakeStepper(mechanism, {**method.settings, "time_step": step}, step)
    stepper.put(scene.start)
    times = step * np.arange(steps + 1, dtype=np.float64)
    controls = None if scene.controls is None else scene.controls(times[:-1])
    stepper.drive(controls, steps)
    motors = stepper.built.motors
    gears = np.array([x.gear for x in mechanism.actuators] + [1.0] * len(motors.held))
    gains = [x.gear**2 * np.array(x.bias[1:]) for x in mechanism.actuators]
    forces = gears * motors.forces(controls, times)
    return stepper, (mechanism.gravity, np.ravel(gains), forces)


def _move(context: Any, starts: list[Any], apart: float) -> None:
    """Give the numbers of a context their derivatives, by contexts on both sides."""
    for i in range(context.num_numeric_parameter_groups()):
        rows = [start.get_numeric_parameter(i).CopyToVector() for start in starts]
        held = context.get_mutable_numeric_parameter(i)
        held.SetFromVector(_moving(held.CopyToVector(), rows, apart))
    states = [start.get_discrete_state_vector().CopyToVector() for start in starts]
    values = context.get_discrete_state_vector().CopyToVector()
    context.SetDiscreteState(_moving(values, states, apart))


def _moving(values: Any, sides: list[Array], apart: float) -> Any:
    """Numbers with their derivatives, shape (n,), by their values on both sides."""
    slopes = (sides[1] - sides[0]) / apart
    return np.array(
        [AutoDiffXd(v.value(), np.array([s])) for v, s in zip(values, slopes, strict=True)]
    )
