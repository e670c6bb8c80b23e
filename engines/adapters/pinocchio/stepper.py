"""A mechanism in Pinocchio, which an integrator of this package steps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.equation import Equation
from plumbob.engines.adapters.integrators import advancing
from plumbob.engines.adapters.pinocchio.builder import Dynamics
from plumbob.engines.adapters.step_clock import StepClock
from plumbob.engines.adapters.turning import TurningEquation
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.stepper import State
from plumbob.models.model_file import Controls


class PinocchioStepper:
    """A mechanism in Pinocchio, which the integrator with this name in a `Scheme` steps by `step`
    [s] from any state. With `controls_at`, a function of the time, controls are evaluated at the
    times of the integrator's stages. Without it, the controls of `advance` are held for a step."""

    def __init__(
        self,
        mechanism: Mechanism,
        integrator: str,
        step: float,
        controls_at: Controls | None = None,
    ) -> None:
        self.step = step
        self.dynamics = Dynamics(mechanism)
        self._controls_at = controls_at
        self._controls: Sequence[float] = self.dynamics.idle
        self._clock = StepClock(step)
        self._state: tuple[Any, Any] = (np.zeros(0), np.zeros(0))
        attitudes = self.dynamics.attitudes
        # The start is set by `put`, and no tolerance needs the scale of the rates, 1.
        fields = (self._acceleration, *self._state, 1.0)
        self._equation = Equation(*fields)
        if attitudes:
            self._equation = TurningEquation(*fields, attitudes=attitudes)
        self._advance = advancing(self._equation, integrator)

    def put(self, state: State, time: float = 0.0) -> None:
        """Sets the state, at a time [s]."""
        self._clock.restart(time)
        self._state = (state.qpos.copy(), state.qvel.copy())

    def state(self) -> State:
        """The present state."""
        return State(*self._state)

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, controls), or with controls that are
        zero."""
        if controls is None:
            self._controls = self.dynamics.idle
            self._take(steps)
            return
        for row in controls.tolist():
            self._controls = row
            self._take(1)

    def _take(self, steps: int) -> None:
        """Takes `steps` steps under the present controls."""
        first = self._clock.steps_taken
        last = first + steps
        self._state = self._advance(self._equation, self._state, first, last, self.step)
        self._clock.steps_taken = last

    def _acceleration(self, time: float, qpos: Array, qvel: Array) -> Array:
        """The accelerations at a time [s] since the state was put."""
        now = self._clock.start + time
        controls = self._controls
        if self._controls_at is not None:
            controls = self._controls_at(np.array([now]))[0].tolist()
        return self.dynamics.acceleration(now, qpos, qvel, controls)
