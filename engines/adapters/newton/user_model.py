"""A user's model file in Newton: the numbers that Newton reads from it, and runs of its model by
MuJoCo Warp."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from plumbob.engines.abilities import Fields
from plumbob.engines.adapters.mjwarp import WarpPort
from plumbob.engines.adapters.ported import load_file, mujoco_ports
from plumbob.engines.peer_model import Layout, MechanismDiffers, PeerModel, RefusedFile
from plumbob.models.border import border

FAR = 1e9  # number above any difference of the gains and gears of two actuators


def _read(path: Path) -> tuple[Any, Any]:
    """Two MuJoCo models of a file: MuJoCo's model, and the model that Newton makes of the file for
    MuJoCo Warp. The second has the order of actuators and the reference coordinates of the first.
    Raises NotRead."""
    import mujoco
    import newton

    solver = newton.solvers.SolverMuJoCo
    with border(RefusedFile):
        builder = newton.ModelBuilder(up_axis=newton.Axis.Z)
        solver.register_custom_attributes(builder)
        builder.add_mjcf(str(path))
        read = solver(builder.finalize(), use_mujoco_cpu=True).mj_model
    file = mujoco.MjModel.from_xml_path(str(path))
    for count in ("nbody", "nq", "nv", "nu"):
        in_file = getattr(file, count)
        in_newton = getattr(read, count)
        if in_file != in_newton:
            raise MechanismDiffers(f"it has {count} = {in_newton}, the file {in_file}")
    order = _order_of_actuators(file, read)
    for name in dir(read):
        if name.startswith("actuator_") and not name.endswith("adr"):
            values = getattr(read, name)
            values[:] = values[order]
    for joint in np.flatnonzero(file.jnt_type >= int(mujoco.mjtJoint.mjJNT_SLIDE)):
        place = file.jnt_qposadr[joint]
        # Newton drops the joint's reference coordinate: the two coordinates [rad] or [m] of the
        # start differ by it.
        shift = file.qpos0[place] - read.qpos0[place]
        read.qpos0[place] += shift
        read.qpos_spring[place] += shift
        read.jnt_range[joint] += shift
    return file, read


def _order_of_actuators(file: Any, read: Any) -> Any:
    """The number that each actuator of the file has in Newton's model, shape (n,): Newton puts
    servos first. Actuators are matched by their joints, then by the nearest gears and gains."""
    from scipy.optimize import linear_sum_assignment

    def numbers(model: Any) -> Any:
        """Numbers that tell the actuators of a model apart, a row for each actuator."""
        joints = FAR * model.actuator_trnid[:, :1]
        gains = model.actuator_gainprm, model.actuator_biasprm
        return np.hstack([joints, model.actuator_gear, *gains])

    distances = np.abs(numbers(file)[:, None] - numbers(read)).sum(axis=-1)
    _, order = linear_sum_assignment(distances)
    return order


def model_fields(path: Path) -> Fields:
    """The numbers that Newton reads from a model file, with the names of the file; raises
    NotRead."""
    file, read = _read(path)
    for field, name, numbers in mujoco_ports().fields(read, file):
        yield field, name, np.add(numbers, 0.0)  # the sum turns -0.0 to 0.0


def user_model(path: Path, layout: Layout, step: float) -> PeerModel:
    """The model that Newton makes of a file, stepped by MuJoCo Warp at `step` [s]; raises
    NotRead."""
    _, read = _read(path)
    return load_file(WarpPort, path, layout, step, read)
