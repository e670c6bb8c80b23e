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
from plumbob.reports.advice.advice import study_recommendation
from plumbob.reports.advice.recommend import Recommendation
from plumbob.reports.advice.simulated_kinds import advised_kinds
from plumbob.reports.advice.user_settings import user_results
from plumbob.reports.analyses.replay import replay
from plumbob.reports.judge.expectations import expected, standing, surprise
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.judge.tolerance import tolerance_excess
from plumbob.reports.judge.verdict import JudgedMethod, Judgement
from plumbob.reports.records.page_records import (
    ERROR_LEVELS,
    SHOWN_SETTINGS,
    Budget,
    ExactRecord,
    MotionSamples,
    PairVerdict,
    RunVerdict,
    SceneRecord,
    StudyRecord,
    SystemRecord,
    advised_name,
)

MAX_PLOTTED_PERIODS = 15  # most periods of a motion that a plot shows
PLOT_SAMPLES = 240  # samples of a motion in a plot
SETTINGS_FRICTION = 0.3  # friction coefficient in the contact settings on pages


def study_record(study: Study, judged: Judgements) -> StudyRecord:
    """Returns the records of a study that belong to no single scene."""
    names = dict.fromkeys(scene.system for scene in study.scenes)
    known_systems = systems_of(*names)
    systems = [known_systems[name] for name in names if name in known_systems]
    systems.sort(key=lambda system: (system.rank, system.name))
    pictures = [file for file in map(_picture, systems) if file]
    return StudyRecord(
        systems=tuple(map(_system_record, systems)),
        pictures={file.name: _base64(file) for file in pictures},
        settings=_settings({method.engine for method in study.methods}),
        user=user_results(study, judged),
        advised=_advised_settings(study, judged),
    )


def scene_record(study: Study, judged: Judgements, scene: Scene) -> SceneRecord:
    """Returns the record of a scene: verdicts, recommendations and the exact motion."""
    of_scene = [series for series in study.convergence if series.scene == scene.name]
    runs = [run for series in of_scene for run in series.measurements]
    is_checked = any(run.status == "done" for run in runs)
    recommendations: tuple[Recommendation, ...] = ()
    if study.costs:
        recommendations = tuple(
            study_recommendation(study, scene, e, judged) for e, _ in ERROR_LEVELS
        )
    has_exact = is_checked or not system_of(scene).distribution
    return SceneRecord(
        verdicts={series.method: verdict_on(study, series, judged) for series in of_scene},
        recommendations=recommendations,
        exact=_exact_record(study, scene) if has_exact else None,
    )


def _exact_record(study: Study, scene: Scene) -> ExactRecord:
    """Returns the exact motion of a scene, its facts that are numbers or texts, and its replay."""
    case = case_of(scene)
    facts = case.system.facts(case.problem)
    return ExactRecord(
        motion=_motion(case, facts.get("period") or np.inf),
        facts={n: v for n, v in facts.items() if isinstance(v, (int, float, str)) and v != ""},
        replay=replay(study, scene),
    )


def verdict_on(study: Study, series: ConvergenceStudy, judged: Judgements) -> PairVerdict:
    """Returns the verdict on one method on one scene, for the pages."""
    pair = judged[series.scene, series.method]
    scene = next(scene for scene in study.scenes if scene.name == series.scene)
    method = next(method for method in study.methods if method.name == series.method)
    declared = expected(scene.name, method.name)
    leading = study.observables(scene.name)[0].name
    step, budgets = _budgets(study, series, pair)
    return PairVerdict(
        verdict=pair.whole.verdict,
        reason=pair.whole.reason,
        standing=standing(scene, method, pair.whole),
        expected=declared.verdict,
        declared=declared.reason,
        runs=tuple(_run_verdict(run, leading) for run in pair.runs),
        unjudged=pair.whole.unjudged,
        surprise=surprise(scene, method, pair.whole),
        budget_step=step,
        budgets=budgets,
    )


def _run_verdict(run: Judgement, leading: str) -> RunVerdict:
    """Returns the verdict on a run, with its bound on the error of the observable `leading`."""
    tolerance = run.tolerances.get(leading)
    return RunVerdict(run.verdict, run.reason, tolerance.bound if tolerance else None)


