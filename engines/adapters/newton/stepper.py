"""A mechanism in a solver of Newton's, stepped from any state.

A step is recorded as a graph, its detection of contacts too. What changes from step to step, forces
and the coordinates that XPBD's drives impose, is written before each.
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
from plumbob.engines.adapters.newton.builder import Built, degrees
from plumbob.engines.adapters.newton.coordinates import Coordinates
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
    """A mechanism in one of Newton's solvers, named in the settings with its own, at a time step
    [s]. Steppers of one model differ in nothing but their settings and steps."""

    def __init__(self, built: Built, settings: Options, step: float) -> None:
        chosen = dict(settings)
        solver = chosen.pop("solver")
        self.step = step
        self.built, self.mechanism = built, built.mechanism
        joints = self.mechanism.joints
        self._coordinates = Coordinates(joints, built.centres)
        self._drawn = np.concatenate([joint.reference for joint in joints])
        self._degrees = degrees(self.mechanism)
        self._now, self._then = built.model.state(), built.model.state()
        self._control = built.model.control()
        if solver == "xpbd":  # where nothing bounces, it makes errors of its own
            chosen.setdefault("enable_restitution", bounces(self.mechanism))
        self.solver = SOLVERS[solver](built.model, **chosen)
        self._maximal = solver == "xpbd"  # its state is that of bodies, not of joints
        self._graph = self._recorded()
        self._reading = self._recorded_reading() if self._maximal else None
        self._begun, self._taken = 0.0, 0
        self._forced = False  # whether forces of the last step act on
        self._imposed = list[float]()  # coordinates that drives have imposed last
        self._latest = State(self._drawn, np.zeros(len(self._drawn)))

    def _recorded(self) -> Any:
        """The graph of a step."""
        pipeline = self.built.pipeline
        contacts = None if pipeline is None else pipeline.contacts()
        with warp.ScopedCapture() as capture:
            if pipeline is not None:
                pipeline.collide(self._now, contacts)
            self.solver.step(self._now, self._then, self._control, contacts, self.step)
            self._now.assign(self._then)
        return capture.graph

    def _recorded_reading(self) -> Any:
        """The graph that works out coordinates of joints from bodies'."""
        now = self._now
        with warp.ScopedCapture() as capture:
            newton.eval_ik(self.built.model, now, now.joint_q, now.joint_qd)
        return capture.graph

    def put(self, state: State, time: float = 0.0) -> None:
        """Set the state, at a time [s]."""
        self._begun, self._taken, self._latest = time, 0, state
        self._imposed = [state.qpos[x.place] - self._drawn[x.place] for x in self.built.held]
        places, rates = self._coordinates.to_newton(state)
        model = self.built.model
        self._now.joint_q.assign(_filled(model.joint_q, places))
        self._now.joint_qd.assign(_filled(model.joint_qd, rates))
        newton.eval_fk(model, self._now.joint_q, self._now.joint_qd, self._now)
        self._control.joint_f.zero_()
        self._forced = False
        self.solver.reset(self._now, flags=newton.StateFlags.NONE)
        if isinstance(self.solver, newton.solvers.SolverMuJoCo):
            # A loop's direction changes by velocities of bodies of the step before.
            self.solver.mjw_data.cvel.zero_()
            self.solver.mjw_data.cdof_dot.zero_()

    def state(self) -> State:
        """The state now; a quaternion has the sign that is nearer to the last one, and an angle
        that XPBD's bodies tell up to whole turns is the nearest to the last one."""
        now = self._now
        if self._reading is not None:
            warp.capture_launch(self._reading)
        found = np.array(now.joint_q.numpy(), float), np.array(now.joint_qd.numpy(), float)
        self._latest = self._coordinates.from_newton(found, self._latest)
        return self._latest

    def advance(self, controls: Array | None, steps: int) -> None:
        """Take `steps` steps under controls, shape (steps, controls)."""
        control = self._control
        rows = (control.joint_f, self._forces(controls, steps))
        targets = (control.joint_target_q, self._targets(steps))
        written = [(_writer(array), x) for array, x in (rows, targets) if x is not None]
        for step in range(steps):
            for write, values in written:
                write(values[step])
            warp.capture_launch(self._graph)
        warp.synchronize()
        self._taken += steps

    def _forces(self, controls: Array | None, steps: int) -> Array | None:
        """Forces on the joints in each of the next steps, shape (steps, degrees of freedom); None
        where they are 0 and have been."""
        turned = [held for held in self.built.held if held.rotor]
        if controls is None and not turned:
            return None
        rows = np.zeros((steps, len(self.built.model.joint_qd)))
        for motor in self.mechanism.actuators:
            control = np.zeros(steps) if controls is None else controls[:, motor.control]
            control = within(control, motor.control_range)
            force = within(motor.gain * control + motor.bias[0], motor.force_range)
            rows[:, self._degrees[motor.joint]] += motor.gear * force
        times = self._times(steps)
        for held in turned:
            # with a step's mean acceleration the velocity is right at every grid time
            rows[:, held.degree] += held.rotor * np.diff(held.velocity(times)) / self.step
        before, self._forced = self._forced, bool(rows[-1].any())
        return rows if before or rows.any() else None

    def _targets(self, steps: int) -> Array | None:
        """The coordinates that drives impose at the end of each of the next steps, shape (steps,
        targets); None where there are none."""
        if not self._maximal or not self.built.held:
            return None
        rows = np.tile(self._control.joint_target_q.numpy(), (steps, 1))
        ends = self._times(steps)[1:]
        for number, held in enumerate(self.built.held):
            course = self._imposed[number] + self.step * np.cumsum(held.velocity(ends))
            self._imposed[number] = course[-1]
            rows[:, held.place] = course
        return rows

    def _times(self, steps: int) -> Array:
        """The grid times of the next steps [s], shape (steps + 1,)."""
        numbers = np.arange(self._taken, self._taken + steps + 1, dtype=np.float64)
        return self._begun + self.step * numbers


def bounces(mechanism: Mechanism) -> bool:
    """Whether a pair of shapes has restitution."""
    return any(touch.restitution for touch in mechanism.touching)


def within(values: Array, limits: tuple[float, float] | None) -> Array:
    """Values, none of them outside the limits."""
    return values if limits is None else np.clip(values, *limits)


def _writer(array: Any) -> Callable[[Array], None]:
    """Writes values into an array of Newton's: on the processor at a tenth of the time of `assign`,
    which makes an array of them first."""
    return partial(np.copyto, array.numpy()) if array.device.is_cpu else array.assign


def _filled(array: Any, values: Array) -> Array:
    """Values for an array of Newton's, which also has the coordinates of joints that close
    loops."""
    whole = np.array(array.numpy())
    whole[: len(values)] = values
    return whole
