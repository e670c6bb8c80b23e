"""Builds a planar mechanism from bodies and joints of pymunk."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import pymunk

from plumbob.engines.adapters.pymunk.links import (
    WORLD,
    Hinge,
    Link,
    Links,
    Pose,
    Slide,
    links_of,
)
from plumbob.engines.adapters.pymunk.methods import MOMENT
from plumbob.engines.adapters.pymunk.moments import platform_spring, turning_rate
from plumbob.engines.adapters.pymunk.plane import CLOSE
from plumbob.engines.adapters.pymunk.simulation import vector
from plumbob.engines.adapters.pymunk.surfaces import Surfaces, surfaces_of
from plumbob.engines.joint_forces import (
    JointForce,
    actuator_force,
    actuators_of,
    passive_and_actuator_force,
)
from plumbob.engines.mechanism import Actuator, Mechanism
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.stepper import State

# Iterations of the solver for several joints or contacts, and for bodies piled on each other. An
# impulse needs one iteration for each joint that it passes. For one joint pymunk's default
# suffices.
SEVERAL, PILED = 50, 20
FAR = 1e3  # length of a slide to either side, in sizes of the mechanism
Push = Callable[[Sequence[float]], None]
"""Controls -> nothing: exerts forces in the step that begins."""


@dataclass(frozen=True)
class Planar:
    """A mechanism as it is built in pymunk by a method. The links have the moments of inertia and
    the centres of pymunk's bodies."""

    mechanism: Mechanism
    method: Method
    links: Links
    surfaces: Surfaces
    rate: float | None  # [rad/s] rate of a plane that turns about its upward direction
    wheels: bool  # whether all links turn about hinges that carry no force

    @cached_property
    def gravity(self) -> complex:
        """Gravity in the plane [m/s^2]."""
        return self.links.plane.flat(self.mechanism.gravity)

    @property
    def size(self) -> float:
        """The largest length of the drawing [m]."""
        centres = [abs(link.centre) for link in self.links.all]
        return max([*centres, *(surface.size for surface in self.surfaces.all)])

    def guided(self, slide: Slide) -> bool:
        """Whether a link on one slide needs a joint that keeps it on the slide, since something may
        push it across the slide."""
        rubbed = any(pair.friction for pair in self.surfaces.pairs)
        carries = any(link.parent != WORLD for link in self.links.all)
        weight = abs((self.gravity * slide.along.conjugate()).imag)
        across = weight > CLOSE * abs(self.gravity)
        return rubbed or carries or across or bool(self.mechanism.loops)


def planar_of(mechanism: Mechanism, start: State, method: Method) -> Planar:
    """A mechanism as it is built in pymunk, for a start in this state; raises Unsupported, which
    names a part that pymunk cannot express."""
    links = links_of(mechanism, start)
    surfaces = surfaces_of(mechanism, links, start)
    rate = turning_rate(mechanism, links)
    on_world = all(
        link.hinge and not link.slides and link.parent == WORLD for link in links.all
    )
    weightless = abs(links.plane.flat(mechanism.gravity)) == 0.0
    alone = on_world and not mechanism.loops and not mechanism.touching
    if rate is not None and not alone:
        raise Unsupported("pymunk has no platform that turns under more than one hinge")
    # Wheels: bodies that only turn, about hinges on the world, and that no weight pulls off them.
    # They are built without a joint, with their moments of inertia about the hinges.
    wheels = alone and (weightless or rate is not None)
    bodies = [_as_body(mechanism, link, wheels) for link in links.all]
    planar = Planar(mechanism, method, replace(links, all=bodies), surfaces, rate, wheels)
    # raises Unsupported now, and not when it is put
    assembled(planar, planar.links.poses(start))
    return planar


def _as_body(mechanism: Mechanism, link: Link, wheel: bool) -> Link:
    """A link with the moment of inertia and the centre of its pymunk body."""
    if link.hinge is None:
        return replace(link, moment=math.inf)
    joint = mechanism.joints[link.hinge.joint]
    armature = float(joint.armature[0])
    length = link.length
    if wheel:
        return replace(link, moment=link.moment + link.mass * length**2 + armature)
    if armature:
        raise Unsupported(f"pymunk has no inertia of a joint beside its bodies': {joint.name}")
    if not link.point:
        return link
    # pymunk needs a moment of inertia I. About a hinge on the world, a body at a distance a swings
    # like a point at L if (I + m a^2) / (m a) = L.
    moment = MOMENT * link.mass * length**2
    arm = length
    if link.parent == WORLD and not link.slides:
        arm = (length + math.sqrt(length**2 - 4.0 * moment / link.mass)) / 2.0
    return replace(link, moment=moment, centre=link.hinge.place + arm * (link.arm / length))