def _budgets(
    study: Study, series: ConvergenceStudy, judged: JudgedMethod
) -> tuple[float, tuple[Budget, ...]]:
    """Returns the step of the run whose error budgets are shown, and the budgets.

    If a run is off its prediction, the budgets are those of the first such run, for all
    observables. Otherwise they are those of the finest judged run, for the leading observable. If
    no run was judged, there are none, and the step is 0."""
    pairs = zip(series.measurements, judged.runs, strict=True)
    with_tolerances = [(run, judgement) for run, judgement in pairs if judgement.tolerances]
    if not with_tolerances:
        return 0.0, ()
    units = {o.name: o.unit for o in study.observables(series.scene)}
    off = [pair for pair in with_tolerances if pair[1].verdict == "off-prediction"]
    run, judgement = off[0] if off else with_tolerances[-1]
    shown = list(units) if off else list(units)[:1]
    names = [name for name in judgement.tolerances if name in shown]
    return run.step, tuple(_budget(run, judgement, name, units) for name in names)


def _budget(run: Measurement, judged: Judgement, name: str, units: Mapping[str, str]) -> Budget:
    """Returns the error budget of one observable in one run."""
    tolerance = judged.tolerances[name]
    reason = tolerance_excess(run, name, tolerance, units) or ""
    return Budget(name, run.errors[name].largest, tolerance, reason)


def _motion(case: Case, period: float) -> MotionSamples:
    """Returns samples of the exact motion of a case, over at most MAX_PLOTTED_PERIODS periods
    [s]."""
    duration = case.scene.duration
    longest = MAX_PLOTTED_PERIODS * period
    times = np.linspace(0.0, min(duration, longest), PLOT_SAMPLES)
    observed = case.reference.observe(times)
    shown = [observed[observable.name].tolist() for observable in case.system.observables[:2]]
    return MotionSamples(
        times=tuple(times.tolist()),
        channels=tuple(map(tuple, shown)),
        periods=MAX_PLOTTED_PERIODS if longest < duration else 0,
    )


def _system_record(system: System) -> SystemRecord:
    """Returns the names and the picture of a system for its page."""
    file = _picture(system)
    return SystemRecord(
        name=system.name,
        title=system.title,
        default=system.default,
        picture=file.name if file else "",
        added=bool(system.distribution),
        phenomenon=system.phenomenon,
    )


def _picture(system: System) -> Path | None:
    """Returns the picture file of a system's model; None if there is none."""
    file = system.mjcf.parent / f"{system.mjcf.parent.name}.png"
    return file if file.is_file() else None


def _base64(file: Path) -> str:
    """Returns the content of a file in base64."""
    return base64.b64encode(file.read_bytes()).decode()


def _settings(engines: set[str]) -> Mapping[str, Settings]:
    """Returns the settings to copy, by method, for the shown methods of these engines."""
    methods = [find_method(name) for name, _ in SHOWN_SETTINGS]
    written = {
        method.name: _settings_of(method) for method in methods if method.engine in engines
    }
    return {name: settings for name, settings in written.items() if settings}


def _advised_settings(study: Study, judged: Judgements) -> Mapping[str, str]:
    """Returns the MJCF of each setting that the index advises for a kind of body."""
    verdicts = {pair: method.whole.verdict for pair, method in judged.items()}
    every = [one for kind in advised_kinds(study, verdicts) for one in kind.advice]
    chosen = {one.setting for one in every} | {one.elsewhere for one in every}
    written = {}
    for setting in chosen - {None}:
        settings = setting and _settings_of(find_method(setting.method), setting.step)
        if setting and settings:
            written[advised_name(setting.method, setting.step)] = settings.snippets[0].mjcf
    return dict(sorted(written.items()))


def _settings_of(method: Method, step: float = REFERENCE_STEP) -> Settings | None:
    """Returns the settings to copy for a method at a step [s]; None if its engine has none."""
    writer = engine_of(method).ability(SettingsToPaste)
    return writer.write(method, step, None, SETTINGS_FRICTION) if writer else None
