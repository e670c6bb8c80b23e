"""The first screen: what was checked, what to use, and the findings that matter most."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from plumbob.engines.study.convergence import timed_run
from plumbob.engines.study.measurement import REFERENCE_STEP, worst
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import DEFAULT_METHOD
from plumbob.reports.view import notation
from plumbob.reports.view.content import Figure, Finding, Table
from plumbob.reports.view.drawing import shown
from plumbob.reports.view.pictures import names, picture
from plumbob.reports.view.records import StudyRecord, Verdicts
from plumbob.reports.view.settings import Pasted, to_copy
from plumbob.reports.view.site.claims import NOT_SHOWN
from plumbob.reports.view.site.matrix import SIGNS, Shown, at_reference, meaning, ordered
from plumbob.reports.view.site.views import View
from plumbob.reports.view.tables import paragraphs, table
from plumbob.reports.view.top_tables import anchor

WITH_CONTACTS = ("mujoco/euler", "mujoco/euler+coulomb", "mujoco/rk4+coulomb")
WITHOUT = ("mujoco/euler", "mujoco/rk4")
FORCED, HELD = "simple-pendulum/forced-large", ("mujoco/rk4", "mujoco/rk4+midpoint")
SMOOTH = "cone-pendulum/rotating-base"
KEY_FINDINGS = (  # name, and which of its figures is its picture
    ("capsule-isotropy", 0),
    ("capsule-displacement", 0),
    ("held-control", 0),
    ("printed-hamiltonian", 0),
    ("capsule-turn-second-order", 0),
    ("energy", 0),
)
MOST_FINDINGS = 5


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
    picture: str
    names: list[tuple[str, str, str]]  # of its curves, with colours and dashes


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
    both = (_contacts(study, record), _joints(study, record))
    return tuple(answer for answer in both if answer is not None)


def cards(findings: Sequence[Finding]) -> tuple[Card, ...]:
    """The findings that matter most; where a study lacks one, or does not show it, others that have
    a figure."""
    known = {finding.name: finding for finding in findings if finding.judgement != NOT_SHOWN}
    wanted = [(known[n], place) for n, place in KEY_FINDINGS if n in known]
    first = {finding.name for finding, _ in wanted}
    others = [(finding, 0) for name, finding in known.items() if name not in first]
    chosen = []
    for finding, place in (*wanted, *others):
        if place >= len(finding.figures) or not (drawn := picture(finding.figures[place])):
            continue
        figure = finding.figures[place]
        chosen.append(Card(finding, figure, drawn, names(figure)))
    return tuple(chosen[:MOST_FINDINGS])


def work_precision(views: Sequence[View]) -> Mapping[str, Any]:
    """The picture of error against cost where nothing is in contact, of the methods that its page
    shows first, with their names; empty where that was not run."""
    for of in (scene for view in views for scene in view.scenes if scene.scene.name == SMOOTH):
        figure = replace(of.figures[0], traces=tuple(shown(of.figures[0], of.at_first)))
        return {"picture": picture(figure), "names": names(figure)}
    return {}


def preview_of(findings: Sequence[Finding]) -> Figure | None:
    """The figure that stands for the site where a link to it is shown; None where it is missing."""
    name, place = KEY_FINDINGS[0]
    shown = (f for f in findings if f.name == name and f.judgement != NOT_SHOWN)
    return next((finding.figures[place] for finding in shown if finding.figures), None)


def _contacts(study: Study, record: StudyRecord) -> Answer | None:
    """The contact settings to use, what they give and what they cost."""
    default, euler, rk4 = WITH_CONTACTS
    scenes = [s for s in study.scenes if s.system.startswith("capsule-")]
    ran = _errors(study, scenes, WITH_CONTACTS)
    usual = [entry for entry in ran if not entry.apart]
    line = [entry for entry in usual if entry.scene.system == usual[0].scene.system]
    if not line or default not in line[0].errors or euler not in line[0].errors:
        return None
    ratios = _cost_ratios(_costs(study, ran))
    finest = _finest(study, [entry.scene.name for entry in line], (default,))
    sentences = paragraphs(
        "with_contacts",
        **_compared(ran, line, ratios, (default, euler, rk4), rk4 if rk4 in ratios else euler),
        scenes=len(line),
        range=_range(line, default),
        turning=_most(usual, rk4) if rk4 in ratios else "",
        finest=finest and (finest[0], finest[1][default]),
    )
    shown = _table(study, ran, record, WITH_CONTACTS, _nearer_by_chance(study, usual))
    pasted = to_copy(record.settings[euler], "Contacts to copy", ratios.get(euler, ""))
    return Answer("with-contacts", "A robot with contacts", sentences, shown, pasted)


def _joints(study: Study, record: StudyRecord) -> Answer | None:
    """The recommendation for a mechanism without contacts."""
    default, rk4 = WITHOUT
    ran = _errors(study, [s for s in study.scenes if s.system.endswith("pendulum")], WITHOUT)
    usual = [entry for entry in ran if not entry.apart]
    if not usual or not set(WITHOUT) <= set(usual[0].errors):
        return None
    ratios = _cost_ratios(_costs(study, ran))
    sentences = paragraphs(
        "without_contacts",
        **_compared(ran, usual, ratios, WITHOUT, rk4),
        range=_range(usual, rk4),
        usual_range=_range(usual, default),
        held=_held_control(study),
    )
    shown = _table(study, ran, record, WITHOUT)
    pasted = to_copy(record.settings[rk4], "Integrator to copy", ratios.get(rk4, ""))
    return Answer("without-contacts", "A robot without contacts", sentences, shown, pasted)


def _compared(
    ran: Sequence[Ran],
    usual: Sequence[Ran],
    ratios: Mapping[str, str],
    methods: Sequence[str],
    advised: str,
) -> Mapping[str, Any]:
    """Values of both recommendations: the largest errors of the default and of the next method on
    usual motions, costs, and the largest errors on the scenes apart."""
    default, better, *_ = methods
    apart = [entry for entry in ran if entry.apart]
    return {
        "methods": methods,
        "usual": _largest(usual, default),
        "most": _largest(usual, better),
        "ratios": ratios,
        "apart": apart,
        "largest": [f"{_most(apart, name)} with {name}" for name in (advised, default) if apart],
    }


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


def _finest(
    study: Study, scenes: Sequence[str], methods: Sequence[str]
) -> tuple[float, Mapping[str, Sequence[float]]] | None:
    """The smallest step [s] at which all of these methods ran all of these scenes, with the errors
    of each there; None where that is no smaller than the reference step."""
    series = [c for c in study.convergence if c.scene in scenes and c.method in methods]
    runs = [(c.method, {m.step: m for m in c.measurements if m.status == "done"}) for c in series]
    steps = set.intersection(*(set(by_step) for _, by_step in runs)) if runs else set[float]()
    step = min(steps, default=REFERENCE_STEP)
    if step >= REFERENCE_STEP:
        return None
    errors: dict[str, list[float]] = {method: [] for method in methods}
    for method, by_step in runs:
        errors[method].append(worst(by_step[step], study.quantities(by_step[step].scene))[1])
    return step, errors


def _nearer_by_chance(study: Study, ran: Sequence[Ran]) -> str:
    """Where default contacts have the smaller error at the reference step though they do not
    converge: what smaller steps make of both."""
    default, euler, _ = WITH_CONTACTS
    scenes = []
    for system in dict.fromkeys(entry.scene.system for entry in ran):
        of_system = [entry for entry in ran if entry.scene.system == system]
        if _largest(of_system, default).error >= _largest(of_system, euler).error:
            continue
        for name in (entry.scene.name for entry in of_system):
            finest = _finest(study, [name], (default, euler))
            if finest is None or not all(finest[1].values()):
                continue
            step, errors = finest
            if errors[euler][0] < errors[default][0]:
                scenes.append((name, step, errors[default][0], errors[euler][0]))
                break
    return " ".join(paragraphs("nearer_by_chance", scenes=scenes))


def _held_control(study: Study) -> tuple[str, str] | None:
    """RK4's relative errors at the reference step with a control read at the step's start, and at
    its middle; None where either was not run."""
    held = _errors(study, [s for s in study.scenes if s.name == FORCED], HELD)
    if not held or set(held[0].errors) != set(HELD):
        return None
    return held[0].errors[HELD[0]].text, held[0].errors[HELD[1]].text


def _costs(study: Study, ran: Sequence[Ran]) -> Mapping[str, float]:
    """The median cost of a step [ns] of each method, over the scenes that all were timed on at the
    reference step."""
    names, methods = list(ran[0].errors) if ran else [], {m.name: m for m in study.methods}
    at = {
        (c.scene, c.method)
        for c in study.convergence
        if (run := timed_run(c, methods[c.method])) is not None and run.step == REFERENCE_STEP
    }
    scenes = [entry.scene.name for entry in ran]
    timed = [s for s in scenes if all((s, name) in at & set(study.costs) for name in names)]
    if not timed:
        return {}
    return {
        name: sorted(study.costs[scene, name].ns_per_step for scene in timed)[len(timed) // 2]
        for name in names
    }


def _cost_ratios(costs: Mapping[str, float]) -> Mapping[str, str]:
    """The same in steps of MuJoCo's default settings, as text."""
    unit = costs.get(DEFAULT_METHOD)
    return {name: notation.number(ns / unit, 2) for name, ns in costs.items()} if unit else {}


def _table(
    study: Study,
    ran: Sequence[Ran],
    record: StudyRecord,
    methods: Sequence[str],
    note: str = "",
) -> Table:
    """Systems against methods, scenes apart each in a row, and what a step costs."""
    names = [m.name for m in study.methods if m.name in methods]
    titles = {system.name: system.title for system in record.systems}
    groups: dict[tuple[str, str], list[Ran]] = {}
    for entry in sorted(ran, key=lambda entry: entry.apart):
        system, scene = entry.scene.system, entry.scene.name
        key = (scene, anchor(scene)) if entry.apart else (titles[system], system)
        groups.setdefault(key, []).append(entry)
    costs = _costs(study, ran)
    ratios = _cost_ratios(costs)
    return table(
        "first_screen",
        names=names,
        default=DEFAULT_METHOD,
        rows={key: [_largest(of, name).text for name in names] for key, of in groups.items()},
        costs=ratios and costs,
        ratios=ratios,
        step=REFERENCE_STEP,
        note=note,
    )
