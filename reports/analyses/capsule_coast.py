"""The page's section on the capsule coasting to rest: what a step does to a stop and to a spin."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.claims import ALIKE, at_most, between
from plumbob.reports.analyses.measurements import (
    METHOD_NAMES,
    case,
    covers,
    measured,
    problem,
    runs,
    scheme,
)
from plumbob.reports.view.content import (
    Cell,
    Finding,
    Statement,
    Table,
    method_cell,
    plain_method_cell,
    row,
    value,
)
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.palette import OF_METHODS
from plumbob.reports.view.sources import CHERNOUSKO
from plumbob.reports.view.traces import Trace, curve, figure, logarithmic, positive

SCENE = "capsule-coast/translation"
METHODS = ("mujoco/euler", "mujoco/euler+coulomb", "mujoco/euler+reduced", "pymunk/feet",
           "pymunk/side")  # fmt: skip
STEPS = (1e-3, 1e-4)
SPIN = "capsule-coast/spin"
DEFAULT = "mujoco/euler"
SPINNING = ("mujoco/euler+coulomb", "mujoco/rk4+coulomb", "pymunk/feet", DEFAULT)
DECADE = (1e-3, 5e-4, 2e-4, 1e-4)


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Runs to rest, and runs of the default contacts on the spin where the study measures it."""
    stopping = runs((SCENE,), METHODS, STEPS)
    spinning = runs((SPIN,), (DEFAULT,), DECADE) if covers(plan, SPIN) else ()
    return (*stopping, *spinning)


def stopping(study: Study) -> Finding | None:
    """Error of the stopping distance over v0 dt/2, in both engines; None where neither ran."""
    posed = problem(SCENE)
    speed = math.hypot(*posed.setup.velocity)
    distance = float(posed.motion.coasting.distance)
    rows, beyond = [], dict[str, float]()
    for name in METHODS:
        cells: list[Cell] = []
        for step in STEPS:
            run = study.recording(ExtraRun(SCENE, name, step))
            if run is None:
                continue
            travelled = np.hypot(run.observables["x"][-1], run.observables["y"][-1])
            half = 0.5 * speed * step
            predicted = _predicted_end(name, step, run.times)
            cells += [value((travelled - distance) / half, 4), value(predicted / half, 4)]
            beyond[name] = float(travelled - distance - predicted) / half
        if len(cells) == 2 * len(STEPS):
            rows.append(row(method_cell(name), *cells))
    if not rows:
        return None
    heads = ("method", *(
        f"{what}, step {short(step)} s" for step in STEPS for what in ("measured", "predicted")
    ))  # fmt: skip
    return Finding(
        "capsule-stopping-distance",
        "MuJoCo stops too early and pymunk too late, by the same half step",
        "confirmed",
        "A sliding body stops half a step too early in MuJoCo's Euler and half a step too "
        "late in pymunk; a smaller step helps in proportion. "
        f"A body at {number(speed)} m/s stops after v₀²/(2fg) = {number(distance)} m wherever "
        "its slider is (v₀: initial speed, f: coefficient of friction). MuJoCo updates "
        "velocities before positions and stops v₀dt/2 too early; pymunk updates positions "
        "first and stops v₀dt/2 too late.",
        (
            "The coefficient is exact except for the last step, in which the body stops: that "
            "adds a sawtooth of second order in the step. Default contacts add an error of "
            "their own, from contact chatter.",
        ),
        (Table("Error of the stopping distance over v₀dt/2", heads, tuple(rows),
               METHOD_NAMES),),
        (),
        (f"plumbob run {SCENE} mujoco/euler+coulomb --step 1e-4",
         f"plumbob run {SCENE} pymunk/feet --step 1e-4"),
        (_in_finite_time(speed, distance, len(rows)),),
        claims=(
            *(at_most(f"what theory leaves of the error of {name}, over v₀dt/2,", left, ALIKE)
          for name, left in beyond.items() if name != DEFAULT),
        ),
    )  # fmt: skip


def _in_finite_time(speed: float, distance: float, count: int) -> Statement:
    """The source's statement on residual motions."""
    fg = speed**2 / (2.0 * distance)
    spinning = problem(SPIN).motion.rest_time
    return Statement(
        CHERNOUSKO,
        "residual motions",
        "With Q fixed, friction stops the body in finite time",
        "finite",
        f"after v₀/(fg) = {number(speed / fg, 5)} s and v₀²/(2fg) = {number(distance, 5)} m from "
        f"{number(speed)} m/s, and so do all {count} methods of the table; spinning at "
        f"once, after {number(spinning, 5)} s, without a formula",
        "extended",
    )


def _predicted_end(method: str, step: float, times: np.ndarray) -> float:
    """The predicted error of the stopping distance [m]: positive where it is too long."""
    predicted = case(SCENE).errors.at_step(scheme(method), step, times).errors
    x, y = predicted["x"][-1], predicted["y"][-1]
    return math.copysign(math.hypot(x, y), x)


