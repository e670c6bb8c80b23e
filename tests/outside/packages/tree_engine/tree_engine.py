"""A physics engine of one's own in plumbob: trees of rigid bodies, by numpy and scipy alone.

Save this file as `tree_engine.py` in an empty folder, and beside it a `pyproject.toml`:

    [project]
    name = "tree-engine"
    version = "1.0"
    entry-points."plumbob.engines".tree = "tree_engine:ENGINE"

After `pip install .` there, where plumbob is installed, `plumbob validate --methods tree` runs the
scenes named at the end; with the file as it is every verdict is "predicted". For an engine of your
own change "tree" in the entry point and in the names of engine and method. plumbob makes a
Mechanism of a scene, records in SI units that the source of `plumbob.engines.mechanism` explains,
and wants a stepper: an attribute `step` [s] and the methods `put`, `state` and `advance`. Positions
and rates are, joint after joint: of a hinge or slide one each; of a ball a quaternion (w, x, y, z)
and its angular velocity in body axes; of a free body its place first, and its velocity."""

import numpy as np
from scipy.spatial.transform import Rotation

from plumbob.analytic.schemes import EULER, Scheme
from plumbob.engines.adapters.stepped_mechanism import simulated
from plumbob.engines.method import Engine, Method, Unsupported
from plumbob.engines.stepper import State

# Numbers of positions and rates; a hinge or a slide has one each. A free body moves, then turns.
PARTS = {"ball": {"ball": (4, 3)}, "free": {"move": (3, 3), "ball": (4, 3)}}
ANY = (-np.inf, np.inf)


