"""Scenes in ports of MuJoCo: the MuJoCo adapter's translation, compiled for a port."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, RK4, Scheme
from plumbob.engines import registry
from plumbob.engines.abilities import CompilesScenes, PortsFiles, SchemeOfCase
from plumbob.engines.adapters.stepping import Built
from plumbob.engines.controlled_steps import controlled_steps
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.registry import find_engine
from plumbob.engines.stepper import State
from plumbob.models.scene import Case

if TYPE_CHECKING:
    from plumbob.engines.peer_model import Layout, PeerModel

STEPS = MappingProxyType(
    {
        "Euler": (Scheme(EULER, "start", implicit_damping=True), 1),
        "RK4": (Scheme(RK4, "start"), 4),
    }
)
"""{integrator: its scheme and order}."""
SINGLE = 2.0**29  # ratio of the rounding of single precision to that of double precision
# ratio of a driven slider's armature to its mass. MuJoCo's 1e10 leaves no digits in single
# precision.
SLIDER_RATIO = 1e4
# Compiling takes seconds: each system has one or two scenes.
SMOOTH = ("simple-pendulum/free-large", "cone-pendulum/rotating-base")
EVERY = (
    *SMOOTH,
    *("linear-pendulum/overdamped", "servo/motor-damped", "free-body/flip"),
    *("heavy-top/nutating", "n-pendulum/triple", "projectile/thrown", "four-bar/crank-rocker"),
    *("slider-crank/turning", "rolling-disc/wobbling", "bouncing-ball/half", "incline/stops"),
    *("pinch/0.5", "rod-impact/sticks", "rolling-ball/slide-to-roll", "stack/equal"),
    *("capsule-coast/translation", "capsule-hold/0.999", "capsule-line/ca1"),
    *("capsule-line/heading-030", "capsule-train/ten", "capsule-turn/0.3"),
    "capsule-plan/near-free",
)
model_error = partial(registry.model_error, engine="mujoco")
# fields of an mjData
LOADED = (
    "qpos",
    "qvel",
    "act",
    "ctrl",
    "qfrc_applied",
    "qacc_warmstart",
)


def ported(name: str, integrator: str, systems: tuple[str, ...], **settings: Any) -> Method:
    """A method of a port: one of MuJoCo's integrators, in single precision unless `float64`."""
    scheme, order = STEPS[integrator]
    settings = {"integrator": integrator, **settings}
    if not settings.get("float64"):
        scheme = replace(scheme, unit=SINGLE)
        settings["slider_ratio"] = SLIDER_RATIO
    return Method(name, scheme, order, settings=settings, systems=systems)


def scheme(case: Case, method: Method) -> Scheme:
    """The scheme of a port's method on a case: MuJoCo's with the same integrator."""
    mujoco_scheme = find_engine("mujoco").ability(SchemeOfCase)
    assert mujoco_scheme is not None
    return mujoco_scheme.of(case, method)


def compiled(case: Case, method: Method, step: float) -> tuple[Any, Any]:
    """The MuJoCo adapter's translation of `case`, and the compiled model at `step` [s]; raises
    Unsupported and ParameterError."""
    import mujoco

    compiles = find_engine("mujoco").ability(CompilesScenes)
    assert compiles is not None
    translation = compiles.translation(case, method, step)
    option = translation.spec.option
    option.timestep = step
    integrator = str(method.settings["integrator"]).upper()
    option.integrator = mujoco.mjtIntegrator.__members__[f"mjINT_{integrator}"]
    for start in translation.spec.keys:  # MJX would compile anew for another keyframe
        translation.spec.delete(start)
    model = translation.spec.compile()
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_SENSOR  # no step reads a sensor
    translation.tune(model)
    return translation, model


def load_file(
    make: Callable[[Any], Any], path: Path, layout: Layout, step: float, read: Any = None
) -> PeerModel:
    """Returns a model file in the port that `make` builds of a compiled model, stepped by `step`
    [s]. If another reader has `read` a compiled model from the file, that model is stepped in place
    of MuJoCo's. Raises NotRead."""
    return mujoco_ports().load(make, path, layout, step, read)


def mujoco_ports() -> PortsFiles:
    """Returns MuJoCo's ability to load model files into its ports."""
    ability = find_engine("mujoco").ability(PortsFiles)
    assert ability is not None
    return ability


def started(port: Any, translation: Any, model: Any) -> Any:
    """The port, put at the start of a scene."""
    import mujoco

    start = mujoco.MjData(model)
    start.qpos[:] = translation.qpos
    start.qvel[:] = translation.qvel
    port.load(start)
    return port


def uncontrolled(translation: Any) -> None:
    """Raises Unsupported if a control changes from step to step."""
    if translation.control is not None:
        raise Unsupported("no control changes while a port of MuJoCo takes all its steps")


@dataclass(frozen=True)
class PortSteps:
    """A port at the start of a scene, as a stepper is advanced and read."""

    port: Any

    def state(self) -> State:
        """Returns the present state, as doubles of numpy: JAX computes in single precision with
        arrays of its own."""
        return State(*(np.array(values, float) for values in self.port.state()))

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, nu), if there are any."""
        if controls is None:
            self.port.steps(steps)
        else:
            self.port.step_under(controls)


def built(port: Any, translation: Any, step: float) -> Built:
    """A scene at its start in a port, to be advanced in steps of `step` [s]."""

    def observed(states: Sequence[tuple[Any, Any]]) -> Any:
        """The observables and channels of pairs of positions and velocities."""
        qpos, qvel = (np.array(values, float) for values in zip(*states, strict=True))
        return translation.observed(qpos, qvel)

    advance = controlled_steps(
        PortSteps(port), translation.control, step, translation.control_at
    )
    return Built(advance, port.state, translation.limits, gather=observed)


def timed(port: Any, steps: int) -> float:
    """The wall time of `steps` steps [s]."""
    begin = time.perf_counter()
    port.steps(steps)
    return time.perf_counter() - begin
