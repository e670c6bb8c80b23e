"""Episodes: how much of a return is the time step's? Each episode has a start of its own, from
which runs at several steps begin."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.mean_returns import HALVED, EpisodeReturns, Setting, returns_of
from plumbob.engines.audit.user_models import quietly
from plumbob.engines.closed_loop import NamedFunction, NamedPolicy, name_of_function
from plumbob.engines.own_motion import OwnModel, Script, Stepped
from plumbob.engines.study import store
from plumbob.engines.study.checkpoint import key_of
from plumbob.engines.study.store_file import writing
from plumbob.engines.tangent_space import space_of_layout
from plumbob.engines.workers import Lost, Task, Workers, results
from plumbob.models.border import must_be
from plumbob.models.entry_points import on_stderr

# [m, rad, and these per second] default largest change of a coordinate of the start
START_SPREAD = 0.01
MOST_SPREAD = 1e6  # [m, rad, and per second] beyond it no start is a robot's
MOST_EPISODES = 100_000
HANGS = 600.0  # [s] processor time of a task with episodes after which its process hangs
TASKS = 4  # tasks with episodes for each process: processes end at about one time
Metric = Callable[..., Any]
"""Times [s], shape (n + 1,), positions, velocities, and controls, shape (n, actuators), of an
episode -> its return, a number."""


class NamedMetric(NamedFunction):
    """A metric MODULE:FUNCTION."""

    option = "metric"
    wanted = "MODULE:FUNCTION, a function of times, qpos, qvel and controls"


@dataclass(frozen=True)
class EpisodePlan:
    """So many episodes (`count`). For a model, a `metric` gives the return of each, and `spread`
    says by how much each coordinate and velocity of a start is moved at most, in m, rad, and per
    second; an environment has rewards and resets of its own. Outcomes are stored in a `file`, if
    given, and read from it. Raises ParameterError."""

    count: int
    metric: Metric | NamedMetric | None = None
    spread: float = START_SPREAD
    file: Path | None = None

    def __post_init__(self) -> None:
        if isinstance(self.count, bool) or not 2 <= self.count <= MOST_EPISODES:
            raise ParameterError("episodes", self.count, f"a number from 2 to {MOST_EPISODES}")
        if positive("spread", self.spread) > MOST_SPREAD:
            raise ParameterError("spread", self.spread, f"at most {MOST_SPREAD:g}")


class Episodes(Protocol):
    """Episodes, each with a start of its own."""

    @property
    def model(self) -> OwnModel: ...
    @property
    def script(self) -> Script: ...
    @property
    def names(self) -> tuple[str, ...]:
        """The names that tell these episodes from others of the same model and script."""

    @property
    def shareable(self) -> bool:
        """Whether other processes can run them."""

    def outcome(self, number: int, setting: Setting) -> tuple[float, float]:
        """Returns the return of an episode at a setting, and its duration [s]; NaN if the run is
        lost. Raises ParameterError."""


@dataclass(frozen=True)
class ModelEpisodes:
    """The episodes of a model: runs of a script from starts that are spread, whose returns a metric
    computes."""

    model: OwnModel
    script: Script
    metric: Metric | NamedMetric
    spread: float = START_SPREAD

    @cached_property
    def _loaded(self) -> Metric:
        """The metric as a function."""
        return self.metric.load() if isinstance(self.metric, NamedMetric) else self.metric

    @property
    def _asked(self) -> Any:
        """The policy in the loop; None if controls are replayed."""
        return getattr(self.script.loop, "policy", None)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the policy and of the metric, and the spread of starts."""
        policy = "" if self._asked is None else name_of_function(self._asked)
        return policy, name_of_function(self.metric), f"{self.spread:g}"

    @property
    def shareable(self) -> bool:
        """Whether the policy and the metric have names, by which other processes load them."""
        named = self._asked is None or isinstance(self._asked, NamedPolicy)
        return named and isinstance(self.metric, NamedMetric)

    def start(self, number: int) -> Array:
        """Returns the start of an episode: each coordinate and velocity of the script's start is
        moved by up to the spread, uniformly, by the random numbers of that episode."""
        space = space_of_layout(self.model.layout)
        size = 2 * space.velocities
        draw = np.random.default_rng(number)
        shift = np.zeros(space.size(self.model.state))
        shift[:size] = draw.uniform(-self.spread, self.spread, size)
        return self.model.shifted(self.script.start, shift)

    def outcome(self, number: int, setting: Setting) -> tuple[float, float]:
        """Returns the return of an episode at a setting, and its duration [s]; NaN if the run ends
        early. Raises ParameterError."""
        script = replace(self.script, start=self.start(number))
        run = self.model.stepped(script, setting.integrator, setting.parts)
        if run.why:
            return math.nan, math.nan
        return self._measured(run, script), script.duration

    def _measured(self, run: Stepped, script: Script) -> float:
        """Returns the metric of a run. Raises ParameterError unless it is a finite number."""
        velocities = self.model.layout.velocity
        states = run.states
        wanted = "a function of times, qpos, qvel and controls that returns a finite number"
        arguments = (
            script.times,
            states[:, : velocities.start].copy(),
            states[:, velocities].copy(),
            run.controls.copy(),
        )
        with must_be(wanted, "metric", name_of_function(self.metric)), on_stderr():
            value = float(self._loaded(*arguments))
        if not math.isfinite(value):
            raise ParameterError(
                "metric", name_of_function(self.metric), f"{wanted}, not {value}"
            )
        return value


