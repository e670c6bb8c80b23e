"""A mechanism as Exudyn steps it. Exudyn's solver takes all steps of a run in C++, and sensors keep
the coordinates of every step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import exudyn
import exudyn.itemInterface
import numpy as np
from scipy.spatial.transform import Rotation

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.exudyn.bodies import AXES
from plumbob.engines.adapters.exudyn.builder import PlacedJoint, build
from plumbob.engines.adapters.exudyn.contacts import rounding_of_forces
from plumbob.engines.adapters.exudyn.tables import Tabulated
from plumbob.engines.adapters.joints import TURNING, joint_places
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Options
from plumbob.engines.sampling import Indices
from plumbob.engines.stepper import State
from plumbob.models.model_file import Controls, Feedback

items = exudyn.itemInterface
INITIAL = exudyn.ConfigurationType.Initial
QUANTITIES = (exudyn.OutputVariableType.Coordinates, exudyn.OutputVariableType.Coordinates_t)

EXPLICIT = "RK"  # prefix of the names of explicit solvers


class ExudynStepper:
    """A mechanism in Exudyn, which the solver named in `settings` steps by `step` [s] from any
    state. `controls` is a function of the time, or a feedback whose answers `advance` is given;
    None stands for controls that stay zero."""

    def __init__(
        self,
        mechanism: Mechanism,
        settings: Options,
        step: float,
        controls: Controls | Feedback | None = None,
    ) -> None:
        self.step = step
        self.mechanism = mechanism
        self.settings = settings
        explicit = settings["solver"].startswith(EXPLICIT)
        self._held: list[float] = []  # the answer of a feedback that acts now
        controls_at: Callable[[float], Sequence[float]] | None = None
        if isinstance(controls, Feedback):
            controls_at = self._held_answer
        elif controls is not None:
            # Stages are at the ends of a step and, in Kutta's method, in the middle of the step.
            controls_at = Tabulated(controls, 0.5 * step)
        self.built = build(mechanism, step, controls_at, explicit=explicit)
        self._sensors = [self._add_sensors(quantity) for quantity in QUANTITIES]
        self.built.system.Assemble()
        self._start_time = 0.0  # [s]
        self._latest = State(np.zeros(0), np.zeros(0))

    def _add_sensors(self, kind: Any) -> list[int]:
        """Adds a sensor of one kind of coordinates to each node; returns the numbers of the
        sensors."""
        return [
            self.built.system.AddSensor(
                items.SensorNode(
                    nodeNumber=node,
                    storeInternal=True,
                    writeToFile=False,
                    outputVariableType=kind,
                )
            )
            for node in self.built.nodes
        ]

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state, at a time [s]."""
        self._start_time = time
        self._latest = state
        data = self.built.system.systemData
        q, v = np.zeros((2, data.ODE2Size()))
        places = joint_places(self.mechanism.joints)
        for joint, (place, place_of_rates) in zip(self.built.joints, places, strict=True):
            q[joint.place], v[joint.place] = to_exudyn(
                joint, state.qpos[place], state.qvel[place_of_rates]
            )
        data.SetODE2Coordinates(q, configuration=INITIAL)
        data.SetODE2Coordinates_t(v, configuration=INITIAL)
        data.SetODE2Coordinates_tt(np.zeros(len(v)), configuration=INITIAL)
        data.SetAECoordinates(np.zeros(data.AEsize()), configuration=INITIAL)

    def state(self) -> State:
        """The present state. The sign of a quaternion is the sign that is nearer to the quaternion
        that was put or read last."""
        return self._latest

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps; the solver starts anew from the present state. Rows of `controls`
        are the answer of a feedback, the same in all steps. Without rows, the stepper has the
        controls as a function of the time."""
        if controls is not None:
            self._held = controls[0].tolist()
        self.run(steps)
        (state,) = self.states(np.array([steps]))
        self.put(state, self._start_time + steps * self.step)

    def _held_answer(self, now: float) -> Sequence[float]:
        """Returns the answer of a feedback that acts, whatever the time [s]."""
        return self._held

    def run(self, steps: int) -> None:
        """Takes `steps` steps from the state that was put last; `states` returns the states.
        Raises RuntimeError or ValueError if the solver fails."""
        options = self._options(steps)
        solver = getattr(exudyn.DynamicSolverType, self.settings["solver"])
        printing = exudyn.config.printToConsole
        exudyn.config.printToConsole = False  # Exudyn prints warnings about memory
        try:
            self.built.system.SolveDynamic(options, solverType=solver, showHints=False)
        finally:
            exudyn.config.printToConsole = printing

    def _options(self, steps: int) -> Any:
        """Exudyn's settings for a run of `steps` steps."""
        options = exudyn.SimulationSettings()
        integration = options.timeIntegration
        integration.startTime = self._start_time
        integration.endTime = self._start_time + steps * self.step
        integration.numberOfSteps = steps
        integration.verboseMode = 0
        integration.adaptiveStep = False
        if self.mechanism.touching:
            integration.discontinuous.useRecommendedStepSize = False
            integration.discontinuous.ignoreMaxIterations = True
            absolute_tolerance = rounding_of_forces(self.mechanism, self.step)
            integration.newton.absoluteTolerance = absolute_tolerance
        tolerance = self.settings.get("relativeTolerance")
        if tolerance is not None:
            integration.newton.relativeTolerance = tolerance
            integration.newton.absoluteTolerance = tolerance
        options.solution.file.write = False
        # With a period of half a step, the sensors keep every step in spite of rounding.
        options.solution.sensors.writePeriod = 0.5 * self.step
        return options

    def steps_of_last_run(self) -> int:
        """The number of steps that the last run took."""
        return len(self._stored(self._sensors[0][0])) - 1

    def states(self, numbers: Indices) -> list[State]:
        """The states of the last run after these `numbers` of steps."""
        q, v = (
            np.concatenate([self._stored(sensor)[numbers, 1:] for sensor in sensors], axis=1)
            for sensors in self._sensors
        )
        positions = list[Array]()
        velocities = list[Array]()
        places = joint_places(self.mechanism.joints)
        for joint, (place, _) in zip(self.built.joints, places, strict=True):
            position, rates = from_exudyn(joint, q[:, joint.place], v[:, joint.place])
            if joint.kind in TURNING:
                latest = self._latest.qpos[place][-4:]
                position[:, -4:] = _continuous(position[:, -4:], latest)
            positions.append(position)
            velocities.append(rates)
        return list(
            map(State, np.concatenate(positions, axis=1), np.concatenate(velocities, axis=1))
        )

    def _stored(self, sensor: int) -> Array:
        """The values that a sensor has kept: for each step a row with the time and the
        coordinates."""
        return np.atleast_2d(self.built.system.GetSensorStoredData(sensor))


