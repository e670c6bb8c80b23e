"""The terms of a mechanism's equations of motion, from its records alone.

Twists and wrenches are taken about the world's origin, along its axes, angular part first
(Featherstone 2008, Rigid Body Dynamics Algorithms, 2 and 5.3). Nothing of MuJoCo is used. Numbers
have extended precision where numpy has it: bodies far from the origin cost digits.
"""

import numpy as np

SIZES = {
    "hinge": (1, 1),
    "slide": (1, 1),
    "ball": (4, 3),
    "free": (7, 6),
}  # coordinates, degrees
ANY = (-np.inf, np.inf)


def matrix(attitude):
    """The rotation matrix of a quaternion, scalar first, of any length but 0."""
    w, x, y, z = np.asarray(attitude) / np.linalg.norm(attitude)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def about(axis, angle):
    """The rotation by an angle about an axis of unit length (Rodrigues)."""
    across = cross_matrix(axis)
    return np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * across @ across


def cross_matrix(v):
    """The matrix that takes the cross product of `v` with a vector."""
    x, y, z = v
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def line(axis, through):
    """The twist of a turn about an axis through a point."""
    return np.concatenate([axis, np.cross(through, axis)])


def shift(axis):
    """The twist of a translation."""
    return np.concatenate([np.zeros(3), axis])


def crossed(twist, other):
    """The rate of a twist that moves with a body of another twist: its Lie bracket."""
    w, v = twist[:3], twist[3:]
    return np.concatenate(
        [np.cross(w, other[:3]), np.cross(v, other[:3]) + np.cross(w, other[3:])]
    )


def crossed_wrench(twist, wrench):
    """The rate of a momentum that moves with a body of that twist."""
    w, v = twist[:3], twist[3:]
    torque, force = wrench[:3], wrench[3:]
    return np.concatenate([np.cross(w, torque) + np.cross(v, force), np.cross(w, force)])


class Moved:
    """Bodies of a mechanism in a state: poses, twists of degrees of freedom, and velocities."""

    def __init__(self, mechanism, qpos, qvel):
        self.turns, self.places = [np.eye(3)], [np.zeros(3)]
        self.twists = []  # of each degree of freedom
        self.rates = []  # of each of these twists
        self.carriers = [()]  # degrees of freedom that move each body
        self.velocities = [np.zeros(6)]
        joints = addresses(mechanism)
        for number, body in enumerate(mechanism.bodies[1:], start=1):
            turn = self.turns[body.parent] @ matrix(body.attitude)
            place = self.places[body.parent] + self.turns[body.parent] @ body.place
            carriers = self.carriers[body.parent]
            velocity = self.velocities[body.parent]
            for joint, q, v in joints:
                if joint.body != number:
                    continue
                twists, turn, place = moved(joint, qpos[q], turn, place)
                rates = [crossed(velocity, twist) for twist in twists]
                velocity = velocity + np.sum(np.array(twists).T * qvel[v], axis=1)
                if joint.kind in ("ball", "free"):  # rotations are about axes of the moved body
                    rates[-3:] = [crossed(velocity, twist) for twist in twists[-3:]]
                if joint.kind == "free":  # translations are along axes of the world
                    rates[:3] = [np.zeros(6)] * 3
                carriers = (*carriers, *range(v.start, v.stop))
                self.twists += twists
                self.rates += rates
            self.turns.append(turn)
            self.places.append(place)
            self.carriers.append(carriers)
            self.velocities.append(velocity)


def moved(joint, q, turn, place):
    """The twists of a joint's degrees of freedom, and the pose of its body after it."""
    if joint.kind == "free":
        turn, place = matrix(q[3:]), q[:3]
        return [*map(shift, np.eye(3)), *(line(axis, place) for axis in turn.T)], turn, place
    through = place + turn @ joint.place
    if joint.kind == "slide":
        axis = turn @ joint.axis
        return [shift(axis)], turn, place + axis * (q[0] - joint.reference[0])
    if joint.kind == "hinge":
        twists = [line(turn @ joint.axis, through)]
        turn = turn @ about(joint.axis, q[0] - joint.reference[0])
    else:
        turn = turn @ matrix(q)
        twists = [line(axis, through) for axis in turn.T]
    return twists, turn, through - turn @ joint.place


