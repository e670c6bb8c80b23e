"""Names of the numbers of a MuJoCo model's start and controls by which derivatives are taken."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.engines.adapters.mujoco.model_fields import name_of
from plumbob.engines.adapters.mujoco.own_model.readings import control_names

TURNS = ("about x", "about y", "about z")
# Names of the degrees of freedom of a joint with several
FREEDOMS = MappingProxyType({6: ("x", "y", "z", *TURNS), 3: TURNS})


def names(model: Any) -> Mapping[str, tuple[str, ...]]:
    """Returns {kind: a name for each number} of positions, velocities, activations and controls."""
    freedoms = []
    for number in range(model.njnt):
        joint = name_of(model, "joint", number)
        several = FREEDOMS.get(int(np.count_nonzero(model.dof_jntid == number)), ("",))
        freedoms += [f"{joint} {freedom}".rstrip() for freedom in several]
    return {
        "position": tuple(freedoms),
        "velocity": tuple(freedoms),
        "activation": tuple(map(str, range(model.na))),
        "control": control_names(model),
    }
