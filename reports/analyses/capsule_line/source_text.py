"""Further statements of the source on straight motions, each computed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.planner.construction import plan as find_plan
from plumbob.analytic.systems.planner.problem import PlanLimits, RestPose
from plumbob.analytic.systems.slider_path import line_stroke
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.measurements import CHECK_LINE, measured_error, problem

CONTACT_METHODS = ("mujoco/euler", "mujoco/euler+coulomb")  # default and convergent contacts
SOURCE_TEXT_STEP = 1e-3  # [s]
THRESHOLD = "capsule-line/w1-threshold"
COASTING_TRANSLATION, COASTING_SPIN = "capsule-coast/translation", "capsule-coast/spin"
LINE_TIME_FACTOR = 1000.0  # factor by which t1 is shortened
ACCELERATION_ABOVE_BOUND = 2.0  # ratio of w2 to f g/mu, above the bound (15)
SLIDER_STARTS = (-0.05, 0.0, 0.08)  # [m] starts of the slider along its line
# ratio of |w| to f g/mu in a plan; [m] distance of the plan's goal
ACCELERATION_MARGIN, GOAL_DISTANCE = 1.002, 1e-3


def time_exponents(line: LineManoeuvre) -> tuple[float, float]:
    """Returns the exponents p of t1^p in the displacements of the slider and of the body, from the
    manoeuvres with t1 and t1/SHORTER."""
    shorter = replace(line, t1=line.t1 / LINE_TIME_FACTOR)
    of_slider = math.log(line.stroke / shorter.stroke) / math.log(LINE_TIME_FACTOR)
    of_body = math.log(line.displacement / shorter.displacement) / math.log(LINE_TIME_FACTOR)
    return of_slider, of_body


def balance_residual(line: LineManoeuvre) -> float:
    """Returns the largest residual of the momentum balance of the whole robot (eqs. 8 and 9
    without the driving force F), divided by the weight. It is evaluated at two times within each
    interval between switches, with accelerations from differences of velocities."""
    switches = np.array([0.0, line.t1, line.t_star, line.t2])
    times = (switches[:-1] + np.diff(switches) * np.array([[0.3], [0.7]])).ravel()
    h = 1e-3 * float(np.diff(switches).min())
    later = line.at(times + h)
    before = line.at(times - h)
    body = line.capsule
    forces = line.friction_force(times)
    momentum = (body.body_mass + body.slider_mass) * (later.velocity - before.velocity)
    momentum += body.slider_mass * (later.stroke_rate - before.stroke_rate)
    momentum_rate = momentum / (2 * h)
    return float(np.abs(momentum_rate - forces).max() / body.weight)


def hard_brake(line: LineManoeuvre, factor: float = ACCELERATION_ABOVE_BOUND) -> Record:
    """Returns the exact motion if w2 is `factor` times f g/mu, where `factor` is above 1: the body
    reverses at t*."""
    body = line.capsule
    limit = line.capsule.holding_acceleration
    w2 = factor * limit
    resistance = body.friction * body.gravity
    path = line_stroke(line.ends[0], line.direction, line.w1, w2, line.t1)
    motion = three_point_motion(body, path)
    push = body.mass_ratio * line.w1 - resistance
    brake = body.mass_ratio * w2 + resistance
    t_star = line.t1 * (1.0 + push / brake)
    braking = line.t1 * (1.0 + line.w1 / w2) - t_star  # [s] time from t* until the slider rests
    forward = body.mass_ratio * w2 - resistance  # [m/s^2] acceleration of the body after t*
    at_t_star, at_rest = motion.at(np.array([t_star, motion.rest_time])).position[:, 0]
    return Record(
        back=at_t_star,  # [m] displacement until t*
        after=at_rest - at_t_star,  # [m] displacement from t* to rest, exact
        # [m] displacement from t* to rest by constant accelerations
        formula=0.5 * forward * braking**2 * (1.0 + forward / resistance),
        ends=motion.rest_time,  # [s] time at which the body rests
    )


def change_by_start(line: LineManoeuvre) -> float:
    """Returns the largest relative change of the displacement of the exact motion if the slider
    starts elsewhere on its line (SLIDER_STARTS)."""

    changes = []
    for start in SLIDER_STARTS:
        path = replace(line, start=start).path
        motion = three_point_motion(line.capsule, path)
        displacement = float(motion.at(np.array([motion.rest_time])).position[0, 0])
        changes.append(abs(displacement / line.displacement - 1.0))
    return max(changes)


def slide_to_rest() -> Record:
    """Returns speed, distance and time of a body with a fixed slider that slides to rest."""
    coast = problem(COASTING_TRANSLATION)
    speed = math.hypot(*coast.setup.velocity)
    distance = float(coast.motion.distance)
    return Record(
        speed=speed,  # [m/s] initial speed
        distance=distance,  # [m]
        time=2.0 * distance / speed,  # [s] time until the body rests
        spinning=problem(
            COASTING_SPIN
        ).motion.rest_time,  # [s] time until a spinning body rests
    )


def friction_errors(study: Study) -> Record:
    """Returns the relative error of the displacement in MuJoCo for each of CONTACT_METHODS, at the
    step SOURCE_TEXT_STEP [s]."""
    errors = [
        measured_error(study, CHECK_LINE, method, SOURCE_TEXT_STEP)
        for method in CONTACT_METHODS
    ]
    return Record(friction_errors=errors, step=SOURCE_TEXT_STEP)


def numbers() -> Record:
    """Returns the quantities of the source's statements, computed."""
    line = problem(CHECK_LINE).motion
    barely = problem(THRESHOLD).motion
    body = line.capsule
    loads = line.normal_forces(np.linspace(0.0, line.t2, 50)).sum(axis=1)
    limit = body.holding_acceleration
    exponents = time_exponents(line)
    plan = find_plan(
        body,
        RestPose(GOAL_DISTANCE, 0.0, 0.0),
        PlanLimits(acceleration=ACCELERATION_MARGIN * limit),
    )
    return Record(
        weight=body.weight,  # [N]
        # largest relative difference of the sum of normal forces from the weight
        load_gap=np.abs(loads / body.weight - 1.0).max(),
        # ratio of the largest residual of eqs. 8 and 9 to the weight
        imbalance=balance_residual(line),
        enough=limit,  # [m/s²] acceleration above which the body moves
        excess=barely.w1 / limit - 1.0,  # relative excess of w1 in the scene THRESHOLD
        barely_moved=barely.displacement,  # [m] displacement in the scene THRESHOLD
        switches=(line.t1, line.t_star, line.t2),  # [s] t1, t*, t2
        exponents=exponents,  # exponents of t1 in the displacements of slider and body
        short_displacement=line.displacement / LINE_TIME_FACTOR ** exponents[1],  # [m]
        # whether slider and body move in opposite directions
        opposite=line.stroke * line.displacement < 0.0,
        plan_lines=plan.lines,
        plan_duration=plan.duration,  # [s]
        acceleration=ACCELERATION_MARGIN * limit,  # [m/s²] largest acceleration of the plan
        hard_brake=hard_brake(line),
        stop=slide_to_rest(),
        # largest relative change of the displacement if the slider starts elsewhere
        by_start=change_by_start(line),
        hard=ACCELERATION_ABOVE_BOUND,
        starts=SLIDER_STARTS,
        spare=ACCELERATION_MARGIN,
        away=GOAL_DISTANCE,
        shorter=LINE_TIME_FACTOR,
    )


LINE_SOURCE_TEXT = Analysis("capsule_line/source", friction_errors, exact=numbers)
