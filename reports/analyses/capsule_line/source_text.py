"""Further statements of the source on straight motions, each computed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.planner.construction import plan as find_plan
from plumbob.analytic.systems.planner.problem import Limits, RestPose
from plumbob.analytic.systems.slider_path import line_stroke
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.measurements import LINE, measured_error, problem

CONTACTS = ("mujoco/euler", "mujoco/euler+coulomb")  # default and convergent
STEP = 1e-3  # [s]
THRESHOLD = "capsule-line/w1-threshold"
SHORTER = 1000.0  # times, of t1
HARD = 2.0  # of w2 over f g/mu, beyond (15)
STARTS = (-0.05, 0.0, 0.08)  # of the slider along its line [m]
SPARE, AWAY = 1.002, 1e-3  # of |w| over f g/mu, and how far a plan goes with it [m]


@dataclass(frozen=True)
class HardBrake:
    """The check manoeuvre with a brake beyond (15): HARD times f g/mu."""

    back: float  # way until t* [m]
    after: float  # way from there to rest [m], exact
    formula: float  # the same by constant accelerations
    ends: float  # when the body rests [s]


@dataclass(frozen=True)
class LineStatements:
    """The check manoeuvre, and one whose acceleration is barely enough, as the source has them."""

    friction_errors: tuple[float | None, ...]  # of the displacement, relative, for CONTACTS
    weight: float  # [N]
    load_gap: float  # of the sum of normal forces from the weight, relative
    imbalance: float  # of eqs. 8 and 9, over the weight
    enough: float  # acceleration [m/s²] above which the body moves
    excess: float  # of the threshold's scene over that, relative
    barely_moved: float  # [m], in that scene
    switches: tuple[float, float, float]  # t1, t*, t2 [s]
    exponents: tuple[float, float]  # of t1, in the displacements of slider and body
    short_displacement: float  # [m]
    opposite: bool  # whether slider and body go in opposite directions
    plan_lines: int
    plan_duration: float  # [s]
    acceleration: float  # [m/s²] of the plan
    hard_brake: HardBrake
    by_start: float  # largest relative change of the displacement with the slider's start
    hard: float = HARD
    starts: tuple[float, ...] = STARTS
    spare: float = SPARE
    away: float = AWAY
    shorter: float = SHORTER
    step: float = STEP


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
    velocities = (line.body_velocity, line.relative_velocity)
    rates = [(f(times + h) - f(times - h)) / (2 * h) for f in velocities]
    body = line.capsule
    forces = line.friction_force(times)
    momentum = (body.body_mass + body.slider_mass) * rates[0] + body.slider_mass * rates[1]
    return float(np.abs(momentum - forces).max() / body.weight)


def hard_brake(line: LineManoeuvre, factor: float = HARD) -> HardBrake:
    """The exact motion with w2 `factor` times f g/mu, 1 < `factor`: at t* the body turns round."""
    body, limit = line.capsule, line.capsule.holding_acceleration
    w2, resistance = factor * limit, body.friction * body.gravity
    path = line_stroke(line.segment.start, line.direction, line.w1, w2, line.t1)
    motion = three_point_motion(body, path)
    push, brake = body.mass_ratio * line.w1 - resistance, body.mass_ratio * w2 + resistance
    t_star = line.t1 * (1.0 + push / brake)
    left = line.t1 * (1.0 + line.w1 / w2) - t_star  # until the slider rests
    forth = body.mass_ratio * w2 - resistance
    places = motion.at(np.array([t_star, motion.rest_time])).position[:, 0]
    return HardBrake(
        float(places[0]),
        float(places[1] - places[0]),
        0.5 * forth * left**2 * (1.0 + forth / resistance),
        motion.rest_time,
    )


def from_starts(line: LineManoeuvre) -> float:
    """Largest relative change of the displacement where the slider starts elsewhere on its line:
    of the exact motion, not of (22)."""

    def moved(start: float) -> float:
        path = replace(line, start=start).path
        motion = three_point_motion(line.capsule, path)
        return float(motion.at(np.array([motion.rest_time])).position[0, 0])

    return max(abs(moved(start) / line.displacement - 1.0) for start in STARTS)


def numbers(study: Study) -> LineStatements:
    """The sources' quantities, computed; and the errors of MuJoCo's friction."""
    line, barely = problem(LINE).motion, problem(THRESHOLD).motion
    body = line.capsule
    loads = line.normal_forces(np.linspace(0.0, line.t2, 50)).sum(axis=1)
    limit, exponents = body.holding_acceleration, slope(line)
    plan = find_plan(body, RestPose(AWAY, 0.0, 0.0), Limits(acceleration=SPARE * limit))
    return LineStatements(
        friction_errors=tuple(measured_error(study, LINE, method, STEP) for method in CONTACTS),
        weight=body.weight,
        load_gap=float(np.abs(loads / body.weight - 1.0).max()),
        imbalance=balance(line),
        enough=limit,
        excess=barely.w1 / limit - 1.0,
        barely_moved=barely.displacement,
        switches=(line.t1, line.t_star, line.t2),
        exponents=exponents,
        short_displacement=line.displacement / SHORTER ** exponents[1],
        opposite=line.stroke * line.displacement < 0.0,
        plan_lines=plan.lines,
        plan_duration=plan.duration,
        acceleration=SPARE * limit,
        hard_brake=hard_brake(line),
        by_start=from_starts(line),
    )


SOURCE = Analysis("capsule_line/source", numbers)
