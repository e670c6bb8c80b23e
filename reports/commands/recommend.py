"""plumbob recommend: the cheapest method and step for an error, from measurement."""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import USER_METHOD, Method
from plumbob.engines.study import store
from plumbob.engines.study.merged_studies import SEARCH, LeftOut, merged, searched_runs
from plumbob.engines.study.merged_studies import with_installed_versions as current
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.commands.arguments import values

if TYPE_CHECKING:
    from plumbob.engines.study.scheduler import Progress
    from plumbob.engines.study.stability import KnownLimit
    from plumbob.reports.advice.advice import Answer, Known, Question, RunStudies
    from plumbob.reports.advice.recommend import Choice, Recommendation
    from plumbob.reports.advice.user_settings import UserResult

FILE = "recommend.sqlite3"  # what this command has run, beside the studies of `validate`
CHANGED = "changed"  # the profile of studies of a scene with parameters of --set


def command(chosen: argparse.Namespace) -> int:
    """Answer from everything that is stored of the scenes; run what is missing. 0 where a method
    reaches the error, 1 where none does."""
    from plumbob.reports.advice.advice import Question, advise
    from plumbob.reports.commands.validate import progress

    error = _wanted(chosen)
    changed = values.changes(chosen.changes)
    user_method = _own(chosen.like) if chosen.like else None
    out = Path(chosen.out)
    scenes = _scenes(chosen.scene, changed, out, chosen.stored)
    if user_method and len(scenes) > 1:
        raise ParameterError("like", chosen.like, "given with one scene, not with a pattern")
    known, left_out = _known(scenes, out, bool(changed), chosen.stored)
    methods = _methods(chosen.engine, known, chosen.stored)
    name = scenes[0].name if len(scenes) == 1 else chosen.scene
    asked = Question(name, scenes, methods, error, chosen.error is None, chosen.observable)
    with progress() as show:
        answer = advise(
            asked,
            known,
            None if chosen.stored else _runner(show),
            progress=lambda what: show(what, 0, 0),
        )
    if not chosen.stored:
        _store(answer, scenes, out / FILE, bool(changed))
    study = answer.studies[scenes[0].name]
    beside = {}
    results: tuple[UserResult, ...] = ()
    if user_method:
        study, results = _with_own(study, scenes, user_method)
        beside = {"user_settings": [asdict(result) for result in results]}
    _show(chosen.json, asked, answer, study, beside, results)
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


def _scenes(name: str, changed: dict[str, Any], out: Path, stored: bool) -> tuple[Scene, ...]:
    """The scenes of a name or pattern, with some parameters changed."""
    if stored and not changed:
        # As it was typed first: to know every scene takes longer than to answer.
        there = store.scene_names(out / store.FILE) + store.scene_names(out / FILE)
        names = [n for n in dict.fromkeys(there) if fnmatchcase(n, name)]
        if studies := [s for n in names if (s := _newest(out, n)) is not None]:
            return tuple(study.scenes[0] for study in studies)
    from plumbob.models.registry import scene as find_scene
    from plumbob.models.registry import scenes as find_scenes

    with values.representable(changed):
        if any(mark in name for mark in "*?[,"):
            scenes = find_scenes(name)
            return tuple(find_scene(s.name, changed) for s in scenes) if changed else scenes
        return (find_scene(name, changed),)


def _newest(out: Path, scene: str) -> Study | None:
    studies = (*_plain(out / FILE, scene), *store.studies_of(out / store.FILE, scene))
    return studies[-1] if studies else None


def _plain(file: Path, scene: str) -> tuple[Study, ...]:
    return tuple(s for s in store.studies_of(file, scene) if CHANGED not in s.profile)


