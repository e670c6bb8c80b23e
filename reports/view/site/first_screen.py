"""The first screen: what was checked, what to use, and the findings that matter most."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from plumbob.engines.study.measurement import REFERENCE_STEP, Measurement, worst
from plumbob.engines.study.results import Study
from plumbob.models.registry import systems
from plumbob.models.scene import Scene
from plumbob.reports.advice.recommend import DEFAULT_METHOD
from plumbob.reports.judge.verdict import Judgements
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Figure, Finding, Table, row
from plumbob.reports.view.settings import Pasted, written_for
from plumbob.reports.view.site.claims import NOT_SHOWN
from plumbob.reports.view.site.matrix import SIGNS, in_order, meaning
from plumbob.reports.view.site.pictures import names, picture

WITH_CONTACTS = ("mujoco/euler", "mujoco/euler+coulomb", "mujoco/rk4+coulomb")
WITHOUT = ("mujoco/euler", "mujoco/rk4")
FORCED, HELD = "simple-pendulum/forced-large", ("mujoco/rk4", "mujoco/rk4+midpoint")
NEAR = 1.25  # a run within this factor of the step asked for stands for it
KEY_FINDINGS = (  # name, and which of its figures is its picture
    ("capsule-isotropy", 0),
    ("capsule-displacement", 0),
    ("held-control", 0),
    ("printed-hamiltonian", 0),
    ("capsule-turn-second-order", 0),
    ("energy", 0),
)
MOST_FINDINGS = 6


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
    """What to use for a kind of robot: in a sentence or two, as a table, and the settings."""

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


def counts(study: Study, judged: Judgements) -> tuple[Count, ...]:
    """How many pairs of a scene and a method are as predicted, converge, and so on."""
    found = Counter(meaning(*pair, one.whole) for pair, one in judged.items())
    return tuple(
        Count(name, *said, found[name])
        for name, said in SIGNS.items()
        if found[name] or name != "unclaimed"
    )


def runs(study: Study) -> int:
    """How many runs were made."""
    ran = (m for c in study.convergence for m in c.measurements)
    return sum(m.status in ("done", "diverged") for m in ran)


def answers(study: Study) -> tuple[Answer, ...]:
    """What to use with contacts and without, of what was measured."""
    return tuple(answer for answer in (_contacts(study), _joints(study)) if answer is not None)


def cards(findings: Sequence[Finding]) -> tuple[Card, ...]:
    """The findings that matter most; where a study lacks one, or does not show it, others that have
    a figure."""
    known = {finding.name: finding for finding in findings if finding.judgement != NOT_SHOWN}
    wanted = [(known[n], place) for n, place in KEY_FINDINGS if n in known]
    first = {finding.name for finding, _ in wanted}
    rest = [(finding, 0) for name, finding in known.items() if name not in first]
    found = []
    for finding, place in (*wanted, *rest):
        if place >= len(finding.figures) or not (drawn := picture(finding.figures[place])):
            continue
        figure = finding.figures[place]
        found.append(Card(finding, figure, drawn, names(figure)))
    return tuple(found[:MOST_FINDINGS])


def _contacts(study: Study) -> Answer | None:
    """The contact settings to use, what they give and what they cost."""
    scenes = [s for s in study.scenes if s.system.startswith("capsule-") and not s.hard]
    scenes = [s for s in scenes if s.parameters.get("friction") != 0.0]
    default, euler, rk4 = WITH_CONTACTS
    found = _errors(study, scenes, WITH_CONTACTS)
    line = found.get("capsule-line") or next(iter(found.values()), None)
    ratios = _cost_ratios(study, scenes, WITH_CONTACTS)
    if line is None or default not in line or euler not in line:
        return None
    usual = f"{_range(*line[default])}, depending on the direction"
    lines = [scene.name for scene in scenes if scene.system == "capsule-line"]
    if (finest := _finest(study, lines, (default,))) is not None:
        step, errors = finest
        still = _range(min(errors[default]), max(errors[default]))
        usual += f", and at {notation.short(step)} s still {still}"
    cost = f", and a step costs {ratios[euler]} times one with default contacts" * (euler in ratios)
    sentences = [
        "Use MuJoCo with an elliptic cone and contacts that are soft along the normal and stiff "
        f"across it, written for your time step (settings below). At 1 ms a robot that slides on a "
        f"line then stops with an error of {notation.relative(line[euler][1])}{cost}. With default "
        f"contacts the error is {usual}."
    ]
    if line[euler][1] > line[default][1]:
        sentences = [
            "In this study contacts written for the step are no better than MuJoCo's default ones: "
            f"at 1 ms a robot that slides on a line stops with an error of up to "
            f"{notation.relative(line[euler][1])}, with default contacts of {usual}."
        ]
    elif rk4 in ratios and all(rk4 in of for of in found.values()):
        worst_of_all = max(of[rk4][1] for of in found.values())
        sentences.append(
            "Where the robot also turns or coasts, take the same contacts with RK4: at most "
            f"{notation.relative(worst_of_all)} on all of these motions, for {ratios[rk4]} times "
            "the cost."
        )
    table = _table("Largest relative error at 1 ms, and what a step costs",
                   found, WITH_CONTACTS, study, scenes)  # fmt: skip
    table = replace(table, note=_nearer_by_chance(study, scenes, found))
    pasted = written_for(euler, REFERENCE_STEP, "Contacts to copy")
    return Answer("with-contacts", "A robot with contacts", tuple(sentences), table, pasted)


def _joints(study: Study) -> Answer | None:
    """What to use for a mechanism without contacts."""
    scenes = [s for s in study.scenes if s.system.endswith("pendulum") and not s.hard]
    default, rk4 = WITHOUT
    found = _errors(study, scenes, WITHOUT)
    both = [of for of in found.values() if default in of and rk4 in of]
    if not both:
        return None
    ratios = _cost_ratios(study, scenes, WITHOUT)
    free = min(of[rk4][0] for of in both)
    cost = f", for {ratios[rk4]} times the cost of a step" if rk4 in ratios else ""
    sentences = [
        f'Use MuJoCo with integrator="RK4": at 1 ms its errors are {notation.relative(free)} to '
        f"{notation.relative(max(of[rk4][1] for of in both))}{cost}; with the default Euler steps "
        f"they are {notation.relative(min(of[default][0] for of in both))} to "
        f"{notation.relative(max(of[default][1] for of in both))}.",
    ]
    most, usual = (max(of[name][1] for of in both) for name in (rk4, default))
    if most > usual:
        sentences = [
            'In this study integrator="RK4" is no better than the default Euler steps: at 1 ms its '
            f"errors are up to {notation.relative(most)}, theirs up to {notation.relative(usual)}."
        ]
    if (held := _held_control(study)) is not None:
        sentences.append(
            "Set a control for the middle of the step and not for its start: a torque that is held "
            f"over the step leaves RK4 an error of {held[0]}, set for the middle {held[1]}."
        )
    table = _table("Largest relative error at 1 ms, and what a step costs",
                   found, WITHOUT, study, scenes)  # fmt: skip
    pasted = written_for(rk4, REFERENCE_STEP, "Integrator to copy")
    return Answer("without-contacts", "A robot without contacts", tuple(sentences), table, pasted)


def _range(low: float, high: float) -> str:
    """Two relative errors as text, or one where they are the same."""
    ends = dict.fromkeys((notation.relative(low), notation.relative(high)))
    return " to ".join(ends)


def _finest(
    study: Study, scenes: Sequence[str], methods: Sequence[str]
) -> tuple[float, Mapping[str, Sequence[float]]] | None:
    """The smallest step [s] at which all of these methods ran all of these scenes, with the errors
    of each there; None where that is no smaller than the reference step."""
    found = [c for c in study.convergence if c.scene in scenes and c.method in methods]
    runs = [(c.method, {m.step: m for m in c.measurements if m.status == "done"}) for c in found]
    steps = set.intersection(*(set(own) for _, own in runs)) if runs else set[float]()
    step = min(steps, default=REFERENCE_STEP)
    if step >= REFERENCE_STEP / NEAR:
        return None
    errors: dict[str, list[float]] = {method: [] for method in methods}
    for method, own in runs:
        errors[method].append(worst(own[step], study.quantities(own[step].scene))[1])
    return step, errors


def _nearer_by_chance(study: Study, scenes: Sequence[Scene], found: Errors) -> str:
    """Where default contacts have the smaller error at the reference step though they do not
    converge: what smaller steps make of both."""
    default, euler, _ = WITH_CONTACTS
    said = []
    for system, of in found.items():
        if default not in of or euler not in of or of[default][1] >= of[euler][1]:
            continue
        for name in (scene.name for scene in scenes if scene.system == system):
            finest = _finest(study, [name], (default, euler))
            if finest is None or not all(finest[1].values()):
                continue
            step, errors = finest
            if errors[euler][0] < errors[default][0]:
                said.append(
                    f"Smaller steps help one of them: at {notation.number(step, 2)} s the error of "
                    f"{name} is {notation.relative(errors[default][0])} with default contacts, "
                    f"{notation.relative(errors[euler][0])} with those written for the step."
                )
                break
    return " ".join(said)


def _held_control(study: Study) -> tuple[str, str] | None:
    """RK4's relative errors at about the reference step with a control read at the step's start,
    and at its middle; None where either was not run."""
    found = {}
    for c in study.convergence:
        run = _near(c.measurements) if c.scene == FORCED and c.method in HELD else None
        if run is not None:
            found[c.method] = notation.relative(worst(run, study.quantities(c.scene))[1])
    return (found[HELD[0]], found[HELD[1]]) if len(found) == len(HELD) else None


Errors = Mapping[str, Mapping[str, tuple[float, float]]]


def _errors(study: Study, scenes: Sequence[Scene], methods: Sequence[str]) -> Errors:
    """The smallest and largest relative error of each method at about the reference step, by
    system: over the scenes that all of these methods ran at such a step."""
    wanted = {scene.name: scene.system for scene in scenes}
    each: dict[str, dict[str, float]] = {}
    for c in study.convergence:
        run = _near(c.measurements)
        if c.scene in wanted and c.method in methods and run is not None:
            error = worst(run, study.quantities(c.scene))[1]
            if math.isfinite(error):
                each.setdefault(c.scene, {})[c.method] = error
    ran = {m.name for m in study.methods} & set(methods)
    whole = {scene: errors for scene, errors in each.items() if set(errors) == ran}
    found: dict[str, dict[str, tuple[float, float]]] = {}
    for system in in_order(list(dict.fromkeys(wanted[scene] for scene in whole))):
        own = [errors for scene, errors in whole.items() if wanted[scene] == system]
        found[system] = {
            name: (min(e[name] for e in own), max(e[name] for e in own)) for name in own[0]
        }
    return found


def _near(found: Sequence[Measurement]) -> Measurement | None:
    """The run at about the reference step, or at twice that where there is none."""
    done = {m.step: m for m in found if m.status == "done"}
    for wanted in (REFERENCE_STEP, 2.0 * REFERENCE_STEP):
        near = [h for h in done if wanted / NEAR <= h <= wanted * NEAR]
        if near:
            return done[min(near, key=lambda h: abs(math.log(h / wanted)))]
    return None


def _cost_ratios(
    study: Study, scenes: Sequence[Scene], methods: Sequence[str]
) -> Mapping[str, str]:
    """The median cost of a step of each method in those of MuJoCo's default settings, as text."""
    found = {}
    for name in methods:
        ratios = sorted(
            study.costs[scene.name, name].ns_per_step
            / study.costs[scene.name, DEFAULT_METHOD].ns_per_step
            for scene in scenes
            if (scene.name, name) in study.costs and (scene.name, DEFAULT_METHOD) in study.costs
        )
        if ratios:
            found[name] = notation.number(ratios[len(ratios) // 2], 2)
    return found


def _table(
    caption: str, found: Errors, methods: Sequence[str], study: Study, scenes: Sequence[Scene]
) -> Table:
    """Systems against methods, and the cost of a step and the speed in the last rows."""
    ran = [m.name for m in study.methods if m.name in methods]
    titles = systems()
    rows = [
        row(Cell(titles[system].title, "scene", link=system),
            *(Cell(notation.relative(of[name][1]), "number") for name in ran))
        for system, of in found.items()
    ]  # fmt: skip
    ratios = _cost_ratios(study, scenes, ran)
    if ratios:
        rows.append(row(Cell("cost of a step, relative", "scene"),
                        *(Cell(ratios.get(name, "–"), "number") for name in ran)))  # fmt: skip
        costs = [_cost(study, scenes, name) for name in ran]
        rows += [
            row(Cell("ns per step", "scene"),
                *(Cell(notation.number(ns), "number") for ns in costs)),
            row(Cell("real-time factor at 1 ms", "scene"),
                *(Cell(notation.real_time_factor(ns / REFERENCE_STEP), "number") for ns in costs)),
        ]  # fmt: skip
    labels = {DEFAULT_METHOD: f"{DEFAULT_METHOD} (default settings)"}
    return Table(caption, ("motion", *(labels.get(n, n) for n in ran)), tuple(rows))


def _cost(study: Study, scenes: Sequence[Scene], method: str) -> float:
    """The median cost of a step [ns] over the scenes; not a number where none was timed."""
    costs = sorted(
        study.costs[scene.name, method].ns_per_step
        for scene in scenes
        if (scene.name, method) in study.costs
    )
    return costs[len(costs) // 2] if costs else math.nan
