"""Works out the tasks of a study: results that are kept are taken, others measured and kept."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from typing import Any

from plumbob.engines.study.checkpoint import Checkpoint
from plumbob.engines.study.results import TaskResult
from plumbob.engines.workers import Lost, Task, results
from plumbob.models.border import Refused, border
from plumbob.models.registry import system_of
from plumbob.models.scene import Scene

Progress = Callable[[str, int, int], None]  # what is being done, how many are done, of how many
PREDICTED = 3e-5  # [s] of a unit of work, the most that a quick run took
GENEROUS = 100.0  # times that, and at least:
LEAST = 300.0  # [s], before a task hangs


def study_task(
    label: str,
    key: str,
    group: str,
    work: float,
    blank: TaskResult,
    do: Callable[..., Any],
    arguments: tuple[Any, ...],
    given_up: Callable[[str], Any] = lambda why: None,
) -> Task:
    """A task that takes roughly as long as `work` steps of a pendulum: the `blank` result with what
    a function answers, or with `given_up` and the reason."""
    limit = LEAST + GENEROUS * PREDICTED * work

    def instead(why: str) -> TaskResult:
        return replace(blank, answer=given_up(why), label=label, lost=why)

    return Task(key, _answered, (blank, do, arguments), limit, group, label, instead)


def _answered(
    blank: TaskResult, do: Callable[..., Any], arguments: tuple[Any, ...]
) -> TaskResult:
    """A result with its answer; given up for a defect in the exact motion or the theory of an added
    system. Raises an error that is plumbob's own."""
    posed = [system_of(of) for of in arguments if isinstance(of, Scene)]
    package = next((system.distribution for system in posed), "")
    if not package:
        return replace(blank, answer=do(*arguments))
    try:
        with border():
            return replace(blank, answer=do(*arguments))
    except Refused as error:
        return TaskResult(lost=f"the system of the package {package} raises {error}")


def worked_out(
    tasks: Sequence[Task],
    kept: Checkpoint,
    executor: Executor | None,
    progress: Progress,
    count: int = 1,
) -> dict[str, TaskResult]:
    """The results of tasks by their keys, in this order. A kept result that is about something else
    than the task of its key is not taken."""
    about = {task.key: task.instead("").subject for task in tasks}
    there = kept.there(list(about))
    found = {key: result for key, result in there.items() if result.subject == about[key]}
    missing = _in_order([task for task in tasks if task.key not in found])

    def begun(task: Task) -> None:
        progress(task.label, len(found), len(tasks))

    for task, result in results(missing, executor, begun, count):
        if why := result.why if isinstance(result, Lost) else result.lost:
            result = task.instead(why)
        found[task.key] = result
        kept.keep({task.key: result})
    return {task.key: found[task.key] for task in tasks}


def _in_order(tasks: Sequence[Task]) -> list[Task]:
    """Groups one after the other, the long ones first, so that nobody is left with one at the
    end."""
    work = defaultdict[str, float](float)
    for task in tasks:
        work[task.group] += task.limit - LEAST
    return sorted(tasks, key=lambda task: (-work[task.group], task.group, -task.limit))
