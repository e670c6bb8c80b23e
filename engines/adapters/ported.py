"""Scenes in ports of MuJoCo: the MuJoCo adapter's translation, compiled as a port steps it."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.schemes import EULER, RK4, Scheme
from plumbob.engines import registry
from plumbob.engines.abilities import CompilesScenes
from plumbob.engines.adapters.stepping import Built
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.registry import find_engine
from plumbob.models.scene import Case

STEPS = MappingProxyType(
    {
        "EULER": (Scheme(EULER, "start", implicit_damping=True), 1),
        "RK4": (Scheme(RK4, "start"), 4),
    }
)  # with their orders
SINGLE = 2.0**29  # single precision has 29 bits fewer
# Compiling takes seconds: one scene of each system, and none with contacts.
SMOOTH = ("simple-pendulum/free-large", "cone-pendulum/rotating-base")
OWN = ("integrator", "float64")  # settings that the MuJoCo adapter's builders do not read
model_error = partial(registry.model_error, engine="mujoco")
LOADED = ("qpos", "qvel", "act", "ctrl", "qfrc_applied", "qacc_warmstart")  # of an mjData
PORTED = "plumbob.engines.adapters.mujoco.terms.PortedModel"  # which imports MuJoCo


def ported(name: str, integrator: str, **settings: Any) -> Method:
    """A method of a port: one of MuJoCo's integrators, in single precision unless `float64`."""
    scheme, order = STEPS[integrator]
    scheme = scheme if settings.get("float64") else replace(scheme, unit=SINGLE)
    settings = {"integrator": integrator, **settings}
    return Method(name, scheme, order, settings=settings, systems=SMOOTH)


def compiled(case: Case, method: Method, step: float) -> tuple[Any, Any]:
    """The translation of `case`, and its model at `step` [s]; raises Unsupported and
    ParameterError."""
    import mujoco

    plain = replace(method, settings={n: v for n, v in method.settings.items() if n not in OWN})
    compiles = find_engine("mujoco").ability(CompilesScenes)
    assert compiles is not None
    translation = compiles.translation(case, plain, step)
    if translation.control is not None:
        raise Unsupported("no control changes while a port of MuJoCo takes its steps")
    option = translation.spec.option
    option.timestep = step
    name = "mjINT_" + str(method.settings["integrator"])
    option.integrator = mujoco.mjtIntegrator.__members__[name]
    for start in translation.spec.keys:  # no step reads it, and MJX compiles anew for another
        translation.spec.delete(start)
    model = translation.spec.compile()
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_SENSOR  # no step reads a sensor
    translation.tune(model)
    return translation, model


def started(port: Any, translation: Any, model: Any) -> Any:
    """The port, at the start of a scene."""
    import mujoco

    start = mujoco.MjData(model)
    start.qpos[:] = translation.qpos
    start.qvel[:] = translation.qvel
    port.load(start)
    return port


def built(port: Any, translation: Any) -> Built:
    """A scene at its start in a port."""

    def observed(states: Sequence[tuple[Any, Any]]) -> Any:
        qpos, qvel = (np.array(values, float) for values in zip(*states, strict=True))
        return translation.observed(qpos, qvel)

    def advance(first: int, last: int) -> None:
        port.steps(last - first)

    return Built(advance, port.state, translation.limits, gather=observed)


def timed(port: Any, steps: int) -> float:
    """Wall time to take steps [s]."""
    begin = time.perf_counter()
    port.steps(steps)
    return time.perf_counter() - begin