@dataclass
class Assembly:
    """A mechanism in a space of pymunk."""

    planar: Planar
    space: pymunk.Space
    bodies: list[pymunk.Body] = field(default_factory=list)  # the bodies of the links
    shapes: list[pymunk.Shape] = field(default_factory=list)  # the shapes of the surfaces
    pushes: list[Push] = field(default_factory=list)  # forces under controls
    always: list[Push] = field(default_factory=list)  # forces that also act without controls

    def body(self, link: int) -> pymunk.Body:
        """The body of a link, or the static body for WORLD."""
        return self.space.static_body if link == WORLD else self.bodies[link]

    def pin(self, first: tuple[int, complex], second: tuple[int, complex]) -> None:
        """Joins two links at a point of each, relative to the link's centre in the drawing [m]."""
        (a, place), (b, other) = first, second
        self.join(pymunk.PivotJoint(self.body(a), self.body(b), vector(place), vector(other)))

    def join(self, joint: pymunk.Constraint) -> None:
        """Add a joint that closes as the method says."""
        joint.error_bias = float(
            self.planar.method.settings.get("error_bias", joint.error_bias)
        )
        self.space.add(joint)


def assembled(planar: Planar, poses: Sequence[Pose]) -> Assembly:
    """The mechanism in a new space, with its links in these poses."""
    made = Assembly(planar, pymunk.Space())
    space = made.space
    if not planar.wheels:
        space.gravity = vector(planar.gravity)
    for number, (link, pose) in enumerate(zip(planar.links.all, poses, strict=True)):
        body = pymunk.Body(link.mass, link.moment)
        body.angle, body.angular_velocity = pose.angle, pose.rate
        if not planar.wheels:
            body.position, body.velocity = vector(pose.place), vector(pose.velocity)
        made.bodies.append(body)
        space.add(body)
        _hold(made, number)
        for slide in link.slides:
            _push_along(made, number, slide)
        if link.hinge is not None:
            _turn(made, number, link.hinge)
    for loop in planar.mechanism.loops:
        made.pin(*map(planar.links.arm, loop.bodies, loop.places))
    made.shapes = planar.surfaces.add(space, made.bodies)
    space.iterations = _iterations(planar, len(space.constraints))
    return made


def _iterations(planar: Planar, joints: int) -> int:
    """The number of iterations of the solver in a step."""
    surfaces = planar.surfaces
    usual = pymunk.Space().iterations
    if surfaces.piled:
        usual = PILED
    elif joints + len(surfaces.pairs) > 1:
        usual = SEVERAL
    return int(planar.method.settings.get("iterations", usual))


def _hold(made: Assembly, number: int) -> None:
    """Adds the joint that keeps a link on its parent: a groove along its slide, or a pin at its
    hinge. No joint is needed for a link that may move anywhere in the plane, for wheels, and for a
    slide that nothing pushes sideways."""
    link = made.planar.links.all[number]
    if link.slides:
        if not link.free and made.planar.guided(link.slides[0]):
            place = link.hinge.place if link.hinge else link.centre
            far = FAR * made.planar.size * link.slides[0].along
            ends = vector(place - far), vector(place + far)
            body = made.bodies[number]
            rail = pymunk.GrooveJoint(made.space.static_body, body, *ends, vector(-link.arm))
            made.join(rail)
    elif link.hinge and not made.planar.wheels:
        place = link.hinge.place
        if link.parent != WORLD:
            place -= made.planar.links.all[link.parent].centre
        made.pin((link.parent, place), (number, -link.arm))


def _push_along(made: Assembly, number: int, slide: Slide) -> None:
    """Adds the forces of a slide's damper and actuators, which act in each step."""
    joint = made.planar.mechanism.joints[slide.joint]
    actuators = actuators_of(made.planar.mechanism, slide.joint)
    damped = bool(joint.damping[0]) or any(a.biased for a in actuators)
    if not (damped or actuators):
        return
    if abs(abs(slide.along) - 1.0) > CLOSE:
        raise Unsupported(f"pymunk moves in a plane, and {joint.name} pushes out of it")
    body = made.bodies[number]
    exerted = passive_and_actuator_force(joint, actuators)
    along = vector(slide.along)
    drawn = made.planar.links.all[number].centre * slide.along.conjugate()
    shift = slide.reference - drawn.real

    def push(controls: Sequence[float]) -> None:
        q = rate = 0.0
        if damped:
            q = body.position.dot(along) + shift
            rate = body.velocity.dot(along)
        force = exerted(q, rate, controls)
        body.apply_force_at_world_point((force * along[0], force * along[1]), body.position)

    _add_push(made, push, damped)


def _add_push(made: Assembly, push: Push, without_controls: bool) -> None:
    """Adds forces to a mechanism, which also act without controls if `without_controls`."""
    made.pushes.append(push)
    if without_controls:
        made.always.append(push)


