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
from plumbob.engines.mechanism import Actuator, Joint, Mechanism
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
    hinged_on_world = all(
        link.hinge and not link.slides and link.parent == WORLD for link in links.all
    )
    only_hinges = hinged_on_world and not mechanism.loops and not mechanism.touching
    if rate is not None and not only_hinges:
        raise Unsupported("pymunk has no platform that turns under more than one hinge")
    # Wheels: bodies that only turn, about hinges on the world, and that no weight pulls off them.
    # They are built without a joint, with their moments of inertia about the hinges.
    weightless = abs(links.plane.flat(mechanism.gravity)) == 0.0
    wheels = only_hinges and (weightless or rate is not None)
    bodies = [_as_body(mechanism, link, wheels) for link in links.all]
    planar = Planar(mechanism, method, replace(links, all=bodies), surfaces, rate, wheels)
    # Raises Unsupported now, and not when the mechanism is put into a state.
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
    # Forces that are exerted before each step: of all dampers and actuators in a step that has
    # controls, and in a step without controls only of those whose force depends on the motion
    controlled_pushes: list[Push] = field(default_factory=list)
    uncontrolled_pushes: list[Push] = field(default_factory=list)

    def body(self, link: int) -> pymunk.Body:
        """The body of a link, or the static body for WORLD."""
        return self.space.static_body if link == WORLD else self.bodies[link]

    def pin(self, first: tuple[int, complex], second: tuple[int, complex]) -> None:
        """Joins two links at a point of each. A point is given by the number of its link, and by
        its place relative to the link's centre [m], along the axes of the reference pose."""
        link, place = first
        other_link, other_place = second
        body, other_body = self.body(link), self.body(other_link)
        self.join(pymunk.PivotJoint(body, other_body, vector(place), vector(other_place)))

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
            _hinged_body(assembly, number, link.hinge).add_moments()
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
    """Adds the forces of a slide's damper and actuators. If they depend on the slide's motion, they
    also act in steps without controls."""
    joint = assembly.planar.mechanism.joints[slide.joint]
    actuators = actuators_of(assembly.planar.mechanism, slide.joint)
    biased = any(actuator.biased for actuator in actuators)
    depends_on_motion = bool(joint.damping[0]) or biased
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

    assembly.controlled_pushes.append(push)
    if depends_on_motion:
        assembly.uncontrolled_pushes.append(push)


