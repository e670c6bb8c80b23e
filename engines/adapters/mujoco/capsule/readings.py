"""How MuJoCo drives the capsule's slider, and what is read off a run: coordinates and forces."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import by_support
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup
from plumbob.engines.adapters.mujoco.translation import Observed
from plumbob.models.tripod_capsule.model import driven_joints
from plumbob.models.tripod_capsule.observed import start_velocity

BODY = mujoco.mjtObj.mjOBJ_BODY
SENSOR = mujoco.mjtSensor
DATA = mujoco.mjtConDataField
CONTACT = sum(
    1 << int(part)
    for part in (
        DATA.mjCONDATA_FOUND,
        DATA.mjCONDATA_FORCE,
        DATA.mjCONDATA_NORMAL,
        DATA.mjCONDATA_TANGENT,
    )
)
"""The fields read of a contact: whether it is there, then force, normal and tangent, 10 numbers."""


def scale_tolerance(spec: mujoco.MjSpec, setup: CapsuleSetup, hold: float) -> None:
    """Scale the solver's tolerance with the slider's armature, `hold` [kg]. The criterion is
    relative to the trace of the mass matrix, which the armature inflates: a nominal 1e-8 would act
    as 1e2."""
    if driven_joints(setup):
        scale = (setup.capsule.body_mass + setup.capsule.slider_mass) / hold
        spec.option.tolerance *= scale
        spec.option.noslip_tolerance *= scale


def control(setup: CapsuleSetup, step: float) -> Callable[[Array], Array] | None:
    """Times at which steps of `step` [s] begin, shape (n,) -> ctrl [m/s^2], shape (n, 1), or (n, 2)
    in the axes of the body where the slider leaves its line.

    Held over the step, the mean brings the slider's velocity to where it should be at every grid
    time, whether or not the acceleration switches inside a step; its value at mid-step does the
    manoeuvre of the nearest switch on the grid, an error of first order.
    """
    if not setup.tracks:
        return None

    def mean_acceleration(times: Array) -> Array:
        # Edges are a step's number times the step: one step's end and the next one's beginning
        # are the same time, to the bit.
        steps = np.rint(times / step)
        edges = np.concatenate([steps, steps + 1.0]) * step
        begun, ended = np.split(setup.slider_velocity(edges), 2)
        return np.asarray((ended - begun) / step)

    return mean_acceleration


def acceleration(problem: CapsuleProblem) -> Callable[[Array], Array] | None:
    """Returns a function of times [s], shape (n,): the slider's acceleration along its tracks
    [m/s^2], shape (n, tracks); None if the slider has no tracks."""
    if not problem.setup.tracks:
        return None
    tracks = np.array(problem.setup.tracks).T
    path = problem.motion.path
    return lambda times: np.asarray(path.kinematics(times)[2] @ tracks)


def start(setup: CapsuleSetup, rest_qpos: Array) -> tuple[Array, Array]:
    """qpos, shape (nq,), and qvel, shape (nv,), of a body at `rest_qpos`, shape (nq,), turned by
    the heading, with the velocities of the start."""
    qpos = np.array(rest_qpos)
    turn = np.array([0.0, 0.0, setup.heading_rate])
    qpos[3:7] = turned(rest_qpos[3:7], setup.heading)
    # about the vertical, in the axes of a body that leans
    mujoco.mju_rotVecQuat(turn, turn.copy(), qpos[3:7] * [1.0, -1.0, -1.0, -1.0])
    return qpos, np.array([*start_velocity(setup), 0.0, *turn, *np.zeros(len(qpos) - 7)])


def turned(attitude: Array, angle: float) -> Array:
    """The quaternion `attitude`, shape (4,), turned by `angle` [rad] about the vertical."""
    turn = np.array([math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle)])
    both = np.empty(4)
    mujoco.mju_mulQuat(both, turn, attitude)
    return both


def add_sensors(spec: mujoco.MjSpec) -> None:
    """Add the sensors that `reading` reads: each support's contact, the slider's acceleration less
    gravity, and the common centre of mass."""
    for i in range(3):
        spec.add_sensor(
            type=SENSOR.mjSENS_CONTACT,
            objtype=mujoco.mjtObj.mjOBJ_GEOM,
            objname="floor",
            reftype=mujoco.mjtObj.mjOBJ_GEOM,
            refname=f"support_{i + 1}",
            intprm=[CONTACT, 0, 1],
        )
    spec.add_sensor(type=SENSOR.mjSENS_FRAMELINACC, objtype=BODY, objname="slider")
    spec.add_sensor(type=SENSOR.mjSENS_SUBTREECOM, objtype=BODY, objname="body")


def reading(setup: CapsuleSetup) -> Callable[[Array], Observed]:
    """Sensor data at the samples, shape (n, 36) -> the normal forces N_i and, along a line,
    friction and the force of the actuator on the slider (what a force sensor between them reads,
    without the armature's inertia) [N], over the step that begins. As channels the number of
    contacts, and along a line the common centre of mass [m]."""
    angle = setup.heading + setup.direction
    line = np.array([math.cos(angle), math.sin(angle), 0.0])

    def read(data: Array) -> Observed:
        feet = data[:, :30].reshape(-1, 3, 10)  # as in CONTACT
        loads = by_support(feet[..., 1])
        counts = feet[..., 0].sum(axis=1)
        if setup.in_plane:
            return loads, {"contacts": counts}
        ahead = feet[..., 7:]
        friction = feet[..., 2, None] * ahead
        friction += feet[..., 3, None] * np.cross(feet[..., 4:7], ahead)
        forces = {
            "friction_force": friction.sum(axis=1) @ line,
            "driving_force": setup.capsule.slider_mass * (data[:, 30:33] @ line),
        }
        return {**loads, **forces}, {
            "contacts": counts,
            "centre_of_mass": data[:, 33:36] @ line,
        }

    return read
