"""plumbob plan: manoeuvres that bring the capsule to a pose, and where they end."""

from __future__ import annotations

import argparse
import re
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError, known
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.planner.result import Plan
from plumbob.analytic.systems.three_points.forces import plane_demand
from plumbob.engines.method import Method
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import Measurement, measure
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Scene
from plumbob.models.tripod_capsule.parameters import CAPSULE_PARAMETERS, CHECK, read_capsule
from plumbob.models.tripod_capsule.plan import CURVE, LIMIT_NAMES, requested_plan
from plumbob.reports.analyses.capsule_plan.pose_errors import (
    error_by_name,
    errors_by_kind,
    pose_errors,
    run_duration,
)
from plumbob.reports.commands.arguments import values
from plumbob.reports.judge.verdict import Judgement, judge

PLACES = ("start", "slider", "slider_at_end", *CURVE)
ABOUT = """\
--set takes, beside the body's ({body}) and the limits ({limits}):
  start=[X, Y, PSI]       the pose at the start (default: 0, 0, 0)
  slider=[X, Y]           the slider's place from C at the start (default: at C)
  slider_at_end=[X, Y]    and at the end (default: as at the start)
on the curve (--track curve), between whose pieces it goes straight where they do not meet:
  legs=[I, J]             it follows C-Ai and C-Aj from C to the circle (default: 1, 2)
  segments=[[DIRECTION, FROM, TO], [DIRECTION, FROM, TO]]
                          or any two segments of lines through C: direction [rad] in the body,
                          ends [m] from C, below zero on its other side
  arc=[FROM, TO]          any arc of the circle [rad] (default: the shorter one between the
                          two lines' directions; --arc longer is the other)"""
SYSTEM = "capsule-plan"
MISSING = 3


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds to --help what --set takes, and lets arguments be negative numbers."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = ABOUT.format(
        body=", ".join(CAPSULE_PARAMETERS), limits=", ".join(LIMIT_NAMES)
    )
    # By its own pattern argparse takes -1e-3 for an option.
    parser._negative_number_matcher = re.compile(r"^-(\d|\.\d)")


def command(chosen: argparse.Namespace) -> int:
    """Prints the manoeuvres, the total time, the pose at the end and, if a method is chosen, its
    errors. Returns 3 if the method's engine is missing."""
    changes = chosen.changes | ({"arc": chosen.arc} if chosen.arc else {})
    known(changes, (*CAPSULE_PARAMETERS, *LIMIT_NAMES, *PLACES))
    parameters = {**changes, "to": chosen.to, "track": chosen.track}
    if (chosen.method is None) != (chosen.step is None):
        raise ParameterError("step", chosen.step, "given with --method, and only with it")
    run = None
    with values.representable(changes or {"to": chosen.to}):
        plan = requested_plan({**CHECK, **parameters})
        answer = plan_record(plan)
        if chosen.method:
            scene = find_scene(SYSTEM, parameters)
            method = find_method(chosen.method)
            run = run_plan(plan, scene, method, chosen.step)
        if chosen.other:
            known(chosen.other, CAPSULE_PARAMETERS)
            body = read_capsule({**asdict(plan.capsule), **chosen.other})
            answer["on"] = _end_errors(replace(plan, capsule=body))
    if run is not None:
        answer["method"] = run_record(plan, run)
    values.show(chosen, answer, "plan", **{"method": None, "on": None, **answer})
    engine_missing = run is not None and run.measurement.status == "missing"
    return MISSING if engine_missing else 0


def plan_record(plan: Plan) -> dict[str, Any]:
    """Returns the JSON data of a plan."""
    return {
        "start": plan.start,
        "goal": plan.goal,
        "track": plan.track,
        "legs": plan.legs if plan.track == "curve" and not plan.segments else None,
        "segments": plan.segments,
        "arc": plan.arc if plan.track == "curve" else None,
        "one_curve": plan.rails.is_curve,
        "limits": plan.limits,
        "parameters": plan.capsule,
        "total_time": plan.duration,
        "turns": plan.turns,
        "lines": plan.lines,
        "manoeuvres": [
            {
                "kind": manoeuvre.kind,
                "start": manoeuvre.start,
                "duration": manoeuvre.duration,
                "parameters": manoeuvre.parameters,
            }
            for manoeuvre in plan.manoeuvres
        ],
        "reached": plan.reached,
        **_end_errors(plan),
        "drive": plane_demand(plan.motion).facts(),
    }


def _end_errors(plan: Plan) -> dict[str, float]:
    """Returns how far from the goal the exact motion of a plan ends: the distance [m] and the angle
    [rad]."""
    distance, angle = plan.error
    return {"position_error": distance, "heading_error": angle}


@dataclass(frozen=True)
class PlanRun:
    """An engine's open-loop run of a plan, and the error of the pose after each manoeuvre."""

    measurement: Measurement
    judgement: Judgement
    # [m, m, rad] errors of the pose after each manoeuvre, shape (manoeuvres, 3); shape (0, 3) if
    # the run did not reach its end.
    errors_after: Array


def run_plan(plan: Plan, scene: Scene, method: Method, step: float) -> PlanRun:
    """Returns the run of `plan` to its end by `method` with `step` [s]. `scene` is the scene of the
    plan. Raises ParameterError."""
    case = case_of(replace(scene, duration=run_duration(plan, step)))
    measurement, run = measure(case, method, step)
    judgement = judge(measurement, case.system, method)
    errors_after = np.empty((0, 3))
    if run is not None and measurement.status == "done":
        errors_after = pose_errors(plan, case.reference, run)
    return PlanRun(measurement, judgement, errors_after)


def run_record(plan: Plan, run: PlanRun) -> dict[str, Any]:
    """Returns the JSON data of an engine's run of a plan."""
    measurement = run.measurement
    return {
        "name": measurement.method,
        "step": measurement.step,
        "status": measurement.status,
        "reason": measurement.reason,
        "verdict": run.judgement.verdict,
        "errors_at_end": {name: error.end for name, error in measurement.errors.items()},
        "predicted_at_end": {
            name: error.predicted.end
            for name, error in measurement.errors.items()
            if error.predicted
        },
        "allowed": {name: error.left_open for name, error in measurement.errors.items()},
        "off_after": [
            None if np.isnan(pose_error).any() else error_by_name(pose_error)
            for pose_error in run.errors_after
        ],
        "arising": {
            kind: error_by_name(pose_error)
            for kind, pose_error in errors_by_kind(plan, run.errors_after).items()
        },
    }
