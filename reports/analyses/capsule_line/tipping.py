"""Where the slider may go: the exact condition for contact, and what is beyond it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import lowest_normal_forces, normal_forces, source_assumption
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.measurements import LINE, covers, problem
from plumbob.reports.view.content import (
    Cell,
    Figure,
    Finding,
    Statement,
    Table,
    method_cell,
    row,
    value,
)
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.palette import GREY, OF_METHODS, RED
from plumbob.reports.view.sources import CHERNOUSKO
from plumbob.reports.view.traces import Trace, curve, linear, over_time

EDGE, METHOD, STEP, LASTING = "capsule-line/near-edge", "mujoco/euler+coulomb", 2e-4, 0.3  # [s]
BEYOND = 0.005  # [m] that the slider starts further along its line than in EDGE
INSIDE = ExtraRun(EDGE, METHOD, STEP, LASTING)
TIPPED = ExtraRun(EDGE, METHOD, STEP, LASTING, settings=(("slider_ahead", BEYOND),))
# The triangle of the check body moved until C is 1 cm outside; the slider starts far enough ahead.
OUTSIDE = (("supports", ((0.31, 0.0), (0.01, 0.15), (0.01, -0.15))), ("start", 0.1))
ENGINES = (METHOD, "pymunk/side")
ENGINE_STEP = 1e-3  # [s]
YES_NO = ("no", "yes")


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """A manoeuvre that ends inside the edge and one that ends beyond; one with C outside."""
    if not covers(plan, LINE):
        return ()
    outside = (ExtraRun(LINE, method, ENGINE_STEP, changes=OUTSIDE) for method in ENGINES)
    return (INSIDE, TIPPED, *outside)


def loads_beyond(times: Array) -> Array:
    """N_i [N], shape (n, 3), that statics asks for at `times` [s] in the run that tips: below
    zero, which a plane that only pushes cannot give."""
    line = problem(EDGE).motion
    places = (line.start + BEYOND + line.strokes(times))[:, None] * line.unit
    return normal_forces(line.capsule, places)


def finding(study: Study) -> Finding | None:
    """The exact condition, motions that hold without the source's, and a run that tips; None where
    the study does not have the check manoeuvre."""
    if not covers(study, LINE):
        return None
    capsule = problem(LINE).setup.capsule
    changed = case_of(find_scene(LINE, dict(OUTSIDE))).problem.motion
    motions = (
        ("the check manoeuvre", problem(LINE).motion),
        ("near-edge: Q outside", problem(EDGE).motion),
        ("triangle moved by 11 cm: C outside", changed),
    )
    exact = float(changed.displacement)
    measured = [
        row(method_cell(method), value(exact, 5), value(dots / exact - 1.0))
        for method in ENGINES
        if (dots := _displacement(study, method)) is not None
    ]
    tables = [
        Table("Motions along a line", ("motion", "C inside", "Q inside", "smallest Nᵢ over (M+m)g"),
              tuple(_row(text, motion) for text, motion in motions),
              "Q is the slider, C the body's centre of mass."),
    ]  # fmt: skip
    if measured:
        heads = ("method", "Δx by eq. 22 [m]", "relative error")
        note = f"At a step of {short(ENGINE_STEP)} s."
        tables.append(Table("With C outside the triangle", heads, tuple(measured), note))
    return Finding(
        "capsule-tipping",
        "Nᵢ > 0 asks for the combined centre of mass inside the triangle, not for C and Q",
        "extended",
        "The slider may go further out than the paper allows before a foot lifts. "
        "The source's condition, C and Q inside the triangle of supports, is sufficient and not "
        f"necessary: the slider of the check body may go {number(1 / capsule.mass_ratio)} times as "
        f"far from C as the triangle does.{_lifted(study)}",
        (
            "The normal forces are the weight times the barycentric coordinates of the combined "
            "centre of mass μr (eq. 7; r is the slider's place from C and μ = m/(M+m)). So every "
            "Nᵢ is above zero where μr is inside the triangle, and only there: with C inside, Q "
            "may be anywhere in the triangle enlarged by 1/μ about C, and C may be outside as long "
            "as Q is far enough on the other side. Each Nᵢ is linear along a line and a cosine "
            "along an arc, so its smallest value on a path is known exactly.",
            "Beyond, the plane would have to pull, and there is no motion in the plane: the "
            "reference refuses such a path and names the support. An engine goes on: in MuJoCo a "
            "foot leaves the plane and the body tips over the edge. pymunk/feet cannot show it, "
            "because it is seen from above and its normal forces are given.",
        ),
        tuple(tables),
        (_figure(study),),
        (f"plumbob solve {EDGE}", f"plumbob run {EDGE} {METHOD} --step {STEP:g}"),
        (
            Statement(
                CHERNOUSKO,
                "assumptions",
                "C and Q inside the triangle assure Nᵢ > 0",
                "C and Q inside",
                f"μr inside: Q up to {number(1 / capsule.mass_ratio)} times as far."
                f"{_lifted(study)}",
                "extended",
                "Sufficient, not necessary.",
            ),),
    )  # fmt: skip


def _row(text: str, motion: LineManoeuvre) -> tuple[Cell, ...]:
    lowest, _ = lowest_normal_forces(motion.capsule, (motion.segment,))
    assumed = source_assumption(motion.capsule, (motion.segment,))
    return row(
        text, YES_NO[assumed.com_inside], YES_NO[assumed.slider_inside],
        value(float(np.min(lowest)) / motion.capsule.weight),
    )  # fmt: skip


def _displacement(study: Study, method: str) -> float | None:
    run = study.recording(ExtraRun(LINE, method, ENGINE_STEP, changes=OUTSIDE))
    return None if run is None else float(run.observables["displacement"][-1])


def _lifted(study: Study) -> str:
    """The result of the run beyond that limit, in a sentence."""
    if (run := study.recording(TIPPED)) is None:
        return ""
    off = np.flatnonzero(run.channels["contacts"] < 3)
    if not off.size:
        return ""
    time, risen = float(run.times[off[0]]), float(run.channels["vertical_displacement"][-1])
    return (
        f" {number(1e3 * BEYOND)} mm further than near-edge MuJoCo lifts A₁ at {number(time, 2)} s;"
        f" C is {number(1e3 * risen, 2)} mm higher at {number(float(run.times[-1]), 2)} s."
    )


def _figure(study: Study) -> Figure:
    line, times = problem(EDGE).motion, np.linspace(0.0, 0.2, 200)
    traces: list[Trace] = [
        curve(times, line.normal_forces(times)[:, 0], colour=GREY, width=2.2, name="inside, exact"),
        curve(times, loads_beyond(times)[:, 0], colour=RED, dash="dash", name="beyond, by statics"),
    ]
    for request, shown, dash in ((INSIDE, "inside", "solid"), (TIPPED, "beyond", "dot")):
        if (run := study.recording(request)) is not None:
            kept = run.times <= times[-1]
            dots = run.times[kept], run.observables["normal_force_1"][kept]
            traces.append(
                curve(*dots, colour=OF_METHODS[METHOD], dash=dash, name=f"{shown}, {METHOD}")
            )
    return over_time(
        "Normal force at A₁",
        "Inside the edge it stays above zero; beyond, the foot lifts where it reaches zero.",
        traces,
        linear("N₁ [N]"),
        height=300,
    )
