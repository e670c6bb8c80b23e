"""A user's model stepped from any state, by MuJoCo or by another engine that builds it from the
records of its mechanism. The errors of such a run come from the engine's step, its contacts and its
precision, and not from a reader of files."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.abilities import BuildsMechanisms
from plumbob.engines.audit.user_models import quiet
from plumbob.engines.derivative_ways import (
    STEP_NUDGE,
    TOUCHING_NUDGE,
    RunDerivatives,
    derivatives_of_steps,
    product_by_start_and_controls,
)
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Unsupported
from plumbob.engines.own_motion import (
    PERIOD_ROUNDING,
    Change,
    NotCertifiable,
    NotControlled,
    OwnModel,
    Script,
    Stepped,
)
from plumbob.engines.stepper import (
    Diverged,
    SceneMechanism,
    Stepper,
    TellsStepDerivatives,
)
from plumbob.engines.tangent_space import space_of_layout, state_row, tangent_space
from plumbob.models.border import border

FOR_PRODUCT = 0.5  # largest fraction of the time for the product of the derivatives of steps


@dataclass(frozen=True)
class BuiltSteppers:
    """Steppers of a model's mechanism in another engine, which builds it anew for each step
    size."""

    builds: BuildsMechanisms
    model: OwnModel

    @cached_property
    def _mechanism(self) -> Mechanism:
        """The mechanism of the model."""
        return self.model.mechanism()

    def stepper(self, method: str, step: float) -> Stepper:
        """Returns a stepper of the mechanism at a step [s], by the engine's only method. Raises
        Unsupported, which names the part of the mechanism that the engine cannot express."""
        with border(Unsupported, Unsupported):
            start = space_of_layout(self.model.layout).state_of(self.model.state)
            return self.builds.build(self._mechanism, start, step)

    function_stepper = stepper

    def changed(self, changes: Sequence[Change]) -> BuiltSteppers:
        """Returns the steppers of the model with changes."""
        return replace(self, model=self.model.changed(changes))


@dataclass(frozen=True)
class ScriptRuns:
    """Runs of a user's model by a stepper, with `parts` steps in a control period. All runs
    together take `seconds` of processor time at most."""

    model: OwnModel
    stepper: Stepper
    parts: int
    seconds: float = math.inf
    begin: float = field(default_factory=time.thread_time)

    def run(self, script: Script) -> Stepped:
        """Returns a run of the motion. Raises Unsupported if the time is spent before the end."""
        step = script.period / self.parts
        states = np.full((len(script.controls) + 1, script.start.size), np.nan)
        states[0] = script.start
        why = ""
        begin = time.thread_time()
        ask = script.new_run()
        with border(Unsupported, Unsupported, ParameterError):
            self.stepper.put(space_of_layout(self.model.layout).state_of(script.start))
            for k in range(len(script.controls)):
                end_of_period = f"{(k + 1) * script.period:.3g} s"
                why = f"diverged within {end_of_period}"
                try:
                    control = ask(k, states[k])
                except NotControlled as reason:
                    why = str(reason)
                    break
                with suppress(Diverged):
                    self.stepper.advance(np.tile(control, (self.parts, 1)), self.parts)
                    numbers = state_row(self.stepper.state())
                    states[k + 1] = np.concatenate([numbers, script.start[numbers.size :]])
                if not np.isfinite(states[k + 1]).all():
                    break
                why = ""
                if time.thread_time() - self.begin > self.seconds:
                    raise Unsupported(f"{self.seconds:g} s were enough for {end_of_period}")
        return Stepped(step, states, time.thread_time() - begin, why)

    def product(self, script: Script) -> RunDerivatives:
        """Returns the derivatives of the positions at the ends of the periods by the state at the
        start and by constant additions to the controls. They are products of the derivatives of
        steps: the engine's own derivatives if it has any, else central differences."""
        controls = np.repeat(script.controls, self.parts, axis=0)
        space = space_of_layout(self.model.layout)
        if isinstance(self.stepper, TellsStepDerivatives):
            name = self.stepper.own_way
            self.stepper.put(space.state_of(script.start))
            steps = self.stepper.own_step_derivatives(controls)
        else:
            name = "product"
            mechanism = self.model.mechanism()
            steps = derivatives_of_steps(
                self.stepper,
                space,
                script.start,
                controls,
                TOUCHING_NUDGE if mechanism.touching else STEP_NUDGE,
                time.process_time() + FOR_PRODUCT * self.seconds,
            )
        size = space.size(script.start)
        inputs = script.controls.shape[1]
        try:
            with quiet():
                along = product_by_start_and_controls(
                    steps, size, space.velocities, inputs, self.parts
                )
        except NotCertifiable as reason:
            return RunDerivatives(name, None, why=str(reason))
        return RunDerivatives(name, along)


def built_runs(
    builds: BuildsMechanisms, model: OwnModel, script: Script, parts: int, seconds: float
) -> ScriptRuns:
    """Returns runs of a motion by a stepper that an engine builds. Raises Unsupported if the engine
    cannot express a part of the mechanism, and names that part."""
    stepper = BuiltSteppers(builds, model).stepper(builds.method, script.period / parts)
    return ScriptRuns(model, stepper, parts, seconds)


def script_scene(mechanism: Mechanism, script: Script) -> SceneMechanism:
    """Returns the mechanism of a model with the start and the controls of a motion."""

    def controls(times: Array) -> Array:
        period = np.floor(times / script.period * (1.0 + PERIOD_ROUNDING)).astype(int)
        return np.asarray(script.controls[np.minimum(period, len(script.controls) - 1)])

    start = tangent_space(mechanism).state_of(script.start)
    controlled = script.controls.shape[1] > 0
    return SceneMechanism(mechanism, start, controls if controlled else None)
