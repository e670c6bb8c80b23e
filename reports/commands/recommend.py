"""plumbob recommend: the cheapest method and step for an error of a scene or a model file."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbob.analytic.parameters import ParameterError, nearest
from plumbob.engines.method import USER_METHOD, Method
from plumbob.engines.registry import engine_of, engines, installed
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study import store
from plumbob.engines.study.provenance import changed_since
from plumbob.engines.study.results import Observables, Study
from plumbob.engines.workers import spent
from plumbob.models.registry import case_of, system_of
from plumbob.models.scene import Scene
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.shared.budget import certify
from plumbob.reports.commands.shared.model_file import (
    is_model_file,
    model_and_script,
    motion_record,
)

if TYPE_CHECKING:
    from plumbob.engines.audit.step_errors import StepError
    from plumbob.engines.own_motion import Script
    from plumbob.engines.study.checkpoint import Checkpoint
    from plumbob.engines.study.measurement import Measurement
    from plumbob.engines.study.scheduler import Progress
    from plumbob.reports.advice.advice import MakeRun, RecommendationSearch
    from plumbob.reports.advice.audit_advice import StepEvidence
    from plumbob.reports.advice.user_settings import UserResult

SAMPLES = 100  # times at which the exact motion is sampled for its size
EXACT_FRACTION = 0.1  # fraction of the budget for an exact motion that is integrated
INCOMPLETE = 3
FILE = "recommend.sqlite3"  # store of this command's runs, beside the studies of `validate`
OUT = "plumbob-out"
BUDGET = 600.0  # [s] processor time for all runs of scenes
FILE_BUDGET = 60.0  # [s] processor time for a model file
# Options that a model file does not take.
SCENE_OPTIONS = ("changes", "like", "stored", "observable", "engine", "out")


class _OutOfTime(Exception):
    """Raised when the budget of processor time is spent."""


def command(chosen: argparse.Namespace) -> int:
    """Answers from the stored runs of the scenes, and runs what is missing. Returns 0 if a method
    reaches the error, 1 if no method does, 3 if the budget is spent before."""
    from plumbob.reports.commands.arguments.like import own_method

    if is_model_file(chosen, SCENE_OPTIONS):
        chosen.budget = chosen.budget or FILE_BUDGET
        return _answer_for_file(chosen)
    chosen.budget = chosen.budget or BUDGET
    chosen.out = chosen.out or OUT
    if chosen.absolute is None and chosen.observable is not None:
        raise ParameterError("observable", chosen.observable, "given with --absolute")
    user_method = own_method(chosen.like) if chosen.like else None
    scenes = () if _answered_by_study(chosen) else values.scenes(chosen.scene, chosen.changes)
    if user_method and len(scenes) > 1:
        raise ParameterError("like", chosen.like, "given with one scene, not with a pattern")
    if chosen.engine is not None and chosen.engine not in engines():
        raise ParameterError("engine", chosen.engine, f"one of {', '.join(engines())}")
    for scene in scenes:
        _check_observable(chosen.observable, system_of(scene).observables)
    if chosen.changes:
        with values.representable(chosen.changes, chosen):
            for scene in scenes:
                certify(case_of(scene), scene.duration, chosen.budget, EXACT_FRACTION)
    if not chosen.stored:
        for scene in scenes:
            _check_reachable(chosen, scene)
    try:
        return _answer_for_scenes(chosen, scenes, user_method)
    except _OutOfTime as stopped:
        print(f"plumbob: {stopped}", file=sys.stderr)
        return INCOMPLETE


def _answer_for_scenes(
    chosen: argparse.Namespace, scenes: Sequence[Scene], user_method: Method | None
) -> int:
    """Prints the answer for `scenes`, or for the scene of a stored study if `scenes` is empty, and
    returns the exit code. Raises _OutOfTime."""
    from plumbob.reports.advice.advice import Question, advise

    open_study = _stored_study if chosen.stored else _measured_study
    with open_study(chosen, scenes) as (study, run):
        _check_observable(chosen.observable, study.observables(study.scenes[0].name))
        methods = tuple(
            method
            for method in study.methods
            if method.name != USER_METHOD and chosen.engine in (None, method.engine)
        )
        question = Question(
            name=chosen.scene if len(study.scenes) > 1 else study.scenes[0].name,
            scenes=study.scenes,
            methods=methods,
            error=chosen.error or chosen.absolute,
            absolute=chosen.error is None,
            observable=chosen.observable,
        )
        answer = advise(question, study, run)
    _print_answer(chosen, question, study, answer, user_method)
    return 0 if answer.recommendation.choice else 1


def _answer_for_file(chosen: argparse.Namespace) -> int:
    """Prints the cheapest integrator and step of MuJoCo whose error [m] on a model file stays
    within the wanted one. Returns 1 if none does, and 3 if the motion is not certified to its end
    or not precisely enough."""
    from plumbob.engines.audit.allowance import Allowance
    from plumbob.engines.audit.audit import compare_with_reference, largest_steps_along
    from plumbob.engines.audit.user_models import quiet
    from plumbob.reports.advice.audit_advice import StepEvidence
    from plumbob.reports.commands.arguments.console import note, progress

    target = chosen.error or chosen.absolute
    with quiet(), progress() as show:
        model, script = model_and_script(chosen)
        allowance = Allowance(chosen.budget, progress=lambda what: show(what, 0, 0))
        reference, steps = compare_with_reference(model, script, allowance)
        if steps is not None:
            limits = largest_steps_along(model, script, reference, allowance)
    if steps is None:
        note(f"{chosen.scene} has no certified motion: {reference.why}")
        return INCOMPLETE
    evidence = StepEvidence(model, reference, steps, limits)
    answer = _file_record(chosen, target, script, evidence)
    values.show(chosen, answer, "recommend_file", format=model.format, **answer)
    if not answer["decided"]:
        return INCOMPLETE
    return 0 if answer["choice"] else 1


def _file_record(
    chosen: argparse.Namespace,
    target: float,
    script: Script,
    evidence: StepEvidence,
) -> dict[str, Any]:
    """Returns the JSON data of the cheapest integrator and step for an error of `target` [m], of
    the run with the model's own integrator and step, and of the run with the smallest error."""
    from plumbob.engines.audit.step_errors import TRUSTED
    from plumbob.reports.advice.audit_advice import step_choice
    from plumbob.reports.view.audit.page import package_versions
    from plumbob.reports.view.audit.records import step_choice_record

    model, reference, steps = evidence.model, evidence.reference, evidence.compared
    index = steps.index
    choice = None
    best = step_choice(evidence, target)
    if best is not None:
        choice = step_choice_record(best)
        del choice["target"]
        choice["options"] = best.new_options

    def step_record(step: StepError) -> dict[str, Any]:
        """Returns the JSON data of a run: its integrator, step, error [m] and cost."""
        names = ("integrator", "step", "ns_per_second")
        return {name: getattr(step, name) for name in names} | {"error": step.at(index)}

    most_accurate = min(steps.steps, key=lambda step: step.at(index))
    known_to_end = index == len(script.controls)
    known_well = bool(reference.uncertainty[index] <= TRUSTED * target)
    return {
        **motion_record(chosen, script, reference, index),
        "target": target,
        "decided": known_to_end and known_well,
        "choice": choice,
        "own": step_record(steps.own),
        "nearest": step_record(most_accurate),
        "clamped": model.clamped if steps.clamping_acts else {},
        "notes": [*model.notes, *steps.own.remarks],
        "versions": package_versions(),
    }


