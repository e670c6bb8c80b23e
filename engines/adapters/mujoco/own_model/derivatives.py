"""Derivatives of a MuJoCo model's own run by `mjd_transitionFD`, multiplied along it, and names of
the numbers that they are taken by."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import repeat
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.model_fields import name_of
from plumbob.engines.adapters.mujoco.own_model.readings import control_names
from plumbob.engines.adapters.mujoco.own_model.user_stepper import diverged
from plumbob.engines.adapters.mujoco.stepper import MujocoStepper
from plumbob.engines.adapters.mujoco.terms import put
from plumbob.engines.adapters.mujoco.transition import advanced, difference
from plumbob.engines.own_motion import NotCertifiable, Script

TURNS = ("about x", "about y", "about z")
FREEDOMS = MappingProxyType({6: ("x", "y", "z", *TURNS), 3: TURNS})  # of joints with several


def names(model: Any) -> Mapping[str, tuple[str, ...]]:
    """Of positions, velocities, activations and controls: {kind: a name for each}."""
    freedoms = []
    for number in range(model.njnt):
        joint = name_of(model, "joint", number)
        several = FREEDOMS.get(int(np.count_nonzero(model.dof_jntid == number)), ("",))
        freedoms += [f"{joint} {freedom}".rstrip() for freedom in several]
    return {
        "position": tuple(freedoms),
        "velocity": tuple(freedoms),
        "activation": tuple(str(i) for i in range(model.na)),
        "control": control_names(model),
    }


def product(model: Any, data: Any, script: Script) -> Array:
    """Derivatives of the positions at the ends of the periods by the state at the start and by
    constant additions to the controls, shape (periods + 1, nv, 2 nv + na + nu); raises
    NotCertifiable where there are none. `data` is one of `model`, at its own step."""
    if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
        raise NotCertifiable("mjd_transitionFD refuses RK4")
    stepper = MujocoStepper(model, data)
    put(data, script.start)
    nv = model.nv
    size = 2 * model.nv + model.na
    parts = round(script.period / model.opt.timestep)
    along = np.eye(size, size + model.nu)
    added = np.eye(model.nu, size + model.nu, size)
    ends = np.full((len(script.controls) + 1, *along[:nv].shape), np.nan)
    ends[0] = along[:nv]
    controls = np.repeat(script.controls, parts, axis=0)
    steps = advanced(stepper, along, controls, repeat(added), difference(model))
    for k, along in enumerate(steps, 1):
        if diverged(data):
            raise NotCertifiable(f"its run diverges within {k * model.opt.timestep:g} s")
        if k % parts == 0:
            ends[k // parts] = along[:nv]
    return ends