def addresses(mechanism):
    """Each joint with its slices of qpos and qvel."""
    rows, q, v = [], 0, 0
    for joint in mechanism.joints:
        coordinates, degrees = SIZES[joint.kind]
        rows.append((joint, slice(q, q + coordinates), slice(v, v + degrees)))
        q, v = q + coordinates, v + degrees
    return rows


def terms(mechanism, qpos, qvel, ctrl):
    """The mass matrix, shape (nv, nv), and the bias, passive and actuator forces, shape (nv,), as
    in M q'' + bias = passive + actuator + constraint."""
    qpos, qvel = qpos.astype(np.longdouble), qvel.astype(np.longdouble)
    state = Moved(mechanism, qpos, qvel)
    count = len(qvel)
    mass = np.zeros((count, count), np.longdouble)
    bias, passive, actuated = np.zeros((3, count), np.longdouble)
    for number, body in enumerate(mechanism.bodies):
        carriers = list(state.carriers[number])
        if not carriers:
            continue
        twists = np.array([state.twists[i] for i in carriers])
        inertia, weight = spatial_inertia(body, state.turns[number], state.places[number])
        force = np.concatenate(
            [np.cross(weight, mechanism.gravity), body.mass * mechanism.gravity]
        )
        velocity = state.velocities[number]
        acceleration = sum(state.rates[i] * qvel[i] for i in carriers)
        wrench = inertia @ acceleration + crossed_wrench(velocity, inertia @ velocity) - force
        mass[np.ix_(carriers, carriers)] += twists @ inertia @ twists.T
        bias[carriers] += twists @ wrench
        passive[carriers] -= body.carried * (twists @ force)
    for joint, q, v in addresses(mechanism):
        mass[v, v] += np.diag(joint.armature)
        passive[v] -= joint.damping * qvel[v] + joint.stiffness * stretched(joint, qpos[q])
        force = joint_force(mechanism, joint, qpos[q], qvel[v], ctrl)
        if joint.kind in ("hinge", "slide"):
            actuated[v] = np.clip(force, *(joint.force_range or ANY))
    return {"mass matrix": mass, "bias": bias, "passive": passive, "actuator": actuated}


def spatial_inertia(body, turn, place):
    """The inertia of a body about the world's origin, shape (6, 6), and its moment of mass."""
    centre = place + turn @ body.centre
    arm = cross_matrix(centre)
    turning = turn @ body.inertia @ turn.T - body.mass * arm @ arm
    moment = body.mass * arm
    return np.block([[turning, moment], [-moment, body.mass * np.eye(3)]]), body.mass * centre


def stretched(joint, q):
    """How far the spring of a joint is from rest, along its degrees of freedom."""
    if joint.kind in ("hinge", "slide"):
        return q - joint.rest
    turn = rotation_vector(matrix(joint.rest[-4:]).T @ matrix(q[-4:]))
    return turn if joint.kind == "ball" else np.concatenate([q[:3] - joint.rest[:3], turn])


def rotation_vector(turn):
    """The axis times the angle, from 0 to pi, of a rotation matrix."""
    axis = (
        np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        / 2
    )
    sine = np.linalg.norm(axis)
    return axis * (np.arctan2(sine, (np.trace(turn) - 1) / 2) / sine) if sine else axis


def joint_force(mechanism, joint, q, v, ctrl):
    """The sum of the forces of a joint's actuators along it."""
    total = 0.0
    for actuator in mechanism.actuators:
        if mechanism.joints[actuator.joint] is joint:
            control = np.clip(ctrl[actuator.control], *(actuator.control_range or ANY))
            length, rate = actuator.gear * q[0], actuator.gear * v[0]
            constant, stiffness, damping = actuator.bias
            force = actuator.gain * control + constant + stiffness * length + damping * rate
            total += actuator.gear * np.clip(force, *(actuator.force_range or ANY))
    return total
