"""The bodies of a mechanism as links that move in a plane, and the coordinates of their joints."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.joints import TURNING, joints_of_body
from plumbob.engines.adapters.pymunk.plane import CLOSE, Plane, plane_of
from plumbob.engines.adapters.reference_pose import ReferencePose, reference_pose
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Unsupported
from plumbob.engines.stepper import State

WORLD = -1  # stands for the world in place of the number of a link


@dataclass(frozen=True)
class Slide:
    """A slide between a link and the world."""

    joint: int  # number of the joint
    along: complex  # part of the axis in the plane, of length 1 if the axis lies in the plane
    reference: float  # coordinate in the reference pose [m]


@dataclass(frozen=True)
class Hinge:
    """A hinge about the normal of the plane, which comes after the slides of its body."""

    joint: int  # number of the joint
    place: complex  # place in the reference pose [m]
    # 1 if its coordinate counts like angles in the plane, -1 if it counts backwards
    sense: float
    reference: float  # coordinate in the reference pose [rad]


@dataclass(frozen=True)
class Link:
    """A body that moves in the plane. Its axes are those of the plane in the reference pose."""

    body: int  # number of the body in the mechanism
    parent: int  # number of the link that carries it, or WORLD
    mass: float  # [kg]
    moment: float  # moment of inertia about its centre [kg m^2]
    point: bool  # whether it stands for a point mass
    centre: complex  # centre of mass in the reference pose [m]
    slides: tuple[Slide, ...]
    hinge: Hinge | None
    length: float = 0.0  # distance from the hinge to the centre of the mechanism's body [m]

    @cached_property
    def free(self) -> bool:
        """Whether its slides let the link move anywhere in the plane."""
        return sum(abs(slide.along) ** 2 for slide in self.slides) > 1.5

    @cached_property
    def arm(self) -> complex:
        """The vector from the hinge to the centre in the reference pose [m]; 0 without a hinge."""
        return self.centre - self.hinge.place if self.hinge else 0j


def turned_by(angle: float, arm: complex) -> complex:
    """A vector in the reference pose [m], rotated by an angle [rad]."""
    return abs(arm) * cmath.exp(1j * (angle + cmath.phase(arm)))


class Pose(NamedTuple):
    """The place of a link's centre and the link's angle, with their rates."""

    place: complex  # [m]
    angle: float  # angle from the drawing [rad]
    velocity: complex  # [m/s]
    rate: float  # [rad/s]

    def at(self, arm: complex) -> tuple[complex, complex]:
        """The place [m] and the velocity [m/s] of the point that is at `arm` from the centre in the
        drawing [m]."""
        turned = turned_by(self.angle, arm)
        return self.place + turned, self.velocity + 1j * self.rate * turned


@dataclass(frozen=True)
class Links:
    """The links of a mechanism in the order of its bodies, and its plane."""

    plane: Plane
    drawn: ReferencePose
    all: list[Link] = field(default_factory=list)
    numbers: dict[int, int] = field(default_factory=dict)
    """{number of a body: number of its link}, without the world and a platform that carries the
    plane."""

    def arm(self, body: int, place: Array) -> tuple[int, complex]:
        """The number of a body's link, and a point of the body relative to the link's centre in the
        drawing [m]. For a body that is no link: WORLD, and the point relative to the origin."""
        number = self.numbers.get(body, WORLD)
        point = self.plane.flat(self.drawn.point(body, place))
        return number, point if number == WORLD else point - self.all[number].centre

    def poses(self, state: State) -> list[Pose]:
        """The pose of each link in a state."""
        poses = list[Pose]()
        for link in self.all:
            place = _shift(link, state.qpos)
            velocity = _shift_rate(link, state.qvel)
            hinge = link.hinge
            if hinge is None:
                poses.append(Pose(place + link.centre, 0.0, velocity, 0.0))
                continue
            angle = hinge.sense * (float(state.qpos[hinge.joint]) - hinge.reference)
            rate = hinge.sense * float(state.qvel[hinge.joint])
            place = place + hinge.place
            if link.parent != WORLD:
                above = poses[link.parent]
                place, velocity = above.at(hinge.place - self.all[link.parent].centre)
                angle, rate = angle + above.angle, rate + above.rate
            turned = turned_by(angle, link.arm)
            poses.append(Pose(place + turned, angle, velocity + 1j * rate * turned, rate))
        return poses

    def unseen_coordinates(self, start: State) -> State:
        """The parts of the joints' coordinates and velocities in a state that are not seen in the
        plane. They are zero unless a slide points out of the plane."""
        qpos = np.zeros(len(start.qpos))
        qvel = np.zeros(len(start.qvel))
        for link in self.all:
            place = _shift(link, start.qpos)
            velocity = _shift_rate(link, start.qvel)
            for slide in link.slides:
                back = slide.along.conjugate()
                qpos[slide.joint] = float(start.qpos[slide.joint]) - (back * place).real
                qvel[slide.joint] = float(start.qvel[slide.joint]) - (back * velocity).real
        return State(qpos, qvel)

    def coordinates(
        self, poses: Sequence[Pose], unseen: State
    ) -> tuple[list[float], list[float]]:
        """The coordinates and the velocities of the joints, in their order, from the poses of the
        links and the `unseen` parts of the coordinates."""
        qpos: list[float] = unseen.qpos.tolist()
        qvel: list[float] = unseen.qvel.tolist()
        for link, pose in zip(self.all, poses, strict=True):
            hinge = link.hinge
            if hinge:
                turn, rate = pose.angle, pose.rate
                if link.parent != WORLD:
                    turn -= poses[link.parent].angle
                    rate -= poses[link.parent].rate
                qpos[hinge.joint] += hinge.sense * turn + hinge.reference
                qvel[hinge.joint] += hinge.sense * rate
            if link.slides:
                place, velocity = pose.place - link.centre, pose.velocity
                if hinge and link.arm:
                    place, velocity = pose.at(-link.arm)
                    place -= hinge.place
                for slide in link.slides:
                    back = slide.along.conjugate()
                    qpos[slide.joint] += (back * place).real
                    qvel[slide.joint] += (back * velocity).real
        return qpos, qvel


def _shift(link: Link, qpos: Array) -> complex:
    """The displacement of a link by its slides in the plane [m]."""
    shift = 0j
    for slide in link.slides:
        shift += (float(qpos[slide.joint]) - slide.reference) * slide.along
    return shift


def _shift_rate(link: Link, qvel: Array) -> complex:
    """The velocity of a link by its slides in the plane [m/s]."""
    velocity = 0j
    for slide in link.slides:
        velocity += float(qvel[slide.joint]) * slide.along
    return velocity


def links_of(mechanism: Mechanism, start: State) -> Links:
    """The links of a mechanism. Raises Unsupported, which names a part that pymunk cannot
    express."""
    _refuse(mechanism)
    drawn = reference_pose(mechanism)
    links = Links(plane_of(mechanism, start, drawn), drawn)
    for number, body in enumerate(mechanism.bodies[1:], start=1):
        joint_numbers = joints_of_body(mechanism, number)
        if any(mechanism.joints[joint].velocity is not None for joint in joint_numbers):
            continue  # the body is a platform that carries the plane
        if not joint_numbers:
            raise Unsupported(f"pymunk has no weld: {body.name} has no joint")
        link = _link(mechanism, links, number, joint_numbers)
        _check_slides(mechanism, links, link, start)
        links.numbers[number] = len(links.all)
        links.all.append(link)
    return links


def _link(
    mechanism: Mechanism, links: Links, number: int, joint_numbers: Sequence[int]
) -> Link:
    """The link of the body with this number, which has joints with these numbers. Raises
    Unsupported."""
    body = mechanism.bodies[number]
    plane = links.plane
    drawn = links.drawn
    parent = links.numbers.get(body.parent, WORLD)
    slides = []
    for joint_number in joint_numbers:
        joint = mechanism.joints[joint_number]
        if joint.kind == "slide":
            along = plane.flat(drawn.axis(joint))
            slides.append(Slide(joint_number, along, float(joint.reference[0])))
    hinge = None
    last_joint = mechanism.joints[joint_numbers[-1]]
    if last_joint.kind == "hinge":
        sense = float(np.sign(plane.across(drawn.axis(last_joint))))
        place = plane.flat(drawn.point(number, last_joint.place))
        hinge = Hinge(joint_numbers[-1], place, sense, float(last_joint.reference[0]))
    if len(slides) + (hinge is not None) != len(joint_numbers):
        raise Unsupported(f"pymunk has no hinge before another joint: {body.name}")
    if slides and parent != WORLD:
        raise Unsupported(f"pymunk has no slide on a body that moves: {body.name}")
    inertia = drawn.turns[number] @ body.inertia @ drawn.turns[number].T
    centre = plane.flat(drawn.point(number, body.centre))
    return Link(
        body=number,
        parent=parent,
        mass=body.mass,
        moment=0.0 if body.point else plane.across(inertia @ plane.normal),
        point=body.point,
        centre=centre,
        slides=tuple(slides),
        hinge=hinge,
        length=abs(centre - hinge.place) if hinge else 0.0,
    )


def _refuse(mechanism: Mechanism) -> None:
    """Raises Unsupported if a mechanism has a part that pymunk cannot express."""
    missing = [part.name for part in mechanism.not_expressed]
    missing += [f"weld {loop.name}" for loop in mechanism.loops if loop.kind == "weld"]
    missing += [f"carried weight of {body.name}" for body in mechanism.bodies if body.carried]
    for joint in mechanism.joints:
        features = {
            f"{joint.kind} joint": joint.kind in TURNING,
            "limits of joint": joint.limits is not None,
            "friction of joint": bool(np.any(joint.friction_loss)),
            "range of forces of joint": joint.force_range is not None,
            "spring along slide": joint.kind == "slide" and joint.stiffness != 0.0,
            "inertia of slide": joint.kind == "slide" and bool(np.any(joint.armature)),
            "moving slide": joint.kind == "slide" and joint.velocity is not None,
        }
        missing += [f"{name} {joint.name}" for name, present in features.items() if present]
    if missing:
        raise Unsupported(f"pymunk has no {missing[0].strip()}")


def _check_slides(mechanism: Mechanism, links: Links, link: Link, start: State) -> None:
    """Raises Unsupported if the slides of a link are not perpendicular to each other, if a slide is
    oblique to the plane, or if a slide is normal to the plane and the initial velocity or gravity
    acts along it."""
    if not link.slides:
        return
    plane = links.plane
    axes = [links.drawn.axis(mechanism.joints[slide.joint]) for slide in link.slides]
    name = mechanism.bodies[link.body].name
    if np.abs(np.array(axes) @ np.transpose(axes) - np.eye(len(axes))).max() > CLOSE:
        raise Unsupported(f"pymunk has no oblique slides: {name}")
    # The squared length of each slide's part in the plane: 1 for each slide that is in the plane
    in_plane = sum(abs(slide.along) ** 2 for slide in link.slides)
    if abs(in_plane - (2.0 if link.free else 1.0)) > CLOSE:
        raise Unsupported(f"pymunk moves in a plane, and {name} slides out of it")
    across = [plane.across(axis) for axis in axes]
    velocity = sum(
        part * start.qvel[slide.joint] for part, slide in zip(across, link.slides, strict=True)
    )
    moves_across = abs(velocity) > CLOSE * np.linalg.norm(start.qvel)
    weight = plane.across(mechanism.gravity) * np.linalg.norm(across)
    weight_acts_across = abs(weight) > CLOSE * np.linalg.norm(mechanism.gravity)
    if moves_across or weight_acts_across:
        raise Unsupported(f"pymunk moves in a plane, and {name} is pushed out of it")