def to_exudyn(joint: PlacedJoint, qpos: Array, qvel: Array) -> tuple[Array, Array]:
    """The coordinates of a joint and their rates in Exudyn, from those in MuJoCo. The attitude of a
    lone free body is a rotation vector. Other attitudes are angles about z, y and x."""
    if joint.kind not in TURNING:
        return qpos, qvel
    attitude = Rotation.from_quat(qpos[-4:], scalar_first=True)
    if joint.lone_free:
        return np.concatenate([qpos[:-4], attitude.as_rotvec()]), qvel
    angles = attitude.as_euler("ZYX")
    rates = np.linalg.solve(_spin_of_rates(angles[None])[0], qvel[-3:])
    return np.concatenate([qpos[:-4], angles]), np.concatenate([qvel[:-3], rates])


def from_exudyn(joint: PlacedJoint, q: Array, v: Array) -> tuple[Array, Array]:
    """The coordinates of a joint and their rates in MuJoCo, shape (n, ...), from those in Exudyn,
    `q` and `v`. A quaternion may have either sign."""
    if joint.kind not in TURNING:
        return q, v
    vector_or_angles = q[:, -3:]
    if joint.lone_free:
        attitude = Rotation.from_rotvec(vector_or_angles)
    else:
        attitude = Rotation.from_euler("ZYX", vector_or_angles)
    qpos = np.concatenate([q[:, :-3], attitude.as_quat(scalar_first=True)], axis=1)
    if joint.lone_free:
        return qpos, v
    rates = np.einsum("nij,nj->ni", _spin_of_rates(vector_or_angles), v[:, -3:])
    return qpos, np.concatenate([v[:, :-3], rates], axis=1)


def _spin_of_rates(angles: Array) -> Array:
    """Matrices, shape (n, 3, 3), one for each row of angles about z, y and x, shape (n, 3). A
    matrix times the rates of these angles is the angular velocity along the body's axes."""
    about_x = Rotation.from_euler("X", angles[:, 2:]).as_matrix()
    about_yx = Rotation.from_euler("YX", angles[:, 1:]).as_matrix()
    columns = [about_yx[:, 2], about_x[:, 1], np.broadcast_to(AXES[0], (len(angles), 3))]
    return np.stack(columns, axis=2)


def _continuous(attitudes: Array, latest: Array) -> Array:
    """The quaternions `attitudes`, shape (n, 4), with signs that make each quaternion nearer to the
    quaternion before it, and the first nearer to the `latest`: q and -q are the same attitude."""
    before = np.concatenate([latest[None], attitudes[:-1]])
    signs = np.where(np.einsum("ni,ni->n", before, attitudes) < 0.0, -1.0, 1.0)
    return attitudes * np.cumprod(signs)[:, None]
