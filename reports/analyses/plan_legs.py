"""Which lines and arc the curve may have: plans along every pair of C-Ai, either way round."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.planner.result import Plan
from plumbob.analytic.systems.planner.tracks import ArcName, Pair
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.tripod_capsule.parameters import CHECK
from plumbob.models.tripod_capsule.plan import BESIDE, CURVES, planned
from plumbob.reports.analyses.plan_errors import command, errors_at_end, plan_of, run_of
from plumbob.reports.view.content import Figure, Finding, Statement, Table, row, value
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.palette import BLUE, GREEN, GREY, RED
from plumbob.reports.view.sources import CHERNOUSKO
from plumbob.reports.view.traces import Trace, curve, figure, linear

METHODS = ("mujoco/euler+coulomb", "pymunk/feet")
STEP = 1e-3  # [s]
PAIRS: tuple[Pair, ...] = ((1, 2), (2, 3), (3, 1))
ARCS: tuple[ArcName, ...] = ("shorter", "longer")
SCENES = tuple(f"capsule-plan/beside-curve-{case}" for case, *_ in CURVES)
COLOURS = (RED, BLUE, GREEN)
POINTS = 400  # of a slider's path


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The plans of SCENES run open-loop, where the study has one of them."""
    if not any(plan.has(name) for name in SCENES):
        return ()
    return [run_of(name, method, STEP) for name in SCENES for method in METHODS]


def plans() -> tuple[Plan, ...]:
    """Plans to the same pose along each pair of lines, with the shorter arc and the longer."""
    to = {**CHECK, "to": (BESIDE.x, BESIDE.y, BESIDE.heading), "track": "curve"}
    curves = itertools.product(PAIRS, ARCS)
    return tuple(planned({**to, "legs": legs, "arc": arc}) for legs, arc in curves)


def said(plan: Plan) -> str:
    """The curve of a plan, in words."""
    i, j = plan.legs
    return f"C–A{i}, {plan.arc} arc, C–A{j}"


def finding(study: Study) -> Finding | None:
    """The six plans, and three of them in two engines; None where the study has no such plan."""
    if not any(scene.name in SCENES for scene in study.scenes):
        return None
    every = plans()
    worst = max(max(plan.error) for plan in every)
    times = [plan.duration for plan in every]
    rows = tuple(
        row(said(plan), value(plan.duration, 4), value(plan.turns), value(plan.lines),
            value(plan.error[0], 1), value(plan.error[1], 1))
        for plan in every
    )  # fmt: skip
    heads = ("curve", "time [s]", "turns", "lines", "error of the reference [m]", "[rad]")
    ends = errors_at_end(study, SCENES, METHODS, STEP)
    tables = [Table("The same pose along six curves", heads, rows)]
    seen = ""
    if ends:
        tables.append(
            Table(
                f"Open-loop in engines, steps of {short(STEP)} s",
                ("curve", "method", "error at the end [m]", "[rad]"),
                tuple(row(said(plan_of(name)), method, value(end.distance), value(end.heading))
                      for (name, method), end in ends.items()),
            )
        )  # fmt: skip
        farthest = max(end.distance for end in ends.values())
        seen = f"; in engines within {number(farthest, 2)} m at {short(STEP)} s"
    to = f"{BESIDE.x:g}, {BESIDE.y:g} m and {BESIDE.heading:g} rad"
    return Finding(
        "capsule-plan-legs",
        "Any two of the three lines C–Aᵢ will do, and the arc may go either way round",
        "confirmed",
        f"To {to}, along each pair of lines and with either arc, a plan ends within "
        f"{number(worst, 1)} of the pose, in metres and radians; the slowest of the six takes "
        f"{number(max(times) / min(times), 2)} times as long as the quickest{seen}.",
        (
            "Two of the three directions C–Aᵢ span the plane, and a body that turns needs some "
            "arc of the circle, no matter which. On the longer arc a turn may be larger, but a "
            "slow return along it takes longer; which one is quicker depends on the pose.",
            "A is a support, C the body's centre of mass, and the slider keeps to its curve, so "
            "that it has one degree of freedom.",
        ),
        tuple(tables),
        (_tracks(every),),
        (command(SCENES[1]), command(SCENES[1], METHODS[1], short(STEP)),
         f"plumbob solve {SCENES[2]}"),
        (
            Statement(
                CHERNOUSKO,
                "controllability, 3",
                "Lines along any two of the three C–Aᵢ, and any arc of the circle, are enough",
                "any two, any arc",
                f"3 pairs, 2 arcs each: six plans within {number(worst, 1)} m and rad{seen}",
                "holds",
            ),),
    )  # fmt: skip


def _tracks(every: Sequence[Plan]) -> Figure:
    """The slider's path in the body: a colour for each pair of lines; dashed: the longer arc."""
    traces: list[Trace] = []
    corners = np.array(every[0].capsule.supports)
    loop = np.vstack([corners, corners[:1]])
    traces.append(curve(loop[:, 0], loop[:, 1], colour=GREY, width=0.8, name="supports"))
    for number_, plan in enumerate(every):
        place: Array = plan.slider(np.linspace(0.0, plan.duration, POINTS))
        longer = plan.arc == "longer"
        traces.append(
            curve(place[:, 0], place[:, 1], colour=COLOURS[number_ // 2],
                  dash="dash" if longer else "solid", width=1.4, name=said(plan))
        )  # fmt: skip
    return figure(
        "Where the slider goes in the body, by curve",
        "In body axes, from C. The lines lead to the supports; parts that a plan does not use are "
        "not drawn.",
        traces, linear("along the body's x [m]", constrain="domain"),
        linear("along its y [m]", scaleanchor="x", constrain="domain"), legend=True, height=430,
    )  # fmt: skip