Outcomes = tuple[tuple[float, float], ...]
"""The return and the duration [s] of an episode at each setting; NaN where the run is lost."""


@dataclass(frozen=True)
class EpisodeOutcomes:
    """The outcomes of an episode, as they are stored."""

    outcomes: Outcomes


def episode_returns(
    episodes: Episodes, plan: EpisodePlan, allowance: Allowance
) -> EpisodeReturns:
    """Returns the returns of the episodes at the model's own step, at halves of it, and with other
    integrators at the model's own step; by several processes, if the allowance has them. Fewer are
    run if they take more processor time than is allowed, but at least two. Raises
    ParameterError."""
    settings = settings_of(episodes)
    with _kept(episodes, settings, plan) as (known, keep):
        missing = [number for number in range(plan.count) if number not in known]
        left = allowance.seconds
        for numbers, outcomes, seconds in _run(episodes, settings, missing, allowance):
            for number, outcome in zip(numbers, outcomes, strict=True):
                known[number] = outcome
                keep(number, outcome)
            allowance.progress(f"episode {len(known)} of {plan.count}")
            left -= seconds
            if left < 0.0 and len(known) >= 2:
                break
    table = np.array([known[number] for number in sorted(known)])
    found = returns_of(settings, table, plan.count)
    if found is None:
        wanted = "so many that two reach their end at the own step"
        raise ParameterError("episodes", plan.count, wanted)
    return found


def settings_of(episodes: Episodes) -> list[Setting]:
    """Returns the settings at which episodes are run: the model's own first, its halves next."""
    model, period = episodes.model, episodes.script.period
    own = episodes.script.parts(model.step)
    pairs = [(model.integrator, own * finer) for finer in HALVED]
    pairs += [(other, own) for other in model.integrators[1:]]
    return [Setting(name, period / parts, parts) for name, parts in pairs]


def _run(
    episodes: Episodes,
    settings: Sequence[Setting],
    missing: Sequence[int],
    allowance: Allowance,
) -> Iterator[tuple[tuple[int, ...], list[Outcomes], float]]:
    """Yields the numbers and outcomes of some of the `missing` episodes after the other, and the
    processor time [s] that they took. Raises ParameterError."""
    workers = allowance.executor
    several = isinstance(workers, Workers) and workers.count > 1 and episodes.shareable
    size = 1
    if isinstance(workers, Workers) and several:
        size = max(1, math.ceil(len(missing) / (TASKS * workers.count)))
    parts = [tuple(missing[k : k + size]) for k in range(0, len(missing), size)]
    limit = HANGS + allowance.seconds
    tasks = [
        Task(numbers, quietly, (outcomes_of, episodes, settings, numbers), limit)
        for numbers in parts
    ]
    for task, answer in results(tasks, workers if several else None):
        if isinstance(answer, Lost):
            numbers = ", ".join(map(str, task.key))
            raise ParameterError("episodes", numbers, f"runs that end; {answer.why}")
        yield task.key, *answer


def outcomes_of(
    episodes: Episodes, settings: Sequence[Setting], numbers: Sequence[int]
) -> tuple[list[Outcomes], float]:
    """Returns the outcomes of some episodes, and the processor time [s] that they have taken.
    Raises ParameterError."""
    begin = time.process_time()
    outcomes = [
        tuple(episodes.outcome(number, setting) for setting in settings) for number in numbers
    ]
    return outcomes, time.process_time() - begin


@contextmanager
def _kept(
    episodes: Episodes, settings: Sequence[Setting], plan: EpisodePlan
) -> Iterator[tuple[dict[int, Outcomes], Callable[[int, Outcomes], None]]]:
    """Yields the outcomes that the plan's file has of these episodes, by number, and a function
    that stores another one at once. The first episode is run again, and its outcomes are a part of
    the key: if a policy or a metric has changed behind its name, none are taken from the file."""
    if plan.file is None:
        yield {}, lambda number, outcomes: None
        return
    first = outcomes_of(episodes, settings, (0,))[0][0]
    script = episodes.script
    motion = [script.start.tolist(), script.period, len(script.controls)]
    names = [*episodes.names, *map(repr, first)]
    key = key_of("episodes", names, dict(episodes.model.fields), motion, [*settings])
    plan.file.parent.mkdir(parents=True, exist_ok=True)
    with writing(plan.file) as opened:
        study = store.study_number(opened, key)[0]
        numbers = map(str, range(plan.count))
        rows = store.stored_results(opened, study, numbers, EpisodeOutcomes)

        def keep(number: int, outcomes: Outcomes) -> None:
            """Stores the outcomes of an episode before it returns."""
            store.keep(opened, study, {str(number): EpisodeOutcomes(outcomes)})

        keep(0, first)
        yield {int(number): row.outcomes for number, row in rows.items()} | {0: first}, keep
