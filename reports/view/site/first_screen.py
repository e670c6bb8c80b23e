"""The first screen of the index: counts of verdicts, recommended settings and key findings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from fnmatch import fnmatch
from statistics import median_high

from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import DEFAULT_METHOD
from plumbob.reports.view import notation
from plumbob.reports.view.content import Finding
from plumbob.reports.view.method_results import Results, Shown
from plumbob.reports.view.records import StudyRecord
from plumbob.reports.view.settings import to_copy
from plumbob.reports.view.site.claims import NOT_SHOWN
from plumbob.reports.view.site.matrix import ordered
from plumbob.reports.view.site.views import View
from plumbob.reports.view.tables import paragraphs

KEY_FINDINGS = (
    "capsule-isotropy",
    "capsule-displacement",
    "held-control",
    "printed-hamiltonian",
    "capsule-turn-second-order",
)
MOST_FINDINGS = 5
# A row for each kind of robot: the name of the kind, its title, the title of its settings, a
# pattern of its systems, a pattern of the systems that the error ranges cover, and methods. The
# methods are the default, the recommended one, and, if there is a third, the one for more kinds of
# motion.
KINDS = (
    (
        *(
            "with-contacts",
            "A robot with contacts",
            "Contacts to copy",
            "capsule-*",
            "capsule-line",
        ),
        (DEFAULT_METHOD, "mujoco/euler+coulomb", "mujoco/rk4+coulomb"),
    ),
    (
        *("without-contacts", "A robot without contacts", "Integrator to copy"),
        *("*pendulum", "*"),
        (DEFAULT_METHOD, "mujoco/rk4"),
    ),
)
Ran = tuple[Scene, Mapping[str, Shown]]  # errors at the reference step, by method


def by_engine(every: Results) -> Mapping[str, Counter[str]]:
    """Counts of meanings ("predicted", "converges", …) over the pairs of scene and method, for each
    engine that ran."""
    engines: dict[str, Counter[str]] = {}
    for of in every.values():
        if of.meaning != "not-run":
            engines.setdefault(of.method.engine, Counter())[of.meaning] += 1
    return engines


def made(every: Results) -> tuple[int, int, int]:
    """Numbers of runs, of scenes and of methods that ran."""
    ran = [of for of in every.values() if of.errors]
    scenes = {of.scene.name for of in ran}
    methods = {of.name for of in ran}
    return sum(len(of.errors) for of in ran), len(scenes), len(methods)


def cards(findings: Sequence[Finding]) -> Sequence[Finding]:
    """At most `MOST_FINDINGS` findings with a figure, the key findings first. Other findings
    replace the key findings that the study lacks or does not show."""
    known = {f.name: f for f in findings if f.judgement != NOT_SHOWN and f.figures}
    names = dict.fromkeys((*(name for name in KEY_FINDINGS if name in known), *known))
    return [known[name] for name in names][:MOST_FINDINGS]


def answers(study: Study, record: StudyRecord, every: Results) -> Sequence[View]:
    """A view for each kind of robot, with and without contacts: the recommended settings, their
    measured errors and their measured costs. A kind without any usual scene is left out."""
    shown = []
    for name, title, heading, systems, first_systems, methods in KINDS:
        default = methods[0]
        better = methods[1]
        last = methods[-1]
        ran = _ran(every, [s for s in study.scenes if fnmatch(s.system, systems)], methods)
        # Hard cases and frictionless scenes are not typical of a robot: they are listed separately.
        apart = [of for of in ran if of[0].hard or of[0].parameters.get("friction") == 0.0]
        usual = [of for of in ran if of not in apart]
        first = [of for of in usual if fnmatch(of[0].system, first_systems)]
        if not first:
            continue
        costs = _costs(study, [scene for scene, _ in ran], methods)
        ratios = {n: notation.number(ns / costs[default], 2) for n, ns in costs.items()}
        turning = last if last in ratios else better
        sentences = paragraphs(
            name.replace("-", "_"),
            methods=methods,
            usual=_by_error(first, default),
            best=_by_error(first, better),
            turning=_by_error(usual, turning),
            ratios=ratios,
            apart=[
                (method, _by_error(apart, method)) for method in (turning, default) if apart
            ],
        )
        pasted = to_copy(record.settings[better], heading, ratios.get(better, ""))
        shown.append(View(name=name, title=title, sentences=sentences, pasted=pasted))
    return shown


def _ran(every: Results, scenes: Sequence[Scene], methods: Sequence[str]) -> list[Ran]:
    """The scenes that all `methods` ran, in the order of their systems, each with the errors of
    these methods at the reference step."""
    ran = list[Ran]()
    for scene in ordered(scenes):
        results = {name: every.get((scene.name, name)) for name in methods}
        errors = {name: at for name, of in results.items() if of and (at := of.at_reference)}
        if len(errors) == len(methods):
            ran.append((scene, errors))
    return ran


def _by_error(ran: Sequence[Ran], method: str) -> list[tuple[Scene, Shown]]:
    """The scenes with the error of one method, sorted from the smallest error to the largest."""
    return sorted(((scene, of[method]) for scene, of in ran), key=lambda pair: pair[1].error)


def _costs(
    study: Study, scenes: Sequence[Scene], methods: Sequence[str]
) -> Mapping[str, float]:
    """The median cost of a step [ns] of each method, over the scenes on which all `methods` were
    timed; empty if there is no such scene."""
    timed = [s.name for s in scenes if all((s.name, name) in study.costs for name in methods)]
    return {
        name: median_high(study.costs[scene, name].ns_per_step for scene in timed)
        for name in methods
        if timed
    }
