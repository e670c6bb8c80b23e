"""How MuJoCo drives the capsule's slider, and what is read off a run: coordinates and forces."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.mujoco.contacts import armature
from plumbob.engines.adapters.mujoco.translation import Named, Probe, Recorder

Observe = Callable[[Array, Array], tuple[Named, Named]]
BODY = int(mujoco.mjtObj.mjOBJ_BODY)
PYRAMIDAL = mujoco.mjtCone.mjCONE_PYRAMIDAL
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

    def along(model: mujoco.MjModel, data: mujoco.MjData) -> Recorder:
        body, slider = model.body("body").id, model.body("slider").id
        pressed, driven = _Pressed(model, data), model.njnt > 1
        shown = data.qacc, data.cfrc_int[slider, 3:], data.subtree_com[body]
        taken: tuple[list[Array], ...] = ([], [], [])  # acceleration, force on the slider, centre

        def take() -> None:
            pressed.take()
            mujoco.mj_rnePostConstraint(model, data)
            for kept, values in zip(taken, shown, strict=True):
                kept.append(values.copy())

        def read() -> tuple[Named, Named]:
            acceleration, pushing, place = map(np.array, taken)
            normal, force = pressed.read()
            friction, driving, centre = (v @ line for v in (force, pushing, place))
            pushed = both * (acceleration[:, :3] @ line - setup.pull)
            pushed = pushed + capsule.slider_mass * acceleration[:, -1] if driven else pushed
            forces = {"friction_force": friction, "driving_force": driving}
            return {**_loads(normal), **forces}, {
                "contacts": pressed.counts(),
                "centre_of_mass": centre,
                "momentum_residual": pushed - friction,
            }

        return Recorder(take, read)

    def in_plane(model: mujoco.MjModel, data: mujoco.MjData) -> Recorder:
        body, slider = model.body("body").id, model.body("slider").id
        pressed, found, centre = _Pressed(model, data), np.zeros((2, 6)), data.subtree_com[body]
        whole, part = found
        taken: tuple[list[Array], ...] = ([], [])  # accelerations of body and slider, centre

        def take() -> None:
            pressed.take()
            mujoco.mj_rnePostConstraint(model, data)
            mujoco.mj_objectAcceleration(model, data, BODY, body, whole, 0)
            mujoco.mj_objectAcceleration(model, data, BODY, slider, part, 0)
            taken[0].append(found.copy())
            taken[1].append(centre.copy())

        def read() -> tuple[Named, Named]:
            moved, places = map(np.array, taken)
            normal, force = pressed.read()
            pushed = capsule.body_mass * moved[:, 0, 3:] + capsule.slider_mass * moved[:, 1, 3:]
            return _loads(normal), {
                "contacts": pressed.counts(),
                "least_normal_force": normal.min(axis=1),
                "centre_of_mass_x": places[:, 0],
                "centre_of_mass_y": places[:, 1],
                "momentum_residual": np.hypot(*(pushed - force)[:, :2].T),
            }

        return Recorder(take, read)

    return in_plane if setup.in_plane else along


def _loads(normal: Array) -> Named:
    return {f"normal_force_{i + 1}": normal[:, i] for i in range(3)}


class _Pressed:
    """The forces of the contacts in the states that are taken: kept as the solver has them, and
    worked out for all states at once. All contacts have the settings of the model's pairs, which
    are those of the first."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self.model, self.data = model, data
        self.first = model.geom("support_1").id
        self.pairs: list[Array] = [np.empty((0, 2), int)]  # of geoms, a row a contact
        self.frames: list[Array] = [np.empty((0, 9))]
        self.begins: list[Array] = [np.empty(0, int)]  # where each contact's part begins of
        self.solved: list[Array] = [np.empty(0)]  # what the solver finds

    def take(self) -> None:
        """Keep the contacts of the data as they are now."""
        contact = self.data.contact
        self.pairs.append(contact.geom.copy())
        self.frames.append(contact.frame.copy())
        self.begins.append(contact.efc_address.copy())
        self.solved.append(self.data.efc_force.copy())

    def counts(self) -> Array:
        """Number of contacts in each of the states, shape (n,)."""
        return np.array([float(len(begins)) for begins in self.begins[1:]])

    def read(self) -> tuple[Array, Array]:
        """Normal forces N_i [N] in each state, and the sum of friction in the world [N], both of
        shape (n, 3)."""
        counts = self.counts().astype(int)
        state = np.repeat(np.arange(len(counts)), counts)
        support = np.concatenate(self.pairs).max(axis=1, initial=0) - self.first
        across = np.concatenate(self.frames).reshape(-1, 3, 3)[:, 1:]
        force = self._forces(counts)
        normal, friction = np.zeros((len(counts), 3)), np.zeros((len(counts), 3))
        np.add.at(normal, (state, support), force[:, 0])
        np.add.at(friction, state, force[:, 1, None] * across[:, 0])
        np.add.at(friction, state, force[:, 2, None] * across[:, 1])
        return normal, friction

    def _forces(self, counts: npt.NDArray[np.int64]) -> Array:
        """Force of each contact in its frame [N], normal first, shape (contacts, 3), as
        `mj_contactForce` has it: of a pyramid from its edges; none of a contact left out."""
        sizes = [len(solved) for solved in self.solved[:-1]]
        begins = np.concatenate(self.begins)
        inside = begins >= 0
        places = (begins + np.repeat(np.cumsum(sizes), counts))[inside]
        width, force = int(self.model.pair_dim[0]), np.zeros((len(begins), 3))
        pyramid = self.model.opt.cone == PYRAMIDAL and width > 1
        if pyramid:
            width = 2 * (width - 1)
        parts = np.concatenate(self.solved)[places[:, None] + np.arange(width)].T
        if pyramid:
            mu, nu = self.model.pair_friction[0, :2]
            parts = [sum(parts[1:], parts[0]), (parts[0] - parts[1]) * mu,
                     (parts[2] - parts[3]) * nu]  # fmt: skip
        for i, values in enumerate(parts[:3]):
            force[inside, i] = values
        return force
