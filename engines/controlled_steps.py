"""Steps of a stepper under the controls of a scene: given functions of time, or fed back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.sampled_control import HeldAnswers
from plumbob.engines.method import Unsupported
from plumbob.engines.stepper import State
from plumbob.models.model_file import Controls, Feedback

# Steps whose controls are read in one call, which takes as long as some hundred rows do.
READ_AHEAD = 1000


class Steps(Protocol):
    """The part of a stepper that controls need: its state, and its steps under rows of controls."""

    def state(self) -> State:
        """Returns the present state."""

    def advance(self, controls: Array | None, steps: int) -> None:
        """Takes `steps` steps under controls, shape (steps, controls)."""


TakeSteps = Callable[[int, int], None]
"""First index, last index -> nothing: takes the steps with these indices, the last one excluded."""


def controlled_steps(
    stepper: Steps, controls: Controls | Feedback | None, step: float, place: float = 0.0
) -> TakeSteps:
    """Returns a function that takes the steps [s] of one run of a stepper, in order. Controls that
    are functions of time are read at a `place` in each step: 0 is its begin, 0.5 its middle. A
    feedback is asked with the state of the stepper at each of its sampling times."""
    if isinstance(controls, Feedback):
        return _fed_back_steps(stepper, controls, step)
    if controls is None:
        return lambda first, last: stepper.advance(None, last - first)
    begin = 0
    rows = np.empty((0, 0))  # controls of the steps from `begin` on

    def take_steps(first: int, last: int) -> None:
        """Takes the steps under the controls at their times, which may have been read before."""
        nonlocal begin, rows
        if last > begin + len(rows):
            begin = first
            indices = np.arange(first, max(last, first + READ_AHEAD), dtype=np.float64)
            rows = controls((indices + place) * step)
        stepper.advance(rows[first - begin : last - begin], last - first)

    return take_steps


def _fed_back_steps(stepper: Steps, feedback: Feedback, step: float) -> TakeSteps:
    """Returns a function that takes the steps of one run under a feedback."""

    def ask(time: float) -> Array:
        """Returns the answer to the present state at the time [s] of a sample."""
        state = stepper.state()
        return feedback.answer(time, state.qpos, state.qvel)

    answers = HeldAnswers(feedback.times, step, ask, np.zeros(feedback.controls))

    def take_steps(first: int, last: int) -> None:
        """Takes the steps, each under the answer that acts in it."""
        for control, count in answers.parts(first, last):
            stepper.advance(np.tile(control, (count, 1)), count)

    return take_steps


def controls_at(controls: Controls | Feedback | None, times: Array) -> Array | None:
    """Returns the controls at times [s], shape (n, controls); None if nothing is controlled. Raises
    Unsupported for controls that are fed back."""
    function_of_time = given_controls(controls)
    return None if function_of_time is None else function_of_time(times)


def given_controls(controls: Controls | Feedback | None) -> Controls | None:
    """Returns controls that are functions of time. Raises Unsupported for controls that are fed
    back: they depend on a run, and cannot be computed before it."""
    if isinstance(controls, Feedback):
        raise Unsupported("its controls are fed back")
    return controls
