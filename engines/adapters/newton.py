"""Newton as an engine: Featherstone's algorithm in single precision, semi-implicit Euler, on the
processor or the GPU that Warp chooses. It compiles its kernels when they are first called; a step
is recorded as a graph. A prescribed motion is a link that no force moves."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.schemes import EULER, Scheme
from plumbob.engines.abilities import Fields, ModelReader, RunsFiles
from plumbob.engines.adapters.chain import by_step
from plumbob.engines.adapters.hinged_body import HingedBody, hinged_body, model_error
from plumbob.engines.adapters.mjwarp import WarpPort, start_warp
from plumbob.engines.adapters.ported import PORTED, SINGLE, SMOOTH
from plumbob.engines.adapters.stepping import Built, stepped
from plumbob.engines.method import Engine, Method, Simulation
from plumbob.engines.peer_model import Layout, NotRead, PeerModel, RefusedFile
from plumbob.models.border import border
from plumbob.models.scene import Case, later
from plumbob.models.tripod_capsule.observed import Pose

FIELDS = "plumbob.engines.adapters.mujoco.model_fields.fields_in"  # which imports MuJoCo
FAR = 1e9  # more than the gains and gears of two actuators differ by
STEP = Scheme(EULER, "start", unit=SINGLE)
# Next to a barrier, and of stiff modes, the rounding of single precision has no theory here.
MEANT = (
    *(
        "simple-pendulum/damped-*",
        "simple-pendulum/forced-large",
        "linear-pendulum/forced-large",
    ),
    *("linear-pendulum/overdamped", "servo/joint-damped", "servo/motor-damped"),
)
METHODS = (Method("newton/featherstone", STEP, 1, systems=(*SMOOTH, *MEANT)),)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Build `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    return stepped(case, step, partial(_built, hinged_body(case), step))


def _model(body: HingedBody) -> Any:
    """The links, each on its hinge."""
    import newton
    import warp

    builder = newton.ModelBuilder(up_axis=newton.Axis.Z, gravity=body.pull)
    hinges, parent = [], -1
    for link in body.links:
        child = builder.add_link(
            com=link.centre,
            inertia=warp.mat33(link.moments),
            mass=link.mass,
            lock_inertia=True,
            is_kinematic=bool(link.hold),
        )
        hinge = builder.add_joint_revolute(
            parent,
            child,
            parent_xform=warp.transform(link.place, warp.quat_identity()),
            axis=link.axis,
            damping=link.damping,
            stiffness=link.stiffness,
            armature=0.0,
        )
        hinges.append(hinge)
        parent = child
    builder.add_articulation(hinges)
    # its check of inertias gives a point more than it has
    return builder.finalize(skip_validation_inertia=True)


def _built(body: HingedBody, step: float) -> Built:
    start_warp()
    import newton
    import warp

    model = _model(body)
    now, then = model.state(), model.state()
    now.joint_q.assign([link.position for link in body.links])
    now.joint_qd.assign([link.rate for link in body.links])
    newton.eval_fk(model, now.joint_q, now.joint_qd, now)
    solver = newton.solvers.SolverFeatherstone(model, angular_damping=0.0)
    control = model.control()
    with warp.ScopedCapture() as capture:
        solver.step(now, then, control, None, step)
        now.assign(then)

    torques = by_step(body.controls, step)

    def advance(first: int, last: int) -> None:
        for _ in range(first, last):
            if body.forcing:
                control.joint_f.assign([*(0.0 for _ in body.links[1:]), *next(torques)])
            warp.capture_launch(capture.graph)
        warp.synchronize()

    def pose() -> Pose:
        angle, rate = (values.numpy()[-1] for values in (now.joint_q, now.joint_qd))
        return Pose(0j, 0j, 0.0, 0.0, float(angle), float(rate))

    return body.built(advance, pose)


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
    for field, name, numbers in later(FIELDS)(read, file):
        yield field, name, np.add(numbers, 0.0)  # no -0.0


def user_model(path: Path, layout: Layout, step: float) -> PeerModel:
    """The model of a file, as Newton has MuJoCo Warp step it; raises NotRead."""
    _, read = _read(path)
    model: PeerModel = later(PORTED)(WarpPort, path, layout, step, read)
    return model


ENGINE = Engine(
    "newton",
    "newton",
    METHODS,
    prepare,
    model_error,
    optional=True,
    abilities=(ModelReader(model_fields), RunsFiles(user_model, 2.0**-24)),
)
