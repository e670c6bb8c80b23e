"""Does the tasks of a study: stored results are loaded, others are measured and stored."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from typing import Any

from plumbob.engines.study.checkpoint import Checkpoint
from plumbob.engines.study.results import TaskResult
from plumbob.engines.workers import Lost, Task, results
from plumbob.models.border import Refused, border
from plumbob.models.registry import system_of
from plumbob.models.scene import Scene

Progress = Callable[[str, int, int], None]  # description, tasks done, tasks in all
PREDICTED = 3e-5  # [s] longest processor time of a unit of work in a quick run
GENEROUS = 100.0  # factor by which a task may take longer than predicted
SPARE_SECONDS = 300.0  # [s] processor time that every task may take in addition


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
    """A task that takes about as long as `work` steps of a pendulum. Its result is `blank` with the
    answer of the function `do`; if the task is given up, with the answer of `given_up` to the
    reason."""
    limit = SPARE_SECONDS + GENEROUS * PREDICTED * work

    def instead(why: str) -> TaskResult:
        return replace(blank, answer=given_up(why), label=label, lost=why)

    return Task(key, _answered, (blank, do, arguments), limit, group, label, instead)


def _answered(
    blank: TaskResult, do: Callable[..., Any], arguments: tuple[Any, ...]
) -> TaskResult:
    """The `blank` result with the answer of `do`. If the system of the scene is of another package,
    an exception gives the result up; otherwise the exception is raised, as plumbob's defect."""
    systems = [system_of(value) for value in arguments if isinstance(value, Scene)]
    package = next((system.distribution for system in systems), "")
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
    """{key: result} of tasks, in their order. A stored result whose subject differs from that of
    its task, as may happen in a damaged file, is measured again."""
    subjects = {task.key: task.instead("").subject for task in tasks}
    stored = kept.there(list(subjects))
    found = {key: result for key, result in stored.items() if result.subject == subjects[key]}
    missing = _in_order([task for task in tasks if task.key not in found])

    def begun(task: Task) -> None:
        progress(task.label, len(found), len(tasks))

    for task, result in results(missing, executor, begun, count):
        why = result.why if isinstance(result, Lost) else result.lost
        if why:
            result = task.instead(why)
        found[task.key] = result
        kept.keep({task.key: result})
    return {task.key: found[task.key] for task in tasks}


def _in_order(tasks: Sequence[Task]) -> list[Task]:
    """The tasks by group, the groups with most work first, so that no worker is left alone with a
    long group at the end."""
    work = work_by_group(tasks)
    return sorted(tasks, key=lambda task: (-work[task.group], task.group, -task.limit))


def work_by_group(tasks: Iterable[Task]) -> Mapping[str, float]:
    """The predicted work of each group of tasks, in seconds of processor time at most."""
    work = defaultdict[str, float](float)
    for task in tasks:
        work[task.group] += task.limit - SPARE_SECONDS
    return work
