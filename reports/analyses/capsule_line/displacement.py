"""Findings on the final displacement: each method's error, its explanation, and the sawtooth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.analytic.errors.sliding_motion.discontinuities import trapezoid_error
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses import measurements
from plumbob.reports.analyses.claims import ALIKE, at_most, clear
from plumbob.reports.analyses.contact_terms import (
    contact_of,
    deflection_term,
    step_term,
    stiction_drift,
)
from plumbob.reports.analyses.measurements import (
    LINE,
    METHOD_NAMES,
    covers,
    measured,
    names,
    problem,
    runs,
)
from plumbob.reports.view.content import (
    Cell,
    Figure,
    Finding,
    Statement,
    Table,
    method_cell,
    plain_method_cell,
    row,
    value,
)
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.palette import GREY, OF_METHODS
from plumbob.reports.view.sources import CHERNOUSKO
from plumbob.reports.view.traces import (
    Trace,
    curve,
    figure,
    linear,
    logarithmic,
    marks,
    positive,
)

STEPS = (1e-3, 1e-4, 1e-5)
TURNED = "capsule-line/heading-030"
FULL, REDUCED = "mujoco/euler+coulomb", "mujoco/euler+reduced"
COMPARED = ("mujoco/euler", FULL, "mujoco/rk4+coulomb", "pymunk/feet")
METHODS = (REDUCED, FULL, "pymunk/side", "pymunk/feet")  # of the sawtooth
COUNT = 4  # steps drawn at random, fifteen times as many in the full profile
COARSE, FINE = 2.5e-3, 6e-4  # [s], what they are drawn between
SEED = 20200101
PART = 0.2  # of the parabola's top: below it, other terms are as large


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The check manoeuvre at steps drawn at random."""
    return runs((LINE,), METHODS, random_steps(plan.profile))


def random_steps(profile: str) -> tuple[float, ...]:
    """Steps [s] drawn at random, evenly in their logarithm; the same in every study."""
    count = COUNT * (15 if profile == "full" else 1)
    draw = np.random.default_rng(SEED).uniform(np.log(FINE), np.log(COARSE), count)
    return tuple(float(step) for step in np.exp(draw))


def errors(study: Study) -> Finding | None:
    """Relative errors by method and step, with the terms beside the step's; None where the study
    does not have the scene."""
    if not covers(study, LINE):
        return None
    exact = problem(LINE).motion.displacement
    rows = [
        row("theory: ½φ(1–φ)(μw₂+fg)dt² / |Δx|", *(value(step_term(LINE, h) / exact)
            for h in STEPS), value(step_term(LINE, 1e-4) / exact))
    ]  # fmt: skip
    at_middle = {}
    for name in names(study):
        here = [_relative(study, LINE, name, step) for step in STEPS]
        if any(error is not None for error in here):
            turned = _relative(study, TURNED, name, 1e-4)
            rows.append(row(method_cell(name), *map(value, here), value(turned)))
            at_middle[name] = here[1]
    good = [abs(e) for n, e in at_middle.items() if e is not None and _converges(n)]
    bad = [abs(e) for n, e in at_middle.items() if e is not None and not _converges(n)]
    summary = (
        "With friction that converges the integrator's own error is left, a sawtooth in the step"
    )
    if good and bad:
        summary += (
            f": at 1e-4 s at most {number(100 * max(good), 2)} % of Δx. Without, the error is "
            f"{number(100 * min(bad), 2)} % to {number(100 * max(bad), 2)} %, whatever the step"
        )
    heads = ("method", *(f"{short(h)} s" for h in STEPS), "heading 30°, 1e-4 s")
    table = Table("Relative error of the final displacement: positive where it is too large",
                  heads, tuple(rows), METHOD_NAMES)  # fmt: skip
    return Finding(
        "capsule-displacement",
        "With contacts that converge the error of a slide falls with the step",
        "measured",
        "With contacts that converge the step decides how exact a slide is; with default "
        "contacts nothing does. "
        f"{summary}.",
        (
            "φ is the fraction of a step at which the body stops, t*/dt less its whole steps. "
            "While the body slides, the velocity of a semi-implicit Euler scheme is exact at grid "
            "times and positions are its trapezoid sums: the only error is from the velocity's "
            "corner at t*, inside a step. RK4 takes the last step of friction as a geometric "
            "series and goes ½(μw₂+fg)dt² too far.",
            "What the full model adds to that is explained: its contacts are springs, and the "
            "common centre of mass moves down on them as the loads become uneven, during which "
            "friction is smaller; and its stiction is regularised and drifts. The reduced model "
            "has the drift alone.",
        ),
        (table, *_beyond_the_step(study)),
        _against_step(study, exact),
        (
            f"plumbob validate --profile full --scenes {LINE},{TURNED} --methods mujoco,pymunk",
            f"plumbob run {LINE} {FULL} --step 1e-4",
        ),
        (
            Statement(
                CHERNOUSKO,
                "(22), Fig. 2",
                "Δx of a line manoeuvre",
                "–½ μ(w₁+w₂)(μw₁–fg)t₁²/(μw₂+fg)",
                f"{number(exact, 8)} m for the check manoeuvre"
                + (f"; engines within {number(max(good), 2)}, relative, at 1e-4 s" if good else ""),
                "holds",
            ),
        ),
        claims=(
            (
                clear(
                    "errors of contacts that do not converge, and of those that do",
                    min(bad),
                    max(good),
                ),
            )
            if good and bad
            else ()
        ),
    )