def spin(study: Study) -> Finding | None:
    """Error of the heading at rest over the step, over a decade of steps, where the study has it;
    and what default contacts do."""
    if not covers(study, SPIN):
        return None
    rows, traces, slopes, falls = [], list[Trace](), dict[str, float](), dict[str, float]()
    for name in SPINNING:
        runs = [measured(study, SPIN, name, step) for step in DECADE]
        errors = [m.errors["heading"] for m in runs if m is not None]
        if len(errors) < len(DECADE):
            continue
        ends = [e.end for e in errors]
        colour = OF_METHODS[name]
        traces.append(
            curve(DECADE, positive(ends), colour=colour, marks=True, width=1.0, name=name)
        )
        last = errors[-1].predicted
        if name == DEFAULT or last is None:
            continue
        slope = slopes[name] = last.end / DECADE[-1]
        falls[name] = ends[0] / ends[-1] if ends[-1] else 0.0
        ratios = [value(e / h, 4) for e, h in zip(ends, DECADE, strict=True)]
        rows.append(row(plain_method_cell(name), *ratios, value(slope, 4)))
        traces.append(
            curve(DECADE, positive([slope * h for h in DECADE]), colour=colour, dash="dash",
                  width=1.0, name=f"{number(abs(slope))} rad/s × step")
        )  # fmt: skip
    if not rows:
        return None
    heads = ("method", *(f"step {short(h)} s" for h in DECADE), "predicted at the smallest step")
    default = _default(study)
    return Finding(
        "capsule-spin",
        "Spin and translation at once: first order in the step, with a predicted coefficient",
        "confirmed",
        "Where a robot spins and slides at once, contacts that converge are of first "
        "order: half the step, half the error. "
        + _spin_summary(slopes, default),
        (
            "Friction couples the two, and one support comes to rest before the others. The "
            "coefficient is predicted by taking the same steps with three degrees of freedom, "
            "with friction solved to round-off.",
            "Default contacts lose the ground: a sliding body bounces on them, as it does on "
            "a line, and what each landing takes from spin and translation is not the work of "
            "Coulomb friction.",
        ),
        (Table("Error of the heading at rest over the step [rad/s]", heads, tuple(rows)),
         *(() if default is None else (default,))),
        (figure("Error of the heading at rest against the step",
                "Dashed: the coefficient times the step.", traces,
                logarithmic("step [s]"), logarithmic("|error of ψ| [rad]"), legend=True),),
        (f"plumbob validate --scenes {SPIN} --methods {','.join(SPINNING)}",
         f"plumbob run {SPIN} pymunk/feet --step 1e-4"),
        claims=tuple(
            between(f"the error of {name}, at ten times the step over at the step,", fall,
                    0.5 * DECADE[0] / DECADE[-1], 2.0 * DECADE[0] / DECADE[-1])
            for name, fall in falls.items()
        ),
    )  # fmt: skip


def _spin_summary(slopes: dict[str, float], default: Table | None) -> str:
    slopes_text = ", ".join(f"{name} {number(slope, 4)}" for name, slope in slopes.items())
    summary = (
        "A body that spins and slides at once has no closed formula; the error of its heading ψ at "
        f"rest is a coefficient times the step, in rad/s: {slopes_text}."
    )
    if default is not None:
        sizes, missing = ([abs(float(line[i].text)) for line in default.rows] for i in (1, 3))
        summary += (
            f" With default contacts the error is {number(min(sizes), 2)} to "
            f"{number(max(sizes), 2)} rad at these steps, and a contact is missing at "
            f"{number(100 * min(missing), 2)} % of the samples or more."
        )
    return summary


def _default(study: Study) -> Table | None:
    """Errors of heading and rate on default contacts, and how often one is missing."""
    rows = []
    rest_time = problem(SPIN).motion.rest_time
    for step in DECADE:
        run = measured(study, SPIN, DEFAULT, step)
        recording = study.recording(ExtraRun(SPIN, DEFAULT, step))
        if run is None or recording is None:
            return None
        sliding = recording.times < rest_time
        missing = float(np.mean(recording.channels["contacts"][sliding] < 3))
        heading, rate = run.errors["heading"], run.errors["heading_rate"]
        rows.append(row(Cell(short(step), "number"), value(heading.end), value(rate.largest),
                        value(missing, 2)))  # fmt: skip
    heads = ("step [s]", "error of the heading at rest [rad]", "largest error of its rate [rad/s]",
             "fraction of samples with a contact missing while it moves")  # fmt: skip
    return Table(f"Default contacts, {DEFAULT}", heads, tuple(rows))


SECTION = Section((stopping, spin), more=requests)
