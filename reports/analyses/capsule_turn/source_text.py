"""Further statements of the source on turns, each computed on the exact motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.analytic.systems.three_points.balance import balance, exchange
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.engines.study.results import Study
from plumbob.models.tripod_capsule.turn import EPSILONS
from plumbob.reports.analyses.capsule_turn.course import course
from plumbob.reports.analyses.capsule_turn.turns import facts, name_of, turn
from plumbob.reports.analyses.measurements import problem
from plumbob.reports.view.content import Finding, Statement
from plumbob.reports.view.notation import number
from plumbob.reports.view.sources import CHERNOUSKO, stated

SHOWN = 0.3  # epsilon: friction is seen there
SMALL, SHORTER = 0.03, 10.0  # epsilon of a turn, and how many times shorter it is made
THOUSAND = "capsule-turn/thousand"
NODES = 32  # Gauss points of a smooth segment


def friction_turning(manoeuvre: TurnManoeuvre, motion: ThreePointMotion) -> tuple[float, float]:
    """Largest |R| of eq. 24 over R_0 while the slider moves, and the integral of R over that time
    [rad/s]: by eq. 24 the body's rate at 2 tau, since that of the slider is zero again."""
    x, weights = np.polynomial.legendre.leggauss(NODES)
    largest, total, stop = 0.0, 0.0, 2.0 * manoeuvre.half_time * (1.0 - 1e-12)
    for begin, segment in zip(motion.begins, motion.segments, strict=True):
        if begin >= stop or not np.isfinite(segment.end):
            continue
        load, pace = exchange(motion, segment, 0.5 * (x + 1.0))
        rate: Array = load.torque / load.at.inertia
        largest = max(largest, float(np.abs(rate).max()))
        total += float(np.sum(0.5 * weights * pace * rate))
    return largest / manoeuvre.friction_bound, total


def shortened() -> tuple[float, float]:
    """Body angle [rad] at 2 tau of the turn of SMALL, and with the same Z in a SHORTERth of the
    time."""
    manoeuvre = turn(SMALL)
    less = replace(manoeuvre, half_time=manoeuvre.half_time / SHORTER)
    end = three_point_motion(less.capsule, less.path).at(np.array([2.0 * less.half_time]))
    return facts(SMALL)["body_angle"], float(end.heading[0])


def finding(study: Study) -> Finding:
    """The statements as a table; all of them are rows of the table of the sources too."""
    manoeuvre, motion = turn(SHOWN), problem(name_of(SHOWN)).motion.single
    sums = balance(motion)
    worst = max(sums.energy, sums.momentum, sums.angular_momentum)
    fraction, integral = friction_turning(manoeuvre, motion)
    about = facts(SHOWN)
    left = about["angular_velocity_at_stop"]
    ends = [facts(epsilon)["body_angle"] for epsilon in (EPSILONS[0], EPSILONS[-1])]
    usual, part = shortened()
    phases = np.array([2.0, about["rest_time"] / manoeuvre.half_time])
    (moved, later) = course(SHOWN, phases)[1]
    after, decay = float(np.hypot(*(later - moved))), about["rest_time"] - about["stop_time"]
    many = problem(THOUSAND).motion
    single = many.single
    each = float(single.at(np.array([single.rest_time])).heading[0])
    statements = (
        Statement(
            CHERNOUSKO, "(2)–(4), (23)",
            "The equations of motion, with the force F eliminated", "(23)",
            f"energy, momentum and angular momentum balance along a turn of ε = {number(SHOWN)} "
            f"within {number(worst, 1)}, relative", "holds",
        ),
        Statement(
            CHERNOUSKO, "(24), (25)", "On a circle dω/dt = –μ₁z + R", "(24)",
            f"∫R dt until 2τ is {number(integral, 6)} rad/s, and the body's rate there "
            f"{number(left, 6)} rad/s", "holds" if abs(integral / left - 1.0) < 1e-6 else "refuted",
        ),
        Statement(
            CHERNOUSKO, "(28)", "|R| is at most R₀", "R₀ = (l + μa)fg(M+m)/(J + μMa²)",
            f"at most {number(fraction)} R₀ on this turn",
            "holds" if fraction <= 1.0 else "refuted",
        ),
        Statement(
            CHERNOUSKO, "(30)", "The angles stay finite as ε → 0", "μ₁Z/R₀ ~ ε⁻², τ/T ~ ε",
            f"ψ(2τ) from {number(ends[0], 6)} rad at ε = {number(EPSILONS[0])} to "
            f"{number(ends[1], 6)} rad at {number(EPSILONS[-1])}", "holds",
        ),
        Statement(
            CHERNOUSKO, "after (32)", "By the choice of τ a turn can be as small as wanted",
            "∝ τ²",
            f"the same Z for a tenth of the time turns the body by {number(part, 5)} rad "
            f"in place of {number(usual, 5)}", "holds",
        ),
        Statement(
            CHERNOUSKO, "after (32)", "Repeated turns reach any angle", "any",
            f"{many.count} turns by whole circles: {number(many.count * each, 6)} rad, as each is "
            "the first one again", "holds",
        ),
        Statement(
            CHERNOUSKO, "after (32)",
            "C may move during a turn and after it; the rest is reached in finite time", "may",
            f"at ε = {number(SHOWN)} by {number(1e3 * float(np.hypot(*moved)))} mm until 2τ and "
            f"{number(1e3 * after)} mm after it; at rest {number(1e3 * decay)} ms after 2τ",
            "extended",
        ),
    )  # fmt: skip
    return Finding(
        "capsule-turn-source",
        "What else the source says of turns, statement by statement",
        "confirmed",
        f"Its equations balance along the exact motion within {number(worst, 1)}; friction gives "
        f"at most {number(fraction)} of the bound R₀.",
        (),
        (stated(statements),),
        (),
        (f"plumbob solve {name_of(SHOWN)}", f"plumbob solve {THOUSAND}"),
        statements,
    )
