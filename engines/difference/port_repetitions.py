"""The motion of a user's model, computed again by ports of MuJoCo: alone and at several places of a
batch, in the precisions that each port has."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import Copies, RunsCopies
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.user_models import quiet
from plumbob.engines.difference.band import BandMeasurement
from plumbob.engines.difference.recording import DOUBLE, SINGLE, Recording
from plumbob.engines.difference.repetitions import (
    BAND_TIME,
    RepeatedMotion,
    Repeater,
    Repetition,
    compared_with_band,
    most_apart,
    recorded_run,
    samples_of,
    start_of,
)
from plumbob.engines.difference.sample_steps import SampleSteps
from plumbob.engines.difference.steps_beside import (
    OtherStep,
    OwnStep,
    OwnSteps,
    StepsBeside,
    compared_steps,
)
from plumbob.engines.own_motion import NotCertifiable, OwnModel, Script
from plumbob.engines.peer_model import RefusedFile
from plumbob.engines.recorded_step import StepInput, StepOutcome
from plumbob.engines.registry import engines, find_engine, installed
from plumbob.engines.workers import Lost, Task, Workers
from plumbob.models.entry_points import captured

WORLDS = 8  # copies in a batch
PLACES = (0, 3, 7)  # places of the motion in a batch; the others hold other states of it
PORT_STEPS_TIME = 0.3  # part of the time in which the steps of a port are checked
HANGS = 600.0  # [s] processor time beside the allowed one: ports compile


def repeated_motion(
    model: OwnModel,
    script: Script,
    control: str,
    allowance: Allowance,
    engine_names: Sequence[str] = (),
) -> RepeatedMotion:
    """Steps a model with its own integrator and step under a script, and returns that run with its
    repetitions in MuJoCo and in the named ports. Raises NotCertifiable if the model's own run
    diverges at once, or has too many steps."""
    began = time.perf_counter()
    start = start_of(script, model)
    recording = recorded_run(model, start, "own")
    if len(recording.times) < 3:
        raise NotCertifiable("its own steps diverge within two steps")
    rows = list(Repeater(model, start, recording, allowance).repetitions())
    given = (engine_names, allowance.seconds, allowance.progress)
    rows += port_repetitions(model, start, recording, *given)
    return RepeatedMotion(
        model=model,
        script=script,
        control=control,
        recording=recording,
        repetitions=tuple(rows),
        seconds=time.perf_counter() - began,
    )


def ports() -> tuple[str, ...]:
    """Returns the names of the installed engines that run copies of MuJoCo's models."""
    able = (engine for engine in engines().values() if engine.ability(RunsCopies) is not None)
    return tuple(engine.name for engine in able if installed(engine))


def port_repetitions(
    model: OwnModel,
    start: StepInput,
    recording: Recording,
    names: Sequence[str],
    seconds: float,
    progress: Callable[[str], None],
) -> Iterator[Repetition]:
    """Yields the repetitions of a recorded run by each precision of the named engines. Each has a
    process of its own, and about `seconds` of processor time beside the time to compile."""
    tasks = []
    for name in dict.fromkeys(names):
        if not installed(find_engine(name)):
            yield Repetition(name, "port", "it is not installed")
            continue
        ability = find_engine(name).ability(RunsCopies)
        for double in ability.doubles if ability else ():
            label = f"{name} in {'double' if double else 'single'} precision"
            arguments = (label, name, double, model, start, recording, seconds)
            task = Task(label, _repetitions, arguments, HANGS + 2.0 * seconds, label=label)
            tasks.append(task)
    with Workers(1) as workers:
        for task, rows in workers.results(tasks, lambda task: progress(task.label)):
            if isinstance(rows, Lost):
                yield Repetition(task.label, "port", rows.why)
            else:
                yield from rows


