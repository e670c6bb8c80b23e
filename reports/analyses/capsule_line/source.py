"""The source's figure and formulas: Fig. 2, two misprints, and eq. 22 on every line through C."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from plumbob.analytic.systems.manoeuvres.line_manoeuvre import printed_body_velocity
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.claims import at_most
from plumbob.reports.analyses.measurements import LINE, displacement_error, problem, runs
from plumbob.reports.view.content import Cell, Figure, Finding, Statement, Table, row, value
from plumbob.reports.view.notation import number
from plumbob.reports.view.palette import GREY, OF_METHODS, RED
from plumbob.reports.view.sources import CHERNOUSKO
from plumbob.reports.view.traces import Trace, curve, linear, marks, over_time

STEP = 1e-3  # [s]
ENGINES = (("mujoco/euler+coulomb", "MuJoCo"), ("pymunk/side", "pymunk"))  # of Fig. 2
STRAIGHT = 1e-3  # [rad]: a body that turns by less goes along a line
EVERY = 5  # samples to a mark
MISPRINTS = "mujoco/euler+coulomb"
LINES = tuple(f"capsule-line/{name}" for name in ("ca1", "ca2", "ca3", "at-50", "at-123", "at-222"))
ON_LINES = ("mujoco/euler+coulomb", "pymunk/feet")


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The check manoeuvre for Fig. 2 and the misprints; six lines."""
    return (
        *runs((LINE,), (method for method, _ in ENGINES), (STEP,)),
        ExtraRun(LINE, MISPRINTS, STEP),
        *runs(LINES, ON_LINES, (STEP,)),
    )


def galleries(study: Study) -> Sequence[tuple[str, Sequence[Figure]]]:
    """v(t), v_c(t) and x(t) of the check manoeuvre, exact and as two engines have them."""
    line = problem(LINE).motion
    switches = (
        f"t₁ = {number(line.t1)} s, t* = {number(line.t_star, 5)} s, t₂ = {number(line.t2, 5)} s."
    )
    panels = (
        ("v(t): the slider in the body", "stroke_rate", "v [m/s]", switches),
        ("v_c(t): the body", "velocity", "v_c [m/s]", "Backwards until t*, then at rest."),
        ("x(t): the body", "displacement", "x [m]",
         f"Δx = {number(line.displacement, 5)} m, eq. 22."),
    )  # fmt: skip
    figures = tuple(_panel(study, *panel) for panel in panels)
    return ((f"Chernousko's Fig. 2: exact, and measured at a step of {number(STEP)} s", figures),)


