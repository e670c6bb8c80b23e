"""plumbob stability: the largest stable step on scenes or a model file; with --long, the time after
which a method is wrong; and predictions of both."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.long_runs import LongRunSearch, MeasuredLongRun
from plumbob.engines.study.loop_limits import LoopSearch, has_loop
from plumbob.engines.study.stability import StabilitySearch
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.shared.model_file import (
    FILE_OPTIONS,
    is_model_file,
    model_and_script,
    motion_record,
)
from plumbob.reports.commands.shared.searches import search_study
from plumbob.reports.judge.long_runs import JudgedLongRun, judged_long_run
from plumbob.reports.judge.stability import JudgedLimit, study_limits
from plumbob.reports.view.own_files import check_replaceable
from plumbob.reports.view.stability import STABILITY_PAGE, stability_table, write_stability_page
from plumbob.reports.view.terminal import aligned

if TYPE_CHECKING:
    from plumbob.engines.method import Method
    from plumbob.engines.study.request import RunRequest
    from plumbob.engines.study.results import Study
    from plumbob.models.scene import Scene

INCOMPLETE = 3
LEAST_DURATION = 1e-9  # [s] duration of a motion that is one control period
BUDGET = 60.0  # [s] processor time for a model file
# Options that a model file does not take.
SCENE_OPTIONS = ("long", "step", "jobs", "out")


def command(chosen: argparse.Namespace) -> int:
    """Measures, judges and prints the largest steps. Returns 1 if a step is not as expected, 3 if
    an engine is missing."""
    if is_model_file(chosen, SCENE_OPTIONS, (*FILE_OPTIONS, "budget", "policy", "delay")):
        if chosen.policy is not None:
            return _print_loops(chosen)
        values.refuse_options(chosen, ("delay",), "given with --policy")
        return _print_file_limits(chosen)
    scenes = values.scenes(chosen.scene, {})
    methods = find_methods(",".join(chosen.method) or "*")
    if chosen.out:
        check_replaceable("out", Path(chosen.out) / STABILITY_PAGE)
    if not chosen.method:
        methods = tuple(method for method in methods if installed(engine_of(method)))
    study = _measured_study(chosen, scenes, methods)
    judged = list(_judged_results(study))
    page = chosen.out and write_stability_page(judged, study.provenance, Path(chosen.out))
    records = [result.record() for result in judged]
    rows = aligned(stability_table(judged))
    surprises = [
        (record, result)
        for record, result in zip(records, judged, strict=True)
        if result.surprise
    ]
    values.show(chosen, records, "stability", rows=rows, surprises=surprises, page=page)
    if surprises:
        return 1
    complete = all(installed(engine_of(method)) for method in methods)
    return 0 if complete else INCOMPLETE


def _print_file_limits(chosen: argparse.Namespace) -> int:
    """Prints the largest steps that hold along the motion of a model file. The methods are those
    that the user names; by default, the file's own integrator and all others. Returns 1 if the
    file's own step is unstable by the first method. Returns 3 if the limit of the first method is
    not known, if the motion is not certified, or if an engine is not installed."""
    from plumbob.engines.audit.allowance import Allowance
    from plumbob.engines.audit.audit import REFERENCE
    from plumbob.engines.audit.reference import certified
    from plumbob.engines.audit.step_of_method import method_steps, runs_of
    from plumbob.engines.audit.user_models import quiet
    from plumbob.engines.study.provenance import version_of
    from plumbob.reports.commands.arguments.console import note, progress
    from plumbob.reports.view.audit.page import package_versions
    from plumbob.reports.view.audit.records import stability_record

    chosen.budget = chosen.budget or BUDGET
    with quiet(), progress() as show:
        model, script = model_and_script(chosen)
        methods: list[Method] = []
        for pattern in chosen.method:
            methods += find_methods(pattern)
        for method in methods:
            runs_of(method, model.steppable)
        engines = {method.engine: engine_of(method) for method in methods}
        for engine in engines.values():
            if not installed(engine):
                note(f"{engine.package} is not installed")
                return INCOMPLETE
        allowance = Allowance(chosen.budget)
        show("the continuous motion, by two methods", 0, 0)
        reference = certified(model, script, allowance.part(REFERENCE))
        show("the largest step that holds", 0, 0)
        rest = allowance.part(max(1.0 - REFERENCE, allowance.left / chosen.budget))
        limits = method_steps(methods, model, script, reference.states, rest)
    answer = {
        **motion_record(chosen, script, reference, reference.known),
        "step": model.step,
        **stability_record(limits),
        "versions": package_versions() | {name: version_of(engines[name]) for name in engines},
    }
    values.show(chosen, answer, "stability_file", limits=limits, **answer)
    if not reference.known or not (limits.own.confirmed or limits.own.holds_to):
        return INCOMPLETE
    return 1 if limits.unstable else 0


def _steps_late(delay: float, step: float, hold: int) -> int:
    """Returns a `delay` [s] in steps [s] of a loop whose control period has `hold` steps. Raises
    ParameterError."""
    from plumbob.engines.audit.loop_stability import MOST_LATE

    longest = MOST_LATE * hold * step
    late = round(min(delay, 2.0 * longest) / step)
    if abs(late * step - delay) > 1e-6 * delay or late > MOST_LATE * hold:
        wanted = f"a multiple of the step, {step:g} s, up to {longest:g} s"
        raise ParameterError("delay", delay, wanted)
    return late


def _print_loops(chosen: argparse.Namespace) -> int:
    """Prints the stability of a model file under a policy about a fixed point, with each integrator
    that the user names; by default with the file's own. Returns 1 if the first loop is unstable, 3
    if there is no fixed point. Raises ParameterError."""
    from plumbob.engines.audit.loop_stability import (
        MOST_GAIN,
        MOST_HOLD,
        MOST_LATE,
        FedBackModel,
        loop_stability,
    )
    from plumbob.engines.audit.step_of_method import runs_of
    from plumbob.engines.audit.user_models import quiet
    from plumbob.engines.closed_loop import ClosedLoop
    from plumbob.engines.own_motion import NotCertifiable
    from plumbob.reports.commands.arguments.console import note
    from plumbob.reports.view.audit.page import package_versions
    from plumbob.reports.view.audit.records import loop_record

    if chosen.ctrl != "rest":
        raise ParameterError("ctrl", chosen.ctrl, "left out with --policy")
    values.refuse_options(chosen, ("duration",), "left out with --policy")
    loops = []
    chosen.budget, chosen.duration = chosen.budget or BUDGET, LEAST_DURATION
    with quiet():
        model, script = model_and_script(chosen)
        named = (runs_of(m, model.steppable) for p in chosen.method for m in find_methods(p))
        integrators = tuple(named) or (model.integrator,)
        hold = script.parts(model.step)
        late = _steps_late(chosen.delay or 0.0, model.step, hold)
        assert isinstance(script.loop, ClosedLoop)
        for name in integrators:
            if name not in model.steppable:
                raise ParameterError("method", name, "an integrator of MuJoCo, with --policy")
            fed_back = FedBackModel(model.with_integrators((name,)), script.loop, hold, late)
            try:
                loops.append(loop_stability(fed_back, script.start))
            except NotCertifiable as why:
                note(f"{chosen.scene} with {name}: {why}")
                return INCOMPLETE
    answer = {
        "model": chosen.scene,
        "policy": chosen.policy,
        "loops": [loop_record(loop) for loop in loops],
        "versions": package_versions(),
    }
    words = {
        "model": chosen.scene,
        "loops": loops,
        "most": {"hold": MOST_HOLD, "delay": MOST_LATE, "gain": MOST_GAIN},
    }
    values.show(chosen, answer, "stability_loop", **words)
    return 1 if loops[0].unstable else 0


def _measured_study(
    chosen: argparse.Namespace, scenes: Sequence[Scene], methods: Sequence[Method]
) -> Study:
    """Returns a study of the largest steps, or of the long runs, of each pair of a scene and a
    method. Raises ParameterError."""
    from plumbob.engines.study.runner import pairs

    looped = {scene.name for scene in scenes if has_loop(scene)}
    if chosen.step is not None and not (chosen.long or len(looped) == len(scenes)):
        wanted = "left out without --long and without a digital controller"
        raise ParameterError("step", chosen.step, wanted)
    searches: list[RunRequest[Any]] = []
    for scene, method in pairs(scenes, methods):
        if chosen.long:
            searches.append(LongRunSearch(scene.name, method.name, chosen.step))
        elif scene.name in looped:
            searches.append(LoopSearch(scene.name, method.name, chosen.step))
        else:
            searches.append(StabilitySearch(scene.name, method.name))
    if not searches:
        given = ",".join(chosen.method) or None
        raise ParameterError("method", given, f"one that is meant for {chosen.scene}")
    return search_study(chosen, methods, searches, chosen.out)


def _judged_results(study: Study) -> Iterator[JudgedLimit | JudgedLongRun]:
    """Gives the judged long runs and largest steps of a study. If the engine of a long run is
    missing or its process was lost, the judged result states that reason."""
    for request in study.extras:
        if isinstance(request, LongRunSearch):
            lost = MeasuredLongRun(why="its engine is missing, or its process was lost")
            yield judged_long_run(request, study.answer(request) or lost)
    yield from study_limits(study)
