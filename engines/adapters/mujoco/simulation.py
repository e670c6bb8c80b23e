"""A scene compiled for one MuJoCo method and step, and its runs."""

from __future__ import annotations

import time
from dataclasses import dataclass

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters import sampling
from plumbob.engines.adapters.divergence import within
from plumbob.engines.adapters.mujoco import flags, messages, options, stepping
from plumbob.engines.adapters.mujoco.translation import Translation, builder
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case


@dataclass
class MujocoSimulation:
    """A compiled model with its start; every `run` begins anew."""

    translation: Translation
    model: mujoco.MjModel
    data: mujoco.MjData
    steps: int
    step: float  # [s]
    compile_seconds: float
    logged: tuple[str, ...] = ()  # while compiling

    def run(self) -> Trajectory:
        """Run from the start to the end, or until the run diverges."""
        control = None if self.translation.control is None else self._control
        with messages.collected() as logged:
            course = stepping.course(self.model, self.data, self._start(), self.steps, control)
        nq, nv = self.model.nq, self.model.nv
        qpos, qvel = course.states[:, 1 : 1 + nq], course.states[:, 1 + nq : 1 + nq + nv]
        observables, channels = self.translation.observe(qpos, qvel)
        if self.translation.felt is not None:
            sensed = stepping.sensed(self.model, self.data, course.states)
            observables = {**observables, **self.translation.felt(sensed)}
        if self.translation.probe is not None:
            with messages.collected():  # as the run's own
                found = stepping.probed(
                    self.model, self.data, course.states, self._held(course.steps),
                    self.translation.probe,
                )  # fmt: skip
            observables, channels = {**observables, **found[0]}, {**channels, **found[1]}
        trajectory = Trajectory(
            times=course.steps.astype(np.float64) * self.step,
            observables=observables,
            channels=channels,
            steps=course.taken,
            seconds=course.seconds,
            diverged_at=None if course.diverged is None else course.diverged * self.step,
            warnings=tuple(dict.fromkeys((*self.logged, *logged))),
        )
        return within(trajectory, self.translation.limits)

    def _start(self) -> Array:
        """Full physics state at time 0."""
        start = np.zeros(mujoco.mj_stateSize(self.model, stepping.STATE))
        given = np.concatenate([self.translation.qpos, self.translation.qvel])
        start[1 : 1 + len(given)] = given
        return start

    def _held(self, steps: sampling.Indices) -> Array:
        """Controls of the steps that begin at the samples with these indices, shape (n, nu)."""
        if self.translation.control is None:
            return np.zeros((len(steps), self.model.nu))
        return self._control(steps)

    def _control(self, steps: sampling.Indices) -> Array:
        """Controls held over each of the steps with these indices, shape (n, nu)."""
        assert self.translation.control is not None
        times = (steps.astype(np.float64) + self.translation.control_at) * self.step
        return self.translation.control(times)


def compiled(case: Case, method: Method, step: float) -> MujocoSimulation:
    """Translate and compile `case` for `method` at `step` [s]; raises Unsupported and
    ParameterError."""
    steps = sampling.step_count(case.scene.duration, step)
    problem = case.problem
    chosen = builder(case.system)
    begin = time.perf_counter()
    with messages.collected() as logged:
        translation = chosen.build(case.system.mjcf, problem, method, step)
        if translation.control is None and "control_at" in method.settings:
            same = method.name.partition("+")[0]
            raise Unsupported(f"nothing is controlled in {case.scene.name}: the same as {same}")
        options.apply(translation.spec, method.settings, step)
        try:
            model = translation.spec.compile()
        except ValueError as error:
            reason = " ".join(str(error).split())
            raise Unsupported(f"MuJoCo refuses the model of {case.scene.name}: {reason}") from None
        model.opt.disableflags |= flags.needless(model) | int(flags.BIT.mjDSBL_AUTORESET)
        translation.tune(model)
        data = mujoco.MjData(model)
    seconds = time.perf_counter() - begin
    return MujocoSimulation(translation, model, data, steps, step, seconds, tuple(logged))
