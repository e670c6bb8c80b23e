"""A planar mechanism in pymunk as a stepper: it is put into a state, stepped, and read."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from itertools import repeat

import numpy as np
import pymunk

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.pymunk.links import WORLD, Pose, turned_by
from plumbob.engines.adapters.pymunk.planar import Planar, assembled, planar_of
from plumbob.engines.adapters.pymunk.simulation import settle, vector
from plumbob.engines.joint_forces import idle_controls
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Method
from plumbob.engines.stepper import Forces, State

# Iterations that find the impulses at the start are SETTLING times the ratio of the largest to the
# smallest mass in contact, times the squared number of bodies, and MOST at most. An error falls by
# a factor of e in as many iterations as that product.
SETTLING = 40.0
MOST = 1_000_000


class PlanarStepper:
    """A planar mechanism in pymunk. Putting it into a state builds a new space, so that nothing of
    earlier steps survives."""

    def __init__(self, planar: Planar, step: float) -> None:
        self._planar = planar
        self._step = step
        self._idle = idle_controls(planar.mechanism)
        self._none = [pymunk.Vec2d.zero()] * len(planar.links.all)  # forces on bodies
        self._untold = Forces(
            np.full((len(planar.mechanism.joints), 3), np.nan),
            np.full((len(planar.surfaces.pairs), 3), np.nan),
        )
        prescribed = [joint.velocity is not None for joint in planar.mechanism.joints]
        self._platform = prescribed.index(True) if any(prescribed) else None

    @property
    def step(self) -> float:
        """The time step [s]."""
        return self._step

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state; the time has no effect."""
        self._hidden = self._planar.links.hidden(state)
        self._started = state
        self._steps = 0
        self._made = assembled(self._planar, self._planar.links.poses(state))
        # for each body: its velocity before the last step, and the force exerted in that step
        self._before: list[pymunk.Vec2d] = []
        self._exerted = self._none
        if not self._planar.mechanism.actuators:
            self._begin(self._idle)

    def state(self) -> State:
        """The present state."""
        qpos, qvel = self._planar.links.coordinates(self._poses(), self._hidden)
        number = self._platform
        rate = self._planar.rate
        if number is not None and rate is not None:
            time = self._step * self._steps
            qpos[number] = float(self._started.qpos[number]) + rate * time
            qvel[number] = rate
        return State(np.array(qpos), np.array(qvel))

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, controls)."""
        if not steps:
            return
        rows = None if controls is None else controls.tolist()
        if self._steps == 0 and self._planar.mechanism.actuators:
            self._begin(rows[0] if rows else self._idle)
        made = self._made
        if steps > 1:
            self._take(rows and rows[:-1], steps - 1)
        pushes = made.always if rows is None else made.pushes
        if pushes:
            for push in pushes:
                push(rows[-1] if rows else self._idle)
            self._exerted = [body.force for body in made.bodies]
        else:
            self._exerted = self._none
        self._before = [body.velocity for body in made.bodies]
        made.space.step(self._step)
        self._steps += steps

    def _take(self, rows: Sequence[Sequence[float]] | None, steps: int) -> None:
        """Takes steps under rows of controls."""
        move = self._made.space.step
        step = self._step
        pushes = self._made.always if rows is None else self._made.pushes
        if not pushes:
            for _ in range(steps):
                move(step)
            return
        for row in repeat(self._idle, steps) if rows is None else rows:
            for push in pushes:
                push(row)
            move(step)

    def _poses(self) -> list[Pose]:
        """Returns the poses of the links. The position of a link is left at zero unless the link
        slides, and its angle unless it is hinged: no coordinate needs them."""
        poses = list[Pose]()
        for link, body in zip(self._planar.links.all, self._made.bodies, strict=True):
            place = velocity = 0j
            angle = rate = 0.0
            if link.slides:
                place, velocity = complex(*body.position), complex(*body.velocity)
            if link.hinge:
                angle, rate = body.angle, body.angular_velocity
            poses.append(Pose(place, angle, velocity, rate))
        return poses

    def _begin(self, controls: Sequence[float]) -> None:
        """Gives the start what an earlier step would have left: the opening of a joint that closes
        in one step, and the impulses between bodies that touch one another."""
        made = self._made
        (*rest, joint) = made.space.constraints or [None]
        if joint is not None and not rest and joint.error_bias == 0.0:
            self._open(controls)
        piled = self._planar.surfaces.piled
        if piled:
            for push in made.pushes:
                push(controls)
            masses = [self._planar.links.all[number].mass for number in piled]
            uneven = max(masses) / min(masses) * len(masses) ** 2
            usual = made.space.iterations
            settle(made.space, self._step, min(round(SETTLING * uneven) + usual, MOST))

    def _open(self, controls: Sequence[float]) -> None:
        """Puts the only body, which hangs on a hinge, to the place where an earlier step would have
        opened the hinge. If the hinge started closed, its first impulse would be too large."""
        (link,) = self._planar.links.all
        (body,) = self._made.bodies
        if link.hinge is None or link.slides:
            return
        for push in self._made.pushes:
            push(controls)
        arm = turned_by(body.angle, link.arm)
        force = link.mass * self._planar.gravity + complex(*body.force)
        inertia = link.moment + link.mass * abs(arm) ** 2
        acceleration = ((force * arm.conjugate()).imag + body.torque) / inertia
        body.force, body.torque = (0.0, 0.0), 0.0
        turn = 1j * self._step * (body.angular_velocity - self._step * acceleration)
        opening = cmath.exp(-turn) * (1 + turn) - 1
        speed = 1j * body.angular_velocity - opening / self._step
        body.position = vector(link.hinge.place + arm * (1 + opening))
        body.velocity = vector(arm * speed)

    def forces(self) -> Forces:
        """The forces of the last step: those of the joints of trees, in the plane, and those of
        shapes that touch. A joint in a loop, or a platform that turns, is nan."""
        planar = self._planar
        plane = planar.links.plane
        pairs = [pair.surfaces for pair in planar.surfaces.pairs]
        joints, touching = self._untold.joints.copy(), self._untold.touching.copy()
        if not self._before:
            return Forces(joints, touching)
        impulses = self._impulses() if pairs else {}
        for number, pair in enumerate(pairs):
            touching[number] = plane.lifted(impulses.get(pair, 0j) / self._step)
        for link, force in zip(planar.links.all, self._carried(impulses), strict=True):
            if planar.wheels or len(link.slides) + (link.hinge is not None) > 1:
                continue
            joint = link.hinge or link.slides[0]
            joints[joint.joint] = plane.lifted(force)
        return Forces(joints, touching)

    def _impulses(self) -> dict[tuple[int, int], complex]:
        """The impulses of the last step [N s] on the second surface of each touching pair."""
        numbers = {shape: number for number, shape in enumerate(self._made.shapes)}
        found = dict[tuple[int, int], complex]()

        def read(arbiter: pymunk.Arbiter) -> None:
            first, second = (numbers[shape] for shape in arbiter.shapes)
            impulse = complex(*arbiter.total_impulse)  # on the first
            found[first, second] = -impulse
            found[second, first] = impulse

        for body in self._made.bodies:
            body.each_arbiter(read)
        return found

    def _carried(self, impulses: dict[tuple[int, int], complex]) -> list[complex]:
        """The force on each link from its parent in the last step [N]: the rate of change of the
        momentum of the link and of all links that it carries, less their weight, the forces exerted
        on them, and the forces of contacts. The force is nan if one of them is part of a loop.
        `impulses` are those of the first surface of a pair on the second."""
        planar = self._planar
        links = planar.links.all
        forces = [self._gained(number) for number in range(len(links))]
        for pair in planar.surfaces.pairs:
            force = impulses.get(pair.surfaces, 0j) / self._step
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

    def _gained(self, number: int) -> complex:
        """The rate of change of a link's momentum in the last step, less its weight and the forces
        exerted on it [N]."""
        faster = complex(*(self._made.bodies[number].velocity - self._before[number]))
        gained = faster / self._step - self._planar.gravity
        return self._planar.links.all[number].mass * gained - complex(*self._exerted[number])


def planar_stepper(
    mechanism: Mechanism, start: State, method: Method, step: float
) -> PlanarStepper:
    """A stepper of a mechanism that will start in a state, by a method at a step [s]. It is not put
    into the state yet. Raises Unsupported, which names a part that pymunk cannot express."""
    return PlanarStepper(planar_of(mechanism, start, method), step)
