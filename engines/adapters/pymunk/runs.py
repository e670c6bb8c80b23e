"""Simulations of scenes in pymunk."""

from __future__ import annotations

from collections.abc import Sequence

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
        return planar_stepper(mechanism, start, method, step)

    return simulated(case, step, stepper_of)


def _built(scene: Translation, step: float) -> Built:
    """A scene at its start, ready to be advanced and read. If the scene has observables of the step
    that begins at a sample, each sample is completed when that step is done."""
    move = scene.space.step
    act = scene.act
    following = scene.following
    sample: dict[str, float] = {}  # the latest sample
    taken = 0

    def take(first: int, last: int) -> None:
        if act is None:
            for _ in range(first, last):
                move(step)
        else:
            for n in range(first, last):
                act(n * step)
                move(step)

    def advance(first: int, last: int) -> None:
        """Takes the steps from number `first` to `last`; the step `first` is followed step by step
        if a follower is given."""
        nonlocal taken
        taken, middle = last, first
        if following is not None:
            follow(first)
            middle = first + 1
        take(middle, last)

    def follow(first: int) -> None:
        take(first, first + 1)
        assert following is not None
        sample.update(following())

    def read() -> ByName:
        nonlocal sample
        sample = {**scene.read()}
        return sample

    def gather(rows: Sequence[ByName]) -> Observed:
        if following is not None:
            follow(taken)
        return by_name(rows)

    return Built(advance, read, scene.limits, gather)
