"""plumbob run: one run of a scene or a model file, with a method and a step: errors and cost."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, cast

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import USER_METHOD, Method, Unsupported
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.cost import Cost, batch_costs, costs, held_to_cost
from plumbob.engines.study.measurement import Measurement, measure
from plumbob.engines.workers import Lost, Task, Workers
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Scene
from plumbob.reports.advice.json_records import run_record
from plumbob.reports.columns.study_columns import error_columns
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.arguments.console import note, progress
from plumbob.reports.commands.arguments.like import own_method
from plumbob.reports.commands.shared.budget import certify
from plumbob.reports.commands.shared.model_file import (
    is_model_file,
    model_and_script,
    motion_record,
)
from plumbob.reports.judge.expectations import run_surprise
from plumbob.reports.judge.verdict import Judgement, judge

if TYPE_CHECKING:
    from plumbob.engines.audit.reference import Certificate
    from plumbob.engines.audit.step_errors import StepError
    from plumbob.engines.own_motion import OwnModel, Script

INCOMPLETE = 3
# Options that a model file does not take.
SCENE_OPTIONS = ("changes", "like", "worlds", "certified", "csv", "latex")
TimedRun = tuple[Measurement, Cost | None, float]
LONGEST_RUN = 3600.0  # [s] longest processor time of a run in a plug-in engine


def command(chosen: argparse.Namespace) -> int:
    """Prints the errors against the exact answer, their tolerances and the cost. Returns 1 if a
    verdict is not as expected, 3 if an engine is missing or nothing is certified."""
    if is_model_file(chosen, SCENE_OPTIONS):
        return _run_file(chosen)
    methods = _methods(chosen.method, chosen.like)
    changed = chosen.changes
    with values.representable(changed, chosen):
        scene = find_scene(chosen.scene, changed)
        case = case_of(scene)
        certify(case, scene.duration, chosen.budget)
        quantities = case.system.quantities(case)
    if chosen.step is None and not chosen.like:
        raise ParameterError("step", None, "given, or the step of the file that --like names")
    step = chosen.step or methods[-1].step_sizes[0]  # default: the step of the user's file
    codes = []
    records = []
    runs = []
    for method in methods:
        with values.representable(changed, chosen):
            run, cost, reference_time = _timed_run(scene, method, step)
            certified = _certified_answer(chosen, scene, method, run)
        judgement = judge(run, case.system, method, quantities)
        worlds = batch_costs(case, method, step, chosen.worlds or [])
        record = run_record(method, run, judgement, None, cost)
        if worlds:
            record["worlds"] = worlds
        codes.append(_exit_code(scene, method, run, judgement))
        if certified is None:
            codes.append(INCOMPLETE)
        elif certified:
            record["certified"] = certified
            answers_agree = certified["within"] or certified["yields"]
            codes.append(0 if answers_agree else 1)
        records.append(record)
        factor = record["real_time_factor"]
        runs.append((run, judgement, cost, reference_time, factor, worlds, certified))
    units = {observable.name: observable.unit for observable in case.system.observables}
    answer = records if len(records) > 1 else records[0]
    table = partial(error_columns, records, {(scene.name, name): units[name] for name in units})
    values.show(chosen, answer, "run", columns=table, runs=runs, units=units)
    return next((code for code in (1, INCOMPLETE) if code in codes), 0)


def _certified_answer(
    chosen: argparse.Namespace, scene: Scene, method: Method, run: Measurement
) -> dict[str, Any] | None:
    """Returns the JSON data of a scene's certified answer and exact answer, with the run's errors
    against both. Returns an empty dict if --certified is not chosen or the method cannot run
    the scene. Returns None, after a note on stderr, if nothing of the motion is certified."""
    if not chosen.certified or run.status in ("missing", "unsupported"):
        return {}
    answer = _call_isolated(method, _two_answers_record, scene, method, run.step, chosen.budget)
    if isinstance(answer, dict):
        return answer
    reason = answer.why if isinstance(answer, Lost) else answer
    note(f"{scene.name} has no certified motion beside {method.name}: {reason}")
    return None


def _two_answers_record(
    scene: Scene, method: Method, step: float, seconds: float
) -> dict[str, Any] | str:
    """Returns the JSON data of a scene's certified answer and exact answer, or the reason why no
    answer is certified. `seconds` [s] is the budget of processor time."""
    from plumbob.engines.audit.scene_reference import scene_reference, two_answers
    from plumbob.engines.own_motion import NotCertifiable

    case = case_of(scene)
    try:
        with progress() as show:
            show("the continuous motion, by two methods", 0, 0)
            reference = scene_reference(case, method, step, seconds)
            answers = two_answers(case, method, step, reference)
    except (NotCertifiable, Unsupported) as why:
        return str(why)
    return {
        "method": reference.method.name,
        "step": reference.step,
        "certified_until": float(reference.times[-1]),
        "why": reference.why,
        "yields": reference.yields,
        "within": all(answer.within for answer in answers.values()),
        "observables": {
            name: {**vars(answer), "within": answer.within} for name, answer in answers.items()
        },
    }


def _run_file(chosen: argparse.Namespace) -> int:
    """Prints the error of a method on a model file. Returns 1 if the run does not reach the end of
    the motion, and 3 if the motion is not certified or the engine cannot run the file."""
    from plumbob.engines.audit.allowance import Allowance
    from plumbob.engines.audit.audit import REFERENCE
    from plumbob.engines.audit.reference import certified
    from plumbob.engines.audit.step_of_method import DISCRETE, method_error, parts_of, runs_of
    from plumbob.engines.audit.user_models import quiet

    with quiet(), progress() as show:
        model, script = model_and_script(chosen)
        method = find_method(chosen.method or f"mujoco/{model.integrator}")
        step = chosen.step or model.step
        parts_of(script, step)
        runs_of(method, (*model.steppable, DISCRETE))
        if not installed(engine_of(method)):
            note(f"{engine_of(method).package} is not installed")
            return INCOMPLETE
        show("the continuous motion, by two methods", 0, 0)
        allowance = Allowance(chosen.budget).part(REFERENCE)
        reference = certified(model, script, allowance)
        if not reference.known:
            note(f"{chosen.scene} has no certified motion: {reference.why}")
            return INCOMPLETE
        show(f"{method.name} at {step:g} s", 0, 0)
        try:
            run = method_error(method, model, script, reference, step, chosen.budget)
        except Unsupported as why:
            note(f"{method.name} does not run {chosen.scene}: {why}")
            return INCOMPLETE
    answer = _file_record(chosen, method, model, script, reference, run)
    values.show(chosen, answer, "run_file", **answer)
    return 0 if math.isfinite(answer["error"]) else 1


def _file_record(
    chosen: argparse.Namespace,
    method: Method,
    model: OwnModel,
    script: Script,
    reference: Certificate,
    run: StepError,
) -> dict[str, Any]:
    """Returns the JSON data of a run of a model file."""
    from plumbob.engines.audit.reference import RESOLVED
    from plumbob.engines.study.provenance import version_of
    from plumbob.reports.view.audit.page import package_versions

    index = reference.known  # index of the last period end to which the motion is certified
    error = run.at(index)
    ns_per_second = run.ns_per_second
    if ns_per_second is None:
        ns_per_second = 1e9 * run.seconds / script.duration
    return {
        **motion_record(chosen, script, reference, index),
        "method": method.name,
        "step": run.step,
        "error": error,
        "resolved": error > RESOLVED * float(reference.uncertainty[index]),
        "worst_body": run.worst,
        "error_over_time": run.errors[: index + 1],
        "ns_per_second": ns_per_second,
        "ended": run.why,
        "notes": [*model.notes, *run.remarks],
        "softened": method.engine == "mujoco" and model.softened(run.step),
        "versions": {**package_versions(), method.engine: version_of(engine_of(method))},
    }


def _timed_run(scene: Scene, method: Method, step: float) -> TimedRun:
    """Returns the run of a scene, its cost, and the time [ns] of the reference step. The cost is
    None if the run did not finish."""
    answer = _call_isolated(method, _measure_and_time, scene, method, step)
    if isinstance(answer, Lost):
        lost = Measurement(scene.name, method.name, step, "missing", reason=answer.why)
        return lost, None, math.nan
    return cast(TimedRun, answer)


def _call_isolated(method: Method, function: Callable[..., Any], *arguments: Any) -> Any:
    """Returns what `function` returns for the `arguments`. A plug-in engine may crash its process:
    its methods run in a process of their own, and Lost is returned if that process dies."""
    if not engine_of(method).distribution:
        return function(*arguments)
    with Workers(1) as workers:
        ((_, answer),) = workers.results([Task("", function, arguments, LONGEST_RUN, "")])
    return answer


def _measure_and_time(scene: Scene, method: Method, step: float) -> TimedRun:
    """Returns the run of a scene, its cost, and the time [ns] of the reference step."""
    case = case_of(scene)
    run = held_to_cost(case, method, measure(case, method, step)[0])
    timed = costs(scene, [(method, step)] if run.status == "done" else [])
    return run, timed.by_method.get(method.name), timed.reference_step


def _methods(name: str | None, like: str | None) -> list[Method]:
    """Returns the methods to run: the method called `name`, if there is one, then the settings of
    the user's file `like`. Raises ParameterError if both are None."""
    if name is None and like is None:
        raise ParameterError("method", name, "given: engine/name, or --like FILE")
    user_methods = [own_method(like)] if like else []
    if name is None or name in [method.name for method in user_methods]:
        return user_methods
    return [find_method(name), *user_methods]


def _exit_code(scene: Scene, method: Method, run: Measurement, judged: Judgement) -> int:
    """Returns the exit code for the run of one method."""
    if run.status == "missing":
        return INCOMPLETE
    if method.name == USER_METHOD:  # the user's own settings have no expected verdict
        return INCOMPLETE if run.status == "unsupported" else 0
    return 1 if run_surprise(scene, method, judged) else 0