def _against_step(study: Study, exact: float) -> tuple[Figure, ...]:
    """The relative error of the final displacement of some methods against the step."""
    ran = {c.method: c for c in study.convergence if c.scene == LINE and c.method in COMPARED}
    traces = [
        curve(
            [m.step for m in done],
            positive([m.errors["displacement"].end / exact for m in done]),
            colour=OF_METHODS[name],
            marks=True,
            name=name,
        )
        for name, c in ran.items()
        if (done := [m for m in c.measurements if m.status == "done"])
    ]
    if not traces:
        return ()
    return (
        figure("Relative error of Δx against step", f"{LINE}, at the end.", traces,
               logarithmic("step [s]"), logarithmic("|error of Δx| / |Δx|"), legend=True),
    )  # fmt: skip


def _converges(name: str) -> bool:
    """Whether theory covers a method's friction."""
    return name.endswith(("coulomb", "coulomb+noslip", "reduced", "feet", "side"))


def _relative(study: Study, scene: str, method: str, step: float) -> float | None:
    run = measured(study, scene, method, step)
    if run is None:
        return None
    return run.errors["displacement"].end / float(problem(scene).motion.displacement)


def _beyond_the_step(study: Study) -> tuple[Table, ...]:
    """The errors of the two models beyond the step's, and what explains them [m]."""
    rows = []
    for name in (FULL, REDUCED):
        for step in STEPS:
            if (run := measured(study, LINE, name, step)) is None:
                continue
            beyond = run.errors["displacement"].end - step_term(LINE, step)
            contact = contact_of(LINE, name, step)
            deflection, drift = deflection_term(LINE, contact), stiction_drift(LINE, contact)
            cells = (beyond, deflection, drift, beyond - deflection - drift)
            rows.append(row(method_cell(name), Cell(short(step), "number"), *map(value, cells)))
    if not rows:
        return ()
    heads = ("method", "step [s]", "beyond the step's error [m]",
             "contact deflection: –f (z₀ – z) [m]", "drift of regularised stiction [m]",
             "unexplained [m]")  # fmt: skip
    note = (
        "Deflection: z = –c ΣNᵢ²/W, with c the compliance of a contact and W the weight. Drift of "
        "the reduced model: (1–d)/d μw₂ dt (t₂–t*) with d its impedance; of the full one the same "
        "with the regularisation of its friction, over three contacts. Unexplained: the contacts' "
        "delay, and the slider's deviation by m/A of its travel in space, with A its armature: "
        "3e-13 m."
    )
    return (Table("Error of the models beyond the step's", heads, tuple(rows), note),)


