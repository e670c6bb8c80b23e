"""Drives the capsule's slider in MuJoCo, and reads coordinates and forces of a run."""

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
"""Fields that a contact sensor reads, 10 numbers: whether there is a contact, force, normal,
tangent."""


def scale_tolerance(spec: mujoco.MjSpec, setup: CapsuleSetup, slider_armature: float) -> None:
    """Scales the solver's tolerance with the slider's armature [kg]. The solver's criterion is
    relative to the trace of the mass matrix, which contains the armature: without scaling, a
    tolerance of 1e-8 would act as 1e2."""
    if driven_joints(setup):
        scale = (setup.capsule.body_mass + setup.capsule.slider_mass) / slider_armature
        spec.option.tolerance *= scale
        spec.option.noslip_tolerance *= scale


def control(setup: CapsuleSetup, step: float) -> Callable[[Array], Array] | None:
    """A function from the times at which steps of `step` [s] begin, shape (n,), to the slider's
    acceleration, averaged over each step [m/s^2]: shape (n, 1), or (n, 2) in the axes of the body
    if the slider leaves its line. None if the slider does not move.

    With the mean, the slider has the right velocity at the end of every step, even if the
    acceleration switches within a step. The acceleration at mid-step would move the switch to the
    nearest end of a step, an error of first order.
    """
    if not setup.tracks:
        return None

    def mean_acceleration(times: Array) -> Array:
        """The mean accelerations over the steps that begin at these times."""
        # The end of a step and the beginning of the next step are the same time, to the bit: both
        # are the number of the step times the step.
        steps = np.rint(times / step)
        edges = np.concatenate([steps, steps + 1.0]) * step
        velocities, next_velocities = np.split(setup.slider_velocity(edges), 2)
        return np.asarray((next_velocities - velocities) / step)

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
    """qpos, shape (nq,), and qvel, shape (nv,), at the start of a run: the body at `rest_qpos`,
    shape (nq,), rotated by the heading, with the initial velocities."""
    qpos = np.array(rest_qpos)
    turn = np.array([0.0, 0.0, setup.heading_rate])
    qpos[3:7] = turned(rest_qpos[3:7], setup.heading)
    # The rate is about the vertical, and qvel has it in the axes of a body that leans.
    mujoco.mju_rotVecQuat(turn, turn.copy(), qpos[3:7] * [1.0, -1.0, -1.0, -1.0])
    return qpos, np.array([*start_velocity(setup), 0.0, *turn, *np.zeros(len(qpos) - 7)])


def turned(attitude: Array, angle: float) -> Array:
    """The quaternion `attitude`, shape (4,), rotated by `angle` [rad] about the vertical."""
    turn = np.array([math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle)])
    product = np.empty(4)
    mujoco.mju_mulQuat(product, turn, attitude)
    return product


def add_sensors(spec: mujoco.MjSpec) -> None:
    """Adds the sensors for `reading`: the contact of each support, the slider's acceleration less
    gravity, and the common centre of mass."""
    for number in (1, 2, 3):
        spec.add_sensor(
            type=SENSOR.mjSENS_CONTACT,
            objtype=mujoco.mjtObj.mjOBJ_GEOM,
            objname="floor",
            reftype=mujoco.mjtObj.mjOBJ_GEOM,
            refname=f"support_{number}",
            intprm=[CONTACT, 0, 1],
        )
    spec.add_sensor(type=SENSOR.mjSENS_FRAMELINACC, objtype=BODY, objname="slider")
    spec.add_sensor(type=SENSOR.mjSENS_SUBTREECOM, objtype=BODY, objname="body")


def reading(setup: CapsuleSetup) -> Callable[[Array], Observed]:
    """A function from sensor data at the samples, shape (n, 36), to observables and channels, with
    the forces [N] of the step that begins at each sample.

    Observables: the normal forces N_i; for motion along a line also friction, and the force of the
    actuator on the slider, as a force sensor between the two reads it, without the armature's
    inertia. Channels: the number of contacts; for motion along a line also the common centre of
    mass [m]."""
    angle = setup.heading + setup.direction
    line = np.array([math.cos(angle), math.sin(angle), 0.0])

    def read(data: Array) -> Observed:
        """The observables and channels from sensor data."""
        feet = data[:, :30].reshape(-1, 3, 10)  # sample, support, the numbers of CONTACT
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
