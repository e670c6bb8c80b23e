"""How MuJoCo drives the capsule's slider, and what is read off a run: coordinates and forces."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.mujoco.contacts import armature
from plumbob.engines.adapters.mujoco.translation import Named, Probe, Values

Observe = Callable[[Array, Array], tuple[Named, Named]]
FREE = 7  # least number of coordinates of the full model: place and quaternion; a planar has 5


def set_slider(spec: mujoco.MjSpec, setup: CapsuleSetup, axis: tuple[float, float]) -> None:
    """Give the slider its mass, and its joint along `axis`, or its two joints of the plane, the
    armature that imposes its motion; a slider without imposed motion is fixed in the body.

    The solver's tolerance is scaled with the armature: its criterion is relative to the trace of
    the mass matrix, which the armature inflates, so that a nominal 1e-8 would act as 1e2.
    """
    capsule, in_plane = setup.capsule, setup.plane_velocity is not None
    spec.body("slider").mass = capsule.slider_mass
    names = ("slider_x", "slider_y") if in_plane else ("slider",)
    if setup.relative_velocity is None and not in_plane:
        spec.delete(spec.actuator("slider"))
        spec.delete(spec.joint("slider"))
        return
    hold = armature(setup)
    if not in_plane:
        spec.joint("slider").axis = [*axis, 0.0]
    for name in names:
        spec.joint(name).armature = spec.actuator(name).gear[0] = hold
    scale = (capsule.body_mass + capsule.slider_mass) / hold
    spec.option.tolerance *= scale
    spec.option.noslip_tolerance *= scale


def control(setup: CapsuleSetup, step: float) -> Callable[[Array], Array] | None:
    """Times at which steps of `step` [s] begin, shape (n,) -> ctrl [m/s^2], shape (n, 1), or (n, 2)
    in the axes of the body where the slider leaves its line.

    Held over the step, the mean brings the slider's velocity to where it should be at every grid
    time, whether or not the acceleration switches inside a step; its value at mid-step does the
    manoeuvre of the nearest switch on the grid, an error of first order.
    """
    if (velocity := _velocity(setup)) is None:
        return None

    def mean(times: Array) -> Array:
        # By index: the velocity that one step ends with is the one that the next begins with.
        first = np.rint(times / step)
        begun, ended = np.split(velocity(np.concatenate([first, first + 1.0]) * step), 2)
        return np.asarray((ended - begun) / step)

    return mean


def _velocity(setup: CapsuleSetup) -> Callable[[Array], Array] | None:
    """Imposed velocity [m/s] at times [s], shape (n,), by its components: (n, 1) or (n, 2)."""
    if (line := setup.relative_velocity) is not None:
        return lambda times: line(times)[:, None]
    return setup.plane_velocity


def start(setup: CapsuleSetup, rest: Array) -> tuple[Array, Array]:
    """qpos, shape (nq,), and qvel, shape (nv,), of a body at `rest`, shape (nq,), turned by the
    heading, with the velocities of the start."""
    qpos = np.array(rest)
    if len(rest) >= FREE:
        qpos[3:7] = turned(rest[3:7], setup.heading)
    else:
        qpos[3] = setup.heading
    vx, vy = _rotated(*setup.velocity, setup.heading)
    turn = np.array([0.0, 0.0, setup.heading_rate])
    if len(rest) >= FREE:  # about the vertical, in the axes of a body that leans
        mujoco.mju_rotVecQuat(turn, turn.copy(), qpos[3:7] * [1.0, -1.0, -1.0, -1.0])
    turn = turn if len(rest) >= FREE else turn[2:]
    slider = [0.0] if setup.relative_velocity is not None else []
    slider = slider if setup.plane_velocity is None else [0.0, 0.0]
    return qpos, np.array([vx, vy, 0.0, *turn, *slider])


def along(setup: CapsuleSetup, rest: Array) -> Observe:
    """What is signed along the line: displacement, velocity, slider, heading, sideways."""
    line, driven = -(setup.heading + setup.direction), setup.relative_velocity is not None

    def observe(qpos: Array, qvel: Array) -> tuple[Named, Named]:
        gone, sideways = _rotated(qpos[:, 0], qpos[:, 1], line)
        velocity, _ = _rotated(qvel[:, 0], qvel[:, 1], line)
        still = np.zeros_like(gone)
        slid, rate = (qpos[:, -1], qvel[:, -1]) if driven else (still, still)
        return {
            "displacement": gone,
            "velocity": velocity,
            "stroke": slid,
            "stroke_rate": rate,
            "heading": _turn(qpos, setup.heading),
            "sideways": sideways,
        }, {"vertical_displacement": qpos[:, 2] - rest[2]}

    return observe


def plane(setup: CapsuleSetup, rest: Array) -> Observe:
    """Place of C and heading, which is also the source's body angle, in the axes of the start."""

    def observe(qpos: Array, qvel: Array) -> tuple[Named, Named]:
        x, y = _rotated(qpos[:, 0], qpos[:, 1], -setup.heading)
        vx, vy = _rotated(qvel[:, 0], qvel[:, 1], -setup.heading)
        rate = qvel[:, 5] if qpos.shape[1] >= FREE else qvel[:, 3]
        turn = _turn(qpos, setup.heading)
        seen = {"x": x, "y": y, "velocity_x": vx, "velocity_y": vy}
        seen |= {"heading": turn, "heading_rate": rate, "body_angle": turn}
        return seen, {"vertical_displacement": qpos[:, 2] - rest[2]}

    return observe


