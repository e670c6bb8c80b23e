"""Analyses of a study: numbers, worked out when it is made and stored with it, for its pages.

Those of a system are in a module found by its name; a system without one has only what every scene
has. The module `engines` holds what is about all systems.
"""

from __future__ import annotations

import importlib
import pickle
import tempfile
from functools import lru_cache
from pathlib import Path

from plumbob.engines.study.extra_runs import Request, StudyPlan
from plumbob.engines.study.results import Analysed, Study
from plumbob.engines.workers import Lost, Task, Workers, workers_of
from plumbob.reports.analyses.analysis import Section, analysed
from plumbob.reports.judge.study_verdicts import Judgements, judge_study
from plumbob.reports.view.replay.runs import requests as replay_requests
from plumbob.reports.view.site.views import OF_ENGINES
from plumbob.reports.view.trimming import requests as trimming_requests

MANY = 8  # scenes: fewer are analysed before another process is ready
LIMIT = 600.0  # [s]: the analyses of a system that take longer hang


def section(system: str) -> Section | None:
    """The section of a system, SECTION of `plumbob.reports.analyses.<system>`; None without one."""
    name = f"{__name__}.{system.replace('-', '_')}"
    try:
        module = importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        return None
    section_of: Section = module.SECTION
    return section_of


def requests(plan: StudyPlan) -> tuple[Request, ...]:
    """All runs that a page of this plan needs beside the study's own, each once: those of the
    systems' findings and of those on engines, then those of the replays and of the table of trimmed
    models."""
    named = dict.fromkeys((*(scene.system for scene in plan.scenes), OF_ENGINES))
    extra = [request for name in named if (of := section(name)) for request in of.requests(plan)]
    return tuple(dict.fromkeys((*extra, *replay_requests(plan), *trimming_requests(plan))))


def analyses_of(study: Study, jobs: int | Workers = 1) -> tuple[Analysed, ...]:
    """The analyses of all systems of a study, and those of engines, the same for any number of
    processes, of which `jobs`, or those given, are used where there is much to analyse."""
    judged = judge_study(study)
    systems = tuple(dict.fromkeys((*(scene.system for scene in study.scenes), OF_ENGINES)))
    named = [name for name in systems if section(name) is not None]
    found: dict[str, tuple[Analysed, ...]] = {}
    with workers_of(jobs) as workers:
        if workers.count > 1 and len(study.scenes) >= MANY:
            found = _side_by_side(study, named, judged, workers)
    missing = [name for name in named if name not in found]
    found |= {name: _analysed(study, name, judged) for name in missing}
    return tuple(analysis for name in named for analysis in found[name])


def _analysed(study: Study, name: str, judged: Judgements) -> tuple[Analysed, ...]:
    of = section(name)
    assert of is not None
    return analysed(study, of, name, judged)


def _side_by_side(
    study: Study, names: list[str], judged: Judgements, workers: Workers
) -> dict[str, tuple[Analysed, ...]]:
    """The analyses of each system by its name, without those whose process died."""
    with tempfile.TemporaryDirectory(prefix="plumbob-") as folder:
        file = Path(folder) / "study.pickle"
        file.write_bytes(pickle.dumps((study, judged), pickle.HIGHEST_PROTOCOL))
        tasks = [Task(name, _by_a_worker, (str(file), name), LIMIT, name) for name in names]
        results = workers.results(tasks)
        return {task.key: part for task, part in results if not isinstance(part, Lost)}


def _by_a_worker(file: str, name: str) -> tuple[Analysed, ...]:
    study, judged = _read(file)
    return _analysed(study, name, judged)


@lru_cache(maxsize=1)
def _read(file: str) -> tuple[Study, Judgements]:
    study, judged = pickle.loads(Path(file).read_bytes())
    return study, judged
