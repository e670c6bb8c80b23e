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

from plumbob.engines.study.codec import to_json
from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.request import Request
from plumbob.engines.study.results import Analysed, Study
from plumbob.engines.study.scheduler import Progress
from plumbob.engines.workers import Lost, Task, Workers, workers_of
from plumbob.models.scene import Scene
from plumbob.reports.advice.simulated_kinds import step_requests
from plumbob.reports.analyses import page_numbers
from plumbob.reports.analyses.analysis import Section, analyse_section
from plumbob.reports.analyses.replay import requests as replay_requests
from plumbob.reports.analyses.trimming import requests as trimming_requests
from plumbob.reports.judge.study_verdicts import Judgements, judge_study
from plumbob.reports.records.page_records import ENGINES_SECTION, PAGES_OF_STUDY, SCENE

SCENES_FOR_PROCESSES = 8  # smallest number of scenes for which other processes are started
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


def requests(plan: StudyPlan, pairs_alone: bool = False) -> tuple[Request[Any], ...]:
    """Returns all extra runs that the pages of a plan need, each once. They are the runs of the
    findings on systems and on engines, of the replays, of the tables of trimmed models, and of the
    advice for kinds of bodies. If `pairs_alone`, findings that need other scenes or methods than
    the plan's are left out."""
    requested = list[Request[Any]]()
    for name in _section_names(plan.scenes):
        system_section = section(name)
        if system_section:
            requested += system_section.requests(plan, pairs_alone)
    requested += [*replay_requests(plan), *trimming_requests(plan), *step_requests(plan)]
    return tuple(dict.fromkeys(requested))


def _section_names(scenes: Sequence[Scene]) -> list[str]:
    """Returns the names that sections may have: the systems of the scenes, each once, and
    "engines"."""
    return list(dict.fromkeys((*(scene.system for scene in scenes), ENGINES_SECTION)))


def analyses_of(
    study: Study,
    jobs: int | Workers = 1,
    judged: Judgements | None = None,
    progress: Progress = lambda what, done, total: None,
) -> tuple[Analysed, ...]:
    """Returns the analyses of all systems and of engines, and the records of a study's pages.

    `jobs` is the number of processes, or the processes, to use if there is much to analyse; the
    results do not depend on it. `judged` are the study's verdicts, if they are known already.
    `progress` is called with the name of a part, the number of finished parts, and of all parts."""
    judged = judge_study(study) if judged is None else judged
    parts = [
        *(("system", name) for name in _section_names(study.scenes) if section(name)),
        *(("scene", scene.name) for scene in study.scenes),
    ]
    results: dict[Part, tuple[Analysed, ...]] = {}
    with workers_of(jobs) as workers:
        if workers.count > 1 and len(study.scenes) >= SCENES_FOR_PROCESSES:
            results = _analyse_in_processes(study, parts, judged, workers, progress)
    analyses = list[Analysed]()
    for number, part in enumerate(parts):
        progress(f"analyses of {part[1]}", number, len(parts))
        analyses += results[part] if part in results else _analyse(study, judged, part)
    record = page_numbers.study_record(study, judged)
    return (*analyses, Analysed("", PAGES_OF_STUDY, "", "", record))


def follow(study: Study) -> bool:
    """Returns whether a study holds all runs that its pages need, and its stored numbers of
    findings and galleries follow from these runs. It takes as long as the analyses do."""
    needed = requests(StudyPlan(study.profile, study.scenes, study.methods), pairs_alone=True)
    if not set(needed) <= set(study.extras):
        return False
    judged = judge_study(study)
    computed = list[Analysed]()
    for name in _section_names(study.scenes):
        computed += _analyse(study, judged, ("system", name))
    stored = [a for a in study.analyses if a.place not in (SCENE, PAGES_OF_STUDY)]
    return to_json(computed) == to_json(stored)


def _analyse(study: Study, judged: Judgements, part: Part) -> tuple[Analysed, ...]:
    """Returns the analyses of one part: the record of a scene, or the analyses of a section."""
    kind, name = part
    if kind == "scene":
        scene = next(scene for scene in study.scenes if scene.name == name)
        record = page_numbers.scene_record(study, judged, scene)
        return (Analysed("", SCENE, scene.system, name, record),)
    system_section = section(name)
    return analyse_section(study, system_section, name, judged) if system_section else ()


def _analyse_in_processes(
    study: Study,
    parts: Sequence[Part],
    judged: Judgements,
    workers: Workers,
    progress: Progress,
) -> dict[Part, tuple[Analysed, ...]]:
    """Returns the analyses of each part, computed in other processes. A part whose process died is
    left out."""
    with tempfile.TemporaryDirectory(prefix="plumbob-") as folder:
        file = Path(folder) / "study.pickle"
        file.write_bytes(pickle.dumps((study, judged), pickle.HIGHEST_PROTOCOL))
        # Systems take longer than scenes and come first, so that all processes end together.
        tasks = [
            Task(part, _analyse_file, (str(file), part), LIMIT, part[1].partition("/")[0])
            for part in sorted(parts, reverse=True)
        ]
        results = dict[Part, tuple[Analysed, ...]]()
        for number, (task, done) in enumerate(workers.results(tasks), 1):
            progress(f"analyses of {task.key[1]}", number, len(tasks))
            if not isinstance(done, Lost):
                results[task.key] = done
        return results


def _analyse_file(file: str, part: Part) -> tuple[Analysed, ...]:
    """Returns the analyses of one part of the study that is pickled in a file."""
    study, judged = _read_study(file)
    return _analyse(study, judged, part)


@lru_cache(maxsize=1)
def _read_study(file: str) -> tuple[Study, Judgements]:
    """Returns a pickled study and its verdicts; the last one is cached for the next part."""
    study, judged = pickle.loads(Path(file).read_bytes())
    return study, judged
