"""A sweep: runs methods and steps at all points of a grid of parameters, in independent chunks."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, NoAnswer, answering
from plumbob.engines.box import EXACT_MOTION_SECONDS, Box
from plumbob.engines.method import Method, Unsupported, meant
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.study.measurement import measure, relative_error
from plumbob.engines.workers import Lost, Task, Workers, results
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Case

CHUNK_RUNS = 200  # runs in one chunk, which take a few seconds
# [s] longest processor time of a chunk: at each place integrating the exact motion may take
# EXACT_MOTION_SECONDS, and the runs as long again
LONGEST_CHUNK = 2.0 * CHUNK_RUNS * EXACT_MOTION_SECONDS
MAX_SWEEP_RUNS = 1_000_000  # largest number of runs of a sweep, which take some hours
NUMBER = re.compile(r"(?<![\w.^])[-+]?\d+\.?\d*(e[-+]?\d+)?(?![\w.])")


@dataclass(frozen=True)
class Sweep:
    """Methods with steps at the points of a grid over a box."""

    box: Box
    counts: tuple[int, ...]  # number of values of each side
    methods: tuple[Method, ...]
    steps: tuple[float, ...]  # [s], or relative tolerances
    chunk: int  # number of points in one task

    @property
    def points(self) -> int:
        """The number of points of the grid."""
        return math.prod(self.counts)

    @property
    def chunks(self) -> int:
        """The number of tasks."""
        return -(-self.points // self.chunk)

    def place(self, point: int) -> tuple[float, ...]:
        """The place of a point of the grid in the box: a fraction of each side. The last side runs
        fastest."""
        indices = np.unravel_index(point, self.counts)
        return tuple(int(k) / max(n - 1, 1) for k, n in zip(indices, self.counts, strict=True))


@dataclass(frozen=True)
class Chunk:
    """The results at some neighbouring points."""

    errors: Array
    """Relative errors, shape (methods, steps, points): nan without a result, infinite if
    diverged."""
    reasons: Mapping[str, int] = field(default_factory=dict)
    """{reason of a run without a result: number of such runs}."""


@dataclass(frozen=True)
class Swept:
    """The relative errors of a whole sweep."""

    sweep: Sweep
    errors: Array
    """Shape (methods, steps, *counts): nan without a result, infinite if diverged."""
    reasons: Mapping[str, int]  # {reason of a run without a result: number of such runs}
    lost: Mapping[int, str] = field(default_factory=dict)  # {chunk: why its worker ended}

    def worst(self, method: int, step: int, most: int) -> list[tuple[int, float]]:
        """At most `most` points with the largest errors of a method and a step, given by their
        numbers, largest first: (number of the point, error). Diverged runs come first."""
        errors = self.errors[method, step].ravel()
        missing_last = np.where(np.isnan(errors), -1.0, errors)
        order = np.argsort(-missing_last, kind="stable")[:most]
        return [(int(k), float(errors[k])) for k in order if not math.isnan(errors[k])]


Keep = Callable[[int, Chunk], None]
SweepProgress = Callable[[int, int], None]  # number of points done, number of all points


def sweep_of(
    box: Box,
    counts: Sequence[int],
    methods: Sequence[Method],
    steps: Sequence[float],
    shards: int = 1,
) -> Sweep:
    """The sweep of a box, with a chunk for each of the `shards` if it has as many points. Raises
    ParameterError if a method is not meant for the scene or its engine is missing, if steps and
    tolerances are mixed, or if there are too many points."""
    runnable(box, methods)
    if len({method.control for method in methods}) > 1:
        raise ParameterError(
            "method",
            ", ".join(m.name for m in methods),
            "all with steps, or all with tolerances",
        )
    each = len(methods) * len(steps)
    if math.prod(counts) * each > MAX_SWEEP_RUNS:
        most = MAX_SWEEP_RUNS // each
        raise ParameterError("vary", math.prod(counts), f"at most {most} points in all")
    chunk = max(min(CHUNK_RUNS // each, math.prod(counts) // shards), 1)
    return Sweep(box, tuple(counts), tuple(methods), tuple(steps), chunk)


def runnable(box: Box, methods: Sequence[Method]) -> None:
    """Raises ParameterError if a method is not meant for the scene of a box, or its engine is
    missing."""
    scene = find_scene(box.scene)
    for method in methods:
        if not installed(engine_of(method)):
            raise ParameterError(
                "method",
                method.name,
                f"of an engine that is installed ({engine_of(method).package} is missing)",
            )
        if not meant(method, scene):
            raise ParameterError("method", method.name, f"meant for {scene.name}")


def sweep(
    asked: Sweep,
    there: Mapping[int, Chunk],
    keep: Keep,
    jobs: int = 1,
    executor: Executor | None = None,
    progress: SweepProgress = lambda done, of: None,
    chunks: Collection[int] | None = None,
) -> Swept:
    """Runs the chunks of a sweep that are not among the stored ones, `there`, in `jobs` processes
    or by `executor`; of all chunks, only those with the numbers `chunks` if they are given. Each
    chunk is given to `keep` when it is done. A chunk whose worker ends twice is lost. Raises
    ParameterError if all chunks are run and no point has an error."""
    errors = np.full((len(asked.methods), len(asked.steps), asked.points), math.nan)
    reasons: Counter[str] = Counter()
    lost: dict[int, str] = {}
    done = 0

    def placed(number: int, found: Chunk) -> None:
        nonlocal done
        first = number * asked.chunk
        errors[:, :, first : first + found.errors.shape[2]] = found.errors
        reasons.update(found.reasons)
        done += found.errors.shape[2]
        progress(done, asked.points)

    for number, found in there.items():
        placed(number, found)
    tasks = [
        Task(number, chunk_of, (asked, number), LONGEST_CHUNK)
        for number in (range(asked.chunks) if chunks is None else sorted(chunks))
        if number not in there
    ]
    with Workers(min(jobs, len(tasks))) as workers:
        here = workers if workers.count > 1 else None
        for task, found in results(tasks, executor or here, count=jobs):
            if isinstance(found, Lost):
                lost[task.key] = found.why
            else:
                keep(task.key, found)
                placed(task.key, found)
    if chunks is None and np.isnan(errors).all() and not lost:
        why = reasons.most_common(1)[0][0] if reasons else "nothing was run"
        names = [side.name for side in asked.box.sides]
        raise ParameterError("vary", names, f"such that an error exists ({why})")
    whole = errors.reshape(*errors.shape[:2], *asked.counts)
    return Swept(asked, whole, dict(reasons), lost)


def assembled_sweep(asked: Sweep, chunks: Mapping[int, Chunk]) -> Swept:
    """A sweep with the errors of its stored chunks, by number; NaN at points that are not stored.
    Chunks whose shape does not fit are left out."""
    shape = len(asked.methods), len(asked.steps), asked.points
    errors = np.full(shape, math.nan)
    reasons: Counter[str] = Counter()
    for number, chunk in chunks.items():
        place = errors[:, :, number * asked.chunk : (number + 1) * asked.chunk]
        if place.shape == chunk.errors.shape:
            place[:] = chunk.errors
            reasons.update(chunk.reasons)
    return Swept(asked, errors.reshape(*shape[:2], *asked.counts), dict(reasons))


def chunk_of(asked: Sweep, number: int) -> Chunk:
    """Runs the points of one chunk."""
    first = number * asked.chunk
    points = range(first, min(first + asked.chunk, asked.points))
    errors = np.full((len(asked.methods), len(asked.steps), len(points)), math.nan)
    reasons: Counter[str] = Counter()
    for k, point in enumerate(points):
        try:
            case = asked.box.case(asked.place(point))
        except NoAnswer as why:
            reasons[_without_numbers(why)] += len(asked.methods) * len(asked.steps)
            continue
        for i, method in enumerate(asked.methods):
            for j, step in enumerate(asked.steps):
                try:
                    errors[i, j, k] = run_error(case, method, step)
                except (NoAnswer, Unsupported) as why:
                    reasons[_without_numbers(why)] += 1
    return Chunk(errors, dict(reasons))


def _without_numbers(why: Exception) -> str:
    """The text of a reason without its numbers, so that neighbouring points have the same text."""
    return NUMBER.sub("…", str(why))


def run_error(case: Case, method: Method, step: float) -> float:
    """The relative error of one run: the largest over the quantities of interest, relative to their
    scales; infinite if the run diverged. Raises NoAnswer and Unsupported."""
    with answering():
        about = case.system.quantities(case)
    run = measure(case, method, step, theory=False)[0]
    if run.status == "unsupported":
        raise Unsupported(run.reason)
    if run.status == "cut-short":
        raise NoAnswer(run.reason)
    error = relative_error(run, about)
    if math.isnan(error):
        raise NoAnswer("the run leaves out what the scene is about, or it is not a number")
    return error
