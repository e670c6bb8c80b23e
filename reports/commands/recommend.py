"""plumbob recommend: the cheapest method and step for an error, from measurement."""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import USER_METHOD, Method
from plumbob.engines.registry import engine_of, engines, installed
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study import store
from plumbob.engines.study.merged_studies import (
    SEARCH,
    LeftOut,
    merged,
    searched_runs,
    with_installed_versions,
)
from plumbob.engines.study.results import Study
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import scenes as find_scenes
from plumbob.models.scene import Scene
from plumbob.reports.commands.arguments import values

if TYPE_CHECKING:
    from plumbob.engines.study.scheduler import Progress
    from plumbob.reports.advice.advice import Answer, Known, RunStudies
    from plumbob.reports.advice.recommend import Choice, Recommendation

FILE = "recommend.sqlite3"  # what this command has run, beside the studies of `validate`


def command(chosen: argparse.Namespace) -> int:
    """Answer from everything that is stored of the scenes; run what is missing. 0 where a method
    reaches the error, 1 where none does."""
    from plumbob.reports.advice.advice import Question, advise
    from plumbob.reports.commands.arguments.like import own_method
    from plumbob.reports.commands.validate import progress

    error = _wanted(chosen)
    user_method = own_method(chosen.like) if chosen.like else None
    out = Path(chosen.out)
    scenes = _scenes(chosen.scene, values.changes(chosen.changes))
    if user_method and len(scenes) > 1:
        raise ParameterError("like", chosen.like, "given with one scene, not with a pattern")
    known, left_out = _known(scenes, out, chosen.stored)
    if chosen.stored and known:
        scenes = tuple(scene for scene in scenes if scene.name in known)
    methods = _methods(chosen.engine, known, chosen.stored)
    name = scenes[0].name if len(scenes) == 1 else chosen.scene
    asked = Question(name, scenes, methods, error, chosen.error is None, chosen.observable)
    with progress() as show:
        run = None if chosen.stored else _runner(show)
        answer = advise(asked, known, run, progress=lambda what: show(what, 0, 0))
    if not chosen.stored:
        _store(answer, scenes, out / FILE)
    _show(chosen.json, asked, answer, user_method)
    for (version, date), runs in left_out.items():
        left = LeftOut(version, date, runs)
        print(f"plumbob: {left} left out; run `plumbob validate` again", file=sys.stderr)
    return 0 if answer.recommendation.choice else 1


def _wanted(chosen: argparse.Namespace) -> float:
    """The error that is asked for; raises ParameterError."""
    if chosen.error is None:
        return values.positive_number("absolute", chosen.absolute)
    if chosen.observable is not None:
        raise ParameterError("observable", chosen.observable, "given with --absolute")
    return values.positive_number("error", chosen.error)


def _scenes(name: str, changed: Mapping[str, Any]) -> tuple[Scene, ...]:
    """The scenes of a name or pattern, with some parameters changed."""
    with values.representable(changed):
        if any(mark in name for mark in "*?[,"):
            scenes = find_scenes(name)
            return tuple(find_scene(s.name, changed) for s in scenes) if changed else scenes
        return (find_scene(name, changed),)


def _known(
    scenes: Sequence[Scene], out: Path, stored: bool
) -> tuple[dict[str, Known], Counter[tuple[str, str]]]:
    """The stored measurements of each scene by the installed versions, and counts of those by other
    versions."""
    from plumbob.reports.advice.advice import Known

    here, known = find_methods(), dict[str, Known]()
    left_out = Counter[tuple[str, str]]()
    for scene in scenes:
        usable = []
        for file in (FILE, store.FILE):
            for study in store.studies_of(out / file, scene.name):
                kept, left = with_installed_versions(_of(study, None if stored else here))
                usable.append(kept)
                for entry in left:
                    left_out[entry.version, entry.date] += entry.runs
        steps_run = merged([s for s in usable if s.profile != SEARCH], scene)
        if steps_run and steps_run.convergence:
            more = searched_runs([s for s in usable if s.profile == SEARCH], scene)
            known[scene.name] = Known(steps_run, more)
    return known, left_out