def _panel(study: Study, title: str, name: str, axis: str, caption: str) -> Figure:
    reference, motion = problem(LINE).reference, problem(LINE).motion
    # The switches among the times, so that a corner is drawn as one.
    switches = [motion.t1, motion.t_star, motion.t2]
    times = np.unique(np.append(np.linspace(0.0, 1.05 * motion.t2, 200), switches))
    exact = reference.observe(times)[name]
    traces: list[Trace] = [curve(times, exact, colour=GREY, width=2.2, name="exact")]
    for place, (method, shown) in enumerate(ENGINES):
        if (run := study.recording(ExtraRun(LINE, method, STEP))) is not None:
            kept = slice(place * EVERY // 2, None, EVERY)
            dots = run.times[kept], run.observables[name][kept]
            traces.append(marks(*dots, OF_METHODS[method], shown))
    return over_time(title, caption, traces, linear(axis), height=300)


def misprints(study: Study) -> Finding:
    """Both misprints, and eq. 19 as printed beside as derived."""
    line = problem(LINE).motion
    late = np.array([line.t_star])
    printed = float(printed_body_velocity(line, late)[0])
    times = np.linspace(0.0, 1.05 * line.t2, 200)
    shown = times <= line.t_star
    traces: list[Trace] = [
        curve(times, line.body_velocity(times), colour=GREY, width=2.2, name="eq. 19 with t₁"),
        curve(times[shown], printed_body_velocity(line, times[shown]), colour=RED, dash="dash",
              width=2.2, name="eq. 19 as printed, with t"),
    ]  # fmt: skip
    at_end = None
    if (run := study.recording(ExtraRun(LINE, MISPRINTS, STEP))) is not None:
        rates = run.observables["velocity"]
        traces.append(marks(run.times[::5], rates[::5], OF_METHODS[MISPRINTS], MISPRINTS))
        at_end = float(np.interp(line.t_star, run.times, rates))
    rows = (
        row("as printed", value(printed)),
        row("with t₁ in its first term", value(float(line.body_velocity(late)[0]))),
        row(f"measured, {MISPRINTS} at {number(STEP)} s", value(at_end, 2)),
    )
    return Finding(
        "capsule-misprints",
        "Eqs. 18 and 19 are misprinted",
        "corrected",
        "Who implements this manoeuvre from the paper must correct two equations first. "
        "Eq. 18 has an angular velocity ω₂ in place of the slider's acceleration w₂; the second "
        "line of eq. 19 has t in place of t₁, and as printed the body still moves at "
        f"{number(printed)} m/s at t*, the time when eq. 20 has it at rest.",
        (
            "Eq. 17 gives Δξ = w₁(w₁ + w₂)t₁²/(2w₂); there is no ω₂ on a line. Eq. 11 integrated "
            "gives v_c = –(μw₁ – fg)t₁ + (μw₂ + fg)(t – t₁) after t₁, which is zero at the t* of "
            "eq. 20 and agrees with eq. 22 and with Fig. 2. (μ = m/(M+m), the slider's mass "
            "fraction; f: coefficient of friction.)",
        ),
        (Table("Velocity of the body at t*, the time of eq. 20", ("eq. 19", "v_c(t*) [m/s]"),
               rows),),
        (over_time("v_c(t), printed and corrected", "The printed form is drawn until t*.", traces,
                   linear("v_c [m/s]"), height=300),),
        ("plumbob solve capsule-line", f"plumbob run {LINE} {MISPRINTS} --step 1e-3"),
        (
            Statement(
                CHERNOUSKO,
                "(18)",
                "Δξ of a line manoeuvre",
                "with an angular velocity ω₂",
                f"with w₂: Δξ = {number(line.strokes(np.array([line.t2]))[0], 8)} m",
                "corrected",
            ),
            Statement(
                CHERNOUSKO,
                "(19), (20)",
                "The body stops at t*",
                f"with t in the first term: {number(printed)} m/s at t*",
                f"with t₁: {number(float(line.body_velocity(late)[0]))} m/s"
                + ("" if at_end is None else f"; in MuJoCo {number(at_end, 2)} m/s"),
                "corrected",
            ),),
    )  # fmt: skip


def any_line(study: Study) -> Finding:
    """Eq. 22 along the source's three lines and three others, in two engines."""
    rows, turned = [], [0.0]
    for scene in LINES:
        motion = problem(scene).motion
        cells: list[str | Cell] = [
            Cell(scene.partition("/")[2], "scene"),
            value(math.degrees(motion.direction) % 360.0),
            value(motion.displacement, 5),
        ]
        for method in ON_LINES:
            run = study.recording(ExtraRun(scene, method, STEP))
            turn = None if run is None else float(np.abs(run.observables["heading"]).max())
            turned.append(turn or 0.0)
            cells += [value(displacement_error(study, scene, method, STEP)), value(turn, 2)]
        rows.append(row(*cells))
    heads = (
        "scene", "angle to C–A₁ [°]", "Δx by eq. 22 [m]",
        *(text for method in ON_LINES for text in (
            f"{method}: relative error of Δx", "largest |heading| [rad]")),
    )  # fmt: skip
    return Finding(
        "capsule-any-line",
        "Eq. 22 holds along every line through C, not only C–Aᵢ",
        "extended",
        "One straight manoeuvre moves the capsule in any direction; the paper takes two. "
        "When the slider moves on a line through C, the body's centre of mass, the centre of the "
        "normal forces is on that line too, so friction has no moment about C while the body "
        "slides along it. One straight manoeuvre takes the body to any place on the plane. In the "
        f"engines it turns by no more than {number(max(turned), 2)} rad.",
        (
            "Σ Nᵢ CAᵢ = m g r, with Aᵢ the supports, Nᵢ their normal forces and r the slider's "
            "place from C: the moment of friction against a motion along d is –f m g (r × d), "
            "which is zero when r is along d, whatever the triangle of the supports. The source "
            "argues for C–A₁ that N₂ and N₃, and so their frictions, are inversely proportional to "
            "their arms, for any triangle too; it takes two manoeuvres along such lines.",
        ),
        (Table(f"Six lines at a step of {number(STEP)} s", heads, tuple(rows)),),
        (),
        (f"plumbob validate --scenes {','.join(LINES)} --methods {','.join(ON_LINES)}",
         "plumbob solve capsule-line/at-123"),
        (
            Statement(
                CHERNOUSKO,
                "(11)–(22)",
                "Δx of a manoeuvre along C–Aᵢ",
                "C–A₁, C–A₂, C–A₃",
                f"any line through C; in engines the body turns by {number(max(turned), 2)} "
                "rad at most",
                "extended",
            ),
        ),
        claims=(
            at_most("the largest turn of the body in an engine", max(turned), STRAIGHT, "rad"),
        ),
    )  # fmt: skip