@dataclass(frozen=True)
class HingedBody:
    """A body of pymunk that a hinge turns, with the spring, the damper and the actuators of the
    hinge.

    pymunk moves bodies before it changes their velocities. A moment that is set before a step
    belongs to the old angle: that is Euler's explicit rule, which gains energy. pymunk evaluates
    the moment of a spring at the new angle, which makes the step semi-implicit. So moments that
    depend on the angle act as springs, and moments that depend only on time and rate are set before
    a step."""

    assembly: Assembly
    link: Link
    hinge: Hinge
    joint: Joint
    body: pymunk.Body
    carrier: pymunk.Body  # body of the parent link, or the static body

    @property
    def on_world(self) -> bool:
        """Whether the hinge is on the world, and not on another link."""
        return self.link.parent == WORLD

    def add_moments(self) -> None:
        """Adds the moments of the hinge's spring, damper and actuators and, on a turning platform,
        the moments of weight and centrifugal forces. Raises Unsupported."""
        planar = self.assembly.planar
        joint = self.joint
        actuators = actuators_of(planar.mechanism, self.hinge.joint)
        motors = [actuator for actuator in actuators if not actuator.biased]
        servos = [actuator for actuator in actuators if actuator.biased]
        if self.link.point and not planar.wheels:
            if joint.stiffness or servos:
                raise Unsupported(f"pymunk has no spring that turns a point: {joint.name}")
            self._push_point(motors)
            return
        if motors:
            self._add_motors(motors)
        depends_on_rate = bool(joint.damping[0] or servos)
        on_platform = planar.rate is not None
        if on_platform and (joint.stiffness or depends_on_rate):
            raise Unsupported(f"pymunk has no spring on a platform that turns: {joint.name}")
        if not (on_platform or joint.stiffness or depends_on_rate):
            return
        spring = pymunk.DampedRotarySpring(
            self.body, self.carrier, self._angle_at_rest, joint.stiffness, 0.0
        )
        self.assembly.space.add(spring)
        if planar.rate is not None:
            spring.torque_func = platform_spring(
                planar.mechanism, planar.links, self.link, planar.rate
            )
        elif depends_on_rate:
            spring.torque_func = self._moment_against(servos)

    @property
    def _angle_at_rest(self) -> float:
        """The angle of the hinge at which its spring has no moment [rad]."""
        return self.hinge.sense * (float(self.joint.rest[0]) - self.hinge.reference)

    def _add_motors(self, motors: Sequence[Actuator]) -> None:
        """Adds the moments of motors, which depend only on their controls."""
        joint_force = actuator_force(self.joint, motors)
        body = self.body
        carrier = self.carrier
        on_world = self.on_world
        sense = self.hinge.sense
        coordinate = rate = 0.0  # without effect: motors have no bias

        def push(controls: Sequence[float]) -> None:
            """Sets the moment of the motors on the body, and the opposite moment on its parent."""
            moment = sense * joint_force(coordinate, rate, controls)
            body.torque = moment  # motors of bodies that this body carries add to it later
            if not on_world:
                carrier.torque -= moment

        self.assembly.controlled_pushes.append(push)

    def _moment_against(
        self, servos: Sequence[Actuator]
    ) -> Callable[[pymunk.DampedRotarySpring, float], float]:
        """The function that pymunk calls for the moment against the hinge [N m], with a spring and
        the hinge's angle [rad]."""
        joint = self.joint
        body = self.body
        carrier = self.carrier
        on_world = self.on_world
        sense = self.hinge.sense
        reference = self.hinge.reference
        if on_world and not servos:
            stiffness = joint.stiffness
            damping = float(joint.damping[0])
            angle_at_rest = self._angle_at_rest
            return lambda spring, angle: (
                stiffness * (angle - angle_at_rest) + damping * body.angular_velocity
            )
        joint_force = passive_and_actuator_force(joint, servos)
        latest_controls = [0.0] * (1 + max((servo.control for servo in servos), default=0))

        def keep(controls: Sequence[float]) -> None:
            """Keeps the controls of the step that begins."""
            latest_controls[:] = controls

        if any(servo.gain for servo in servos):
            self.assembly.controlled_pushes.append(keep)

        def moment_against(spring: pymunk.DampedRotarySpring, angle: float) -> float:
            """The moment of spring, damper and servos against the hinge [N m]."""
            rate = body.angular_velocity - (0.0 if on_world else carrier.angular_velocity)
            coordinate = sense * angle + reference
            return -sense * joint_force(coordinate, sense * rate, latest_controls)

        return moment_against

    def _push_point(self, motors: Sequence[Actuator]) -> None:
        """Adds the moment of the hinge's damper and motors on a point mass, as a force across its
        arm. A torque would lose its digits on a body with hardly any moment of inertia. In steps
        without controls only the damper acts."""
        damped = bool(self.joint.damping[0])
        if not (damped or motors):
            return
        if not self.on_world:
            raise Unsupported(
                f"pymunk has no moment on a point that hangs on a body: {self.joint.name}"
            )
        body = self.body
        length = self.link.length
        sense = self.hinge.sense
        x, y = vector(1j * sense * self.link.arm / abs(self.link.arm))
        coordinate = 0.0  # without effect: the hinge of a point has no spring and no servo

        def pushing(joint_force: JointForce) -> Push:
            """Returns the function that exerts a joint's force on the point."""

            def push(controls: Sequence[float]) -> None:
                """Sets a force perpendicular to the arm, whose moment about the hinge is that of
                the joint."""
                rate = sense * body.angular_velocity
                force = joint_force(coordinate, rate, controls) / length
                cosine, sine = body.rotation_vector
                body.force = force * (x * cosine - y * sine), force * (x * sine + y * cosine)

            return push

        damper_and_motors = passive_and_actuator_force(self.joint, motors)
        self.assembly.controlled_pushes.append(pushing(damper_and_motors))
        if damped:
            damper = passive_and_actuator_force(self.joint, [])
            self.assembly.uncontrolled_pushes.append(pushing(damper))


def _hinged_body(assembly: Assembly, number: int, hinge: Hinge) -> HingedBody:
    """The body of the link with this number, on its hinge."""
    link = assembly.planar.links.all[number]
    return HingedBody(
        assembly=assembly,
        link=link,
        hinge=hinge,
        joint=assembly.planar.mechanism.joints[hinge.joint],
        body=assembly.bodies[number],
        carrier=assembly.body(link.parent),
    )