def sawtooth(study: Study) -> Finding | None:
    """The errors at steps drawn at random against the parabola, and how near they are."""
    line = problem(LINE).motion
    unit = line.closed.braking
    phi = np.linspace(0.0, 1.0, 101)
    # The deflection term is the same multiple of dt^2 at every step.
    fine = line.t1 / 100
    raised = -deflection_term(LINE, contact_of(LINE, FULL, fine)) / (unit * fine**2)
    parabola = 0.5 * phi * (1 - phi)
    traces: list[Trace] = [
        curve(phi, parabola, colour=GREY, width=2.0, name="½φ(1–φ)"),
        curve(phi, parabola + raised, colour=GREY, dash="dash", name="with contact deflection"),
    ]
    rows, left = [], dict[str, float]()
    for name in METHODS:
        points = _on_parabola(study, name)
        if not points:
            continue
        places, measured_errors, deflections = (np.array(c) for c in zip(*points, strict=True))
        traces.append(marks(places, measured_errors, OF_METHODS[name], name))
        theory = 0.5 * places * (1 - places)
        used = theory > PART / 8
        left[name] = float(np.abs((measured_errors - deflections) / theory - 1)[used].max())
        rows.append(
            row(plain_method_cell(name), value(float(len(points))),
                value(float(np.abs(measured_errors / theory - 1)[used].max())),
                value(left[name]))
        )  # fmt: skip
    if not rows:
        return None
    heads = ("method", "steps", "largest relative distance from ½φ(1–φ)",
             "with contact deflection added")  # fmt: skip
    return Finding(
        "capsule-sawtooth",
        "The error is ½φ(1–φ)(μw₂+fg)dt², in both engines, at any step",
        "confirmed",
        "Do not fit an order to a stopping distance: its error is a sawtooth in the step. "
        "φ is the fraction of t*/dt: where in its step the body stops. The error is a sawtooth in "
        "the step, so a fitted slope says nothing and a convergence study with round step sizes "
        "may make it look better than it is; the coefficient is the test.",
        (
            f"Steps drawn at random from {short(FINE)} to {short(COARSE)} s (seed {SEED}). Off the "
            "grid the switch at t₁ gives the velocity a corner inside a step too, by μ(w₁+w₂): the "
            "same parabola in the fraction of t₁/dt, with the opposite sign, which is subtracted "
            "here.",
            f"The full MuJoCo model's points are {number(8 * raised, 2)} of the parabola's top "
            "higher, from the deflection of its contacts, which is proportional to dt² too.",
        ),
        (Table("Relative distance from the parabola, where that is above a fifth of its top",
               heads, tuple(rows)),),
        (figure("Error of Δx over (μw₂+fg)dt²", "Against φ, at steps drawn at random.", traces,
                linear("φ = frac(t* / dt)"), linear("–error / ((μw₂+fg) dt²)"), legend=True,
                wide=True),),
        tuple(f"plumbob run {LINE} {name} --step 0.00061" for name in (FULL, "pymunk/feet")),
        claims=(
            *(at_most(f"the distance of {name} from the parabola, relative,", distance, ALIKE)
              for name, distance in left.items()),
        ),
    )  # fmt: skip


def _on_parabola(study: Study, method: str) -> list[tuple[float, float, float]]:
    """phi, the error over -(mu w2 + f g) dt^2 without that of the corner at t1, and its part from
    contact deflection."""
    line, points = problem(LINE).motion, []
    jump = line.closed.backward + line.closed.braking
    for step in random_steps(study.profile):
        if (end := measurements.displacement(study, LINE, method, step)) is None:
            continue
        unit = -line.closed.braking * step**2
        at_t1 = float(trapezoid_error(jump, np.array(line.t1 / step))) * step**2
        deflection = 0.0
        if method == FULL:
            deflection = deflection_term(LINE, contact_of(LINE, FULL, step))
        phi = line.t_star / step % 1.0
        points.append((phi, (end - line.displacement - at_t1) / unit, deflection / unit))
    return points