def _answered_by_study(chosen: argparse.Namespace) -> bool:
    """Returns whether a stored study can answer without the scene itself, which is so for a single
    scene. Loading all systems would take longer than the answer."""
    is_one_scene = "/" in chosen.scene and not set("*?[,") & set(chosen.scene)
    return chosen.stored and is_one_scene and not chosen.changes


def _check_observable(observable: str | None, observables: Observables) -> None:
    """Raises ParameterError if `observable` is given and is none of the `observables`."""
    names = [known.name for known in observables]
    if observable not in (None, *names):
        raise ParameterError(
            "observable", observable, f"one of {nearest(str(observable), names)}"
        )


def _check_reachable(chosen: argparse.Namespace, scene: Scene) -> None:
    """Raises ParameterError if the wanted error is smaller than the rounding error of the scene's
    exact motion: no method and no step reaches it."""
    from plumbob.analytic.numerics.arithmetic import ROUNDOFF
    from plumbob.reports.advice.advice import quantities_in_units

    case = case_of(scene)
    if case.system.distribution:  # a plug-in's exact motion may fail: the study reports it
        return
    quantities = case.system.quantities(case)
    if chosen.error is None:
        quantities = quantities_in_units(quantities, chosen.observable)
    exact = case.reference.observe(np.linspace(0.0, scene.duration, SAMPLES))
    smallest_error = 0.0
    for quantity in quantities:
        samples = exact[quantity.observable]
        if quantity.when == "end":
            samples = samples[-1:]
        rounding = ROUNDOFF * float(np.abs(samples).max()) / quantity.scale
        smallest_error = max(smallest_error, rounding)
    option = "error" if chosen.error else "absolute"
    wanted_error = getattr(chosen, option)
    if 0.0 < wanted_error < smallest_error:
        expected = f"at least {smallest_error:.2g}"
        reason = f"rounding alone makes such an error on {scene.name}"
        raise ParameterError(option, wanted_error, f"{expected}: {reason}")


