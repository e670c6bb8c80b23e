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
from plumbob.models.scene import Quantity, Scene
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.budget import certify
from plumbob.reports.commands.own_file import described, is_file, motion

if TYPE_CHECKING:
    from plumbob.engines.audit.step_errors import StepError
    from plumbob.engines.own_motion import Script
    from plumbob.engines.study.checkpoint import Checkpoint
    from plumbob.engines.study.measurement import Measurement
    from plumbob.engines.study.scheduler import Progress
    from plumbob.reports.advice.advice import Answer, MakeRun
    from plumbob.reports.advice.audit_advice import StepEvidence
    from plumbob.reports.advice.user_settings import UserResult

SAMPLES = 100  # of the exact motion, to see how large it is
ROUNDING = 2.0**-53  # relative, of a double
EXACT = 0.1  # of the budget: the exact motion, where it is integrated
INCOMPLETE = 3
FILE = "recommend.sqlite3"  # what this command has run, beside the studies of `validate`
OUT = "plumbob-out"
BUDGET, OF_FILE = 600.0, 60.0  # [s] of processor time for scenes, for a model file
OF_SCENES = ("changes", "like", "stored", "observable", "engine", "out")  # options no file has


class _OutOfTime(Exception):
    """The budget is spent."""


def command(chosen: argparse.Namespace) -> int:
    """Answer from what is stored of the scenes, and run what is missing. 0 where a method reaches
    the error, 1 where none does, 3 where the budget ends before."""
    from plumbob.reports.commands.arguments.like import own_method

    if is_file(chosen, OF_SCENES):
        chosen.budget = chosen.budget or OF_FILE
        return _of_file(chosen)
    chosen.budget = chosen.budget or BUDGET
    chosen.out = chosen.out or OUT
    if chosen.absolute is None and chosen.observable is not None:
        raise ParameterError("observable", chosen.observable, "given with --absolute")
    user_method = own_method(chosen.like) if chosen.like else None
    scenes = () if _said_by_study(chosen) else values.scenes(chosen.scene, chosen.changes)
    if user_method and len(scenes) > 1:
        raise ParameterError("like", chosen.like, "given with one scene, not with a pattern")
    if chosen.engine is not None and chosen.engine not in engines():
        raise ParameterError("engine", chosen.engine, f"one of {', '.join(engines())}")
    for scene in scenes:
        _check(chosen.observable, system_of(scene).observables)
    if chosen.changes:
        with values.representable(chosen.changes, chosen):
            for scene in scenes:
                certify(case_of(scene), scene.duration, chosen.budget, EXACT)
    if not chosen.stored:
        for scene in scenes:
            _reachable(chosen, scene)
    try:
        return _answered(chosen, scenes, user_method)
    except _OutOfTime as stopped:
        print(f"plumbob: {stopped}", file=sys.stderr)
        return INCOMPLETE


def _answered(
    chosen: argparse.Namespace, scenes: Sequence[Scene], user_method: Method | None
) -> int:
    """Answer the question about these scenes, or the one that is named; raises _OutOfTime."""
    from plumbob.reports.advice.advice import Question, advise

    measured = _stored if chosen.stored else _run
    with measured(chosen, scenes) as (study, run):
        _check(chosen.observable, study.observables(study.scenes[0].name))
        methods = tuple(
            m
            for m in study.methods
            if m.name != USER_METHOD and chosen.engine in (None, m.engine)
        )
        name = chosen.scene if len(study.scenes) > 1 else study.scenes[0].name
        error = chosen.error or chosen.absolute
        absolute = chosen.error is None
        asked = Question(name, study.scenes, methods, error, absolute, chosen.observable)
        answer = advise(asked, study, run)
    _show(chosen, asked, study, answer, user_method)
    return 0 if answer.recommendation.choice else 1


