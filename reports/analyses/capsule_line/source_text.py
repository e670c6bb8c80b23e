"""Further statements of the source on straight motions, each computed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.planner.construction import plan as find_plan
from plumbob.analytic.systems.planner.problem import Limits, RestPose
from plumbob.analytic.systems.slider_path import line_stroke
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.measurements import LINE, measured_error, problem

CONTACTS = ("mujoco/euler", "mujoco/euler+coulomb")  # default and convergent
STEP = 1e-3  # [s]
THRESHOLD = "capsule-line/w1-threshold"
COAST, SPIN = "capsule-coast/translation", "capsule-coast/spin"
SHORTER = 1000.0  # times, of t1
HARD = 2.0  # of w2 over f g/mu, beyond (15)
STARTS = (-0.05, 0.0, 0.08)  # of the slider along its line [m]
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
    later = line.at(times + h)
    before = line.at(times - h)
    body = line.capsule
    forces = line.friction_force(times)
    gained = (body.body_mass + body.slider_mass) * (later.velocity - before.velocity)
    gained += body.slider_mass * (later.stroke_rate - before.stroke_rate)
    momentum = gained / (2 * h)
    return float(np.abs(momentum - forces).max() / body.weight)


def hard_brake(line: LineManoeuvre, factor: float = HARD) -> Record:
    """The exact motion with w2 `factor` times f g/mu, 1 < `factor`: at t* the body turns round."""
    body = line.capsule
    limit = line.capsule.holding_acceleration
    w2 = factor * limit
    resistance = body.friction * body.gravity
    path = line_stroke(line.ends[0], line.direction, line.w1, w2, line.t1)
    motion = three_point_motion(body, path)
    push = body.mass_ratio * line.w1 - resistance
    brake = body.mass_ratio * w2 + resistance
    t_star = line.t1 * (1.0 + push / brake)
    left = line.t1 * (1.0 + line.w1 / w2) - t_star  # until the slider rests
    forth = body.mass_ratio * w2 - resistance
    places = motion.at(np.array([t_star, motion.rest_time])).position[:, 0]
    return Record(
        back=places[0],  # way until t* [m]
        after=places[1] - places[0],  # way from there to rest [m], exact
        # the same by constant accelerations
        formula=0.5 * forth * left**2 * (1.0 + forth / resistance),
        ends=motion.rest_time,  # when the body rests [s]
    )


def from_starts(line: LineManoeuvre) -> float:
    """Largest relative change of the displacement where the slider starts elsewhere on its line:
    of the exact motion, not of (22)."""

    def moved(start: float) -> float:
        path = replace(line, start=start).path
        motion = three_point_motion(line.capsule, path)
        return float(motion.at(np.array([motion.rest_time])).position[0, 0])

    return max(abs(moved(start) / line.displacement - 1.0) for start in STARTS)


def stop() -> Record:
    """How a body with a fixed slider comes to rest."""
    coast = problem(COAST)
    speed = math.hypot(*coast.setup.velocity)
    distance = float(coast.motion.distance)
    return Record(
        speed=speed,  # at first [m/s]
        distance=distance,  # [m]
        time=2.0 * distance / speed,  # until it rests [s]
        spinning=problem(SPIN).motion.rest_time,  # until one rests that spins too [s]
    )


def numbers(study: Study) -> Record:
    """The sources quantities, computed; and the errors of MuJoCo's friction."""
    line = problem(LINE).motion
    barely = problem(THRESHOLD).motion
    body = line.capsule
    loads = line.normal_forces(np.linspace(0.0, line.t2, 50)).sum(axis=1)
    limit = body.holding_acceleration
    exponents = slope(line)
    plan = find_plan(body, RestPose(AWAY, 0.0, 0.0), Limits(acceleration=SPARE * limit))
    return Record(
        # of the displacement, relative, for CONTACTS
        friction_errors=[measured_error(study, LINE, method, STEP) for method in CONTACTS],
        weight=body.weight,  # [N]
        # of the sum of normal forces from the weight, relative
        load_gap=np.abs(loads / body.weight - 1.0).max(),
        imbalance=balance(line),  # of eqs. 8 and 9, over the weight
        enough=limit,  # acceleration [m/s²] above which the body moves
        excess=barely.w1 / limit - 1.0,  # of the threshold's scene over that, relative
        barely_moved=barely.displacement,  # [m], in that scene
        switches=(line.t1, line.t_star, line.t2),  # t1, t*, t2 [s]
        exponents=exponents,  # of t1, in the displacements of slider and body
        short_displacement=line.displacement / SHORTER ** exponents[1],  # [m]
        # whether slider and body go in opposite directions
        opposite=line.stroke * line.displacement < 0.0,
        plan_lines=plan.lines,
        plan_duration=plan.duration,  # [s]
        acceleration=SPARE * limit,  # [m/s²] of the plan
        hard_brake=hard_brake(line),
        stop=stop(),
        # largest relative change of the displacement with the slider's start
        by_start=from_starts(line),
        hard=HARD,
        starts=STARTS,
        spare=SPARE,
        away=AWAY,
        shorter=SHORTER,
        step=STEP,
    )


SOURCE = Analysis("capsule_line/source", numbers)
