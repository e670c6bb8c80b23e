"""The motion of a user's model in another engine that builds it from the records of its mechanism:
what is wrong there is the engine's step, its contacts and its precision, and no importer's."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import BuildsMechanisms
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Unsupported
from plumbob.engines.own_motion import Change, OwnModel, Script, Stepped
from plumbob.engines.stepper import State, Stepper
from plumbob.models.border import border


@dataclass(frozen=True)
class BuiltSteppers:
    """The mechanism of a model in an engine that builds it anew for each step size."""

    builds: BuildsMechanisms
    model: OwnModel

    @cached_property
    def _mechanism(self) -> Mechanism:
        return self.model.mechanism()

    def stepper(self, method: str, step: float) -> Stepper:
        """The mechanism at a step [s], by the engine's one method. Raises Unsupported, which names
        the part of the mechanism that the engine does not express."""
        with border(Unsupported, Unsupported):
            return self.builds.build(
                self._mechanism, _split(self.model.state, self.model), step
            )

    function_stepper = stepper

    def changed(self, changes: Sequence[Change]) -> BuiltSteppers:
        """The steppers of the model with changes."""
        return replace(self, model=self.model.changed(changes))


def built_motion(
    builds: BuildsMechanisms, model: OwnModel, script: Script, parts: int, seconds: float
) -> Stepped:
    """A run with `parts` steps in a control period in an engine that builds the mechanism of a
    model. Raises Unsupported if the engine cannot express a part of the mechanism, and names that
    part, or if the run takes more than so many `seconds` of processor time."""
    step = script.period / parts
    states = np.full((len(script.controls) + 1, script.start.size), np.nan)
    states[0] = script.start
    with border(Unsupported, Unsupported):
        start = _split(script.start, model)
        stepper = builds.build(model.mechanism(), start, step)
        stepper.put(start)
        why = ""
        begin = time.thread_time()
        for k, control in enumerate(script.controls):
            stepper.advance(np.tile(control, (parts, 1)), parts)
            now = stepper.state()
            moved = [now.qpos, now.qvel]
            states[k + 1] = np.concatenate([*moved, script.start[sum(map(len, moved)) :]])
            at = f"{(k + 1) * script.period:.3g} s"
            if not np.isfinite(states[k + 1]).all():
                why = f"it diverges within {at}"
                break
            if time.thread_time() - begin > seconds:
                raise Unsupported(f"{seconds:g} s were enough for {at}")
        return Stepped(step, states, time.thread_time() - begin, why)


def _split(state: Array, model: OwnModel) -> State:
    """A state of the audit as positions and velocities; a mechanism has no activations."""
    velocity = model.layout.velocity
    return State(state[: velocity.start], state[velocity])
