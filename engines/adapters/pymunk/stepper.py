"""A planar mechanism in pymunk as a stepper: it is put into a state, stepped, and read."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from itertools import repeat

import numpy as np
import pymunk

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.pymunk.links import WORLD, Pose, turned_by
from plumbob.engines.adapters.pymunk.planar import Planar, Push, assembled, planar_of
from plumbob.engines.adapters.pymunk.simulation import settle, vector
from plumbob.engines.joint_forces import idle_controls
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Method
from plumbob.engines.stepper import Forces, State

# Iterations that find the impulses at the start are SETTLING times the ratio of the largest to the
# smallest mass in contact, times the squared number of bodies, and MAX_SETTLING_ITERATIONS at most.
# An error falls by a factor of e in as many iterations as that product.
SETTLING = 40.0
MAX_SETTLING_ITERATIONS = 1_000_000


class PlanarStepper:
    """A planar mechanism in pymunk. Putting it into a state builds a new space, so that nothing of
    earlier steps survives."""

    def __init__(self, planar: Planar, step: float) -> None:
        self.step = step
        self._planar = planar
        self._idle = idle_controls(planar.mechanism)
        self._no_forces = [pymunk.Vec2d.zero()] * len(planar.links.all)
        prescribed = [joint.velocity is not None for joint in planar.mechanism.joints]
        self._platform = prescribed.index(True) if any(prescribed) else None

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state; the time has no effect."""
        self._start = state
        self._unseen = self._planar.links.unseen_coordinates(state)
        self._steps_taken = 0
        self._assembly = assembled(self._planar, self._planar.links.poses(state))
        # For each body: its velocity before the last step, and the force exerted in that step
        self._velocities_before: list[pymunk.Vec2d] = []
        self._exerted = self._no_forces
        if not self._planar.mechanism.actuators:
            self._prepare_first_step(self._idle)

    def state(self) -> State:
        """The present state."""
        qpos, qvel = self._planar.links.coordinates(self._poses(), self._unseen)
        platform = self._platform
        rate = self._planar.rate
        if platform is not None and rate is not None:
            time = self.step * self._steps_taken
            qpos[platform] = float(self._start.qpos[platform]) + rate * time
            qvel[platform] = rate
        return State(np.array(qpos), np.array(qvel))

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, controls), or with controls that are
        zero. The velocities before the last step and the forces exerted in it are kept for
        `forces_of_last_step`."""
        if not steps:
            return
        assembly = self._assembly
        rows = None if controls is None else controls.tolist()
        pushes = assembly.controlled_pushes
        if rows is None:
            pushes = assembly.uncontrolled_pushes
        if self._steps_taken == 0 and self._planar.mechanism.actuators:
            self._prepare_first_step(rows[0] if rows else self._idle)
        if steps > 1:
            self._take(pushes, rows and rows[:-1], steps - 1)
        self._exerted = self._no_forces
        if pushes:
            for push in pushes:
                push(rows[-1] if rows else self._idle)
            self._exerted = [body.force for body in assembly.bodies]
        self._velocities_before = [body.velocity for body in assembly.bodies]
        assembly.space.step(self.step)
        self._steps_taken += steps

    def _take(
        self, pushes: Sequence[Push], rows: Sequence[Sequence[float]] | None, steps: int
    ) -> None:
        """Takes steps with these pushes under rows of controls."""
        move = self._assembly.space.step
        step = self.step
        if not pushes:
            for _ in range(steps):
                move(step)
            return
        for row in repeat(self._idle, steps) if rows is None else rows:
            for push in pushes:
                push(row)
            move(step)

    def _poses(self) -> list[Pose]:
        """The poses of the links. The position of a link is left at zero unless the link slides,
        and its angle unless it is hinged: no coordinate needs them."""
        poses = list[Pose]()
        for link, body in zip(self._planar.links.all, self._assembly.bodies, strict=True):
            place = velocity = 0j
            angle = rate = 0.0
            if link.slides:
                place, velocity = complex(*body.position), complex(*body.velocity)
            if link.hinge:
                angle, rate = body.angle, body.angular_velocity
            poses.append(Pose(place, angle, velocity, rate))
        return poses

    def _prepare_first_step(self, controls: Sequence[float]) -> None:
        """Gives the start what an earlier step would have left: the opening of a joint that closes
        in one step, and the impulses between bodies that touch one another."""
        assembly = self._assembly
        joints = list(assembly.space.constraints)
        if len(joints) == 1 and joints[0].error_bias == 0.0:
            self._open_hinge(controls)
        piled = self._planar.surfaces.piled
        if piled:
            for push in assembly.controlled_pushes:
                push(controls)
            masses = [self._planar.links.all[number].mass for number in piled]
            slowness = max(masses) / min(masses) * len(masses) ** 2
            iterations = round(SETTLING * slowness) + assembly.space.iterations
            settle(assembly.space, self.step, min(iterations, MAX_SETTLING_ITERATIONS))

    def _open_hinge(self, controls: Sequence[float]) -> None:
        """Puts the only body, which hangs on a hinge, to the place where an earlier step would have
        opened the hinge. If the hinge started closed, its first impulse would be too large."""
        (link,) = self._planar.links.all
        (body,) = self._assembly.bodies
        if link.hinge is None or link.slides:
            return
        for push in self._assembly.controlled_pushes:
            push(controls)
        arm = turned_by(body.angle, link.arm)
        force = link.mass * self._planar.gravity + complex(*body.force)
        inertia = link.moment + link.mass * abs(arm) ** 2
        acceleration = ((force * arm.conjugate()).imag + body.torque) / inertia
        body.force, body.torque = (0.0, 0.0), 0.0
        turn = 1j * self.step * (body.angular_velocity - self.step * acceleration)
        opening = cmath.exp(-turn) * (1 + turn) - 1
        speed = 1j * body.angular_velocity - opening / self.step
        body.position = vector(link.hinge.place + arm * (1 + opening))
        body.velocity = vector(arm * speed)

    def forces_of_last_step(self) -> Forces:
        """The forces of the last step: those of the joints of trees, in the plane, and those of
        shapes that touch. The force of a joint in a loop, and of a platform that turns, is nan."""
        planar = self._planar
        plane = planar.links.plane
        pairs = [pair.surfaces for pair in planar.surfaces.pairs]
        joints = np.full((len(planar.mechanism.joints), 3), np.nan)
        touching = np.full((len(pairs), 3), np.nan)
        if not self._velocities_before:
            return Forces(joints, touching)
        impulses = self._impulses() if pairs else {}
        for number, pair in enumerate(pairs):
            touching[number] = plane.lifted(impulses.get(pair, 0j) / self.step)
        for link, force in zip(planar.links.all, self._parent_forces(impulses), strict=True):
            numbers = [slide.joint for slide in link.slides]
            numbers += [link.hinge.joint] if link.hinge else []
            if len(numbers) == 1 and not planar.wheels:
                joints[numbers[0]] = plane.lifted(force)
        return Forces(joints, touching)

    def _impulses(self) -> dict[tuple[int, int], complex]:
        """The impulses of the last step [N s] on the second surface of each touching pair."""
        numbers = {shape: number for number, shape in enumerate(self._assembly.shapes)}
        impulses = dict[tuple[int, int], complex]()

        def read(arbiter: pymunk.Arbiter) -> None:
            """Keeps the impulse of a contact."""
            first, second = (numbers[shape] for shape in arbiter.shapes)
            impulse_on_first = complex(*arbiter.total_impulse)
            impulses[first, second] = -impulse_on_first
            impulses[second, first] = impulse_on_first

        for body in self._assembly.bodies:
            body.each_arbiter(read)
        return impulses

    def _parent_forces(self, impulses: dict[tuple[int, int], complex]) -> list[complex]:
        """The force on each link from its parent in the last step [N]: the rate of change of the
        momentum of the link and of all links that it carries, less their weight, the forces exerted
        on them, and the forces of contacts. The force is nan if one of them is part of a loop.
        `impulses` are those of the first surface of a pair on the second."""
        planar = self._planar
        links = planar.links.all
        forces = [self._unexplained_force(number) for number in range(len(links))]
        for pair in planar.surfaces.pairs:
            force = impulses.get(pair.surfaces, 0j) / self.step
            first, second = planar.surfaces.links(pair)
            if first != WORLD:
                forces[first] += force
            if second != WORLD:
                forces[second] -= force
        for loop in planar.mechanism.loops:
            for body in loop.bodies:
                number = planar.links.numbers.get(body)
                if number is not None:
                    forces[number] = complex(np.nan, np.nan)
        for number in reversed(range(len(links))):
            if links[number].parent != WORLD:
                forces[links[number].parent] += forces[number]
        return forces

    def _unexplained_force(self, number: int) -> complex:
        """The rate of change of a link's momentum in the last step, less its weight and the forces
        exerted on it [N]."""
        velocity = self._assembly.bodies[number].velocity
        change = complex(*(velocity - self._velocities_before[number]))
        acceleration = change / self.step - self._planar.gravity
        force = self._planar.links.all[number].mass * acceleration
        return force - complex(*self._exerted[number])


def planar_stepper(
    mechanism: Mechanism, start: State, method: Method, step: float
) -> PlanarStepper:
    """A stepper of a mechanism that will start in a state, by a method at a step [s]. It is not put
    into the state yet. Raises Unsupported, which names a part that pymunk cannot express."""
    return PlanarStepper(planar_of(mechanism, start, method), step)