def _turn(made: Assembly, number: int, hinge: Hinge) -> None:
    """Adds the moments of a hinge's spring, damper and actuators and, on a turning platform, the
    moments of weight and centrifugal forces.

    pymunk moves bodies before it changes their velocities. A moment that is set before a step
    belongs to the old angle: that is Euler's explicit rule, which gains energy. pymunk evaluates
    the moment of a spring at the new angle, which makes the step semi-implicit. So moments that
    depend on the angle act as springs, and moments that depend only on time and rate are set before
    a step."""
    planar = made.planar
    link = planar.links.all[number]
    joint = planar.mechanism.joints[hinge.joint]
    actuators = actuators_of(planar.mechanism, hinge.joint)
    motors = [a for a in actuators if not a.biased]
    servos = [a for a in actuators if a.biased]
    sense = hinge.sense
    body = made.bodies[number]
    carrier = made.body(link.parent)
    if link.point and not planar.wheels:
        if joint.stiffness or servos:
            raise Unsupported(f"pymunk has no spring that turns a point: {joint.name}")
        _push_point(made, number, hinge)
        return
    if motors:
        exerted = actuator_force(joint, motors)

        def push(controls: Sequence[float]) -> None:
            moment = sense * exerted(0.0, 0.0, controls)
            body.torque = moment  # motors of bodies that this body carries add to it later
            if link.parent != WORLD:
                carrier.torque -= moment

        _add_push(made, push, without_controls=False)
    if planar.rate is not None or joint.stiffness or joint.damping[0] or servos:
        rest = sense * (float(joint.rest[0]) - hinge.reference)
        spring = pymunk.DampedRotarySpring(body, carrier, rest, joint.stiffness, 0.0)
        made.space.add(spring)
        if planar.rate is not None or joint.damping[0] or servos:
            spring.torque_func = _spring(made, number, hinge, servos)


def _spring(
    made: Assembly, number: int, hinge: Hinge, servos: Sequence[Actuator]
) -> Callable[[pymunk.DampedRotarySpring, float], float]:
    """The function that pymunk calls for the moment against a hinge [N m], with a spring and the
    hinge's angle [rad]."""
    planar = made.planar
    link = planar.links.all[number]
    joint = planar.mechanism.joints[hinge.joint]
    body = made.bodies[number]
    carrier = made.body(link.parent)
    sense = hinge.sense
    reference = hinge.reference
    exerted = passive_and_actuator_force(joint, servos)
    if planar.rate is not None:
        if joint.stiffness or joint.damping[0] or servos:
            raise Unsupported(f"pymunk has no spring on a platform that turns: {joint.name}")
        return platform_spring(planar.mechanism, planar.links, link, planar.rate)
    held = [0.0] * (1 + max((a.control for a in servos), default=0))
    if any(a.gain for a in servos):
        _add_push(made, lambda controls: held.__setitem__(slice(None), controls), False)

    damping = float(joint.damping[0])
    rest = sense * (float(joint.rest[0]) - reference)
    if link.parent == WORLD and not servos:
        return lambda spring, angle: (
            joint.stiffness * (angle - rest) + damping * body.angular_velocity
        )
    still = link.parent == WORLD

    def against(spring: pymunk.DampedRotarySpring, angle: float) -> float:
        rate = body.angular_velocity - (0.0 if still else carrier.angular_velocity)
        return -sense * exerted(sense * angle + reference, sense * rate, held)

    return against


def _push_point(made: Assembly, number: int, hinge: Hinge) -> None:
    """Adds the moment of a hinge's damper and motors on a point mass, as a force across its arm. A
    torque would lose its digits on a body with hardly any moment of inertia."""
    link = made.planar.links.all[number]
    joint = made.planar.mechanism.joints[hinge.joint]
    motors = actuators_of(made.planar.mechanism, hinge.joint)
    damped = bool(joint.damping[0])
    if not (damped or motors):
        return
    if link.parent != WORLD:
        raise Unsupported(f"pymunk has no moment on a point that hangs on a body: {joint.name}")
    body = made.bodies[number]
    length = link.length
    x, y = vector(1j * hinge.sense * link.arm / abs(link.arm))

    def pushing(exerted: JointForce) -> Push:
        def push(controls: Sequence[float]) -> None:
            force = exerted(0.0, hinge.sense * body.angular_velocity, controls) / length
            cosine, sine = body.rotation_vector
            body.force = force * (x * cosine - y * sine), force * (x * sine + y * cosine)

        return push

    made.pushes.append(pushing(passive_and_actuator_force(joint, motors)))
    if damped:
        made.always.append(pushing(passive_and_actuator_force(joint, [])))