def _repetitions(
    label: str,
    name: str,
    double: bool,
    model: OwnModel,
    start: StepInput,
    recording: Recording,
    seconds: float,
) -> list[Repetition]:
    """Returns the repetitions of a recorded run by an engine in a precision: alone, and in a
    batch."""
    ability = find_engine(name).ability(RunsCopies)
    assert ability is not None
    recording = replace(recording, resolution=DOUBLE if double else SINGLE)
    with captured(), quiet():
        try:
            copies = ability.make(model.as_stepped(), double)
            alone = copies.run(start.state[None], start.warm_start[None], start.controls[None])
        except RefusedFile as why:
            return [Repetition(label, "port", f"it refuses the model: {why}")]
        rows = []
        if np.isfinite(alone).all():
            rows = [_in_a_batch(label, copies, model, start, recording, alone[0], seconds)]
        own = OwnSteps(samples_of(model, recording))
        row = compared_with_band(_band(own.samples, seconds), label, "port", alone[0])
        # The batch before has compiled the port's step: its time does not count.
        steps = _steps(own, copies, model, Allowance(PORT_STEPS_TIME * seconds))
        return [replace(row, steps=steps), *rows]


def _band(samples: SampleSteps, seconds: float) -> BandMeasurement:
    """Returns the measurement of the band along the recording of `samples`."""
    return BandMeasurement(samples, Allowance(BAND_TIME * seconds), samples.precision)


def _in_a_batch(
    label: str,
    copies: Copies,
    model: OwnModel,
    start: StepInput,
    recording: Recording,
    alone: Array,
    seconds: float,
) -> Repetition:
    """Returns the repetition of a motion at several places of a batch, beside the same motion
    `alone`, whose states have the shape (steps + 1, n)."""
    count = len(recording.states)
    rows = np.linspace(0, count - 1, WORLDS, dtype=int)
    states = recording.states[rows]
    states[list(PLACES)] = start.state
    warm_starts = np.tile(start.warm_start, (WORLDS, 1))
    controls = np.tile(start.controls, (WORLDS, 1, 1))
    runs = copies.run(states, warm_starts, controls)[list(PLACES)]
    samples = samples_of(model, replace(recording, states=alone[:count]))
    run = most_apart(alone[:count], runs)
    name = f"{label}, at {len(PLACES)} places of a batch"
    return compared_with_band(_band(samples, seconds), name, "port", run)


def _steps(own: OwnSteps, copies: Copies, model: OwnModel, allowance: Allowance) -> StepsBeside:
    """Returns the single steps of a port beside those of a model."""
    outcomes = _outcomes(own, copies)

    def take(step: OwnStep) -> OtherStep:
        """Returns the step of the port. What its solver leaves is not known: it is allowed as much
        as the model's own."""
        return OtherStep(next(outcomes), step.converged, step.allowed.solver)

    steps = compared_steps(own, take, allowance)
    if not steps.use > 1.0:
        return steps
    samples = own.samples
    first = own[int(np.searchsorted(samples.recording.times, steps.begin))]
    touching = model.touching_in(copies.port, first.before, first.outcome.touching)
    differing = set(touching) ^ set(first.outcome.touching)
    if differing:
        names = samples.steps.names_of(tuple(sorted(differing)))
        return replace(steps, term="contact set", part=", ".join(names), there=(0.0, 0.0))
    return steps


def _outcomes(own: OwnSteps, copies: Copies) -> Iterator[StepOutcome]:
    """Yields the outcomes of the steps of a port from all samples of a recording, which are taken
    WORLDS at a time."""
    intervals = own.samples.intervals
    for first in range(0, intervals, WORLDS):
        rows = [min(first + number, intervals - 1) for number in range(WORLDS)]
        befores = [own[row].before for row in rows]
        after = copies.run(
            np.array([before.state for before in befores]),
            np.array([before.warm_start for before in befores]),
            np.array([before.controls for before in befores]),
        )
        for row, state in zip(rows, after[:, -1], strict=True):
            outcome = own[row].outcome
            yield replace(outcome, state=state)
