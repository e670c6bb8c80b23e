"""The bodies of a mechanism that move in a plane, and their joints' coordinates."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.pymunk.plane import CLOSE, Drawing, Plane, drawing, plane_of
from plumbob.engines.mechanism import Joint, Mechanism
from plumbob.engines.method import Unsupported
from plumbob.engines.stepper import State

WORLD = -1  # in place of the number of a link


@dataclass(frozen=True)
class Slide:
    """A slide on the world."""

    joint: int
    along: complex  # the part of its axis in the plane, which has a length of 1 if all of it is
    reference: float  # its coordinate in the drawing [m]


@dataclass(frozen=True)
class Hinge:
    """A hinge across the plane, after the slides of its body if it has any."""

    joint: int
    place: complex  # in the drawing [m]
    sense: float  # 1 or -1: of its coordinate, in that of angles in the plane
    reference: float  # its coordinate in the drawing [rad]


@dataclass(frozen=True)
class Link:
    """A body that moves in the plane. Its own axes are those of the plane in the drawing."""

    body: int
    parent: int  # number of the link that carries it, or WORLD
    mass: float  # [kg]
    moment: float  # of inertia about its centre [kg m^2]
    point: bool  # a point is meant
    centre: complex  # of mass, in the drawing [m]
    slides: tuple[Slide, ...]
    hinge: Hinge | None
    length: float = 0.0  # from the hinge to the centre of the mechanism's body [m]

    @cached_property
    def free(self) -> bool:
        """Whether its slides let it move anywhere in the plane."""
        return sum(abs(slide.along) ** 2 for slide in self.slides) > 1.5

    @cached_property
    def arm(self) -> complex:
        """From the hinge to the centre in the drawing [m]; 0 without a hinge."""
        return self.centre - self.hinge.place if self.hinge else 0j


def turned_by(angle: float, arm: complex) -> complex:
    """An arm [m] of the drawing, turned by an angle."""
    return abs(arm) * cmath.exp(1j * (angle + cmath.phase(arm)))


class Pose(NamedTuple):
    """Where the centre of a link is and how the link is turned, with their rates."""

    place: complex  # [m]
    angle: float  # from the drawing [rad]
    velocity: complex  # [m/s]
    rate: float  # [rad/s]

    def at(self, arm: complex) -> tuple[complex, complex]:
        """The place [m] and the velocity [m/s] of a point by its place from the centre in the
        drawing [m]."""
        turned = turned_by(self.angle, arm)
        return self.place + turned, self.velocity + 1j * self.rate * turned


@dataclass(frozen=True)
class Links:
    """The links of a mechanism in the order of its bodies, and its plane."""

    plane: Plane
    drawn: Drawing
    all: list[Link] = field(default_factory=list)
    numbers: dict[int, int] = field(default_factory=dict)
    """{number of a body: number of its link}: without the world and what carries the plane."""

    def arm(self, body: int, place: Array) -> tuple[int, complex]:
        """The number of a body's link, and a point of the body [m] from the link's centre in the
        drawing; from the origin on a body that is not in the plane."""
        number = self.numbers.get(body, WORLD)
        point = self.plane.flat(self.drawn.point(body, place))
        return number, point if number == WORLD else point - self.all[number].centre

    def poses(self, state: State) -> list[Pose]:
        """The pose of each link in a state."""
        poses = list[Pose]()
        for link in self.all:
            place = _shift(link, state.qpos)
            velocity = _shift(link, state.qvel, rates=True)
            hinge = link.hinge
            if hinge is None:
                poses.append(Pose(place + link.centre, 0.0, velocity, 0.0))
                continue
            angle, rate = (
                hinge.sense * (float(state.qpos[hinge.joint]) - hinge.reference),
                hinge.sense * float(state.qvel[hinge.joint]),
            )
            place = place + hinge.place
            if link.parent != WORLD:
                above = poses[link.parent]
                place, velocity = above.at(hinge.place - self.all[link.parent].centre)
                angle, rate = angle + above.angle, rate + above.rate
            turned = turned_by(angle, link.arm)
            poses.append(Pose(place + turned, angle, velocity + 1j * rate * turned, rate))
        return poses

    def hidden(self, begun: State) -> list[tuple[float, float]]:
        """Of each joint, the parts of a state's coordinate and velocity that are not seen in the
        plane: of a slide that is not wholly in it."""
        hidden = [(0.0, 0.0)] * len(begun.qpos)
        for link in self.all:
            place = _shift(link, begun.qpos)
            velocity = _shift(link, begun.qvel, rates=True)
            for slide in link.slides:
                back = slide.along.conjugate()
                hidden[slide.joint] = (
                    float(begun.qpos[slide.joint]) - (back * place).real,
                    float(begun.qvel[slide.joint]) - (back * velocity).real,
                )
        return hidden

    def coordinates(
        self, poses: Sequence[Pose], hidden: Sequence[tuple[float, float]]
    ) -> tuple[list[float], list[float]]:
        """The coordinates of links in these poses, and their velocities, in the order of joints."""
        qpos = [position for position, _ in hidden]
        qvel = [velocity for _, velocity in hidden]
        for link, pose in zip(self.all, poses, strict=True):
            if hinge := link.hinge:
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


def _shift(link: Link, values: Array, rates: bool = False) -> complex:
    """How far the slides of a link have moved it in the plane [m], by all coordinates, or how fast
    [m/s], by all `rates`."""
    moved = 0j
    for slide in link.slides:
        moved += (
            float(values[slide.joint]) - (0.0 if rates else slide.reference)
        ) * slide.along
    return moved


def links_of(mechanism: Mechanism, start: State) -> Links:
    """The links of a mechanism. Raises Unsupported, which names what pymunk cannot have."""
    _refuse(mechanism)
    drawn = drawing(mechanism)
    links = Links(plane_of(mechanism, start, drawn), drawn)
    for number, body in enumerate(mechanism.bodies[1:], start=1):
        joints = [(n, j) for n, j in enumerate(mechanism.joints) if j.body == number]
        if any(joint.velocity is not None for _, joint in joints):
            continue  # it carries the plane
        if not joints:
            raise Unsupported(f"pymunk has no weld: {body.name} has no joint")
        links.numbers[number] = len(links.all)
        links.all.append(_link(mechanism, links, number, joints))
        _check_across(mechanism, links, start)
    return links


def _link(
    mechanism: Mechanism, links: Links, number: int, joints: Sequence[tuple[int, Joint]]
) -> Link:
    """The link of a body with these joints, by their numbers."""
    body = mechanism.bodies[number]
    plane = links.plane
    drawn = links.drawn
    parent = links.numbers.get(body.parent, WORLD)
    slides = [
        Slide(n, plane.flat(drawn.axis(joint)), float(joint.reference[0]))
        for n, joint in joints
        if joint.kind == "slide"
    ]
    hinge = None
    if joints[-1][1].kind == "hinge":
        last, joint = joints[-1]
        sense = float(np.sign(plane.across(drawn.axis(joint))))
        place = plane.flat(drawn.point(number, joint.place))
        hinge = Hinge(last, place, sense, float(joint.reference[0]))
    if len(slides) + (hinge is not None) != len(joints):
        raise Unsupported(f"pymunk has no hinge before another joint: {body.name}")
    if slides and parent != WORLD:
        raise Unsupported(f"pymunk has no slide on a body that moves: {body.name}")
    inertia = drawn.turns[number] @ body.inertia @ drawn.turns[number].T
    centre = plane.flat(drawn.point(number, body.centre))
    return Link(
        number,
        parent,
        body.mass,
        0.0 if body.point else plane.across(inertia @ plane.normal),
        body.point,
        centre,
        tuple(slides),
        hinge,
        abs(centre - hinge.place) if hinge else 0.0,
    )


def _refuse(mechanism: Mechanism) -> None:
    """Raises Unsupported if a mechanism has a part that the builder has no counterpart for."""
    missing = [part.name for part in mechanism.not_expressed]
    missing += [f"weld {loop.name}" for loop in mechanism.loops if loop.kind == "weld"]
    missing += [f"carried weight of {body.name}" for body in mechanism.bodies if body.carried]
    for joint in mechanism.joints:
        features = {
            f"{joint.kind} joint": joint.kind in ("ball", "free"),
            "limits of joint": joint.limits is not None,
            "friction of joint": bool(np.any(joint.friction_loss)),
            "range of forces of joint": joint.force_range is not None,
            "spring along slide": joint.kind == "slide" and joint.stiffness != 0.0,
            "inertia of slide": joint.kind == "slide" and bool(np.any(joint.armature)),
            "moving slide": joint.kind == "slide" and joint.velocity is not None,
        }
        missing += [f"{name} {joint.name}" for name, there in features.items() if there]
    if missing:
        raise Unsupported(f"pymunk has no {missing[0].strip()}")


def _check_across(mechanism: Mechanism, links: Links, start: State) -> None:
    """Raises Unsupported if the slides of the last link are not perpendicular to each other; if
    one is oblique to the plane; or if one is across the plane, and the start's velocity or gravity
    acts along it."""
    link = links.all[-1]
    plane = links.plane
    axes = [links.drawn.axis(mechanism.joints[slide.joint]) for slide in link.slides]
    name = mechanism.bodies[link.body].name
    if not axes:
        return
    if np.abs(np.array(axes) @ np.transpose(axes) - np.eye(len(axes))).max() > CLOSE:
        raise Unsupported(f"pymunk has no oblique slides: {name}")
    # the squared length of each slide's part in the plane: 1 for each slide that is in it
    in_plane = sum(abs(slide.along) ** 2 for slide in link.slides)
    if abs(in_plane - (2.0 if link.free else 1.0)) > CLOSE:
        raise Unsupported(f"pymunk moves in a plane, and {name} slides out of it")
    across = [plane.across(axis) for axis in axes]
    velocity = sum(a * start.qvel[s.joint] for a, s in zip(across, link.slides, strict=True))
    weight = plane.across(mechanism.gravity) * np.linalg.norm(across)
    if abs(velocity) > CLOSE * np.linalg.norm(start.qvel) or abs(
        weight
    ) > CLOSE * np.linalg.norm(mechanism.gravity):
        raise Unsupported(f"pymunk moves in a plane, and {name} is pushed out of it")
