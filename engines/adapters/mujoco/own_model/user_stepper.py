"""A user's model, stepped from any state by an integrator at a time step."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.mujoco.options import integrator_number
from plumbob.engines.adapters.mujoco.stepper import MujocoStepper
from plumbob.engines.adapters.mujoco.transition import difference_size
from plumbob.engines.own_motion import NotCertifiable
from plumbob.engines.stepper import State, StepDerivatives

# MuJoCo's warnings that positions, velocities or accelerations have no bounds
_BAD = slice(int(mujoco.mjtWarning.mjWARN_BADQPOS), int(mujoco.mjtWarning.mjWARN_BADQACC) + 1)


def diverged(data: Any) -> bool:
    """Whether MuJoCo has warned of numbers without bounds, or a position is not finite."""
    return bool(data.warning.number[_BAD].any() or not np.isfinite(data.qpos).all())


def like_start(data: Any, start: Any) -> Any:
    """Returns the mjData `data` with the mocap poses and the active constraints of another,
    `start`."""
    if data.mocap_pos.size:
        data.mocap_pos[:] = start.mocap_pos
        data.mocap_quat[:] = start.mocap_quat
    data.eq_active[:] = start.eq_active
    return data


class UserStepper(MujocoStepper):
    """Steps a model that several steppers share with its mjData. Each stepper sets its integrator
    and its step when it is put; its steps end before another is put."""

    alarms = _BAD
    own_way = "transition"

    def __init__(self, model: Any, data: Any, start: Any, integrator: str, step: float) -> None:
        """Takes the mocap poses and the active constraints of the mjData `start`."""
        super().__init__(model, data)
        self._start = start
        self._integrator, self._step = integrator_number(integrator), step

    @property
    def step(self) -> float:
        """The time step [s]."""
        return self._step

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state, at a time [s]. The solver begins as in a new model."""
        self.model.opt.timestep, self.model.opt.integrator = self._step, self._integrator
        super().put(state, time)
        like_start(self.data, self._start)

    def own_step_derivatives(self, controls: Array) -> Iterator[StepDerivatives]:
        """Yields the derivatives of each step under `controls` by `mjd_transitionFD`, while the
        step is taken. Raises NotCertifiable if MuJoCo has none, or the run diverges."""
        if self.model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
            raise NotCertifiable("mjd_transitionFD refuses RK4")
        steps = self.derivatives_of_steps(controls, difference_size(self.model))
        for number, step in enumerate(steps, 1):
            if diverged(self.data):
                raise NotCertifiable(f"its run diverges within {number * self.step:g} s")
            yield step
