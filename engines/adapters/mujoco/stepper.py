"""A compiled MuJoCo model as a stepper: its state, its steps in C, the derivatives of a step."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.stepper import Diverged, State, StepDerivatives

PHYSICS = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)  # time, qpos, qvel and so on


class MujocoStepper:
    """A compiled model, stepped at its own time step by its own integrator."""

    alarms = slice(None)  # which of MuJoCo's warnings tell that a run diverges

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData | None = None) -> None:
        """In a state of its own, or in the `data` of the model."""
        self.model = model
        self.data = mujoco.MjData(model) if data is None else data

    @property
    def step(self) -> float:
        """[s]"""
        return float(self.model.opt.timestep)

    def put(self, state: State, time: float = 0.0) -> None:
        """Set the state, at a time [s]; the solver begins as in a new model."""
        data = self.data
        mujoco.mj_resetData(self.model, data)
        data.time = time
        data.qpos[:] = state.qpos
        data.qvel[:] = state.qvel
        data.act[:] = state.act

    def state(self) -> State:
        """The state now."""
        data = self.data
        return State(data.qpos.copy(), data.qvel.copy(), data.act.copy())

    def advance(self, controls: Array | None, steps: int) -> None:
        """Take `steps` steps, all in C where no control changes, else under controls, shape (steps,
        nu). Raises Diverged if MuJoCo resets a state that is not finite, as its warnings show."""
        model = self.model
        data = self.data
        if controls is None:
            mujoco.mj_step(model, data, steps)
        else:
            for control in controls.tolist():
                data.ctrl[:] = control
                mujoco.mj_step(model, data)
        if data.warning.number[self.alarms].any():
            raise Diverged

    def physics(self) -> Array:
        """All that the next step depends on, apart from controls and the solver's start: MuJoCo's
        full physics state."""
        state = np.empty(mujoco.mj_stateSize(self.model, PHYSICS))
        mujoco.mj_getState(self.model, self.data, state, PHYSICS)
        return state

    def derivatives(self, control: Array, nudge: float) -> tuple[Array, Array]:
        """The derivatives of the state after the next step, which a `control` is held for, by the
        state now, shape (2 nv + na, 2 nv + na) in tangent coordinates, and by the control, shape
        (2 nv + na, nu), from MuJoCo's central differences of size `nudge`."""
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
