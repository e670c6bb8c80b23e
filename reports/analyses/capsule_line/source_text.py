"""Further statements of the source on straight motions, each computed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.planner.construction import plan as find_plan
from plumbob.analytic.systems.planner.problem import Limits, RestPose
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.measurements import LINE, measured, problem
from plumbob.reports.view.content import Finding, Statement
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.sources import CHERNOUSKO, stated

DEFAULT, CONVERGENT, STEP = "mujoco/euler", "mujoco/euler+coulomb", 1e-3  # [s]
THRESHOLD = "capsule-line/w1-threshold"
SHORTER = 1000.0  # times, of t1
SPARE, AWAY = 1.002, 1e-3  # of |w| over f g/mu, and how far a plan goes with it [m]


def slope(line: LineManoeuvre) -> tuple[float, float]:
    """Exponents p of t1^p in the displacements of slider and body, between t1 and t1/SHORTER."""
    less = replace(line, t1=line.t1 / SHORTER)
    pairs = ((line.stroke, less.stroke), (line.displacement, less.displacement))
    first, second = (math.log(a / b) / math.log(SHORTER) for a, b in pairs)
    return first, second


def balance(line: LineManoeuvre) -> float:
    """Largest residual of eqs. 8 and 9 with F eliminated, over the weight: at times within each
    interval, with accelerations from differences of the velocities."""
    switches = np.array([0.0, line.t1, line.t_star, line.t2])
    times = (switches[:-1] + np.diff(switches) * np.array([[0.3], [0.7]])).ravel()
    h = 1e-3 * float(np.diff(switches).min())
    rates = [(f(times + h) - f(times - h)) / (2 * h)
             for f in (line.body_velocity, line.relative_velocity)]  # fmt: skip
    body = line.capsule
    forces = line.friction_force(times)
    momentum = (body.body_mass + body.slider_mass) * rates[0] + body.slider_mass * rates[1]
    return float(np.abs(momentum - forces).max() / body.weight)


def finding(study: Study) -> Finding:
    """The statements as a table; all of them are rows of the table of the sources too."""
    line, barely = problem(LINE).motion, problem(THRESHOLD).motion
    body = line.capsule
    loads = line.normal_forces(np.linspace(0.0, line.t2, 50)).sum(axis=1)
    off = float(np.abs(loads / body.weight - 1.0).max())
    stroke, moved = slope(line)
    sums, limit = balance(line), body.holding_acceleration
    enough = find_plan(body, RestPose(AWAY, 0.0, 0.0), Limits(acceleration=SPARE * limit))
    statements = (
        Statement(CHERNOUSKO, "(1)", "Friction at each support is Coulomb's", "fN_i against v_i",
                  _friction(study), "extended"),
        Statement(CHERNOUSKO, "(7)", "The normal forces add up to the weight", "(M + m)g",
                  f"{number(body.weight, 6)} N, within {number(off, 1)}, relative, along the check "
                  "manoeuvre", "holds"),
        Statement(CHERNOUSKO, "(8)–(12)", "On a line dv_c/dt = –μw – fg q(v_c)", "(11)",
                  f"(8) and (9) without F balance within {number(sums, 1)} of the weight",
                  "holds"),
        Statement(CHERNOUSKO, "(15)", "The body moves only if w₁ > fg/μ", "fg/μ",
                  f"{number(limit, 6)} m/s²; a fraction of {number(barely.w1 / limit - 1.0, 1)} "
                  f"above it Δx is {number(1e9 * barely.displacement)} nm", "holds"),
        Statement(CHERNOUSKO, "(17), (20), Fig. 2", "t₁ < t* < t₂", "(17), (20)",
                  f"{number(line.t1)}, {number(line.t_star, 6)}, {number(line.t2, 6)} s",
                  "holds" if line.t1 < line.t_star < line.t2 else "refuted"),
        Statement(CHERNOUSKO, "after (22)",
                  "Both displacements go with t₁², with opposite signs, as small as wanted",
                  "∝ t₁²", f"exponents {number(stroke, 6)} and {number(moved, 6)} down to "
                  f"t₁/{SHORTER:g}, where Δx is "
                  f"{number(1e9 * line.displacement / SHORTER**moved)} nm",
                  "holds" if line.stroke * line.displacement < 0.0 else "refuted"),
        Statement(CHERNOUSKO, "conclusion", "Q needs a sufficiently large acceleration",
                  "sufficiently large",
                  f"for lines, any above fg/μ = {number(limit, 6)} m/s²: "
                  f"with {number(SPARE, 4)} of it a plan goes {number(1e3 * AWAY)} mm in "
                  f"{enough.lines} lines and {number(enough.duration)} s", "extended"),
    )  # fmt: skip
    return Finding(
        "capsule-line-source",
        "What else the source says of straight motions, statement by statement",
        "confirmed",
        f"The body stops at t* = {number(line.t_star, 6)} s, before the slider; "
        f"{_friction(study)}.",
        (),
        (stated(statements),),
        (),
        (f"plumbob solve {LINE}", f"plumbob solve {THRESHOLD}",
         f"plumbob plan --to {AWAY:g} 0 0 --set acceleration={SPARE * limit:.6g}"),
        statements,
    )  # fmt: skip


def _friction(study: Study) -> str:
    """Eq. 1 in MuJoCo, with default contacts and with convergent ones."""
    errors = []
    displacement = float(problem(LINE).motion.displacement)
    for name, contacts in ((DEFAULT, "default contacts"), (CONVERGENT, "the profile +coulomb")):
        if (run := measured(study, LINE, name, STEP)) is not None:
            error = abs(run.errors["displacement"].end / displacement)
            errors.append(f"{number(100 * error, 2)} % with {contacts}")
    if not errors:
        return "exact friction is fN_i against the velocity while a support slides"
    return f"in MuJoCo, steps of {short(STEP)} s, the error of Δx is {', '.join(errors)}"
