"""The page's section on plans: poses reached, plans run open-loop in engines, one plan drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np

from plumbob.analytic.systems.planner.construction import plan as find_plan
from plumbob.analytic.systems.planner.result import Plan
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import scenes as find_scenes
from plumbob.models.scene import Scene
from plumbob.reports.analyses import plan_legs
from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.plan_errors import by_kind, command, errors_of, plan_of, run_of
from plumbob.reports.analyses.plan_path import gallery
from plumbob.reports.view.content import (
    Cell,
    Figure,
    Finding,
    Statement,
    Table,
    plain_method_cell,
    row,
    value,
)
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.palette import OF_METHODS
from plumbob.reports.view.sources import CHERNOUSKO
from plumbob.reports.view.traces import Trace, curve, logarithmic, over_time

SHOWN = "capsule-plan/near-free"  # drawn where the study has it
DEFAULT = "mujoco/euler"
METHODS = ("mujoco/euler+coulomb", "pymunk/feet", "mujoco/rk4+coulomb", DEFAULT)
QUICK = METHODS[:2]
STEP = 1e-3  # [s]
KINDS = (("turn", "turns"), ("line", "lines"), ("slow", "slow motions"))
SMALLEST = 1e-12  # [m] and [rad]: where an error of zero is drawn
HEADS = ("plan", "x, y [m], ψ [rad]", "time [s]", "turns", "lines", "all manoeuvres",
         "naive: time [s]", "turns", "lines", "naive over best",
         "error of the reference [m]", "[rad]")  # fmt: skip


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Each plan of the study, run open-loop to its end, and those along each pair of lines."""
    own = [run_of(scene.name, method, STEP) for scene in scenes(plan) for method in _methods(plan)]
    return [*own, *plan_legs.requests(plan)]


def scenes(plan: Study | StudyPlan) -> tuple[Scene, ...]:
    """The plans that a study has."""
    names = {scene.name for scene in plan.scenes}
    return tuple(scene for scene in find_scenes("capsule-plan") if scene.name in names)


@cache
def naive(name: str) -> Plan:
    """The plan of equal manoeuvres for the same pose, under the same limits."""
    best = plan_of(name)
    return find_plan(
        best.capsule, best.goal, best.limits, best.track, best.start,
        equal=True, legs=best.legs, arc=best.arc,
    )  # fmt: skip


def figures(study: Study) -> Sequence[tuple[str, Sequence[Figure]]]:
    """One plan drawn: the one to be shown, or the first that the study has."""
    names = [scene.name for scene in scenes(study)]
    return (gallery(plan_of(SHOWN if SHOWN in names else names[0])),) if names else ()


def poses(study: Study) -> Finding | None:
    """Each plan that the study has, beside the naive one; None without any."""
    chosen = scenes(study)
    if not chosen:
        return None
    factors = [naive(s.name).duration / plan_of(s.name).duration for s in chosen]
    worst = max(max(plan_of(s.name).error) for s in chosen)
    span = number(min(factors), 2)
    if len(factors) > 1:
        span += f" to {number(max(factors), 2)}"
    note = (
        "Naive: as few equal turns and lines as possible, with w₁ = 3fg/μ, w₂ = 0.8fg/μ, "
        "μ₁Z = 3R₀, and a slow return after each. All manoeuvres: with slow motions and waits."
    )
    if study.profile != "full":
        note += " The full profile has five poses on both tracks."
    names = [scene.name.partition("/")[2] for scene in chosen]
    end = f"All {len(names)} plans end" if len(names) > 1 else f"The plan {names[0]} ends"
    return Finding(
        "capsule-plan-poses",
        "Any pose can be reached, and choosing the manoeuvres for time pays",
        "confirmed",
        "A planner can bring this robot to every pose, and should choose its manoeuvres for "
        "time. "
        f"{end}, in the exact motion, within {number(worst, 1)} of the pose, in metres and "
        f"radians; the naive plan takes {span} times as long.",
        (
            "A plan turns the body to the heading wanted, moves it along lines to the place, "
            "returns the slider by slow motions, and waits for every residual motion to end. The "
            "slider's accelerations w₁ and w₂ in lines and Z in turns are as large as the limits "
            "on |w| and on friction allow; lines are as long as the limit on the stroke allows, "
            "and the last one covers the rest; turns are of one size. The planner takes the "
            "quickest of a few numbers of turns and places to begin. Every turn is followed by the "
            "exact motion to rest, since eq. 32 alone has an error of order ε².",
            "On the free plane one line in any direction through C is enough for the translation. "
            "On the source's curve (segment, arc, segment) the slider has one degree of freedom, "
            "needs lines in two directions, and returns after each.",
        ),
        (Table("Plans", HEADS, tuple(_row(scene) for scene in chosen), note),),
        (),
        (command(chosen[0].name),
         "plumbob validate --profile full --scenes 'capsule-plan/*' --methods pymunk/feet"),
        (
            Statement(
                CHERNOUSKO,
                "controllability",
                "From rest to rest at any (x, y, ψ), with Q on one curve",
                "any pose",
                f"{len(chosen)} planned, within {number(worst, 1)} m and rad; {span} times as fast "
                "as the naive plan",
                "holds",
            ),),
    )  # fmt: skip


