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

# An impulse needs one iteration of the solver for each joint that it passes. For one joint pymunk's
# default suffices.
SEVERAL_ITERATIONS = 50  # for several joints or contacts
PILED_ITERATIONS = 20  # for bodies piled on each other
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
        """The largest length in the reference pose [m]."""
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
    only_on_world = on_world and not mechanism.loops and not mechanism.touching
    if rate is not None and not only_on_world:
        raise Unsupported("pymunk has no platform that turns under more than one hinge")
    # Wheels: bodies that only turn, about hinges on the world, and that no weight pulls off them.
    # They are built without a joint, with their moments of inertia about the hinges.
    wheels = only_on_world and (weightless or rate is not None)
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
        """Joins two links at a point of each, relative to the link's centre [m], along
        the axes of the reference pose."""
        (a, place), (b, other) = first, second
        self.join(pymunk.PivotJoint(self.body(a), self.body(b), vector(place), vector(other)))

    def join(self, joint: pymunk.Constraint) -> None:
        """Adds a joint that corrects its opening at the rate that the method says."""
        joint.error_bias = float(
            self.planar.method.settings.get("error_bias", joint.error_bias)
        )
        self.space.add(joint)


def assembled(planar: Planar, poses: Sequence[Pose]) -> Assembly:
    """The mechanism in a new space, with its links in these poses."""
    assembly = Assembly(planar, pymunk.Space())
    space = assembly.space
    if not planar.wheels:
        space.gravity = vector(planar.gravity)
    for number, (link, pose) in enumerate(zip(planar.links.all, poses, strict=True)):
        body = pymunk.Body(link.mass, link.moment)
        body.angle, body.angular_velocity = pose.angle, pose.rate
        if not planar.wheels:
            body.position, body.velocity = vector(pose.place), vector(pose.velocity)
        assembly.bodies.append(body)
        space.add(body)
        _hold(assembly, number)
        for slide in link.slides:
            _push_along(assembly, number, slide)
        if link.hinge is not None:
            _turn(assembly, number, link.hinge)
    for loop in planar.mechanism.loops:
        assembly.pin(*map(planar.links.arm, loop.bodies, loop.places))
    assembly.shapes = planar.surfaces.add(space, assembly.bodies)
    space.iterations = _iterations(planar, len(space.constraints))
    return assembly


def _iterations(planar: Planar, joints: int) -> int:
    """The number of iterations of the solver in a step."""
    surfaces = planar.surfaces
    usual = pymunk.Space().iterations
    if surfaces.piled:
        usual = PILED_ITERATIONS
    elif joints + len(surfaces.pairs) > 1:
        usual = SEVERAL_ITERATIONS
    return int(planar.method.settings.get("iterations", usual))


def _hold(assembly: Assembly, number: int) -> None:
    """Adds the joint that keeps a link on its parent: a groove along its slide, or a pin at its
    hinge. No joint is needed for a link that may move anywhere in the plane, for wheels, and for a
    slide that nothing pushes sideways."""
    link = assembly.planar.links.all[number]
    if link.slides:
        if not link.free and assembly.planar.guided(link.slides[0]):
            place = link.hinge.place if link.hinge else link.centre
            far = FAR * assembly.planar.size * link.slides[0].along
            ends = vector(place - far), vector(place + far)
            body = assembly.bodies[number]
            rail = pymunk.GrooveJoint(
                assembly.space.static_body, body, *ends, vector(-link.arm)
            )
            assembly.join(rail)
    elif link.hinge and not assembly.planar.wheels:
        place = link.hinge.place
        if link.parent != WORLD:
            place -= assembly.planar.links.all[link.parent].centre
        assembly.pin((link.parent, place), (number, -link.arm))


def _push_along(assembly: Assembly, number: int, slide: Slide) -> None:
    """Adds the forces of a slide's damper and actuators, which act in each step."""
    joint = assembly.planar.mechanism.joints[slide.joint]
    actuators = actuators_of(assembly.planar.mechanism, slide.joint)
    depends_on_motion = bool(joint.damping[0]) or any(a.biased for a in actuators)
    if not (depends_on_motion or actuators):
        return
    if abs(abs(slide.along) - 1.0) > CLOSE:
        raise Unsupported(f"pymunk moves in a plane, and {joint.name} pushes out of it")
    body = assembly.bodies[number]
    joint_force = passive_and_actuator_force(joint, actuators)
    axis = vector(slide.along)
    reference_place = assembly.planar.links.all[number].centre * slide.along.conjugate()
    coordinate_offset = slide.reference - reference_place.real

    def push(controls: Sequence[float]) -> None:
        """Exerts the joint's force on the body, along the slide. The joint's coordinate and rate
        are computed only if the force depends on them."""
        coordinate = rate = 0.0
        if depends_on_motion:
            coordinate = body.position.dot(axis) + coordinate_offset
            rate = body.velocity.dot(axis)
        force = joint_force(coordinate, rate, controls)
        body.apply_force_at_world_point((force * axis[0], force * axis[1]), body.position)

    _add_push(assembly, push, depends_on_motion)


