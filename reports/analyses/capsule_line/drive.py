"""The force of the slider's actuator: in time, as engines have it, and what sizes an actuator."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.systems.capsule_motion import Demand
from plumbob.analytic.systems.manoeuvres.driving_force import demand
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import turn_of
from plumbob.analytic.systems.three_points.drive import plane_demand
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.capsule_line.source import ENGINES, STEP
from plumbob.reports.analyses.claims import at_most
from plumbob.reports.analyses.measurements import LINE, covers, measured, names, problem
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
from plumbob.reports.view.palette import GREY, OF_METHODS
from plumbob.reports.view.sources import CHERNOUSKO
from plumbob.reports.view.traces import Trace, curve, linear, marks, over_time

EPSILONS, RADIUS = (0.3, 0.1, 0.03), 0.12  # of turns, and of the slider's circle [m]
WITHIN = 1e-2  # of the force's peak: what theory may leave unpredicted
EVERY = 4  # samples to a mark
NOT_COULOMB = ("pymunk/pivots",)  # three bare joints, whose friction no step brings to Coulomb's


def finding(study: Study) -> Finding | None:
    """The actuator's force on the line and the turn, and each method's error of it; None where the
    study does not have the scene."""
    if not covers(study, LINE):
        return None
    line = problem(LINE).motion
    wanted = demand(line, line.t2)
    turns = {epsilon: _of_turn(epsilon) for epsilon in EPSILONS}
    demands = (
        ("line, C–A₁", wanted),
        *((f"turn, ε = {number(epsilon)}", effort) for epsilon, effort in turns.items()),
    )
    rows, errors = [], []
    for name in names(study):
        run = measured(study, LINE, name, STEP)
        if run is None or (error := run.errors.get("driving_force")) is None:
            continue
        beyond = error.predicted.beyond if error.predicted else None
        bound = error.model_error if error.model else None
        if bound is not None and beyond is not None and name not in NOT_COULOMB:
            errors.append(beyond / wanted.peak)
        rows.append(row(method_cell(name), value(error.largest), value(beyond), value(bound)))
    note = ""
    if errors:
        note = (
            f" In engines whose friction converges it is within {number(max(errors), 2)} of the "
            "peak of what theory predicts at each sample."
        )
    return Finding(
        "capsule-driving-force",
        "What the actuator must give: newtons on a line, kilonewtons on a turn",
        "extended",
        "An actuator needs newtons to push along a line and kilonewtons for a quick turn. "
        f"The check manoeuvre asks for {number(wanted.peak)} N at most and {number(wanted.rms)} N "
        f"r.m.s.; a turn with ε = 0.1 asks for {number(turns[0.1].peak)} N and "
        f"{number(1e-3 * turns[0.1].power)} kW.{note}",
        (
            "The source has the force F of the actuator in eqs. 3 and 9 and eliminates it. With "
            "the body's acceleration eliminated instead, F = μF_f + (1–μ)m w, where F_f is the "
            "resultant of friction, m the slider's mass, w its acceleration in the body and "
            "μ = m/(M+m): on a line it is constant between two switches.",
            "On a turn nearly all of F is centripetal: the slider's largest speed is aZτ, where "
            "Z is its angular acceleration, τ half the time of the turn and a the radius of its "
            "circle, so that F grows as 1/ε², which is what the small angle error of eq. 32 costs.",
            "MuJoCo reads F as a force sensor between body and slider does: the force of the "
            "actuator less the inertia of its armature, which here imposes the motion. pymunk's "
            "is the impulse of the joint over a step, so both are means over the step that "
            "follows, and where a switch is inside a step they differ from F by the part of the "
            "jump that falls into it.",
        ),
        (
            Table(
                "What sizes an actuator, until the slider stops",
                ("motion", "peak of |F| [N]", "r.m.s. [N]", "peak power [W]"),
                tuple(row(Cell(text, "text"), *map(value, (effort.peak, effort.rms, effort.power)))
                      for text, effort in demands),
                "Power: F times the slider's velocity in the body.",
            ),
            Table(
                f"Errors of F on the check manoeuvre, step {short(STEP)} s",
                ("method", "largest error [N]", "of it not predicted [N]", "model-error bound [N]"),
                tuple(rows),
            ),
        ),
        (_figure(study),),
        ("plumbob solve capsule-line/ca1", "plumbob solve capsule-turn/0.1",
         f"plumbob run {LINE} mujoco/euler+coulomb --step 1e-3"),
        (
            Statement(
                CHERNOUSKO,
                "(3), (9)",
                "The driving force F is eliminated",
                "no value",
                f"at most {number(wanted.peak)} N, {number(wanted.rms)} N r.m.s. on the check "
                f"manoeuvre.{note}",
                "extended",
            ),),
        claims=(
            (at_most("the distance from the predicted force, over its peak,", max(errors), WITHIN),)
            if errors
            else ()
        ),
    )  # fmt: skip


def _of_turn(epsilon: float) -> Demand:
    manoeuvre = turn_of(problem(LINE).setup.capsule, RADIUS, epsilon)
    return plane_demand(three_point_motion(manoeuvre.capsule, manoeuvre.path))


def _figure(study: Study) -> Figure:
    line = problem(LINE).motion
    edges = np.array([0.0, line.t1, line.t_star, line.t2, 1.05 * line.t2])
    forces = line.driving_force(0.5 * (edges[1:] + edges[:-1]))
    steps = np.repeat(edges, 2)[1:-1], np.repeat(forces, 2)
    traces: list[Trace] = [curve(*steps, colour=GREY, width=2.2, name="exact")]
    for place, (method, shown) in enumerate(ENGINES):
        if (run := study.recording(ExtraRun(LINE, method, STEP))) is not None:
            kept = slice(place * EVERY // 2, None, EVERY)
            dots = run.times[kept], run.observables["driving_force"][kept]
            traces.append(marks(*dots, OF_METHODS[method], shown))
    return over_time(
        "F(t) of the check manoeuvre",
        f"The force of the actuator on the slider, exact and at a step of {number(STEP)} s.",
        traces,
        linear("F [N]"),
        height=300,
    )