def _row(scene: Scene) -> tuple[Cell, ...]:
    best, other = plan_of(scene.name), naive(scene.name)
    goal, (distance, angle) = best.goal, best.error
    return row(
        scene.name.partition("/")[2],
        f"{goal.x:g}, {goal.y:g}, {number(goal.heading)}",
        value(best.duration, 4), value(best.turns), value(best.lines),
        value(len(best.manoeuvres)), value(other.duration, 4), value(other.turns),
        value(other.lines), value(other.duration / best.duration), value(distance, 1),
        value(angle, 1),
    )  # fmt: skip


def _methods(plan: Study | StudyPlan) -> tuple[str, ...]:
    return METHODS if plan.profile == "full" else QUICK


def open_loop(study: Study) -> Finding | None:
    """The pose's error at the end by plan and method, and by the kind of manoeuvre that caused it;
    None without a plan or an engine."""
    chosen = [scene.name for scene in scenes(study)]
    rows, ends, held = [], dict[str, list[float]](), dict[bool, list[float]]()
    for name in chosen:
        for method in _methods(study):
            if (after := errors_of(study, name, method, STEP)) is None or (
                last := after[-1]
            ) is None:
                continue
            parts = by_kind(plan_of(name), after)
            cells = [value(last.distance), value(last.heading)]
            for kind, _ in KINDS:
                part = parts.get(kind)
                cells += [value(None if part is None else part.distance, 2),
                          value(None if part is None else part.heading, 2)]  # fmt: skip
            ends.setdefault(method, []).append(last.distance)
            if "slow" in parts:
                held.setdefault(method == DEFAULT, []).append(parts["slow"].distance)
            rows.append(row(name.partition("/")[2], plain_method_cell(method), *cells))
    if not rows:
        return None
    heads = ("plan", "method", "error at the end [m]", "[rad]",
             *(head for _, kind in KINDS for head in (f"from {kind} [m]", "[rad]")))  # fmt: skip
    said = "; ".join(
        f"{name} {number(min(e), 2)}" + (f" to {number(max(e), 2)}" if len(e) > 1 else "")
        for name, e in ends.items()
    )
    return Finding(
        "capsule-plan-open-loop",
        "Run open-loop, a plan ends with the errors that its turns and lines added",
        "measured",
        "Without feedback a plan misses its goal by the errors of its turns and lines "
        "together. "
        f"With steps of {short(STEP)} s the error of the place at the end is, in metres: {said}."
        f"{_slow(held)}",
        (
            "The engines follow the planned motion of the slider, and nothing is measured on the "
            "way. A turn is charged with the error after its residual motion less the error "
            "before; an error of the heading rotates every later line, and that counts as the "
            "lines'.",
            "Turns cause the error of the heading, most of all with semi-implicit Euler, which "
            "loses angular momentum; lines cause the error of a stop inside a step, and the "
            "sideways error.",
        ),
        (Table(f"Error of the pose at the end, by kind of manoeuvre, steps of {short(STEP)} s",
               heads, tuple(rows)),),
        (() if SHOWN not in chosen else tuple(_along(study, SHOWN, which)
                                              for which in ("distance", "heading"))),
        tuple(command(chosen[0], method, short(STEP)) for method in QUICK),
        () if False not in held else (
            Statement(
                CHERNOUSKO, "slow motions",
                "With a small enough |w| friction holds the body while Q goes anywhere", "at rest",
                f"at rest; in engines with convergent friction all slow motions of a plan move it "
                f"by {number(max(held[False]), 2)} m at most", "holds",
            ),
        ),
    )  # fmt: skip


def _slow(held: Mapping[bool, Sequence[float]]) -> str:
    """What slow motions add, with convergent friction and on default contacts."""
    said = ""
    if False in held:
        said += f" Slow motions add at most {number(max(held[False]), 2)} m"
    if True in held:
        said += (
            f"; on default contacts, whose stiction drifts, up to {number(max(held[True]), 2)} m"
        )
    return f"{said}." if said else ""


def _along(study: Study, name: str, which: str) -> Figure:
    """The error of the place or of the heading after each manoeuvre."""
    plan, traces = plan_of(name), list[Trace]()
    for method in _methods(study):
        if (after := errors_of(study, name, method, STEP)) is None:
            continue
        known = [(end, abs(getattr(error, which)), one.kind)
                 for end, error, one in zip(plan.ends, after, plan.manoeuvres, strict=True)
                 if error is not None]  # fmt: skip
        times, sizes, kinds = zip(*known, strict=True)
        traces.append(
            curve(times, np.maximum(sizes, SMALLEST), colour=OF_METHODS[method], marks=True,
                  width=1.0, name=method, hints=[f"after a {kind}" for kind in kinds],
                  hint="%{text}, t = %{x:.3g} s: %{y:.3g}")
        )  # fmt: skip
    title, unit = ("place", "m") if which == "distance" else ("heading", "rad")
    return over_time(
        f"Error of the {title} after each manoeuvre of {name.partition('/')[2]}",
        f"Where the body is at rest, steps of {short(STEP)} s.",
        traces, logarithmic(f"error [{unit}]"),
    )  # fmt: skip


SECTION = Section((poses, plan_legs.finding, open_loop), (figures,), more=requests)