def _known(
    scenes: Sequence[Scene], out: Path, changed: bool, stored: bool
) -> tuple[dict[str, Known], Counter[tuple[str, str]]]:
    """The stored measurements of each scene by the installed versions, and counts of those by other
    versions."""
    from plumbob.engines.registry import methods as find_methods
    from plumbob.reports.advice.advice import Known

    here = find_methods()
    known: dict[str, Known] = {}
    left_out = Counter[tuple[str, str]]()
    for scene in scenes:
        studies = list(store.studies_of(out / FILE, scene.name))
        if not changed:
            studies = [s for s in studies if CHANGED not in s.profile]
            studies += store.studies_of(out / store.FILE, scene.name)
        usable = []
        for study in (_of(study, None if stored else here) for study in studies):
            kept, left = current(study)
            usable.append(kept)
            for entry in left:
                left_out[entry.version, entry.date] += entry.runs
        steps_run = merged([s for s in usable if SEARCH not in s.profile], scene)
        if steps_run and steps_run.convergence:
            more = searched_runs([s for s in usable if SEARCH in s.profile], scene)
            known[scene.name] = Known(steps_run, more)
    return known, left_out


def _of(study: Study, here: Sequence[Method] | None) -> Study:
    """A study without a user's settings, which another file may have been, and without methods that
    are defined in another way than `here`."""
    known = [replace(m, surrogate="") for m in here or study.methods if m.name != USER_METHOD]
    return study.of_methods([m.name for m in study.methods if replace(m, surrogate="") in known])


def _methods(engine: str | None, known: Mapping[str, Known], stored: bool) -> tuple[Method, ...]:
    """The methods that may be named: all that are installed, or all that were run."""
    from plumbob.engines.registry import engine_of, engines, installed
    from plumbob.engines.registry import methods as find_methods

    if engine is not None and engine not in engines():
        raise ParameterError("engine", engine, f"one of {', '.join(engines())}")
    if stored:
        every = {m.name: m for methods in known.values() for m in methods.study.methods}
        methods = tuple(every.values())
    else:
        methods = tuple(m for m in find_methods() if installed(engine_of(m)))
    return tuple(m for m in methods if engine in (None, m.engine))