@contextmanager
def _stored_study(
    chosen: argparse.Namespace, scenes: Sequence[Scene]
) -> Iterator[tuple[Study, MakeRun | None]]:
    """Gives the newest stored study of the scenes, and None, because nothing is run. If `scenes` is
    empty, the scene's name is the one on the command line. Raises ParameterError."""
    by_name = {scene.name: scene for scene in scenes}
    names = by_name or (chosen.scene,)
    study = store.load(Path(chosen.out) / store.FILE, scenes=names)
    matching = []
    for stored in study.scenes if study else ():
        asked = by_name.get(stored.name, stored)
        # The step sizes may differ.
        same_parameters = dict(stored.parameters) == dict(asked.parameters)
        if stored.name in names and stored.duration == asked.duration and same_parameters:
            matching.append(stored)
    if study is None or not matching:
        raise ParameterError(
            "scene", next(iter(names)), "one that was measured, as nothing is run"
        )
    for entry in changed_since(study.provenance):
        print(f"plumbob: the stored runs are of {entry}", file=sys.stderr)
    yield replace(study, scenes=tuple(matching)), None


@contextmanager
def _measured_study(
    chosen: argparse.Namespace, scenes: Sequence[Scene]
) -> Iterator[tuple[Study, MakeRun]]:
    """Gives the study of the scenes with every installed method and with the predicted largest
    steps, and a function that makes one more run. Results are taken from the store if they are
    there, and are stored otherwise."""
    from plumbob.engines.study.checkpoint import shared_results
    from plumbob.engines.study.runner import run_study
    from plumbob.reports.analyses.engines.largest_steps import predictions
    from plumbob.reports.commands.arguments.console import note, progress, writable_folder

    methods = [method for method in find_methods() if installed(engine_of(method))]
    number_of_tasks = len(scenes) * len(methods)
    out = Path(chosen.out)
    file: Path | None = out / FILE
    try:
        writable_folder("out", out)
    except ParameterError as error:
        file = None
        note(f"the runs are not stored: {error}")
    with shared_results(file, out / store.FILE, note) as checkpoint, progress() as bar:
        show = _limited_progress(chosen.budget, bar)
        study = run_study(
            scenes,
            methods,
            jobs=min(os.cpu_count() or 1, 1 + number_of_tasks // 4),
            progress=show,
            requests=predictions,
            command=chosen.line,
            kept=checkpoint,
        )
        yield study, _single_run(checkpoint, show)


def _limited_progress(seconds: float, show: Progress) -> Progress:
    """Returns the progress callback `show`, which raises _OutOfTime after `seconds` [s] of
    processor time."""
    spent_before = spent()

    def limited(what: str, done: int, total: int) -> None:
        if spent() - spent_before > seconds:
            finished = f"{done} of {total} results are" if total else "the study is"
            raise _OutOfTime(
                f"the runs took more than {seconds:g} s of processor time (--budget): {finished} "
                f"there, next is {what}; the same command goes on"
            )
        show(what, done, total)

    return limited


def _single_run(checkpoint: Checkpoint, show: Progress) -> MakeRun:
    """Returns a function that runs a scene with a method at a step. The function takes the run from
    the checkpoint if it is there; otherwise it stores the run."""
    from plumbob.engines.study.checkpoint import key_of
    from plumbob.engines.study.measurement import Measurement, measure
    from plumbob.engines.study.provenance import versions_of
    from plumbob.engines.study.results import TaskResult

    def run(scene: Scene, method: Method, step: float) -> Measurement:
        key = key_of("run", scene, method, step, versions_of(method))
        stored_results = checkpoint.there([key])
        stored = stored_results[key].answer if stored_results else None
        if isinstance(stored, Measurement):
            stored_run = stored.scene, stored.method, stored.step
            if stored_run == (scene.name, method.name, step):
                return stored
        show(f"{scene.name} {method.name} at {step:.3g}", 0, 0)
        measurement, _ = measure(case_of(scene), method, step, theory=False)
        checkpoint.keep({key: TaskResult(measurement)})
        return measurement

    return run


def _print_answer(
    chosen: argparse.Namespace,
    question: Any,
    study: Study,
    answer: RecommendationSearch,
    user_method: Method | None,
) -> None:
    """Prints the answer, and beside it the errors with the settings of the user's file, which are
    measured now."""
    from plumbob.reports.view.user_settings import cost_factor

    provenance = study.provenance
    record = {
        **vars(answer.recommendation),
        "scenes": [scene.name for scene in question.scenes],
        "study": {"date": provenance.date, "versions": provenance.versions},
        "cut_short": answer.cut_short,
    }
    results: Sequence[UserResult] = ()
    if user_method:
        from plumbob.engines.study.runner import joined, run_study
        from plumbob.reports.advice.user_settings import user_results
        from plumbob.reports.judge.study_verdicts import judge_study

        study = joined(study, run_study(question.scenes, [user_method]))
        results = user_results(study, judge_study(study))
        record["user_settings"] = results
    values.show(
        chosen,
        record,
        "recommend",
        answer=answer.recommendation,
        asked=question,
        cut_short=answer.cut_short,
        made=provenance,
        engines=dict.fromkeys(method.engine for method in study.methods),
        results=results,
        factor=cost_factor,
    )
