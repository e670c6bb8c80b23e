"""A scene in MuJoCo's terms: the record that builders return, and functions to build it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.schemes import SoftLoop
from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.contacts import ContactProfile
from plumbob.engines.adapters.stepping import Observed as Observed
from plumbob.engines.controlled_steps import controls_at
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.registry import builder
from plumbob.engines.trajectory import ByName
from plumbob.models.model_file import Controls, Feedback, ModelFile
from plumbob.models.scene import Case

LARGEST = 1e10  # MuJoCo warns of larger numbers


def sensor_data(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """The sensor data of one state, shape (nsensordata,)."""
    return np.array(data.sensordata)


@dataclass(frozen=True)
class Translation:
    """A scene in MuJoCo's terms: a model that is not compiled yet, its start, and how to read
    it."""

    spec: mujoco.MjSpec
    qpos: Array  # start, shape (nq,)
    qvel: Array  # start, shape (nv,)
    observe: Callable[[Array, Array], Observed] | None = None
    """qpos, shape (n, nq), and qvel, shape (n, nv) -> observables and channels; None if the
    system's model file reads them."""
    channels: Callable[[Array, Array], Signals] = lambda qpos, qvel: {}
    """qpos and qvel -> channels beside the observables of the system's model file."""
    limits: ByName = field(default_factory=dict)
    """Magnitudes of observables that only a diverged run exceeds, beside the system's limits."""
    control: Controls | Feedback | None = None
    """Times [s], shape (n,) -> ctrl, shape (n, nu), held over each step; or a feedback. None: the
    system's."""
    changing_control: Callable[[Array], Array] | None = None
    """The control as it changes within a step, if `control` is the mean over each step."""
    control_at: float = 0.0  # place in a step where the control is read: 0 start, 0.5 middle
    sensors: Callable[[Array], Observed] | None = None
    """Readings of `probe` at the samples, shape (n, k) -> observables and channels that are not
    functions of the state."""
    probe: Callable[[mujoco.MjModel, mujoco.MjData], Array] = sensor_data
    """Model and data, with the forces of the step that begins -> a reading, shape (k,)."""
    visual: mujoco.MjSpec | None = None
    """The model with its visual parts. None if `spec` has them, or if it is the model file with the
    problem's numbers, whose geoms are visual."""
    tune: Callable[[mujoco.MjModel], None] = lambda model: None
    """Changes the compiled model in ways that a file cannot express."""

    def held_controls(self, steps: Array, step: float) -> Array | None:
        """The controls held over the steps with these indices, at `step` [s], shape (n, nu); None
        if nothing is controlled. Raises Unsupported for controls that are fed back."""
        return controls_at(self.control, (steps + self.control_at) * step)

    def observed(self, qpos: Array, qvel: Array) -> Observed:
        """The observables and channels of coordinates, shape (n, nq) and (n, nv)."""
        assert self.observe is not None  # `translated` sets it
        return self.observe(qpos, qvel)


def translated(case: Case, method: Method, step: float) -> Translation:
    """The translation of a case: by the builder of its system if there is one, else its model file
    without visual parts. Raises Unsupported and ParameterError."""
    system, problem = case.system, case.problem
    file = system.model_file
    build = getattr(builder("mujoco", system), "build", None)
    if build is not None:
        built: Translation = build(system.mjcf, problem, method, step)
    elif file is not None:
        built = at_start(bare(filled(system.mjcf, file, problem)))
    else:
        raise Unsupported(f"mujoco has no builder for {system.name}")
    if file is None:
        return built

    def observe(qpos: Array, qvel: Array) -> Observed:
        """The observables that the model file reads, and the channels of the builder."""
        return file.observe(problem, qpos, qvel), built.channels(qpos, qvel)

    return replace(
        built,
        observe=built.observe or observe,
        limits={**file.largest(problem), **built.limits},
        control=built.control or file.controls(problem),
    )


def with_visual_parts(translation: Translation, case: Case) -> mujoco.MjSpec:
    """The model of a translation of a case, with its visual parts. Raises Unsupported if there is
    none."""
    if translation.visual is not None:
        return translation.visual
    if translation.spec.geoms:
        return translation.spec.copy()
    file = case.system.model_file
    if file is None:
        raise Unsupported(f"mujoco has no model file of {case.scene.name}")
    return filled(case.system.mjcf, file, case.problem)


def at_start(spec: mujoco.MjSpec, **more: Any) -> Translation:
    """The translation of a model that starts at its keyframe "start"."""
    start = spec.key("start")
    return Translation(spec, np.array(start.qpos), np.array(start.qvel), **more)


def bare(spec: mujoco.MjSpec) -> mujoco.MjSpec:
    """Deletes the geoms and meshes of a model, which only cost time, and returns it."""
    for shown in (*spec.geoms, *spec.meshes):
        spec.delete(shown)
    return spec


def solved_loop(motion: CertifiedMotion, loop: SoftLoop, duration: float) -> ByName:
    """The bound on the rounding of the solver of a loop, as an angle [rad], by its reason. The
    condition of the solver's Hessian is 1/(1 - d) times that of the mass matrix. That many ulps of
    the largest acceleration, which is about the square of the largest rate, may be lost in every
    step."""
    states = motion.observe(np.linspace(0.0, duration, 101))
    fastest_rate = max(float(np.abs(states[name]).max()) for name in motion.system.rates)
    bound = ULP / (1 - loop.impedance) * (fastest_rate * duration) ** 2 / 2
    return {"rounding of the solver": bound}


def set_contacts(spec: mujoco.MjSpec, profile: ContactProfile, step: float) -> None:
    """Sets the options of a profile, and its fields of every contact pair, at `step` [s]. The
    compiled model is to be softened: see `ContactProfile.soften`."""
    options.apply(spec, profile.options, step)
    for pair in spec.pairs:
        for name, value in profile.pair(step).items():
            setattr(pair, name, value)


def at_rest(model: mujoco.MjModel, steps: int) -> Array:
    """The coordinates after `steps` steps of a model from its reference pose, shape (nq,)."""
    binary = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, binary)
    return np.array(_end_of_steps(binary.tobytes(), steps))


@lru_cache(maxsize=256)  # methods that differ only in their later steps have the same model
def _end_of_steps(binary: bytes, steps: int) -> tuple[float, ...]:
    """The coordinates after `steps` steps of a model in MuJoCo's binary format."""
    model = mujoco.MjModel.from_binary_path("model.mjb", {"model.mjb": binary})
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=steps)
    return tuple(data.qpos.tolist())


def filled(mjcf: Path, model: ModelFile, problem: Any) -> mujoco.MjSpec:
    """The model in the file `mjcf` with the numbers of `problem`, visual parts included. If the
    problem has a variant of the file, it is in the same folder. Raises ParameterError if the file
    holds no model."""
    spec = read(mjcf.with_name(model.variant(problem) or mjcf.name))
    model.fill(spec, problem)
    return spec


def read(mjcf: Path) -> mujoco.MjSpec:
    """A copy of the model in the file `mjcf`; raises ParameterError if the file holds no model."""
    try:
        return _parsed(str(mjcf), mjcf.stat().st_mtime_ns).copy()
    except (ValueError, OSError) as error:
        raise ParameterError("mjcf", str(mjcf), f"a MuJoCo model file ({error})") from None


@lru_cache(maxsize=32)  # a copy costs a twentieth of what reading costs
def _parsed(path: str, changed: int) -> mujoco.MjSpec:
    """The model in a file that was last `changed` at this time [ns]."""
    return mujoco.MjSpec.from_file(path)
