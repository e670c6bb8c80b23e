"""A mechanism as a discrete plant of Drake steps it.

Drake's step is semi-implicit Euler, with implicit dampers and explicit springs of joints. An
attitude is a quaternion, which a step moves along its tangent by the new angular velocity.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydrake.math import RollPitchYaw, RotationMatrix
from pydrake.systems.analysis import Simulator

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.drake.builder import Built, build
from plumbob.engines.adapters.drake.motors import held_forces
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Options
from plumbob.engines.peer_model import rotation
from plumbob.engines.stepper import Forces, State

FREE, BALL = 7, 4  # number of coordinates of a free body and of a ball


class DrakeStepper:
    """A mechanism in a Drake plant with these settings, which takes steps of `step` [s] from any
    state. The settings include the plant's time step [s]. If that is 0, the plant is continuous,
    and forces of the source are held for `control` [s]."""

    def __init__(
        self, mechanism: Mechanism, settings: Options, step: float, control: float = 0.0
    ) -> None:
        self.step = step
        self.built = build(mechanism, settings, control)
        self.mechanism = mechanism
        self._fresh = self.built.diagram.CreateDefaultContext()
        self.simulator = simulator_of(self.built.diagram, self._fresh.Clone())
        self._within = self.built.within(self.simulator.get_mutable_context())
        self._begun, self._taken = 0.0, 0
        self._latest = State(np.zeros(0), np.zeros(0))

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state, at a time [s]."""
        self._begun, self._taken = time, 0
        self._latest = state
        context = self.simulator.get_mutable_context()
        context.SetTimeStateAndParametersFrom(self._fresh)
        put(self.mechanism, self.built, self._within, state)
        self.simulator.Initialize()

    def state(self) -> State:
        """The present state. The sign of a quaternion is the sign that is nearer to the quaternion
        that was put or read last."""
        self._latest = state_of(self.mechanism, self.built, self._within, self._latest)
        return self._latest

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, controls), or with controls that are
        zero."""
        self.drive(controls, steps)
        self._taken += steps
        advance(self.simulator, self._taken, self.step)

    def drive(self, controls: Array | None, steps: int) -> None:
        """Gives the source its outputs in the next `steps` steps under controls, shape (steps,
        controls), or with controls that are zero."""
        motors = self.built.motors
        if motors.source is not None:
            marks = np.arange(self._taken, self._taken + steps + 1, dtype=np.float64)
            rows = motors.forces(controls, self._begun + self.step * marks)
            # The source's outputs change half a step before each step begins: no output changes at
            # a time at which Drake reads it.
            motors.source.UpdateTrajectory(held_forces(rows, self.step * (marks - 0.5)))

    def forces(self) -> Forces:
        """The contact forces of the last step. The forces of joints are not read: they are nan."""
        touching = np.full((len(self.mechanism.touching), 3), math.nan)
        if self._taken:
            touching[:] = 0.0
            found = self.built.plant.get_contact_results_output_port().Eval(self._within)
            for i in range(found.num_point_pair_contacts()):
                contact = found.point_pair_contact_info(i)
                pair = contact.point_pair()
                number, sign = self.built.touching[pair.id_A, pair.id_B]
                touching[number] += sign * contact.contact_force()  # force on the second body
        return Forces(np.full((len(self.mechanism.joints), 3), math.nan), touching)


def simulator_of(diagram: Any, context: Any) -> Any:
    """A simulator of a diagram, initialised from a context."""
    simulator = Simulator(diagram, context)
    simulator.set_target_realtime_rate(0.0)
    simulator.Initialize()
    return simulator


def advance(simulator: Any, taken: int, step: float) -> None:
    """Advances a simulator until it has taken `taken` steps of `step` [s] since the time 0."""
    # A discrete update takes place at the time at which its step begins. The simulator stops half a
    # step before the next update, so that rounding cannot decide whether the update is done.
    simulator.AdvanceTo((taken - 0.5) * step)


def put(mechanism: Mechanism, built: Built, within: Any, state: State) -> None:
    """Sets the state of a plant in the plant's context."""
    q = np.zeros(built.plant.num_positions())
    v = np.zeros(built.plant.num_velocities())
    first = degree = 0
    for joint, made in zip(mechanism.joints, built.joints, strict=True):
        places, rates = made.num_positions(), made.num_velocities()
        of_file = BALL if joint.kind == "ball" else places
        here = state.qpos[first : first + of_file]
        moving = state.qvel[degree : degree + rates]
        first, degree = first + of_file, degree + rates
        at, of = made.position_start(), made.velocity_start()
        if joint.kind == "free":  # Drake has the angular velocity along the world's axes
            here = np.concatenate([here[3:], here[:3]])
            moving = np.concatenate([rotation(here[:4]) @ moving[3:], moving[:3]])
        elif joint.kind == "ball":
            turn = rotation(here)
            here = RollPitchYaw(RotationMatrix(turn)).vector()
            moving = turn @ moving
        else:
            here = here - joint.reference
        q[at : at + places] = here
        v[of : of + rates] = moving
    built.plant.SetPositions(within, q)
    built.plant.SetVelocities(within, v)


def state_of(mechanism: Mechanism, built: Built, within: Any, latest: State) -> State:
    """The state of a plant from the plant's context. The sign of each quaternion is the sign that
    is nearer to the quaternion in the `latest` state."""
    q, v = built.plant.GetPositions(within), built.plant.GetVelocities(within)
    places, rates = list[Array](), list[Array]()
    first = 0
    for joint, made in zip(mechanism.joints, built.joints, strict=True):
        here = q[made.position_start() :][: made.num_positions()]
        moving = v[made.velocity_start() :][: made.num_velocities()]
        if joint.kind == "free":
            attitude = _signed(here[:4], latest.qpos[first + 3 : first + FREE])
            here = np.concatenate([here[4:], attitude])
            moving = np.concatenate([moving[3:], rotation(attitude).T @ moving[:3]])
        elif joint.kind == "ball":
            turn = RollPitchYaw(here)
            moving = turn.ToRotationMatrix().matrix().T @ moving
            here = _signed(turn.ToQuaternion().wxyz(), latest.qpos[first : first + BALL])
        else:
            here = here + joint.reference
        places.append(here)
        rates.append(moving)
        first += len(here)
    return State(np.concatenate(places), np.concatenate(rates))


def _signed(attitude: Array, latest: Array) -> Array:
    """The quaternion `attitude`, normalised, with the sign that is nearer to the `latest`."""
    unit = attitude / math.sqrt(attitude @ attitude)
    return -unit if unit @ latest < 0.0 else unit
