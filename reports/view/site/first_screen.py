"""The first screen: what was checked, what to use, and the findings that matter most."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from statistics import median_high
from typing import Any

from plumbob.engines.study.measurement import REFERENCE_STEP
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import DEFAULT_METHOD
from plumbob.reports.view import notation
from plumbob.reports.view.content import Figure, Finding, Table
from plumbob.reports.view.records import StudyRecord, Verdicts
from plumbob.reports.view.settings import Pasted, to_copy
from plumbob.reports.view.site.claims import NOT_SHOWN
from plumbob.reports.view.site.matrix import SIGNS, Shown, at_reference, meaning, ordered
from plumbob.reports.view.site.views import View
from plumbob.reports.view.tables import paragraphs, table
from plumbob.reports.view.top_tables import anchor

SMOOTH = "cone-pendulum/rotating-base"
KEY_FINDINGS = (  # name, and which of its figures is its picture
    ("capsule-isotropy", 0),
    ("capsule-displacement", 0),
    ("held-control", 0),
    ("printed-hamiltonian", 0),
    ("capsule-turn-second-order", 0),
)
MOST_FINDINGS = 5


@dataclass(frozen=True)
class Kind:
    """A kind of robot: its systems, those that the ranges of errors are of, and its methods, the
    default one, the one to use, and the one for further motions."""

    name: str
    title: str
    to_copy: str
    systems: str  # patterns
    first: str
    methods: tuple[str, ...]


KINDS = (
    Kind(
        "with-contacts",
        "A robot with contacts",
        "Contacts to copy",
        "capsule-*",
        "capsule-line",
        (DEFAULT_METHOD, "mujoco/euler+coulomb", "mujoco/rk4+coulomb"),
    ),
    Kind(
        "without-contacts",
        "A robot without contacts",
        "Integrator to copy",
        "*pendulum",
        "*",
        (DEFAULT_METHOD, "mujoco/rk4"),
    ),
)


@dataclass(frozen=True)
class Count:
    """How many pairs of a scene and a method have a meaning."""

    meaning: str
    sign: str
    name: str
    explained: str
    count: int


@dataclass(frozen=True)
class Answer:
    """The recommendation for a kind of robot: in a sentence or two, as a table, and the
    settings."""

    name: str  # the id of its place
    title: str
    sentences: tuple[str, ...]
    table: Table
    pasted: Pasted


@dataclass(frozen=True)
class Card:
    """A finding on the first screen, with its picture."""

    finding: Finding
    figure: Figure


def counts(verdicts: Verdicts) -> tuple[Count, ...]:
    """How many pairs of a scene and a method are as predicted, converge, and so on."""
    numbers = Counter(map(meaning, verdicts.values()))
    return tuple(
        Count(name, *texts, numbers[name])
        for name, texts in SIGNS.items()
        if numbers[name] or name != "unclaimed"
    )


def by_engine(verdicts: Verdicts) -> Mapping[str, Counter[str]]:
    """For each engine that ran how many of its pairs of a scene and a method have a meaning."""
    pairs = [(name, meaning(of)) for (_, name), of in verdicts.items()]
    ran = [(name.partition("/")[0], means) for name, means in pairs if means != "not-run"]
    return {
        engine: Counter(means for other, means in ran if other == engine)
        for engine in dict.fromkeys(engine for engine, _ in ran)
    }


def made(study: Study) -> tuple[int, int, int]:
    """How many runs were made, on how many scenes, and with how many methods."""
    runs = [
        m for c in study.convergence for m in c.measurements if m.status in ("done", "diverged")
    ]
    return len(runs), len({m.scene for m in runs}), len({m.method for m in runs})


def answers(study: Study, record: StudyRecord) -> tuple[Answer, ...]:
    """The recommendations with contacts and without, of what was measured."""
    return tuple(answer for kind in KINDS if (answer := _answer(study, record, kind)))


def cards(findings: Sequence[Finding]) -> tuple[Card, ...]:
    """The findings that matter most; where a study lacks one, or does not show it, others that have
    a figure."""
    known = {finding.name: finding for finding in findings if finding.judgement != NOT_SHOWN}
    wanted = [(known[n], place) for n, place in KEY_FINDINGS if n in known]
    first = {finding.name for finding, _ in wanted}
    others = [(finding, 0) for name, finding in known.items() if name not in first]
    chosen = []
    for finding, place in (*wanted, *others):
        if place < len(finding.figures):
            chosen.append(Card(finding, finding.figures[place]))
    return tuple(chosen[:MOST_FINDINGS])


def work_precision(views: Sequence[View]) -> Mapping[str, Any]:
    """The figure of error against cost where nothing is in contact, and the methods that its page
    shows first; empty where that was not run."""
    scenes = (scene for view in views for scene in view.scenes if scene.scene.name == SMOOTH)
    return next(({"figure": of.figures[0], "chosen": of.at_first} for of in scenes), {})


def _answer(study: Study, record: StudyRecord, kind: Kind) -> Answer | None:
    """The settings to use, what they give and what they cost; None where that was not measured."""
    default, better, last = kind.methods[0], kind.methods[1], kind.methods[-1]
    ran = _errors(study, [s for s in study.scenes if fnmatch(s.system, kind.systems)], kind.methods)
    usual = [entry for entry in ran if not entry.apart]
    first = [entry for entry in usual if fnmatch(entry.scene.system, kind.first)]
    if not first or not {default, better} <= set(first[0].errors):
        return None
    costs, apart = _costs(study, ran), [entry for entry in ran if entry.apart]
    ratios = {name: notation.number(ns / costs[default], 2) for name, ns in costs.items()}
    sentences = paragraphs(
        kind.name.replace("-", "_"),
        methods=kind.methods,
        scenes=len(first),
        usual=_largest(first, default),
        most=_largest(first, better),
        usual_range=_range(first, default),
        range=_range(first, better),
        turning=_most(usual, last) if last in ratios else "",
        ratios=ratios,
        apart=apart,
        largest=[
            f"{_most(apart, name)} with {name}"
            for name in (last if last in ratios else better, default)
            if apart
        ],
    )
    pasted = to_copy(record.settings[better], kind.to_copy, ratios.get(better, ""))
    return Answer(
        kind.name,
        kind.title,
        sentences,
        _table(study, ran, record, kind.methods, costs, ratios),
        pasted,
    )


@dataclass(frozen=True)
class Ran:
    """A scene with the errors at the reference step of the methods that are compared."""

    scene: Scene
    errors: Mapping[str, Shown]

    @property
    def apart(self) -> bool:
        """Whether it is no usual motion: a hard case, or one without friction."""
        return bool(self.scene.hard) or self.scene.parameters.get("friction") == 0.0


def _errors(study: Study, scenes: Sequence[Scene], methods: Sequence[str]) -> list[Ran]:
    """The errors of these methods on the scenes that all of them ran, system by system."""
    by_name = {m.name: m for m in study.methods if m.name in methods}
    each: dict[str, dict[str, Shown]] = {scene.name: {} for scene in ordered(scenes)}
    for c in study.convergence:
        if c.scene in each and c.method in by_name:
            error = at_reference(c, by_name[c.method], study.quantities(c.scene))
            if error is not None and not math.isnan(error.error):
                each[c.scene][c.method] = error
    of = {scene.name: scene for scene in scenes}
    return [Ran(of[name], errors) for name, errors in each.items() if len(errors) == len(by_name)]


def _largest(ran: Sequence[Ran], method: str) -> Shown:
    return max((entry.errors[method] for entry in ran), key=lambda shown: shown.error)


def _range(ran: Sequence[Ran], method: str) -> str:
    """The smallest and the largest error of a method as text, or one where they are the same."""
    least = min((entry.errors[method] for entry in ran), key=lambda shown: shown.error)
    return " to ".join(dict.fromkeys((least.text, _largest(ran, method).text)))


def _most(ran: Sequence[Ran], method: str) -> str:
    """The largest error of a method, and the scene that it has it on."""
    worst_of_all = max(ran, key=lambda entry: entry.errors[method].error)
    return f"{worst_of_all.errors[method].text} (on {worst_of_all.scene.name})"


def _costs(study: Study, ran: Sequence[Ran]) -> Mapping[str, float]:
    """The median cost of a step [ns] of each method, over the scenes that all were timed on."""
    names = list(ran[0].errors)
    scenes = (entry.scene.name for entry in ran)
    timed = [s for s in scenes if all((s, name) in study.costs for name in names)]
    return {
        name: median_high(study.costs[scene, name].ns_per_step for scene in timed)
        for name in names
        if timed
    }


def _table(
    study: Study,
    ran: Sequence[Ran],
    record: StudyRecord,
    methods: Sequence[str],
    costs: Mapping[str, float],
    ratios: Mapping[str, str],
) -> Table:
    """Systems against methods, scenes apart each in a row, and what a step costs."""
    names = [m.name for m in study.methods if m.name in methods]
    titles = {system.name: system.title for system in record.systems}
    groups: dict[tuple[str, str], list[Ran]] = {}
    for entry in sorted(ran, key=lambda entry: entry.apart):
        system, scene = entry.scene.system, entry.scene.name
        key = (scene, anchor(scene)) if entry.apart else (titles[system], system)
        groups.setdefault(key, []).append(entry)
    return table(
        "first_screen",
        names=names,
        default=DEFAULT_METHOD,
        rows={key: [_largest(of, name).text for name in names] for key, of in groups.items()},
        costs=costs,
        ratios=ratios,
        step=REFERENCE_STEP,
    )
