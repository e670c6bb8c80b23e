"""Simulations of scenes in Drake: in a discrete plant, or in a continuous plant with an integrator
that controls its error."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, SimulatorConfig

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.drake.motors import held_forces
from plumbob.engines.adapters.drake.stepper import DrakeStepper
from plumbob.engines.adapters.stepped_mechanism import (
    compiled_scene,
    ready_to_step,
    simulated,
)
from plumbob.engines.adapters.stepping import (
    Built,
    Followed,
    FollowedSimulation,
    relative_tolerance,
)
from plumbob.engines.controlled_steps import controls_at
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Method, Options, Simulation
from plumbob.engines.peer_model import rotation
from plumbob.engines.sampling import step_count
from plumbob.engines.stepper import SceneMechanism, State
from plumbob.models.scene import Case

# Drake's exceptions if numbers are no longer finite
NOT_FINITE_ERRORS = (OverflowError, ValueError, RuntimeError)
CONTROL = 1e-3  # [s] time for which forces of a source are held in a continuous plant
SETTLING = 1000  # number of steps in which bodies come to rest on contacts
SETTLING_STEP = 1e-3  # [s]
CHECK_EVERY = 20  # number of steps between checks whether the bodies fall
AT_REST = 1e-3  # [m], [rad] largest displacement of a body that stands on a plane as it settles


def discrete(case: Case, method: Method, step: float) -> Simulation:
    """The simulation of a case at `step` [s] in a discrete plant, with the contact solver that the
    method names; raises Unsupported and ParameterError."""
    scene = with_settled_start(compiled_scene(case), method.settings)
    settings = {**method.settings, "time_step": step}

    def build(mechanism: Mechanism, start: State) -> DrakeStepper:
        """The stepper of a mechanism in the discrete plant."""
        return DrakeStepper(mechanism, settings, step)

    return simulated(case, step, build, NOT_FINITE_ERRORS, scene)


def with_settled_start(scene: SceneMechanism, settings: Options) -> SceneMechanism:
    """The scene with a start at which its bodies rest on their contacts; if the bodies do not stand
    on a plane, the scene as it is. Drake's contacts are springs: until they are compressed, a plane
    does not carry the weight of the bodies, and friction is proportional to the force that it
    carries."""
    mechanism = scene.mechanism
    start = scene.start
    planes = [shape for shape in mechanism.shapes if shape.kind == "plane" and shape.body == 0]
    if not planes:
        return scene
    normal = rotation(planes[0].attitude)[:, 2]
    joints = tuple(
        replace(joint, velocity=joint.velocity and np.zeros_like) for joint in mechanism.joints
    )
    pressed = replace(mechanism, joints=joints, gravity=normal @ mechanism.gravity * normal)
    stepper = DrakeStepper(pressed, {**settings, "time_step": SETTLING_STEP}, SETTLING_STEP)
    stepper.put(State(start.qpos, np.zeros_like(start.qvel)))
    qpos = start.qpos
    for _ in range(SETTLING // CHECK_EVERY):
        stepper.advance(None, CHECK_EVERY)
        qpos = stepper.state().qpos
        if np.abs(qpos - start.qpos).max() > AT_REST:  # the bodies fall
            return scene
    return replace(scene, start=State(qpos, start.qvel))


class ContinuousStepper(DrakeStepper):
    """The mechanism of a scene in a continuous plant, over a duration [s]. A "step" [s] here is the
    time from one sample to the next; within it, the integrator that `config` configures takes steps
    of any length."""

    def __init__(
        self, scene: SceneMechanism, step: float, duration: float, config: Any
    ) -> None:
        super().__init__(scene.mechanism, {"time_step": 0.0}, step, CONTROL)
        self.config = config
        times = CONTROL * np.arange(step_count(duration, CONTROL) + 1, dtype=np.float64)
        motors = self.built.motors
        if motors.source is not None:
            forces = motors.forces(controls_at(scene.controls, times[:-1]), times)
            motors.source.UpdateTrajectory(held_forces(forces, times - 0.5 * CONTROL))

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state, at the time 0, and resets the integrator."""
        super().put(state, time)
        ApplySimulatorConfig(self.config, self.simulator)
        self.simulator.Initialize()

    def advance(self, controls: Array | None, steps: int) -> None:
        """Advances by `steps` steps. The argument `controls` is ignored: the source has the
        controls of the scene."""
        self._clock.steps_taken += steps
        self.simulator.AdvanceTo(self._clock.steps_taken * self.step)


def continuous(case: Case, method: Method, accuracy: float, smallest: float) -> Simulation:
    """The simulation of a case in a continuous plant at a relative `accuracy`, with the integrator
    that the method names. Raises Unsupported, and ParameterError if the accuracy is below the
    `smallest`."""
    scene_duration = case.scene.duration
    config = SimulatorConfig(
        integration_scheme=method.settings["integration_scheme"],
        accuracy=relative_tolerance(accuracy, smallest),
        max_step_size=scene_duration,
        use_error_control=True,
        target_realtime_rate=0.0,
    )
    scene = with_settled_start(compiled_scene(case), {})

    def follow(duration: float, samples: int) -> Followed:
        """Follows the motion over a duration [s] from sample to sample, until Drake gives up."""
        step = duration / samples
        stepper, built = _start(case, scene, step, config)
        rows = [built.read()]
        errors = list[str]()
        try:
            for sample in range(samples):
                built.advance(sample, sample + 1)
                rows.append(built.read())
        except NOT_FINITE_ERRORS as error:
            errors.append(" ".join(str(error).split()))
        observables, _ = built.gather(rows)
        return Followed(
            times=np.asarray(step * np.arange(len(rows))),
            states=observables,
            evaluations=_evaluations(stepper.simulator),
            ended=not errors,
            why=tuple(errors),
        )

    begin = time.perf_counter()
    _, built = _start(case, scene, scene_duration, config)
    return FollowedSimulation(
        follow=follow,
        observe=dict,
        duration=scene_duration,
        compile_seconds=time.perf_counter() - begin,
        limits=built.limits,
        samples=case.samples,
    )


def _start(
    case: Case, scene: SceneMechanism, step: float, config: Any
) -> tuple[ContinuousStepper, Built]:
    """A stepper of a case in a continuous plant, and the case at its start in that stepper, ready
    to be advanced and read."""
    stepper = ContinuousStepper(scene, step, case.scene.duration, config)
    uncontrolled = replace(scene, controls=None)  # the source has the controls
    return stepper, ready_to_step(case, uncontrolled, step, stepper)


def _evaluations(simulator: Any) -> int:
    """The number of evaluations of derivatives that a simulator has made. CENIC does not count
    them: for CENIC it is three times the number of steps tried, rejected steps included."""
    integrator = simulator.get_integrator()
    evaluations = integrator.get_num_derivative_evaluations()
    if evaluations:
        return int(evaluations)
    rejected = integrator.get_num_step_shrinkages_from_error_control()
    return int(3 * (integrator.get_num_steps_taken() + rejected))