def _runner(show: Progress) -> RunStudies:
    """A runner of convergence studies, with predicted limits of the step: a few runs in this
    process, many in others too."""
    from plumbob.engines.study.runner import run_study
    from plumbob.reports.analyses.engines.largest_steps import predictions

    def run(scenes: Sequence[Scene], methods: Sequence[Method]) -> Study:
        what = scenes[0].name if len(scenes) == 1 else f"{len(scenes)} scenes"
        which = methods[0].name if len(methods) == 1 else f"{len(methods)} methods"
        if sys.stderr.isatty():
            print(f"plumbob: not stored yet: running {which} on {what}", file=sys.stderr)
        jobs = min(os.cpu_count() or 1, 1 + len(scenes) * len(methods) // 4)
        timed = len(scenes) == 1
        return run_study(
            scenes, methods, jobs=jobs, progress=show, timed=timed, requests=predictions
        )

    return run


def _store(answer: Answer, scenes: Sequence[Scene], file: Path, changed: bool) -> None:
    """Keep what was run, for the next time."""
    from plumbob.engines.study.convergence import ConvergenceStudy
    from plumbob.engines.study.provenance import provenance

    suffix = f" {CHANGED}" if changed else ""
    studies = [replace(s, profile=f"{s.profile}{suffix}") for s in answer.made]
    for scene in scenes:
        study = answer.studies.get(scene.name)
        runs = {m: each for (name, m), each in answer.runs.items() if name == scene.name}
        if study and runs:
            studies.append(
                replace(
                    study,
                    profile=f"{SEARCH}{suffix}",
                    scenes=(scene,),
                    costs={},
                    extras={},
                    convergence=tuple(
                        ConvergenceStudy(scene.name, m, tuple(each)) for m, each in runs.items()
                    ),
                    methods=tuple(m for m in study.methods if m.name in runs),
                    provenance=provenance("plumbob recommend"),
                )
            )
    if studies:
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            for study in studies:
                store.save(study, file)
        except (OSError, ParameterError) as error:
            print(f"plumbob: the runs are not stored: {error}", file=sys.stderr)


def _own(path: str) -> Method:
    from plumbob.reports.commands.arguments.like import own_method

    return own_method(path)


def _with_own(
    study: Study, scenes: Sequence[Scene], method: Method
) -> tuple[Study, tuple[UserResult, ...]]:
    """The study with the user's own settings, measured now, and their results."""
    from plumbob.engines.study.runner import joined, run_study
    from plumbob.reports.advice.user_settings import user_results
    from plumbob.reports.judge.study_verdicts import judge_study

    both = joined(study, run_study(scenes, [method]))
    return both, user_results(both, judge_study(both))


def _show(
    as_json: bool,
    asked: Question,
    answer: Answer,
    study: Study,
    beside: Mapping[str, Any],
    results: Sequence[UserResult],
) -> None:
    if as_json:
        study_of = {"date": study.provenance.date, "versions": study.provenance.versions}
        data = asdict(answer.recommendation) | {
            "scenes": [scene.name for scene in asked.scenes],
            "study": study_of,
            "cut_short": answer.cut_short,
            **beside,
        }
        values.print_json(data)
        return
    _print(answer.recommendation, asked)
    if answer.cut_short:
        print("  the search was cut short: a larger step of some method may do")
    print(f"  measured   {_measured_when(study)}")
    if results:
        from plumbob.reports.view.user_settings import lines

        print(*lines(results), sep="\n")


def _measured_when(study: Study) -> str:
    """Date and engine versions of a study, for a reader to doubt."""
    names = dict.fromkeys(method.engine for method in study.methods)
    versions = [f"{n} {v}" for n in names if (v := study.provenance.versions.get(n))]
    return ", ".join([study.provenance.date or "now", *versions])


def _print(answer: Recommendation, asked: Question) -> None:
    many = f" (the worst of {len(asked.scenes)} scenes)" if len(asked.scenes) > 1 else ""
    of = f"{answer.observable} within {answer.absolute:.3g} {answer.unit}"
    wanted = of if asked.absolute else f"error within {answer.error:g} ({of})"
    print(f"{answer.scene}, {wanted}{many}:")
    if answer.choice is None:
        print("  nothing that converges reaches it")
    named = {answer.choice: "use", answer.runner_up: "runner-up", answer.best: "the best:"}
    for choice in answer.by_engine:
        named.setdefault(choice, f"in {choice.method.partition('/')[0]}")
    named[answer.surrogate] = "surrogate"
    rows = [(c, name) for c, name in named.items() if c]
    for choice, name in [*rows, *((c, "at 0.002 s") for c in answer.defaults)]:
        print(f"  {name:<10} {_text(choice, answer.unit, asked.absolute)}")
        if name == "use" and choice.limit:
            print(f"  {'':<10} {_stability(choice, choice.limit)}")
        if name == "surrogate":
            print(f"  {'':<10} ({choice.surrogate})")


def _stability(choice: Choice, limit: KnownLimit) -> str:
    known = "measured" if limit.measured else "predicted"
    return (
        f"{'limited by stability: ' if choice.limited else ''}loses the motion from "
        f"{limit.step:.3g} s on ({limit.kind}, {known}), {choice.margin:.3g} times this step"
    )


def _text(choice: Choice, unit: str, absolute: bool) -> str:
    word = "rtol" if choice.control == "tolerance" else "step"
    tail = "" if word == "rtol" else " s"
    error = f"{choice.absolute:.2g} {unit}"
    if not absolute:
        error = f"{choice.error:.2g} ({error})"
    return (
        f"{choice.method:<22} {word} {choice.step:g}{tail}: error {error}, "
        f"{choice.ns_per_second / 1e6:.3g} ms per simulated second"
    )
