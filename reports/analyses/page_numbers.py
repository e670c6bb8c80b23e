"""The records of a study for its pages: verdicts, exact motions and recommendations."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from plumbob.engines.abilities import Settings, SettingsToPaste
from plumbob.engines.method import Method
from plumbob.engines.registry import engine_of
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import REFERENCE_STEP, Measurement
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of, system_of, systems_of
from plumbob.models.scene import Case, Scene, System
from plumbob.reports.advice.advice import from_study
from plumbob.reports.advice.user_settings import user_results
from plumbob.reports.analyses.replay import replay
from plumbob.reports.judge.expectations import expected, standing, surprise
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.judge.tolerance import exceeded
from plumbob.reports.judge.verdict import Judged, Judgement
from plumbob.reports.view.records import (
    Budget,
    ExactRecord,
    Motion,
    PairVerdict,
    RunVerdict,
    SceneRecord,
    StudyRecord,
    SystemRecord,
)
from plumbob.reports.view.settings import SHOWN
from plumbob.reports.view.top_tables import ERRORS

PERIODS = 15  # most periods of a motion that a plot shows
SAMPLES = 240  # samples of a motion in a plot
FRICTION = 0.3  # friction coefficient in settings, the default of `plumbob settings`


def study_record(study: Study, judged: Judgements) -> StudyRecord:
    """Returns the records of a study that belong to no single scene."""
    names = dict.fromkeys(scene.system for scene in study.scenes)
    there = systems_of(*names)
    systems = [there[name] for name in names if name in there]
    return StudyRecord(
        tuple(map(_system, systems)),
        {file.name: _base64(file) for system in systems if (file := _picture(system))},
        _settings({method.engine for method in study.methods}),
        user_results(study, judged),
    )


def scene_record(study: Study, judged: Judgements, scene: Scene) -> SceneRecord:
    """Returns the record of a scene: verdicts, recommendations and the exact motion."""
    series = [c for c in study.convergence if c.scene == scene.name]
    held = any(m.status == "done" for c in series for m in c.measurements)
    return SceneRecord(
        {c.method: verdict_on(study, c, judged) for c in series},
        tuple(from_study(study, scene, e, judged) for e, _ in ERRORS) if study.costs else (),
        _exact(study, scene) if held or not system_of(scene).distribution else None,
    )


def _exact(study: Study, scene: Scene) -> ExactRecord:
    case = case_of(scene)
    facts = case.system.facts(case.problem)
    return ExactRecord(
        _motion(case, facts.get("period") or np.inf),
        {n: v for n, v in facts.items() if isinstance(v, (int, float, str)) and v != ""},
        replay(study, scene),
    )


def verdict_on(study: Study, series: ConvergenceStudy, judged: Judgements) -> PairVerdict:
    """Returns the verdict on one method on one scene, for the pages."""
    both = judged[series.scene, series.method]
    scene = next(scene for scene in study.scenes if scene.name == series.scene)
    method = next(method for method in study.methods if method.name == series.method)
    wanted = expected(scene.name, method.name)
    step, budgets = _budgets(study, series, both)
    return PairVerdict(
        both.whole.verdict,
        both.whole.reason,
        standing(scene, method, both.whole),
        wanted.verdict,
        wanted.reason,
        tuple(_run(run, study.observables(scene.name)[0].name) for run in both.runs),
        both.whole.unjudged,
        surprise(scene, method, both.whole),
        step,
        budgets,
    )


def _run(run: Judgement, leading: str) -> RunVerdict:
    held = run.tolerances.get(leading)
    return RunVerdict(run.verdict, run.reason, held.bound if held else None)


def _budgets(
    study: Study, series: ConvergenceStudy, judged: Judged
) -> tuple[float, tuple[Budget, ...]]:
    """Returns the step of the run whose error budgets are shown, and the budgets.

    If a run is off its prediction, the budgets are those of the first such run, for all
    observables. Otherwise they are those of the finest judged run, for the leading observable. If
    no run was judged, there are none, and the step is 0."""
    runs = zip(series.measurements, judged.runs, strict=True)
    held = [(m, run) for m, run in runs if run.tolerances]
    if not held:
        return 0.0, ()
    m, run = next((pair for pair in held if pair[1].verdict == "off-prediction"), held[-1])
    units = {o.name: o.unit for o in study.observables(series.scene)}
    shown = [next(iter(units))] if run.verdict != "off-prediction" else list(units)
    return m.step, tuple(
        _budget(m, run, name, units) for name in run.tolerances if name in shown
    )


def _budget(run: Measurement, judged: Judgement, name: str, units: Mapping[str, str]) -> Budget:
    held = judged.tolerances[name]
    why = exceeded(run, name, held, units) or ""
    return Budget(name, run.errors[name].largest, held, why)


def _motion(case: Case, period: float) -> Motion:
    duration = case.scene.duration
    most = PERIODS * period
    times = np.linspace(0.0, min(duration, most), SAMPLES)
    observed = case.reference.observe(times)
    channels = [observed[o.name].tolist() for o in case.system.observables[:2]]
    return Motion(
        tuple(times.tolist()), tuple(map(tuple, channels)), PERIODS * (most < duration)
    )


def _system(system: System) -> SystemRecord:
    file = _picture(system)
    added = bool(system.distribution)
    return SystemRecord(
        system.name, system.title, system.default, file.name if file else "", added
    )


def _picture(system: System) -> Path | None:
    """Returns the picture file of a system's model; None if there is none."""
    file = system.mjcf.parent / f"{system.mjcf.parent.name}.png"
    return file if file.is_file() else None


def _base64(file: Path) -> str:
    return base64.b64encode(file.read_bytes()).decode()


def _settings(engines: set[str]) -> Mapping[str, Settings]:
    """Returns the settings to copy, by method, for the shown methods of these engines."""
    methods = [find_method(name) for name, _ in SHOWN]
    return {
        m.name: written for m in methods if m.engine in engines and (written := _written(m))
    }


def _written(method: Method) -> Settings | None:
    settings = engine_of(method).ability(SettingsToPaste)
    return None if settings is None else settings.write(method, REFERENCE_STEP, None, FRICTION)
