"""A scene compiled for one MuJoCo method and step, and its runs: stepped in C, block by block,
keeping every k-th state."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from plumbob.analytic.reference import Array
from plumbob.engines import sampling
from plumbob.engines.adapters.divergence import within
from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.translation import LARGEST, Translation
from plumbob.engines.method import Method, Stepping, Unsupported
from plumbob.engines.registry import find_builder
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case

BLOCK = 8192  # steps in one call: its states stay in the cache, and the call itself costs nothing
STATE = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)  # time, qpos, qvel and so on, one row a step
CTRL = int(mujoco.mjtState.mjSTATE_CTRL)


@dataclass
class MujocoSimulation:
    """A compiled model with its start; every `run` starts afresh."""

    translation: Translation
    model: mujoco.MjModel
    data: mujoco.MjData
    steps: int
    step: float  # [s]
    compile_seconds: float
    logged: tuple[str, ...] = ()  # while compiling
    samples: int = sampling.SAMPLES

    def run(self) -> Trajectory:
        """Run from the start to the end, or until the run diverges."""
        control = None if self.translation.control is None else self._control
        with options.collected() as logged:
            kept = take_steps(
                self.model, self.data, self._start(), self.steps, control, self.samples
            )
        trajectory = Trajectory(
            times=kept.steps.astype(np.float64) * self.step,
            observables={},
            steps=kept.taken,
            seconds=kept.seconds,
            diverged_at=None if kept.diverged is None else kept.diverged * self.step,
            warnings=tuple(dict.fromkeys((*self.logged, *logged))),
        )
        if not len(kept.steps):  # the start itself is beyond what MuJoCo takes
            return trajectory
        nq, nv = self.model.nq, self.model.nv
        qpos, qvel = kept.states[:, 1 : 1 + nq], kept.states[:, 1 + nq : 1 + nq + nv]
        observables, channels = self.translation.observe(qpos, qvel)
        if self.translation.sensors is not None:
            with options.collected():  # as the run's own
                more = self.translation.sensors(self.readings(kept))
            observables, channels = {**observables, **more[0]}, {**channels, **more[1]}
        trajectory = replace(trajectory, observables=observables, channels=channels)
        return within(trajectory, self.translation.limits)

    def stepped(self, fraction: float) -> Stepping:
        """The steps of the first `fraction` of the duration alone."""
        control = None if self.translation.control is None else self._control
        steps = sampling.first_steps(self.steps, fraction)
        with options.collected():
            kept = take_steps(
                self.model, self.data, self._start(), steps, control, clock=time.thread_time
            )
        return Stepping(kept.taken, kept.seconds)

    def readings(self, kept: KeptStates) -> Array:
        """Readings of the translation's probe in each state, with the forces that begin there, of
        shape (n, k); the solver begins each time where the run has ended."""
        model, data, rows = self.model, self.data, []
        option, before = model.opt, (model.opt.disableflags, model.opt.integrator)
        option.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
        option.integrator = int(mujoco.mjtIntegrator.mjINT_EULER)
        for state, control in zip(kept.states, self.held_controls(kept.steps), strict=True):
            mujoco.mj_setState(model, data, state, STATE)
            data.ctrl[:] = control
            mujoco.mj_forward(model, data)
            rows.append(self.translation.probe(model, data))
        option.disableflags, option.integrator = before
        return np.array(rows)

    def _start(self) -> Array:
        """Full physics state at time 0."""
        start = np.zeros(mujoco.mj_stateSize(self.model, STATE))
        coordinates = np.concatenate([self.translation.qpos, self.translation.qvel])
        start[1 : 1 + len(coordinates)] = coordinates
        return start

    def held_controls(self, steps: sampling.Indices) -> Array:
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
    with options.collected() as logged:
        translation: Translation = find_builder("mujoco", case.system).build(
            case.system.mjcf, case.problem, method, step
        )
        if translation.control is None and "control_at" in method.settings:
            same = method.name.partition("+")[0]
            raise Unsupported(f"nothing is controlled in {case.scene.name}: the same as {same}")
        options.apply(translation.spec, method.settings, step)
        begin = time.perf_counter()
        model = options.compiled(translation.spec)
        model.opt.disableflags |= options.needless_stages(model) | int(options.BIT.mjDSBL_AUTORESET)
        translation.tune(model)
        data = mujoco.MjData(model)
        seconds = time.perf_counter() - begin
    warned = tuple(logged)
    return MujocoSimulation(translation, model, data, steps, step, seconds, warned, case.samples)


@dataclass(frozen=True)
class KeptStates:
    """States that a run went through, until its end or until it diverged."""

    steps: sampling.Indices  # index of the step after which each state was kept, shape (n,)
    states: Array  # shape (n, nstate)
    taken: int  # steps taken in all
    seconds: float  # of the stepping alone, by the clock given, wall time without
    diverged: int | None  # the first step after which the state is not reliable


def take_steps(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    start: Array,
    steps: int,
    control: Callable[[sampling.Indices], Array] | None = None,
    samples: int = sampling.SAMPLES,
    clock: Callable[[], float] = time.perf_counter,
) -> KeptStates:
    """Take `steps` steps from the state `start`, shape (nstate,); `control` gives ctrl, shape
    (n, nu), for the step indices, shape (n,). Nothing is raised for a run that diverges."""
    kept = sampling.sampled(steps, samples)
    states = np.empty((len(kept), len(start)))
    states[0] = start
    diverged = None if reliable(start) else 0
    done, seconds = 0, 0.0
    block = _block(sampling.stride(steps, samples))
    rows = np.empty((1, min(block, steps), len(start)))
    mujoco.mj_resetData(model, data)
    with Rollout(nthread=0) as engine:
        while done < steps and diverged is None:
            n = min(block, steps - done)
            out = rows if n == rows.shape[1] else np.empty((1, n, len(start)))
            first = start if done == 0 else rows[0, -1].copy()  # rows are written over
            # each call starts the solver cold, unless given where the last one ended
            warm = data.qacc_warmstart[None].copy() if done else None
            seconds += _roll_out(
                engine, model, data, first, _controls(control, done, n), warm, out, clock
            )
            inside = (kept > done) & (kept <= done + n)
            states[inside] = out[0, kept[inside] - done - 1]
            if (bad := _first_bad(data, out[0], first)) is not None:
                diverged = min(done + bad + 1, steps)
            rows, done = out, done + n
    good = kept < (steps + 1 if diverged is None else diverged)
    return KeptStates(kept[good], states[good], diverged or done, seconds, diverged)


def _controls(
    control: Callable[[sampling.Indices], Array] | None, first: int, count: int
) -> Array | None:
    if control is None:
        return None
    return control(np.arange(first, first + count, dtype=np.int64))[None]


def _block(every: int) -> int:
    """Steps that are taken at once, of which every so many-th is kept."""
    return every * max(1, BLOCK // every)


def _roll_out(
    engine: Rollout,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    first: Array,
    controls: Array | None,
    warm: Array | None,
    out: Array,
    clock: Callable[[], float],
) -> float:
    """Take steps from `first`, as many as `out` has rows, into it; the time that took [s]."""
    begin = clock()
    engine.rollout(
        [model],
        [data],
        first[None].copy(),
        controls,
        control_spec=CTRL,
        skip_checks=True,
        nstep=out.shape[1],
        initial_warmstart=warm,
        state=out,
    )
    return clock() - begin


def reliable(states: Array) -> bool:
    """Whether every number is finite and below what the engine calls huge."""
    return bool(np.all(np.abs(states) < LARGEST))  # NaN compares false


def _first_bad(data: mujoco.MjData, rows: Array, before: Array) -> int | None:
    """Index of the first row that the engine itself rejects: after a warning it repeats a row, the
    first time in the next block where the warning came with the last row of this one."""
    if not data.warning.number.any():
        return None if reliable(rows[-1]) else _first_unreliable(rows)
    stalled = np.flatnonzero(np.diff(rows[:, 0], prepend=before[0]) <= 0.0)
    return int(min(_first_unreliable(rows), *stalled[:1], len(rows)))


def _first_unreliable(rows: Array) -> int:
    good = np.all(np.abs(rows) < LARGEST, axis=1)
    return int(np.argmin(good)) if not good.all() else len(rows)
