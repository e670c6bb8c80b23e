"""The pairs of a study, measured a second time in another process and in the opposite order: the
bits of both should be the same."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from plumbob.engines.registry import limits_of
from plumbob.engines.study.codec import to_json
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Study
from plumbob.engines.study.runner import convergence_task, pairs
from plumbob.engines.study.scheduler import Progress
from plumbob.engines.workers import Lost, Workers


@dataclass(frozen=True)
class OtherBits:
    """A difference of two measurements of a scene with a method."""

    step: float  # [s] step, or tolerance, of the run
    what: str  # the observable whose error differs, or "status"
    first: float | str
    second: float | str


@dataclass(frozen=True)
class RepeatedPair:
    """A scene with a method, measured a second time."""

    scene: str
    method: str
    difference: OtherBits | None  # the first difference; None if all bits are the same
    declared: str = ""  # why the engine does not repeat its bits; empty if that is not declared

    @property
    def unexpected(self) -> bool:
        """Whether the bits differ, and no exception is declared."""
        return self.difference is not None and not self.declared


def repeated_pairs(study: Study, progress: Progress) -> tuple[RepeatedPair, ...]:
    """Returns the pairs of a study, each measured again: all in one new process, in the opposite
    order."""
    first = {(series.scene, series.method): series for series in study.convergence}
    seed = study.seed
    tasks = [
        convergence_task(scene, method, study.profile, seed)
        for scene, method in reversed(pairs(study.scenes, study.methods))
    ]
    answers: dict[str, ConvergenceStudy | str] = {}
    with Workers(1) as workers:
        for task, result in workers.results(
            tasks, lambda task: progress(f"{task.label} again", len(answers), len(tasks))
        ):
            why = result.why if isinstance(result, Lost) else result.lost
            answers[task.label] = why or result.answer
    return tuple(
        _repeated_pair(series, answers[" ".join(pair)]) for pair, series in first.items()
    )


def _repeated_pair(first: ConvergenceStudy, second: ConvergenceStudy | str) -> RepeatedPair:
    """Returns the pair of two studies, of which the second may be lost for a reason."""
    pair = first.scene, first.method
    if isinstance(second, str):
        run = first.measurements[0]
        return RepeatedPair(*pair, OtherBits(run.step, "status", run.status, second))
    difference = next(_differences(first, second), None)
    declared = limits_of(first.method).other_bits(*pair) if difference else ""
    return RepeatedPair(*pair, difference, declared)


def _differences(first: ConvergenceStudy, second: ConvergenceStudy) -> Iterator[OtherBits]:
    """Yields a difference for each run of two studies that has other bits."""
    again = {run.step: run for run in _runs(second)}
    for run in _runs(first):
        other = again.pop(run.step, None)
        if other is None:
            yield OtherBits(run.step, "status", run.status, "not run")
        elif to_json(run) != to_json(other):
            yield _first_difference(run, other)
    for run in again.values():
        yield OtherBits(run.step, "status", "not run", run.status)


def _runs(study: ConvergenceStudy) -> Iterator[Measurement]:
    """Yields the runs of a study without the times that they took."""
    drawn = () if study.drawn is None else (study.drawn,)
    for run in (*study.measurements, *drawn):
        yield replace(run, seconds=0.0, compile_seconds=0.0)


def _first_difference(first: Measurement, second: Measurement) -> OtherBits:
    """Returns the first difference of two runs: of an error, else of their status."""
    for name in first.errors.keys() & second.errors.keys():
        sizes = [(run.errors[name].largest, run.errors[name].end) for run in (first, second)]
        for one, other in zip(*sizes, strict=True):
            if one != other:
                return OtherBits(first.step, name, one, other)
    return OtherBits(first.step, "status", first.status, second.status)
