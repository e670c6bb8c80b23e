"""A mechanism as a solver of Newton steps it.

A step and its detection of contacts are recorded as a graph. Forces, and the coordinates that
XPBD's drives impose, change from step to step: they are written before each step.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from types import MappingProxyType
from typing import Any

import newton
import numpy as np
import warp

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.joints import joint_places
from plumbob.engines.adapters.newton.builder import Built
from plumbob.engines.adapters.newton.coordinates import Coordinates
from plumbob.engines.adapters.step_clock import StepClock
from plumbob.engines.joint_forces import ends, force_of_controls
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Options
from plumbob.engines.stepper import State

SOLVERS = MappingProxyType(
    {
        "featherstone": newton.solvers.SolverFeatherstone,
        "xpbd": newton.solvers.SolverXPBD,
        "mujoco": newton.solvers.SolverMuJoCo,
    }
)


class NewtonStepper:
    """A mechanism in one of Newton's solvers, which takes steps of `step` [s] from any state. The
    settings have the name of the solver and the arguments of the solver. Steppers may share a
    model: they differ only in their settings and their steps."""

    def __init__(self, built: Built, settings: Options, step: float) -> None:
        arguments = dict(settings)
        solver = arguments.pop("solver")
        self.step = step
        self.built = built
        self.mechanism = built.mechanism
        joints = self.mechanism.joints
        self._maximal = solver == "xpbd"  # whether the solver's state has bodies, and no joints
        self._coordinates = Coordinates(joints, built.centres, maximal=self._maximal)
        self._reference = np.concatenate([joint.reference for joint in joints])
        self._first_rates = [place.start for _, place in joint_places(joints)]
        self._present = built.model.state()
        self._next = built.model.state()
        self._control = built.model.control()
        # XPBD's restitution adds errors even to contacts that do not bounce: it is off for them.
        if solver == "xpbd":
            arguments.setdefault("enable_restitution", bounces(self.mechanism))
        self.solver = SOLVERS[solver](built.model, **arguments)
        self._step_graph = self._record_step()
        self._reading_graph = self._record_reading() if self._maximal else None
        self._clock = StepClock(step)
        self._forced = False  # whether forces of the last step act on
        self._imposed = list[float]()  # latest coordinates that drives have imposed
        self._latest = State(self._reference, np.zeros(len(self._reference)))

    def _record_step(self) -> Any:
        """The graph of a step, with the detection of contacts."""
        pipeline = self.built.pipeline
        contacts = None if pipeline is None else pipeline.contacts()
        with warp.ScopedCapture() as capture:
            if pipeline is not None:
                pipeline.collide(self._present, contacts)
            self.solver.step(self._present, self._next, self._control, contacts, self.step)
            self._present.assign(self._next)
        return capture.graph

    def _record_reading(self) -> Any:
        """The graph that computes the coordinates of joints from the places of bodies."""
        present = self._present
        with warp.ScopedCapture() as capture:
            newton.eval_ik(self.built.model, present, present.joint_q, present.joint_qd)
        return capture.graph

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state, at a time [s]."""
        self._clock.restart(time)
        self._latest = state
        held_places = [held.place for held in self.built.held]
        self._imposed = [state.qpos[place] - self._reference[place] for place in held_places]
        positions, rates = self._coordinates.to_newton(state)
        model = self.built.model
        present = self._present
        present.joint_q.assign(_with_first_values(model.joint_q, positions))
        present.joint_qd.assign(_with_first_values(model.joint_qd, rates))
        newton.eval_fk(model, present.joint_q, present.joint_qd, present)
        self._control.joint_f.zero_()
        self._forced = False
        self.solver.reset(present, flags=newton.StateFlags.NONE)
        if isinstance(self.solver, newton.solvers.SolverMuJoCo):
            # MuJoCo Warp takes the change of a loop's direction from the velocities of bodies in
            # the step before: they are set to zero, as in a new model.
            self.solver.mjw_data.cvel.zero_()
            self.solver.mjw_data.cdof_dot.zero_()

    def state(self) -> State:
        """The present state. The sign of a quaternion is the sign that is nearer to the quaternion
        that was put or read last. XPBD's bodies give an angle up to whole turns: the number of
        turns is the nearest to the angle that was put or read last."""
        present = self._present
        if self._reading_graph is not None:
            warp.capture_launch(self._reading_graph)
        joint_q = np.array(present.joint_q.numpy(), float)
        joint_qd = np.array(present.joint_qd.numpy(), float)
        self._latest = self._coordinates.from_newton(joint_q, joint_qd, self._latest)
        return self._latest

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, controls), or with controls that are
        zero."""
        forces = self._forces(controls, steps)
        targets = self._targets(steps)
        inputs = list[tuple[Callable[[Array], None], Array]]()
        if forces is not None:
            inputs.append((_writer(self._control.joint_f), forces))
        if targets is not None:
            inputs.append((_writer(self._control.joint_target_q), targets))
        for number in range(steps):
            for write, rows in inputs:
                write(rows[number])
            warp.capture_launch(self._step_graph)
        warp.synchronize()
        self._clock.steps_taken += steps

    def _forces(self, controls: Array | None, steps: int) -> Array | None:
        """The forces on the joints in each of the next steps, shape (steps, degrees of freedom).
        None if they are zero, and were zero in the last step."""
        rotors = [held for held in self.built.held if held.rotor]
        if controls is None and not rotors:
            return None
        rows = np.zeros((steps, len(self.built.model.joint_qd)))
        for motor in self.mechanism.actuators:
            unclamped = force_of_controls(motor, controls, steps)
            force = np.clip(unclamped, *ends(motor.force_range))
            rows[:, self._first_rates[motor.joint]] += motor.gear * force
        times = self._clock.next_times(steps)
        for held in rotors:
            # With the mean acceleration of a step, the velocity is exact at the end of the step.
            rows[:, held.degree] += held.rotor * np.diff(held.velocity(times)) / self.step
        forced_before = self._forced
        self._forced = bool(rows[-1].any())
        return rows if forced_before or rows.any() else None

    def _targets(self, steps: int) -> Array | None:
        """The coordinates that drives impose at the end of each of the next steps, shape (steps,
        targets). None if there are no drives."""
        if not self._maximal or not self.built.held:
            return None
        rows = np.tile(self._control.joint_target_q.numpy(), (steps, 1))
        end_times = self._clock.next_times(steps)[1:]
        for number, held in enumerate(self.built.held):
            displacements = self.step * np.cumsum(held.velocity(end_times))
            coordinates = self._imposed[number] + displacements
            self._imposed[number] = coordinates[-1]
            rows[:, held.place] = coordinates
        return rows


def bounces(mechanism: Mechanism) -> bool:
    """Whether a pair of shapes has restitution."""
    return any(touch.restitution for touch in mechanism.touching)


def _writer(array: Any) -> Callable[[Array], None]:
    """A function that writes values into an array of Newton. On the processor it takes a tenth of
    the time of `assign`, which first makes an array of Newton from the values."""
    return partial(np.copyto, array.numpy()) if array.device.is_cpu else array.assign


def _with_first_values(array: Any, values: Array) -> Array:
    """A copy of an array of Newton that begins with the given values. Its other elements belong to
    the joints that close loops."""
    copy = np.array(array.numpy())
    copy[: len(values)] = values
    return copy
