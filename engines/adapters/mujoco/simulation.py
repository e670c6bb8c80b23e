"""A scene compiled for one MuJoCo method and step, and its runs."""

from __future__ import annotations

import time
from collections.abc import Sequence
from copy import copy
from dataclasses import replace

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines import sampling
from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.stepper import PHYSICS, MujocoStepper
from plumbob.engines.adapters.mujoco.translation import Observed, Translation, translated
from plumbob.engines.adapters.stepping import Built, SteppedSimulation
from plumbob.engines.controlled_steps import controlled_steps
from plumbob.engines.method import Method, Stepping, Unsupported
from plumbob.engines.stepper import Diverged, State
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case

# Sensors are computed at the samples only, and not in every step.
SENSOR = int(mujoco.mjtDisableBit.mjDSBL_SENSOR)


class MujocoSimulation(SteppedSimulation):
    """A compiled model with its start. Every `run` begins at the start."""

    def __init__(
        self,
        translation: Translation,
        model: mujoco.MjModel,
        steps: int,
        step: float,
        compile_seconds: float = 0.0,
        samples: int = sampling.MAX_SAMPLES,
        logged: Sequence[str] = (),
    ) -> None:
        """`logged` are messages of the compiler."""
        super().__init__(self._begun, steps, step, compile_seconds, BROKEN, samples)
        self.translation, self.logged = translation, logged
        self.stepper = MujocoStepper(model)

    @property
    def model(self) -> mujoco.MjModel:
        """The model that is stepped."""
        return self.stepper.model

    @property
    def data(self) -> mujoco.MjData:
        """The present state of the model."""
        return self.stepper.data

    def run(self) -> Trajectory:
        """Runs from the start to the end, or until the run diverges."""
        with options.collected() as logged:
            run = super().run()
        messages = dict.fromkeys((*self.logged, *logged, *run.warnings))
        return replace(run, warnings=tuple(messages))

    def stepped(self, fraction: float) -> Stepping:
        """Takes the steps of the first `fraction` of the duration, and reads no state."""
        with options.collected():
            return super().stepped(fraction)

    def _begun(self) -> Built:
        """The model at its start, ready to be advanced and read."""
        stepper = self.stepper
        translation = self.translation
        stepper.put(State(translation.qpos, translation.qvel))
        advance = controlled_steps(
            stepper, translation.control, self.step, translation.control_at
        )
        return Built(advance, stepper.physics, translation.limits, gather=self._observed)

    def _observed(self, states: Sequence[Array]) -> Observed:
        """The observables and channels of states, with those that sensors read."""
        nq = self.model.nq
        nv = self.model.nv
        _, qpos, qvel, _ = np.split(np.array(states), (1, 1 + nq, 1 + nq + nv), axis=1)
        observables, channels = self.translation.observed(qpos, qvel)
        if self.translation.sensors is not None:
            more = self.translation.sensors(self.readings(states))
            observables = {**observables, **more[0]}
            channels = {**channels, **more[1]}
        return observables, channels

    def readings(self, states: Sequence[Array]) -> Array:
        """The readings of the translation's probe at each sample, shape (n, k), with the forces of
        the step that begins there. The solver starts each time from where the run has ended."""
        model = copy(self.model)
        data = self.data
        rows = []
        model.opt.disableflags &= ~SENSOR
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
        marks = sampling.sampled(self.steps, self.samples)[: len(states)].astype(np.float64)
        for state, control in zip(states, self.held_controls(marks, self.step), strict=True):
            mujoco.mj_setState(model, data, state, PHYSICS)
            data.ctrl[:] = control
            mujoco.mj_forward(model, data)
            rows.append(self.translation.probe(model, data))
        return np.array(rows)

    def held_controls(self, steps: Array, step: float) -> Array:
        """The controls held over the steps with these indices, at `step` [s], shape (n, nu)."""
        controls = self.translation.held_controls(steps, step)
        return np.zeros((len(steps), self.model.nu)) if controls is None else controls


BROKEN = (Diverged, mujoco.FatalError)


def compiled(case: Case, method: Method, step: float) -> MujocoSimulation:
    """Translates and compiles a case for a method at `step` [s]; raises Unsupported and
    ParameterError."""
    steps = sampling.step_count(case.scene.duration, step)
    with options.collected() as logged:
        translation = translated(case, method, step)
        if translation.control is None and "control_at" in method.settings:
            same = method.name.partition("+")[0]
            raise Unsupported(f"nothing is controlled in {case.scene.name}: the same as {same}")
        options.apply(translation.spec, method.settings, step)
        begin = time.perf_counter()
        model = options.compiled(translation.spec)
        model.opt.disableflags |= options.needless_stages(model) | SENSOR
        translation.tune(model)
        seconds = time.perf_counter() - begin
    return MujocoSimulation(translation, model, steps, step, seconds, case.samples, logged)
