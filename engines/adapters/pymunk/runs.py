"""Simulations of scenes in pymunk."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

from plumbob.engines.adapters.pymunk.simulation import Translation
from plumbob.engines.adapters.pymunk.stepper import planar_stepper
from plumbob.engines.adapters.stepped_mechanism import simulated
from plumbob.engines.adapters.stepping import (
    Built,
    Observed,
    SteppedSimulation,
    by_name,
    stepped,
)
from plumbob.engines.mechanism import Mechanism
from plumbob.engines.method import Method
from plumbob.engines.registry import builder
from plumbob.engines.stepper import State, Stepper
from plumbob.engines.trajectory import ByName
from plumbob.models.scene import Case


def prepared(case: Case, method: Method, step: float) -> SteppedSimulation:
    """The simulation of a case by a method at `step` [s]: by the builder of the system if there is
    one, else by the mechanism of the system's model file. Raises Unsupported and ParameterError."""
    module = builder("pymunk", case.system)
    if module is not None:
        build = module.build
        return stepped(case, step, lambda: _built(build(case.problem, method, step), step))

    def stepper_of(mechanism: Mechanism, start: State) -> Stepper:
        """The stepper of a mechanism by the method."""
        return planar_stepper(mechanism, start, method, step)

    return simulated(case, step, stepper_of)


def _built(scene: Translation, step: float) -> Built:
    """A scene at its start, ready to be advanced in steps of `step` [s] and read."""
    if scene.following is None:
        return Built(partial(_take, scene, step), scene.read, scene.limits)
    followed = FollowedSamples(scene, step, scene.following)
    return Built(followed.advance, followed.read, scene.limits, followed.gather)


def _take(scene: Translation, step: float, first: int, last: int) -> None:
    """Takes the steps `first` to `last` - 1 of `step` [s]."""
    move = scene.space.step
    act = scene.act
    if act is None:
        for _ in range(first, last):
            move(step)
        return
    for number in range(first, last):
        act(number * step)
        move(step)


@dataclass
class FollowedSamples:
    """Steps of a scene with observables of the step that begins at a sample. A sample is completed
    when that step is done."""

    scene: Translation
    step: float  # [s]
    following: Callable[[], ByName]
    steps_taken: int = 0
    sample: dict[str, float] = field(default_factory=dict)  # the latest sample

    def advance(self, first: int, last: int) -> None:
        """Takes the steps `first` to `last` - 1."""
        self._complete_sample(first)
        _take(self.scene, self.step, first + 1, last)
        self.steps_taken = last

    def _complete_sample(self, number: int) -> None:
        """Takes the step with this number, and adds its observables to the latest sample."""
        _take(self.scene, self.step, number, number + 1)
        self.sample.update(self.following())

    def read(self) -> ByName:
        """The observables of the present state, to which those of the next step are added later."""
        self.sample = {**self.scene.read()}
        return self.sample

    def gather(self, samples: Sequence[ByName]) -> Observed:
        """The observables of all samples, the last of which is completed by a further step."""
        self._complete_sample(self.steps_taken)
        return by_name(samples)
