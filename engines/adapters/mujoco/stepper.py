"""A compiled MuJoCo model as a stepper: its state, its steps in C, the derivatives of a step."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.stepper import Diverged, State, StepDerivatives

PHYSICS = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)  # parts of a state: time, qpos, qvel, ...


class MujocoStepper:
    """A compiled model, stepped at the model's time step by the model's integrator."""

    alarms = slice(None)  # the kinds of MuJoCo's warnings that mean divergence

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData | None = None) -> None:
        """Steps the given `data` of the model, or new data."""
        self.model = model
        self.data = mujoco.MjData(model) if data is None else data
        # Numbers of warnings by kind: a view, since asking for it takes as long as a step.
        self.warned = self.data.warning.number

    @property
    def step(self) -> float:
        """The time step of the model [s]."""
        return float(self.model.opt.timestep)

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state, at a time [s]. The solver starts as in a new model."""
        data = self.data
        mujoco.mj_resetData(self.model, data)
        data.time = time
        data.qpos[:] = state.qpos
        data.qvel[:] = state.qvel
        data.act[:] = state.act

    def state(self) -> State:
        """The present state."""
        data = self.data
        return State(data.qpos.copy(), data.qvel.copy(), data.act.copy())

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, nu), or all in C if there are none.
        Raises Diverged if MuJoCo's warnings show that it has reset a state that is not finite."""
        model = self.model
        data = self.data
        if controls is None:
            mujoco.mj_step(model, data, steps)
        else:
            ctrl = data.ctrl
            for control in controls.tolist():
                ctrl[:] = control
                mujoco.mj_step(model, data)
        if any(self.warned[self.alarms].tolist()):
            raise Diverged

    def physics(self) -> Array:
        """MuJoCo's full physics state: all numbers on which the next step depends, apart from the
        controls and the start of the solver."""
        state = np.empty(mujoco.mj_stateSize(self.model, PHYSICS))
        mujoco.mj_getState(self.model, self.data, state, PHYSICS)
        return state

    def derivatives(self, control: Array, nudge: float) -> tuple[Array, Array]:
        """The derivatives of the state after the next step, under a `control` that is held, in
        tangent coordinates: by the present state, shape (2 nv + na, 2 nv + na), and by the control,
        shape (2 nv + na, nu). They are MuJoCo's central differences of size `nudge`."""
        model = self.model
        self.data.ctrl[:] = control
        size = 2 * model.nv + model.na
        by_state = np.zeros((size, size))
        by_control = np.zeros((size, model.nu))
        mujoco.mjd_transitionFD(model, self.data, nudge, True, by_state, by_control, None, None)
        return by_state, by_control

    def derivatives_of_steps(self, controls: Array, nudge: float) -> Iterator[StepDerivatives]:
        """The derivatives of each step under `controls`, shape (steps, nu), as that step is
        taken."""
        for control in controls:
            derivatives = self.derivatives(control, nudge)
            mujoco.mj_step(self.model, self.data)
            yield derivatives