def cross(a):
    """The matrix that takes b to a x b."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def turn(q):
    """The rotation of a quaternion (w, x, y, z), or of a rotation vector [rad]."""
    return Rotation.from_quat(q, scalar_first=True) if len(q) == 4 else Rotation.from_rotvec(q)


class Tree:
    """A mechanism that takes steps of semi-implicit Euler, each of `step` seconds."""

    def __init__(self, mechanism, step):
        odd = [x for x in mechanism.joints if x.limits or x.force_range or any(x.friction_loss)]
        odd += (*mechanism.touching, *mechanism.loops, *mechanism.not_expressed)
        for part in odd:  # this engine has no more than joints, springs, dampers and actuators
            raise Unsupported(f"{type(part).__name__} {getattr(part, 'name', 'of shapes')}")
        self.mechanism, self.step, self.joints = mechanism, step, []
        begin = np.zeros(2, dtype=int)
        for joint in mechanism.joints:  # with slices of the positions and the rates
            for kind, counts in PARTS.get(joint.kind, {joint.kind: (1, 1)}).items():
                self.joints.append((joint, kind, *map(slice, begin, begin + counts)))
                begin = begin + counts

    def put(self, state, time=0.0):
        self.qpos, self.qvel, self.time = state.qpos.copy(), state.qvel.copy(), time

    def state(self):
        return State(self.qpos.copy(), self.qvel.copy())

    def advance(self, controls, steps):
        """Take steps, each under a row of the controls at its start; None where there are none."""
        for row in [None] * steps if controls is None else controls:
            self.qvel = self.qvel + self.step * self.accelerations(self.forces(row))
            for _, kind, places, rates in self.joints:  # positions move at the new rates
                q, moved = self.qpos[places], self.step * self.qvel[rates]
                if kind == "ball":
                    q[:] = (turn(q) * turn(moved)).as_quat(scalar_first=True)
                else:
                    q += moved
            self.time += self.step

    def forces(self, controls):
        """The forces of dampers, springs and actuators, one for each rate."""
        joints = self.mechanism.joints
        force = -np.concatenate([joint.damping for joint in joints]) * self.qvel
        for joint, _, places, rates in self.joints:
            q, v = self.qpos[places], self.qvel[rates]
            force[rates] -= joint.stiffness * (q - joint.rest) if joint.stiffness else 0.0
            for motor in (x for x in self.mechanism.actuators if joints[x.joint] is joint):
                control = 0.0 if controls is None else controls[motor.control]
                push = motor.gain * np.clip(control, *(motor.control_range or ANY))
                push += motor.bias[0] + motor.gear * (motor.bias[1] * q + motor.bias[2] * v)
                force[rates] += motor.gear * np.clip(push, *(motor.force_range or ANY))
        return force

    def accelerations(self, force):
        """How qvel changes, by Kane's equations. by @ qvel is a body's angular velocity and the
        velocity of its point at the world's origin, drift their changes while qvel is constant."""
        qvel = self.qvel
        mass = np.diag(np.concatenate([joint.armature for joint in self.mechanism.joints]))
        frames = [(np.zeros(3), np.eye(3), np.zeros((6, len(qvel))), np.zeros(6))]
        for number, body in enumerate(self.mechanism.bodies[1:], start=1):
            place, axes, by, drift = map(np.copy, frames[body.parent])
            place, axes = place + axes @ body.place, axes @ turn(body.attitude).as_matrix()
            for joint, kind, places, rates in self.joints:
                if joint.body == number:
                    place, axes, own = behind(joint, kind, self.qpos[places], place, axes)
                    spin, flow = map(cross, np.split(by @ qvel, 2))
                    turning, moving = np.split(own @ qvel[rates], 2)
                    drift += np.append(spin @ turning, flow @ turning + spin @ moving)
                    by[:, rates] = own
            frames.append((place, axes, by, drift))
            arm = cross(place + axes @ body.centre)
            about, along = by[:3], by[3:] - arm @ by[:3]  # the turn and the centre
            spin, moments = about @ qvel, axes @ body.inertia @ axes.T
            torque = -moments @ drift[:3] - cross(spin) @ moments @ spin
            pull = (1.0 - body.carried) * self.mechanism.gravity - cross(spin) @ along @ qvel
            pull += arm @ drift[:3] - drift[3:]  # less the centre's acceleration: it is inertia
            force = force + about.T @ torque + body.mass * along.T @ pull
            mass += about.T @ moments @ about + body.mass * along.T @ along
        change, free = np.zeros(len(qvel)), np.ones(len(qvel), dtype=bool)
        ends = self.time + np.array([0.0, self.step])
        for joint, _, _, rates in self.joints:
            if joint.velocity is not None:  # prescribed: by its mean change over the step
                free[rates] = False
                change[rates] = np.diff(joint.velocity(ends)) / self.step
        change[free] = np.linalg.solve(mass[free][:, free], (force - mass @ change)[free])
        return change


def behind(joint, kind, q, place, axes):
    """The place and axes of a frame behind a joint at q, and its motions, one for each rate."""
    if kind == "move":
        return q, np.eye(3), np.eye(6)[:, 3:]
    axis = (axes @ joint.axis)[:, None]
    if kind == "slide":
        return place + axis @ (q - joint.reference), axes, np.vstack([0.0 * axis, axis])
    centre = place + axes @ joint.place
    axes = axes @ turn(q if kind == "ball" else joint.axis * (q - joint.reference)).as_matrix()
    about = axes if kind == "ball" else axis
    return centre - axes @ joint.place, axes, np.vstack([about, cross(centre) @ about])


def prepare(case, method, step):
    return simulated(case, step, lambda mechanism, start: Tree(mechanism, step))


SCENES = """cone-pendulum/equal-wells-short heavy-top/nutating n-pendulum/triple servo/motor-damped
projectile/thrown simple-pendulum/near-top-1e-6 linear-pendulum/overdamped free-body/symmetric"""
ENGINE = Engine(
    name="tree",
    package="numpy",  # the engine is left out if this is not installed
    # Errors are predicted for the scheme of `advance`; a Scheme("own name") has no prediction.
    methods=(Method("tree/euler", Scheme(EULER, "start"), 1, systems=tuple(SCENES.split())),),
    prepare=prepare,
    model_error=lambda case, method, step: {},  # {observable: errors at any step}: none here
    not_read={"tension": "no force of a hinge is read"},  # {observable: why it is not read}
)
