"""Runs of a stepper from a state and from a nearby state, and the growth of the nudge between
them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.method import Unsupported
from plumbob.engines.own_motion import NotCertifiable
from plumbob.engines.step_jacobian import check_time
from plumbob.engines.stepper import Stepper
from plumbob.engines.tangent_space import TangentSpace, state_row
from plumbob.models.border import Refused, border

# Size of a nudge [m, rad, ...] in a random direction. An unstable contact chatters: the growth of a
# nudge ends when the contact opens, at some 1e-5 m, which must be more than a thousandfold growth.
STATE_NUDGE = 1e-9
# Largest magnitude of a state [m, rad, m/s, ...] at which doubles resolve a nudge. Some engines
# keep velocities within bounds and never report that a run diverges.
LARGEST_NUDGED_NUMBER = STATE_NUDGE / np.finfo(float).eps
LAST = 10  # the last steps of a run are its last tenth


@dataclass(frozen=True)
class NudgedRuns:
    """Runs of a stepper from any state, until the processor time `ends` [s]."""

    stepper: Stepper
    space: TangentSpace
    ends: float = math.inf

    def states(self, start: Array, controls: Array) -> Array | None:
        """Returns the states after each step of a run from `start` under controls, a row for each
        step, shape (steps, n); None if the run diverges. Raises NotCertifiable when the time
        ends."""
        stepper = self.stepper
        states = np.empty((len(controls), start.size))
        try:
            with border(Refused, Unsupported, ParameterError, NotCertifiable):
                stepper.put(self.space.state_of(start))
                for number in range(len(controls)):
                    check_time(self.ends)
                    stepper.advance(controls[number : number + 1], 1)
                    states[number] = state_row(stepper.state())
        except Refused:
            return None
        return states if np.abs(states).max(initial=0.0) < LARGEST_NUDGED_NUMBER else None

    def growth(self, start: Array, controls: Array) -> float:
        """Returns the largest ratio of the difference of the positions of two runs to the nudge of
        `start` between them; infinite if a run diverges."""
        change = np.random.default_rng(0).standard_normal(self.space.size(start))
        change *= STATE_NUDGE / np.abs(change).max()
        states = self.states(start, controls)
        if states is None:
            return math.inf
        nudged = self.states(self.space.shifted(start, change), controls)
        if nudged is None:
            return math.inf
        changes = self.space.differences(states, nudged)[:, : self.space.velocities]
        return float(np.abs(changes).max()) / STATE_NUDGE

    def last_velocity(self, start: Array, controls: Array) -> float:
        """Returns the largest velocity of a degree of freedom [m/s, rad/s] in the last tenth of a
        run; infinite if the run diverges."""
        states = self.states(start, controls)
        if states is None:
            return math.inf
        first = self.space.positions
        velocities = states[len(states) - len(states) // LAST :, first:]
        return float(np.abs(velocities[:, : self.space.velocities]).max(initial=0.0))
