"""Model files of users in Newton: what its importer reads of them, and runs by MuJoCo Warp, its
solver for them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from plumbob.engines.abilities import Fields
from plumbob.engines.adapters.mjwarp import WarpPort
from plumbob.engines.adapters.ported import load_file, mujoco_ports
from plumbob.engines.peer_model import Layout, NotRead, PeerModel, RefusedFile
from plumbob.models.border import border

FAR = 1e9  # more than the gains and gears of two actuators differ by


def _read(path: Path) -> tuple[Any, Any]:
    """A model file, and what Newton compiles for MuJoCo's solver of what it reads there, in the
    file's coordinates; raises NotRead."""
    import mujoco
    import newton

    solver = newton.solvers.SolverMuJoCo
    with border(RefusedFile):
        builder = newton.ModelBuilder(up_axis=newton.Axis.Z)
        solver.register_custom_attributes(builder)
        builder.add_mjcf(str(path))
        read = solver(builder.finalize(), use_mujoco_cpu=True).mj_model
    file = mujoco.MjModel.from_xml_path(str(path))
    for what in ("nbody", "nq", "nv", "nu"):
        if (ours := getattr(file, what)) != (theirs := getattr(read, what)):
            raise NotRead(f"it has {what} = {theirs}, the file {ours}")
    order = _order_of_actuators(file, read)
    for name in dir(read):
        if name.startswith("actuator_") and not name.endswith("adr"):
            values = getattr(read, name)
            values[:] = values[order]
    for joint in np.flatnonzero(file.jnt_type >= int(mujoco.mjtJoint.mjJNT_SLIDE)):
        at = file.jnt_qposadr[joint]
        shift = file.qpos0[at] - read.qpos0[at]  # as drawn, with a `ref` or without
        read.qpos0[at] += shift
        read.qpos_spring[at] += shift
        read.jnt_range[joint] += shift
    return file, read


def _order_of_actuators(file: Any, read: Any) -> Any:
    """The number in Newton's model of each actuator of the file, shape (n,): Newton puts servos
    first. Actuators are matched by their joints, then by the nearest gears and gains."""
    from scipy.optimize import linear_sum_assignment

    def numbers(model: Any) -> Any:
        joints = FAR * model.actuator_trnid[:, :1]
        gains = model.actuator_gainprm, model.actuator_biasprm
        return np.hstack([joints, model.actuator_gear, *gains])

    apart = np.abs(numbers(file)[:, None] - numbers(read)).sum(axis=-1)
    return linear_sum_assignment(apart)[1]


def model_fields(path: Path) -> Fields:
    """The numbers that Newton reads from a model file, by the file's names; raises NotRead."""
    file, read = _read(path)
    for field, name, numbers in mujoco_ports().fields(read, file):
        yield field, name, np.add(numbers, 0.0)  # no -0.0


def user_model(path: Path, layout: Layout, step: float) -> PeerModel:
    """The model of a file, as Newton has MuJoCo Warp step it; raises NotRead."""
    _, read = _read(path)
    return load_file(WarpPort, path, layout, step, read)
