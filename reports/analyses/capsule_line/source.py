"""The source's Fig. 2, two misprints in its formulas, and eq. 22 on lines through C."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from plumbob.analytic.reference import Signals
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import printed_body_velocity
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, at_most
from plumbob.reports.analyses.measurements import LINE, displacement_error, extra_runs, problem

STEP = 1e-3  # [s]
MUJOCO = "mujoco/euler+coulomb"
ENGINES = (MUJOCO, "pymunk/side")  # methods in Fig. 2
DRAWN = ("stroke_rate", "velocity", "displacement")  # observables in Fig. 2
STRAIGHT = 1e-3  # [rad] largest turn of a body that moves along a line
EVERY = 5  # samples per mark in a figure
LINES = tuple(
    f"capsule-line/{name}" for name in ("ca1", "ca2", "ca3", "at-50", "at-123", "at-222")
)
ON_LINES = (MUJOCO, "pymunk/feet")
LINE_RUNS = extra_runs(LINES, ON_LINES, (STEP,))


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Returns the runs of the check manoeuvre for Fig. 2, the misprints and the actuator's
    force."""
    return extra_runs((LINE,), ENGINES, (STEP,))


def samples(study: Study, every: int, names: Sequence[str]) -> Mapping[str, Signals]:
    """Returns observables of the check manoeuvre in each engine that ran, at one sample in `every`.
    The engines have different samples, so that no mark in a figure hides another."""
    by_engine = {}
    for number, method in enumerate(ENGINES):
        run = study.answer(ExtraRun(LINE, method, STEP))
        if run:
            shown = slice(number * every // 2, None, every)
            observables = {name: run.observables[name][shown] for name in names}
            by_engine[method] = {"times": run.times[shown], **observables}
    return by_engine


def figure_2(study: Study) -> Record:
    """Returns v(t), v_c(t) and x(t) of the check manoeuvre, exact and in two engines."""
    line = problem(LINE).motion
    # The times include the switches, so that a corner is drawn as a corner.
    switches = (line.t1, line.t_star, line.t2)
    times = np.unique(np.append(np.linspace(0.0, 1.05 * line.t2, 200), switches))
    observed = problem(LINE).reference.observe(times)
    exact = {"times": times, **{name: observed[name] for name in DRAWN}}
    engines = samples(study, EVERY, DRAWN)
    return Record(
        switches=switches,  # [s] t1, t*, t2
        displacement=line.displacement,  # [m]
        exact=exact,
        engines=engines,
        step=STEP,
    )


def misprints(study: Study) -> Record:
    """Returns the velocities by eq. 19 as printed and as derived, and the velocity at t* in an
    engine."""
    line = problem(LINE).motion
    stop = np.array([line.t_star])
    times = np.linspace(0.0, 1.05 * line.t2, 200)
    at_stop = None
    run = study.answer(ExtraRun(LINE, MUJOCO, STEP))
    if run:
        at_stop = float(np.interp(line.t_star, run.times, run.observables["velocity"]))
    return Record(
        printed=printed_body_velocity(line, stop)[0],  # [m/s] at t*
        derived=line.at(stop).velocity[0],  # [m/s] at t*
        measured=at_stop,  # [m/s] at t*
        travel=line.at(np.array([line.t2])).stroke[0],  # [m] stroke of the slider until t2
        times=times,  # [s]
        derived_rates=line.at(times).velocity,  # [m/s]
        printed_rates=printed_body_velocity(
            line, times[times <= line.t_star]
        ),  # [m/s] until t*
        velocities=samples(study, EVERY, ("velocity",)).get(MUJOCO),  # [m/s] in MuJoCo
        step=STEP,
    )


def any_line(study: Study) -> Record:
    """Returns the displacement by eq. 22 and the errors of two engines, along the source's three
    lines and three others."""
    lines = tuple(_line_numbers(study, scene) for scene in LINES)
    turns = [turn or 0.0 for line in lines for turn in line.turns]
    return Record(
        lines=lines,
        largest_turn=max(turns),  # [rad]
        methods=ON_LINES,
        step=STEP,
    )


def _line_numbers(study: Study, scene: str) -> Record:
    """Returns the numbers of a line through C: its angle to C-A1, its displacement, and the errors
    and turns of the engines."""
    motion = problem(scene).motion
    turns = list[float | None]()
    for method in ON_LINES:
        run = study.answer(ExtraRun(scene, method, STEP))
        turns.append(None if run is None else float(np.abs(run.observables["heading"]).max()))
    return Record(
        scene=scene,
        angle=math.degrees(motion.direction) % 360.0,  # [degrees]
        displacement=motion.displacement,  # [m]
        # relative error of the displacement for each of ON_LINES
        errors=[displacement_error(study, scene, method, STEP) for method in ON_LINES],
        turns=turns,  # [rad] largest turn for each of ON_LINES
    )


def _straight(numbers: Record) -> Claims:
    """Returns the check that the body does not turn in any engine."""
    turn = numbers.largest_turn
    return (at_most("the largest turn of the body in an engine", turn, STRAIGHT, "rad"),)


FIGURE_2 = Analysis("capsule_line/figure_2", figure_2, requests)
MISPRINTS = Analysis("capsule_line/misprints", misprints, requests)
ANY_LINE = Analysis("capsule_line/any_line", any_line, lambda plan: LINE_RUNS, _straight)
