"""Analyses of a study: numbers for its pages, computed when the study is made and stored with it.

The analyses of a system are in the module with the system's name. A system without such a module
has no analyses beyond those of every scene. The module `engines` holds the analyses of all systems.
"""

from __future__ import annotations

import importlib
import pickle
import tempfile
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from plumbob.engines.study.codec import plain, to_json
from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.request import Request
from plumbob.engines.study.results import Analysed, Study
from plumbob.engines.workers import Lost, Task, Workers, workers_of
from plumbob.reports.analyses import page_numbers
from plumbob.reports.analyses.analysis import Section, analysed
from plumbob.reports.analyses.replay import requests as replay_requests
from plumbob.reports.judge.study_verdicts import Judgements, judge_study
from plumbob.reports.view.records import SCENE, STUDY
from plumbob.reports.view.site.views import OF_ENGINES
from plumbob.reports.view.trimming import requests as trimming_requests

MANY = 8  # number of scenes from which other processes are worth starting
LIMIT = 600.0  # [s] time after which one part of the analyses counts as hung
Part = tuple[str, str]  # "system" or "scene", and its name


def section(system: str) -> Section | None:
    """Returns the section of a system: SECTION of the module `plumbob.reports.analyses.<system>`;
    None if there is no such module."""
    name = f"{__name__}.{system.replace('-', '_')}"
    try:
        module = importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        return None
    section_of: Section = module.SECTION
    return section_of


def requests(plan: StudyPlan) -> tuple[Request[Any], ...]:
    """Returns all extra runs that the pages of a plan need, each once. They are the runs of the
    findings on systems and on engines, of the replays, and of the tables of trimmed models."""
    named = dict.fromkeys((*(scene.system for scene in plan.scenes), OF_ENGINES))
    extra = [
        request for name in named if (of := section(name)) for request in of.requests(plan)
    ]
    return tuple(dict.fromkeys((*extra, *replay_requests(plan), *trimming_requests(plan))))


def analyses_of(
    study: Study, jobs: int | Workers = 1, judged: Judgements | None = None
) -> tuple[Analysed, ...]:
    """Returns the analyses of all systems and of engines, and the records of a study's pages.

    `jobs` is the number of processes, or the processes, to use if there is much to analyse; the
    results do not depend on it. `judged` are the study's verdicts, if they are known already."""
    judged = judge_study(study) if judged is None else judged
    systems = dict.fromkeys((*(scene.system for scene in study.scenes), OF_ENGINES))
    parts = [
        *(("system", name) for name in systems if section(name) is not None),
        *(("scene", scene.name) for scene in study.scenes),
    ]
    results: dict[Part, tuple[Analysed, ...]] = {}
    with workers_of(jobs) as workers:
        if workers.count > 1 and len(study.scenes) >= MANY:
            results = _side_by_side(study, parts, judged, workers)
    results |= {part: _analysed(study, judged, part) for part in parts if part not in results}
    every = (analysis for part in parts for analysis in results[part])
    about = page_numbers.study_record(study, judged)
    return (*every, Analysed("", STUDY, "", "", plain(about)))


def follow(study: Study) -> bool:
    """Returns whether a study holds all runs that its pages need, and its stored numbers of
    findings and galleries follow from these runs. It takes as long as the analyses do."""
    needed = requests(StudyPlan(study.profile, study.scenes, study.methods))
    if not set(needed) <= set(study.extras):
        return False
    judged = judge_study(study)
    systems = dict.fromkeys((*(scene.system for scene in study.scenes), OF_ENGINES))
    made = [a for name in systems for a in _analysed(study, judged, ("system", name))]
    stored = [a for a in study.analyses if a.place not in (SCENE, STUDY)]
    return to_json(made) == to_json(stored)


def _analysed(study: Study, judged: Judgements, part: Part) -> tuple[Analysed, ...]:
    kind, name = part
    if kind == "scene":
        scene = next(scene for scene in study.scenes if scene.name == name)
        record = page_numbers.scene_record(study, judged, scene)
        return (Analysed("", SCENE, scene.system, name, plain(record)),)
    of = section(name)
    return analysed(study, of, name, judged) if of else ()


def _side_by_side(
    study: Study, parts: Sequence[Part], judged: Judgements, workers: Workers
) -> dict[Part, tuple[Analysed, ...]]:
    """Returns the analyses of each part, computed in other processes. A part whose process died is
    left out."""
    with tempfile.TemporaryDirectory(prefix="plumbob-") as folder:
        file = Path(folder) / "study.pickle"
        file.write_bytes(pickle.dumps((study, judged), pickle.HIGHEST_PROTOCOL))
        tasks = [
            Task(part, _by_a_worker, (str(file), part), LIMIT, part[1].partition("/")[0])
            for part in sorted(
                parts, reverse=True
            )  # systems first: scenes fill what they leave
        ]
        results = workers.results(tasks)
        return {task.key: of for task, of in results if not isinstance(of, Lost)}


def _by_a_worker(file: str, part: Part) -> tuple[Analysed, ...]:
    return _analysed(*_read(file), part)


@lru_cache(maxsize=1)
def _read(file: str) -> tuple[Study, Judgements]:
    study, judged = pickle.loads(Path(file).read_bytes())
    return study, judged