def _turn(qpos: Array, since: float) -> Array:
    """Angle turned since the heading was `since` [rad], at the first of the samples."""
    if qpos.shape[1] < FREE:
        return np.asarray(qpos[:, 3] - since)
    angles = np.unwrap(heading(qpos[:, 3:7])) - since
    return np.asarray(angles - 2 * np.pi * np.round(angles[0] / (2 * np.pi)))


def _rotated(x: Array | float, y: Array | float, angle: float) -> tuple[Array, Array]:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.asarray(cos * x - sin * y), np.asarray(sin * x + cos * y)


def heading(attitude: Array) -> Array:
    """Angle about the vertical [rad] of quaternions, shape (..., 4): shape (...)."""
    w, x, y, z = np.moveaxis(np.asarray(attitude, dtype=np.float64), -1, 0)
    return np.asarray(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def turned(attitude: Array, angle: float) -> Array:
    """The quaternion `attitude`, shape (4,), turned by `angle` [rad] about the vertical."""
    cos, sin = math.cos(0.5 * angle), math.sin(0.5 * angle)
    w, x, y, z = attitude
    return np.array([cos * w - sin * z, cos * x - sin * y, cos * y + sin * x, cos * z + sin * w])


def reading(setup: CapsuleSetup) -> Probe:
    """The normal forces N_i and, along a line, friction and the force of the actuator on the slider
    (what a force sensor between them reads, without the armature's inertia) [N], over the step
    that begins. As channels the number of contacts, the common centre of mass [m], and what is left
    of the balance of momentum [N]: the actuator is inside, so the plane and gravity alone may
    change it."""
    capsule, angle = setup.capsule, setup.heading + setup.direction
    line = np.array([math.cos(angle), math.sin(angle), 0.0])
    both = capsule.body_mass + capsule.slider_mass

    def probe(model: mujoco.MjModel, data: mujoco.MjData) -> Callable[[], tuple[Values, Values]]:
        body, slider = model.body("body").id, model.body("slider").id
        driven = model.njnt > 1

        def along() -> tuple[Values, Values]:
            normal, force = _pressed(model, data)
            friction = float(force @ line)
            pushed = both * (data.qacc[:3] @ line - setup.pull)
            pushed += capsule.slider_mass * data.qacc[-1] if driven else 0.0
            mujoco.mj_rnePostConstraint(model, data)
            driving = float(data.cfrc_int[slider, 3:] @ line)
            forces = {"friction_force": friction, "driving_force": driving}
            return {**_loads(normal), **forces}, {
                "contacts": float(data.ncon),
                "centre_of_mass": float(data.subtree_com[body] @ line),
                "momentum_residual": float(pushed) - friction,
            }

        def in_plane() -> tuple[Values, Values]:
            normal, force = _pressed(model, data)
            mujoco.mj_rnePostConstraint(model, data)
            pushed = capsule.body_mass * _acceleration(model, data, body)
            pushed = pushed + capsule.slider_mass * _acceleration(model, data, slider)
            x, y, _ = data.subtree_com[body]
            return _loads(normal), {
                "contacts": float(data.ncon),
                "least_normal_force": float(normal.min()),
                "centre_of_mass_x": float(x),
                "centre_of_mass_y": float(y),
                "momentum_residual": float(np.hypot(*(pushed - force)[:2])),
            }

        return in_plane if setup.in_plane else along

    return probe


def _loads(normal: Array) -> Values:
    return {f"normal_force_{i + 1}": float(normal[i]) for i in range(3)}


def _pressed(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[Array, Array]:
    """Normal forces N_i [N], shape (3,), and the sum of friction in the world [N], shape (3,)."""
    first, force = model.geom("support_1").id, np.zeros(6)
    normal, friction = np.zeros(3), np.zeros(3)
    pairs, across = data.contact.geom, data.contact.frame.reshape(-1, 3, 3)[:, 1:]
    for i in range(data.ncon):
        mujoco.mj_contactForce(model, data, i, force)
        normal[pairs[i].max() - first] += force[0]
        friction += force[1:3] @ across[i]
    return normal, friction


def _acceleration(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> Array:
    """Acceleration of a body's centre of mass in the world [m/s^2], shape (3,)."""
    found = np.zeros(6)
    mujoco.mj_objectAcceleration(model, data, mujoco.mjtObj.mjOBJ_BODY, body, found, 0)
    return found[3:]