def _of(study: Study, here: Sequence[Method] | None) -> Study:
    """A study without a user's settings, which another file may have been, and without methods that
    are defined in another way than `here`."""
    known = [replace(m, surrogate="") for m in here or study.methods if m.name != USER_METHOD]
    return study.of_methods([m.name for m in study.methods if replace(m, surrogate="") in known])


def _methods(engine: str | None, known: Mapping[str, Known], stored: bool) -> tuple[Method, ...]:
    """The methods that may be named: all that are installed, or all that were run."""
    if engine is not None and engine not in engines():
        raise ParameterError("engine", engine, f"one of {', '.join(engines())}")
    every = {m.name: m for m in find_methods() if installed(engine_of(m))}
    if stored:
        every = {m.name: m for of_scene in known.values() for m in of_scene.study.methods}
    return tuple(m for m in every.values() if engine in (None, m.engine))


def _runner(show: Progress) -> RunStudies:
    """A runner of convergence studies, with predicted limits of the step: a few runs in this
    process, many in others too."""
    from plumbob.engines.study.runner import run_study
    from plumbob.reports.analyses.engines.largest_steps import predictions

    def run(scenes: Sequence[Scene], methods: Sequence[Method]) -> Study:
        jobs = min(os.cpu_count() or 1, 1 + len(scenes) * len(methods) // 4)
        timed = len(scenes) == 1
        return run_study(
            scenes, methods, jobs=jobs, progress=show, timed=timed, requests=predictions
        )

    return run


def _store(answer: Answer, scenes: Sequence[Scene], file: Path) -> None:
    """Keep what was run, for the next time."""
    from plumbob.engines.study.convergence import ConvergenceStudy
    from plumbob.engines.study.provenance import provenance

    studies = [*answer.made]
    for scene in scenes:
        runs = {m: each for (name, m), each in answer.runs.items() if name == scene.name}
        if runs:
            study = answer.studies[scene.name]
            by_method = (ConvergenceStudy(scene.name, m, tuple(each)) for m, each in runs.items())
            studies.append(
                replace(
                    study,
                    profile=SEARCH,
                    scenes=(scene,),
                    costs={},
                    extras={},
                    convergence=tuple(by_method),
                    methods=tuple(m for m in study.methods if m.name in runs),
                    provenance=provenance("plumbob recommend"),
                )
            )
    try:
        for study in studies:
            file.parent.mkdir(parents=True, exist_ok=True)
            store.save(study, file)
    except (OSError, ParameterError) as error:
        print(f"plumbob: the runs are not stored: {error}", file=sys.stderr)


def _show(as_json: bool, asked: Any, answer: Answer, user_method: Method | None) -> None:
    """Print the answer, and what a user's own settings, measured now, give beside it."""
    from plumbob.engines.study.runner import joined, run_study
    from plumbob.reports.advice.user_settings import user_results
    from plumbob.reports.judge.study_verdicts import judge_study
    from plumbob.reports.view import tables
    from plumbob.reports.view.user_settings import lines

    study = answer.studies[asked.scenes[0].name]
    made = study.provenance
    beside: dict[str, Any] = {}
    if user_method:
        study = joined(study, run_study(asked.scenes, [user_method]))
        beside["user_settings"] = user_results(study, judge_study(study))
    if as_json:
        values.print_json(
            {
                **asdict(answer.recommendation),
                "scenes": [scene.name for scene in asked.scenes],
                "study": {"date": made.date, "versions": made.versions},
                "cut_short": answer.cut_short,
                **{key: [asdict(result) for result in results] for key, results in beside.items()},
            }
        )
        return
    shown = tables.lines(
        "recommend",
        answer=answer.recommendation,
        asked=asked,
        named=_named(answer.recommendation),
        cut_short=answer.cut_short,
        made=made,
        engines=dict.fromkeys(method.engine for method in study.methods),
    )
    print(*shown, *lines(beside.get("user_settings", ())), sep="\n")


def _named(answer: Recommendation) -> list[tuple[str, Choice]]:
    """Choices, each with what it is."""
    named = {answer.choice: "use", answer.runner_up: "runner-up", answer.best: "the best:"}
    for choice in answer.by_engine:
        named.setdefault(choice, f"in {choice.method.partition('/')[0]}")
    named[answer.surrogate] = "surrogate"
    rows = [(name, choice) for choice, name in named.items() if choice]
    return [*rows, *(("at 0.002 s", choice) for choice in answer.defaults)]