def _add_push(assembly: Assembly, push: Push, without_controls: bool) -> None:
    """Adds forces to a mechanism, which also act without controls if `without_controls`."""
    assembly.pushes.append(push)
    if without_controls:
        assembly.always.append(push)


def _turn(assembly: Assembly, number: int, hinge: Hinge) -> None:
    """Adds the moments of a hinge's spring, damper and actuators and, on a turning platform, the
    moments of weight and centrifugal forces.

    pymunk moves bodies before it changes their velocities. A moment that is set before a step
    belongs to the old angle: that is Euler's explicit rule, which gains energy. pymunk evaluates
    the moment of a spring at the new angle, which makes the step semi-implicit. So moments that
    depend on the angle act as springs, and moments that depend only on time and rate are set before
    a step."""
    planar = assembly.planar
    link = planar.links.all[number]
    joint = planar.mechanism.joints[hinge.joint]
    actuators = actuators_of(planar.mechanism, hinge.joint)
    motors = [a for a in actuators if not a.biased]
    servos = [a for a in actuators if a.biased]
    sense = hinge.sense
    body = assembly.bodies[number]
    carrier = assembly.body(link.parent)
    if link.point and not planar.wheels:
        if joint.stiffness or servos:
            raise Unsupported(f"pymunk has no spring that turns a point: {joint.name}")
        _push_point(assembly, number, hinge)
        return
    if motors:
        joint_force = actuator_force(joint, motors)

        def push(controls: Sequence[float]) -> None:
            """Sets the moment of the motors on the body, and the opposite moment on its parent."""
            moment = sense * joint_force(0.0, 0.0, controls)
            body.torque = moment  # motors of bodies that this body carries add to it later
            if link.parent != WORLD:
                carrier.torque -= moment

        _add_push(assembly, push, without_controls=False)
    if planar.rate is not None or joint.stiffness or joint.damping[0] or servos:
        rest = sense * (float(joint.rest[0]) - hinge.reference)
        spring = pymunk.DampedRotarySpring(body, carrier, rest, joint.stiffness, 0.0)
        assembly.space.add(spring)
        if planar.rate is not None or joint.damping[0] or servos:
            spring.torque_func = _spring(assembly, number, hinge, servos)


def _spring(
    assembly: Assembly, number: int, hinge: Hinge, servos: Sequence[Actuator]
) -> Callable[[pymunk.DampedRotarySpring, float], float]:
    """The function that pymunk calls for the moment against a hinge [N m], with a spring and the
    hinge's angle [rad]."""
    planar = assembly.planar
    link = planar.links.all[number]
    joint = planar.mechanism.joints[hinge.joint]
    body = assembly.bodies[number]
    carrier = assembly.body(link.parent)
    sense = hinge.sense
    reference = hinge.reference
    joint_force = passive_and_actuator_force(joint, servos)
    if planar.rate is not None:
        if joint.stiffness or joint.damping[0] or servos:
            raise Unsupported(f"pymunk has no spring on a platform that turns: {joint.name}")
        return platform_spring(planar.mechanism, planar.links, link, planar.rate)
    held = [0.0] * (1 + max((a.control for a in servos), default=0))
    if any(a.gain for a in servos):
        _add_push(assembly, lambda controls: held.__setitem__(slice(None), controls), False)

    damping = float(joint.damping[0])
    rest = sense * (float(joint.rest[0]) - reference)
    if link.parent == WORLD and not servos:
        return lambda spring, angle: (
            joint.stiffness * (angle - rest) + damping * body.angular_velocity
        )
    on_world = link.parent == WORLD

    def moment_against(spring: pymunk.DampedRotarySpring, angle: float) -> float:
        """Returns the moment of spring, damper and servos against the hinge [N m]."""
        rate = body.angular_velocity - (0.0 if on_world else carrier.angular_velocity)
        return -sense * joint_force(sense * angle + reference, sense * rate, held)

    return moment_against


def _push_point(assembly: Assembly, number: int, hinge: Hinge) -> None:
    """Adds the moment of a hinge's damper and motors on a point mass, as a force across its arm. A
    torque would lose its digits on a body with hardly any moment of inertia."""
    link = assembly.planar.links.all[number]
    joint = assembly.planar.mechanism.joints[hinge.joint]
    motors = actuators_of(assembly.planar.mechanism, hinge.joint)
    damped = bool(joint.damping[0])
    if not (damped or motors):
        return
    if link.parent != WORLD:
        raise Unsupported(f"pymunk has no moment on a point that hangs on a body: {joint.name}")
    body = assembly.bodies[number]
    length = link.length
    x, y = vector(1j * hinge.sense * link.arm / abs(link.arm))

    def pushing(joint_force: JointForce) -> Push:
        """Returns the function that exerts a joint's force on the point."""

        def push(controls: Sequence[float]) -> None:
            """Sets the force across the arm that has the moment of the joint."""
            force = joint_force(0.0, hinge.sense * body.angular_velocity, controls) / length
            cosine, sine = body.rotation_vector
            body.force = force * (x * cosine - y * sine), force * (x * sine + y * cosine)

        return push

    assembly.pushes.append(pushing(passive_and_actuator_force(joint, motors)))
    if damped:
        assembly.always.append(pushing(passive_and_actuator_force(joint, [])))
