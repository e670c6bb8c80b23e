"""Derivatives of a MuJoCo model's own run by `mjd_transitionFD`, multiplied along it, and names of
the numbers that they are taken by."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.engines.adapters.mujoco.model_fields import name_of
from plumbob.engines.adapters.mujoco.own_model.readings import control_names

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