def _of_file(chosen: argparse.Namespace) -> int:
    """Print the cheapest integrator and step of MuJoCo's whose error on a model file, in metres,
    stays within what is asked for: 1 where none does, 3 where the motion is not certified to its
    end, or not well enough."""
    from plumbob.engines.audit.allowance import Allowance
    from plumbob.engines.audit.audit import held_to_reference, largest_steps_along
    from plumbob.engines.audit.user_models import quiet
    from plumbob.reports.advice.audit_advice import StepEvidence
    from plumbob.reports.commands.arguments.console import note, progress

    target = chosen.error or chosen.absolute
    with quiet(), progress() as show:
        model, script = motion(chosen)
        allowance = Allowance(chosen.budget, progress=lambda what: show(what, 0, 0))
        reference, steps = held_to_reference(model, script, allowance)
        if steps is not None:
            limits = largest_steps_along(model, script, reference, allowance)
    if steps is None:
        note(f"{chosen.scene} has no certified motion: {reference.why}")
        return INCOMPLETE
    evidence = StepEvidence(model, reference, steps, limits)
    answer = _file_choice(chosen, target, script, evidence)
    values.show(chosen, answer, "recommend_file", format=model.format, **answer)
    if not answer["decided"]:
        return INCOMPLETE
    return 0 if answer["choice"] else 1


def _file_choice(
    chosen: argparse.Namespace,
    target: float,
    script: Script,
    evidence: StepEvidence,
) -> dict[str, Any]:
    """The cheapest integrator and step for an error of `target` [m] as plain data, the model's own
    and the one with the smallest error beside it."""
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
        choice["options"] = {name: then for name, (_, then) in best.options.items()}

    def plain(step: StepError) -> dict[str, Any]:
        names = ("integrator", "step", "ns_per_second")
        return {name: getattr(step, name) for name in names} | {"error": step.at(index)}

    return {
        **described(chosen, script, reference, index),
        "target": target,
        "decided": index == len(script.controls)
        and bool(reference.uncertainty[index] <= TRUSTED * target),
        "choice": choice,
        "own": plain(steps.own),
        "nearest": plain(min(steps.steps, key=lambda step: step.at(index))),
        "clamped": model.clamped if steps.clamping_acts else {},
        "notes": [*model.notes, *steps.own.remarks],
        "versions": package_versions(),
    }


def _said_by_study(chosen: argparse.Namespace) -> bool:
    """Whether a stored study says all of the one scene that is named: to load every system would
    take longer than the answer."""
    named = "/" in chosen.scene and not set("*?[,") & set(chosen.scene)
    return chosen.stored and named and not chosen.changes


def _check(observable: str | None, observables: Observables) -> None:
    """Raises ParameterError where an observable is none of these."""
    names = [o.name for o in observables]
    if observable not in (None, *names):
        raise ParameterError(
            "observable", observable, f"one of {nearest(str(observable), names)}"
        )


def _reachable(chosen: argparse.Namespace, scene: Scene) -> None:
    """Raises ParameterError if the wanted error is less than what rounding alone makes of the exact
    motion of a scene: no method and no step reaches it."""
    case = case_of(scene)
    if case.system.distribution:  # its exact motion may be a defect, which the study tells
        return
    about = case.system.quantities(case)
    if chosen.error is None:
        name = chosen.observable or about[0].observable
        of_interest = (q for q in about if q.observable == name)
        about = (replace(next(of_interest, Quantity(name, 1.0)), scale=1.0),)
    exact = case.reference.observe(np.linspace(0.0, scene.duration, SAMPLES))
    counted = {q: exact[q.observable][-1 if q.when == "end" else 0 :] for q in about}
    least = max(ROUNDING * float(np.abs(v).max()) / q.scale for q, v in counted.items())
    option, wanted = ("error", chosen.error) if chosen.error else ("absolute", chosen.absolute)
    if 0.0 < wanted < least:
        what = f"at least {least:.2g}: rounding alone makes such an error on {scene.name}"
        raise ParameterError(option, wanted, what)


@contextmanager
def _stored(
    chosen: argparse.Namespace, scenes: Sequence[Scene]
) -> Iterator[tuple[Study, MakeRun | None]]:
    """The newest stored study of these scenes, or without any of the one that is named, and nothing
    to run; raises ParameterError."""
    by_name = {scene.name: scene for scene in scenes}
    names = by_name or (chosen.scene,)
    study = store.load(Path(chosen.out) / store.FILE, scenes=names)
    there = [
        s
        for s in (study.scenes if study else ())
        if s.name in names and s.duration == (of := by_name.get(s.name, s)).duration
        if dict(s.parameters) == dict(of.parameters)  # at whatever steps
    ]
    if study is None or not there:
        raise ParameterError(
            "scene", next(iter(names)), "one that was measured, as nothing is run"
        )
    for entry in changed_since(study.provenance):
        print(f"plumbob: the stored runs are of {entry}", file=sys.stderr)
    yield replace(study, scenes=tuple(there)), None


