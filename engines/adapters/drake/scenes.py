"""Scenes in Drake: in a discrete plant, or in a continuous one with an integrator that controls its
error, a prescribed motion imposed step by step."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, SimulatorConfig

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.drake.motors import held_forces
from plumbob.engines.adapters.drake.stepper import DrakeStepper
from plumbob.engines.adapters.stepped_mechanism import begun, compiled_scene
from plumbob.engines.adapters.stepping import (
    Built,
    Followed,
    FollowedSimulation,
    relative_tolerance,
    stepped,
)
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Method, Options, Simulation
from plumbob.engines.peer_model import rotation
from plumbob.engines.sampling import step_count
from plumbob.engines.stepper import SceneMechanism, State
from plumbob.models.scene import Case

BROKEN = (OverflowError, ValueError, RuntimeError)  # raised where numbers are no longer finite
CONTROL = 1e-3  # [s] for which forces of a source are held in a continuous plant


SETTLING, SETTLING_STEP = 1000, 1e-3  # steps, and [s], in which bodies come to rest on contacts
LOOKED_AT = 20  # steps after which bodies that fall are seen to
AT_REST = 1e-3  # [m], [rad] by which a body that stands on a plane settles at most


def discrete(case: Case, method: Method, step: float) -> Simulation:
    """The discrete plant of `case` with the contact solver that `method` names, at `step` [s];
    raises Unsupported and ParameterError."""
    scene = settled(compiled_scene(case), method.settings)
    settings = {**method.settings, "time_step": step}
    stepper = cache(lambda: DrakeStepper(scene.mechanism, settings, step))
    return stepped(case, step, lambda: begun(case, scene, step, stepper()), BROKEN)


def built(mechanism: Mechanism, start: State, step: float) -> DrakeStepper:
    """A mechanism in Drake's discrete plant with its default settings, at `step` [s]; raises
    Unsupported."""
    return DrakeStepper(mechanism, {"time_step": step}, step)


def settled(scene: SceneMechanism, settings: Options) -> SceneMechanism:
    """A scene whose bodies, if they stand on a plane at the start, have come to rest on contacts
    that yield: until then a plane does not carry their weight, which friction follows."""
    mechanism, start = scene.mechanism, scene.start
    planes = [x for x in mechanism.shapes if x.kind == "plane" and x.body == 0]
    if not planes:
        return scene
    normal = rotation(planes[0].attitude)[:, 2]
    joints = tuple(
        replace(joint, velocity=joint.velocity and np.zeros_like) for joint in mechanism.joints
    )
    pressed = replace(mechanism, joints=joints, gravity=normal @ mechanism.gravity * normal)
    settling = {**settings, "time_step": SETTLING_STEP}
    stepper = DrakeStepper(pressed, settling, SETTLING_STEP)
    stepper.put(State(start.qpos, np.zeros_like(start.qvel)))
    now = start.qpos
    for _ in range(SETTLING // LOOKED_AT):
        stepper.advance(None, LOOKED_AT)
        now = stepper.state().qpos
        if np.abs(now - start.qpos).max() > AT_REST:  # they fall
            return scene
    return replace(scene, start=State(now, start.qvel))


class ContinuousStepper(DrakeStepper):
    """A scene's mechanism in a continuous plant, over a duration [s]: a "step" is from sample to
    sample, the integrator that a configuration names takes its own."""

    def __init__(
        self, scene: SceneMechanism, step: float, duration: float, chosen: Any
    ) -> None:
        super().__init__(scene.mechanism, {"time_step": 0.0}, step, CONTROL)
        self.chosen = chosen
        times = CONTROL * np.arange(step_count(duration, CONTROL) + 1, dtype=np.float64)
        if self.built.motors.source is not None:
            rows = None if scene.controls is None else scene.controls(times[:-1])
            held = held_forces(self.built.motors.forces(rows, times), times - 0.5 * CONTROL)
            self.built.motors.source.UpdateTrajectory(held)

    def put(self, state: State, time: float = 0.0) -> None:
        """Set the state, at the time 0, for an integrator that has taken no step."""
        super().put(state, time)
        ApplySimulatorConfig(self.chosen, self.simulator)
        self.simulator.Initialize()

    def advance(self, controls: Array | None, steps: int) -> None:
        """Go on to the end of the last of the `steps`; the controls are the scene's."""
        self._taken += steps
        self.simulator.AdvanceTo(self._taken * self.step)


def continuous(case: Case, method: Method, accuracy: float, smallest: float) -> Simulation:
    """The continuous plant of `case` with the integrator that `method` names, at an accuracy of at
    least the `smallest`, forces of a source held for CONTROL; raises Unsupported and
    ParameterError."""
    lasting = case.scene.duration
    chosen = SimulatorConfig(
        integration_scheme=method.settings["integration_scheme"],
        accuracy=relative_tolerance(accuracy, smallest),
        max_step_size=lasting,
        use_error_control=True,
        target_realtime_rate=0.0,
    )
    scene = settled(compiled_scene(case), {})

    def follow(duration: float, samples: int) -> Followed:
        step = duration / samples
        stepper, built = _started(case, scene, step, chosen)
        rows = [built.read()]
        why = list[str]()
        try:
            for k in range(samples):
                built.advance(k, k + 1)
                rows.append(built.read())
        except BROKEN as error:
            why.append(" ".join(str(error).split()))
        observed, _ = built.gather(rows)
        times = np.asarray(step * np.arange(len(rows)))
        evaluations = _evaluations(stepper.simulator)
        return Followed(times, observed, evaluations, not why, tuple(why))

    begin = time.perf_counter()
    limits = _started(case, scene, lasting, chosen)[1].limits
    return FollowedSimulation(
        follow, dict, lasting, time.perf_counter() - begin, limits, case.samples
    )


def _started(
    case: Case, scene: SceneMechanism, step: float, chosen: Any
) -> tuple[ContinuousStepper, Built]:
    """A case at its start in a continuous plant, with what reads it off."""
    stepper = ContinuousStepper(scene, step, case.scene.duration, chosen)
    driven = replace(scene, controls=None)  # by the plant's own source
    return stepper, begun(case, driven, step, stepper)


def _evaluations(simulator: Any) -> int:
    """How often a simulator has evaluated derivatives. CENIC does not count them: then three for
    each step that it tried, rejected ones included."""
    integrator = simulator.get_integrator()
    if counted := integrator.get_num_derivative_evaluations():
        return int(counted)
    rejected = integrator.get_num_step_shrinkages_from_error_control()
    return int(3 * (integrator.get_num_steps_taken() + rejected))
