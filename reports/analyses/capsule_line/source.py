"""The source's figure and formulas: Fig. 2, two misprints, and eq. 22 on every line through C."""

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
from plumbob.reports.analyses.measurements import LINE, displacement_error, problem, runs

STEP = 1e-3  # [s]
MUJOCO = "mujoco/euler+coulomb"
ENGINES = (MUJOCO, "pymunk/side")  # of Fig. 2
DRAWN = ("stroke_rate", "velocity", "displacement")  # in Fig. 2
STRAIGHT = 1e-3  # [rad]: a body that turns by less goes along a line
EVERY = 5  # samples to a mark
LINES = tuple(
    f"capsule-line/{name}" for name in ("ca1", "ca2", "ca3", "at-50", "at-123", "at-222")
)
ON_LINES = (MUJOCO, "pymunk/feet")
LINE_RUNS = runs(LINES, ON_LINES, (STEP,))


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The check manoeuvre for Fig. 2, the misprints and the actuator's force."""
    return runs((LINE,), ENGINES, (STEP,))


def samples(study: Study, every: int, names: Sequence[str]) -> Mapping[str, Signals]:
    """Observables of the check manoeuvre in each engine that ran, at one sample in `every`: not at
    the same ones, so that no mark hides another."""
    by_engine = {}
    for place, method in enumerate(ENGINES):
        if run := study.answer(ExtraRun(LINE, method, STEP)):
            kept = slice(place * every // 2, None, every)
            shown = {name: run.observables[name][kept] for name in names}
            by_engine[method] = {"times": run.times[kept], **shown}
    return by_engine


def figure_2(study: Study) -> Record:
    """v(t), v_c(t) and x(t) of the check manoeuvre, exact and as two engines have them."""
    line = problem(LINE).motion
    # The switches among the times, so that a corner is drawn as one.
    switches = (line.t1, line.t_star, line.t2)
    times = np.unique(np.append(np.linspace(0.0, 1.05 * line.t2, 200), switches))
    observed = problem(LINE).reference.observe(times)
    exact = {"times": times, **{name: observed[name] for name in DRAWN}}
    engines = samples(study, EVERY, DRAWN)
    return Record(
        switches=switches,  # t1, t*, t2 [s]
        displacement=line.displacement,  # [m]
        exact=exact,
        engines=engines,
        step=STEP,
    )


def misprints(study: Study) -> Record:
    """Eq. 19 as printed beside as derived, and the velocity at t* in an engine."""
    line = problem(LINE).motion
    stop = np.array([line.t_star])
    times = np.linspace(0.0, 1.05 * line.t2, 200)
    at_stop = None
    if run := study.answer(ExtraRun(LINE, MUJOCO, STEP)):
        at_stop = float(np.interp(line.t_star, run.times, run.observables["velocity"]))
    return Record(
        printed=printed_body_velocity(line, stop)[0],  # [m/s] at t*, as the two below
        derived=line.at(stop).velocity[0],
        measured=at_stop,
        travel=line.at(np.array([line.t2])).stroke[0],  # [m], of the slider until t2
        times=times,
        derived_rates=line.at(times).velocity,
        printed_rates=printed_body_velocity(line, times[times <= line.t_star]),  # until t*
        velocities=samples(study, EVERY, ("velocity",)).get(MUJOCO),  # in MuJoCo
        step=STEP,
    )


def any_line(study: Study) -> Record:
    """Eq. 22 along the source's three lines and three others, in two engines."""
    lines = tuple(_line(study, scene) for scene in LINES)
    turns = [turn or 0.0 for line in lines for turn in line.turns]
    return Record(
        lines=lines,
        largest_turn=max(turns),  # [rad]
        methods=ON_LINES,
        step=STEP,
    )


def _line(study: Study, scene: str) -> Record:
    """A line through C: its angle to C-A1 and displacement, and how engines go along it."""
    motion = problem(scene).motion
    turns = list[float | None]()
    for method in ON_LINES:
        run = study.answer(ExtraRun(scene, method, STEP))
        turns.append(None if run is None else float(np.abs(run.observables["heading"]).max()))
    return Record(
        scene=scene,
        angle=math.degrees(motion.direction) % 360.0,  # [degrees]
        displacement=motion.displacement,  # [m]
        # of the displacement, relative, for each of ON_LINES
        errors=[displacement_error(study, scene, method, STEP) for method in ON_LINES],
        turns=turns,  # [rad], the largest
    )


def _straight(numbers: Record) -> Claims:
    turn = numbers.largest_turn
    return (at_most("the largest turn of the body in an engine", turn, STRAIGHT, "rad"),)


FIGURE_2 = Analysis("capsule_line/figure_2", figure_2, requests)
MISPRINTS = Analysis("capsule_line/misprints", misprints, requests)
ANY_LINE = Analysis("capsule_line/any_line", any_line, lambda plan: LINE_RUNS, _straight)