@contextmanager
def _run(
    chosen: argparse.Namespace, scenes: Sequence[Scene]
) -> Iterator[tuple[Study, MakeRun]]:
    """The study of these scenes with every method that is installed, with predicted limits of the
    step, and what runs one more; what is stored of both is taken, the rest is stored."""
    from plumbob.engines.study.checkpoint import shared_results
    from plumbob.engines.study.runner import run_study
    from plumbob.reports.analyses.engines.largest_steps import predictions
    from plumbob.reports.commands.arguments.console import note, progress, writable_folder

    methods = [m for m in find_methods() if installed(engine_of(m))]
    out = Path(chosen.out)
    file: Path | None = out / FILE
    try:
        writable_folder("out", out)
    except ParameterError as error:
        file = None
        note(f"the runs are not stored: {error}")
    with shared_results(file, out / store.FILE, note) as kept, progress() as shown:
        show = _within(chosen.budget, shown)
        study = run_study(
            scenes,
            methods,
            jobs=min(os.cpu_count() or 1, 1 + len(scenes) * len(methods) // 4),
            progress=show,
            requests=predictions,
            command=chosen.line,
            kept=kept,
        )
        yield study, _one_more(kept, show)


def _within(seconds: float, show: Progress) -> Progress:
    """The progress `show`, which raises _OutOfTime after so many seconds of processor time."""
    begin = spent()

    def within(what: str, done: int, total: int) -> None:
        if spent() - begin > seconds:
            there = f"{done} of {total} results are" if total else "the study is"
            raise _OutOfTime(
                f"the runs took more than {seconds:g} s of processor time (--budget): {there} "
                f"there, next is {what}; the same command goes on"
            )
        show(what, done, total)

    return within


def _one_more(kept: Checkpoint, show: Progress) -> MakeRun:
    """A run of a scene with a method at a step, taken where it is kept, and else kept."""
    from plumbob.engines.study.checkpoint import key_of
    from plumbob.engines.study.measurement import Measurement, measure
    from plumbob.engines.study.provenance import versions_of
    from plumbob.engines.study.results import TaskResult

    def run(scene: Scene, method: Method, step: float) -> Measurement:
        key = key_of("run", scene, method, step, versions_of(method))
        there = kept.there([key])
        stored = there[key].answer if there else None
        asked = scene.name, method.name, step
        if (
            isinstance(stored, Measurement)
            and (stored.scene, stored.method, stored.step) == asked
        ):
            return stored
        show(f"{scene.name} {method.name} at {step:.3g}", 0, 0)
        measurement, _ = measure(case_of(scene), method, step, theory=False)
        kept.keep({key: TaskResult(measurement)})
        return measurement

    return run


def _show(
    chosen: argparse.Namespace,
    asked: Any,
    study: Study,
    answer: Answer,
    user_method: Method | None,
) -> None:
    """Print the answer, and what a user's own settings, measured now, give beside it."""
    from plumbob.reports.view.user_settings import cost_factor

    made = study.provenance
    record = {
        **vars(answer.recommendation),
        "scenes": [scene.name for scene in asked.scenes],
        "study": {"date": made.date, "versions": made.versions},
        "cut_short": answer.cut_short,
    }
    results: Sequence[UserResult] = ()
    if user_method:
        from plumbob.engines.study.runner import joined, run_study
        from plumbob.reports.advice.user_settings import user_results
        from plumbob.reports.judge.study_verdicts import judge_study

        study = joined(study, run_study(asked.scenes, [user_method]))
        results = user_results(study, judge_study(study))
        record["user_settings"] = results
    values.show(
        chosen,
        record,
        "recommend",
        answer=answer.recommendation,
        asked=asked,
        cut_short=answer.cut_short,
        made=made,
        engines=dict.fromkeys(method.engine for method in study.methods),
        results=results,
        factor=cost_factor,
    )
