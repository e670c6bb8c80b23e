"""A sweep: runs methods and steps at all points of a grid of parameters, in independent chunks."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from itertools import product

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
        return tuple(
            int(index) / max(count - 1, 1)
            for index, count in zip(indices, self.counts, strict=True)
        )


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
        """(number of the point, error) of the `most` points with the largest errors of a method and
        a step, which are given by their numbers; the largest errors, of diverged runs, come first.
        Points without an error are left out."""
        errors = self.errors[method, step].ravel()
        missing_last = np.where(np.isnan(errors), -1.0, errors)
        points = np.argsort(-missing_last, kind="stable")[:most].tolist()
        return [
            (point, float(errors[point])) for point in points if not math.isnan(errors[point])
        ]


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
        names = ", ".join(method.name for method in methods)
        raise ParameterError("method", names, "all with steps, or all with tolerances")
    runs_per_point = len(methods) * len(steps)
    points = math.prod(counts)
    if points * runs_per_point > MAX_SWEEP_RUNS:
        most = MAX_SWEEP_RUNS // runs_per_point
        raise ParameterError("vary", points, f"at most {most} points in all")
    chunk = max(min(CHUNK_RUNS // runs_per_point, points // shards), 1)
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
    request: Sweep,
    stored: Mapping[int, Chunk],
    keep: Keep,
    jobs: int = 1,
    executor: Executor | None = None,
    progress: SweepProgress = lambda done, points: None,
    numbers: Collection[int] | None = None,
) -> Swept:
    """Runs the chunks of a sweep that are not `stored`, by number, in `jobs` processes or by
    `executor`; of all chunks, only those with the `numbers` if they are given. Each chunk is given
    to `keep` when it is done. A chunk whose worker ends twice is lost. Raises ParameterError if all
    chunks are run and no point has an error."""
    chunks = dict(stored)
    lost: dict[int, str] = {}
    points_done = sum(chunk.errors.shape[2] for chunk in stored.values())
    if stored:
        progress(points_done, request.points)
    tasks = [
        Task(number, chunk_of, (request, number), LONGEST_CHUNK)
        for number in (range(request.chunks) if numbers is None else sorted(numbers))
        if number not in stored
    ]
    with Workers(min(jobs, len(tasks))) as workers:
        own_workers = workers if workers.count > 1 else None
        for task, result in results(tasks, executor or own_workers, count=jobs):
            if isinstance(result, Lost):
                lost[task.key] = result.why
            else:
                keep(task.key, result)
                chunks[task.key] = result
                points_done += result.errors.shape[2]
                progress(points_done, request.points)
    swept = replace(assembled_sweep(request, chunks), lost=lost)
    if numbers is None and np.isnan(swept.errors).all() and not lost:
        reasons = Counter(swept.reasons).most_common(1)
        why = reasons[0][0] if reasons else "nothing was run"
        names = [side.name for side in request.box.sides]
        raise ParameterError("vary", names, f"such that an error exists ({why})")
    return swept


def assembled_sweep(request: Sweep, chunks: Mapping[int, Chunk]) -> Swept:
    """A sweep with the errors of its chunks, by number; NaN at points of other chunks. Chunks whose
    shape does not fit are left out."""
    shape = len(request.methods), len(request.steps), request.points
    errors = np.full(shape, math.nan)
    reasons: Counter[str] = Counter()
    for number, chunk in chunks.items():
        place = errors[:, :, number * request.chunk : (number + 1) * request.chunk]
        if place.shape == chunk.errors.shape:
            place[:] = chunk.errors
            reasons.update(chunk.reasons)
    return Swept(request, errors.reshape(*shape[:2], *request.counts), dict(reasons))


def chunk_of(request: Sweep, number: int) -> Chunk:
    """Runs the points of the chunk with this number."""
    first = number * request.chunk
    points = range(first, min(first + request.chunk, request.points))
    runs = list(product(enumerate(request.methods), enumerate(request.steps)))
    errors = np.full((len(request.methods), len(request.steps), len(points)), math.nan)
    reasons: Counter[str] = Counter()
    for column, point in enumerate(points):
        try:
            case = request.box.case(request.place(point))
        except NoAnswer as why:
            reasons[_without_numbers(why)] += len(runs)
            continue
        for (method_number, method), (step_number, step) in runs:
            try:
                error = run_error(case, method, step)
            except (NoAnswer, Unsupported) as why:
                reasons[_without_numbers(why)] += 1
            else:
                errors[method_number, step_number, column] = error
    return Chunk(errors, dict(reasons))


def _without_numbers(why: Exception) -> str:
    """The text of a reason without its numbers, so that neighbouring points have the same text."""
    return NUMBER.sub("…", str(why))


def run_error(case: Case, method: Method, step: float) -> float:
    """The relative error of one run: the largest over the quantities of interest, relative to their
    scales; infinite if the run diverged. Raises NoAnswer and Unsupported."""
    with answering():
        quantities = case.system.quantities(case)
    run = measure(case, method, step, theory=False)[0]
    if run.status == "unsupported":
        raise Unsupported(run.reason)
    if run.status == "cut-short":
        raise NoAnswer(run.reason)
    error = relative_error(run, quantities)
    if math.isnan(error):
        raise NoAnswer("the run leaves out what the scene is about, or it is not a number")
    return error
