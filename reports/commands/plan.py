"""plumbob plan: the capsule brought to a pose: its manoeuvres, their time, where they lead."""

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
from plumbob.models.tripod_capsule.parameters import BODY, CHECK, capsule
from plumbob.models.tripod_capsule.plan import CURVE, LIMITS, requested_plan
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
    """Say what --set takes, and read numbers below zero."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = ABOUT.format(body=", ".join(BODY), limits=", ".join(LIMITS))
    # Without this argparse takes -1e-3 for an option.
    parser._negative_number_matcher = re.compile(r"^-(\d|\.\d)")


def command(chosen: argparse.Namespace) -> int:
    """Print the manoeuvres, the total time and where the reference ends, and an engine's errors."""
    changes = chosen.changes | ({"arc": chosen.arc} if chosen.arc else {})
    known(changes, (*BODY, *LIMITS, *PLACES))
    parameters = {**changes, "to": chosen.to, "track": chosen.track}
    if (chosen.method is None) != (chosen.step is None):
        raise ParameterError("step", chosen.step, "given with --method, and only with it")
    measured = None
    with values.representable(changes or {"to": chosen.to}):
        found = requested_plan({**CHECK, **parameters})
        answer = described(found)
        if chosen.method:
            scene = find_scene(SYSTEM, parameters)
            method = find_method(chosen.method)
            measured = run_plan(found, scene, method, chosen.step)
        if chosen.other:
            known(chosen.other, BODY)
            body = capsule({**asdict(found.capsule), **chosen.other})
            answer["on"] = _misses(replace(found, capsule=body))
    if measured is not None:
        answer["method"] = measured_data(found, measured)
    values.show(chosen, answer, "plan", **{"method": None, "on": None, **answer})
    return MISSING if measured is not None and measured.found.status == "missing" else 0


def described(found: Plan) -> dict[str, Any]:
    """A plan as plain data."""
    return {
        "start": found.start,
        "goal": found.goal,
        "track": found.track,
        "legs": found.legs if found.track == "curve" and not found.segments else None,
        "segments": found.segments,
        "arc": found.arc if found.track == "curve" else None,
        "one_curve": found.rails.is_curve,
        "limits": found.limits,
        "parameters": found.capsule,
        "total_time": found.duration,
        "turns": found.turns,
        "lines": found.lines,
        "manoeuvres": [
            {name: getattr(m, name) for name in ("kind", "start", "duration", "parameters")}
            for m in found.manoeuvres
        ],
        "reached": found.reached,
        **_misses(found),
        "drive": plane_demand(found.motion).facts(),
    }


def _misses(plan: Plan) -> dict[str, float]:
    """How far from its goal the plan's motion of the slider ends."""
    distance, angle = plan.error
    return {"position_error": distance, "heading_error": angle}


@dataclass(frozen=True)
class PlanRun:
    """A plan run open-loop: its measurement, and the error of the pose after each manoeuvre."""

    found: Measurement
    judgement: Judgement
    after: Array  # shape (manoeuvres, 3), as pose_errors has them; empty where it did not end


def run_plan(plan: Plan, scene: Scene, method: Method, step: float) -> PlanRun:
    """Run `plan`, which is that of `scene`, with `step` [s] to its end. Raises ParameterError."""
    case = case_of(replace(scene, duration=run_duration(plan, step)))
    found, run = measure(case, method, step)
    judgement = judge(found, case.system, method)
    if run is None or found.status != "done":
        return PlanRun(found, judgement, np.empty((0, 3)))
    return PlanRun(found, judgement, pose_errors(plan, case.reference, run))


def measured_data(plan: Plan, run: PlanRun) -> dict[str, Any]:
    """An engine's run of a plan, as plain data."""
    measured = run.found
    return {
        "name": measured.method,
        "step": measured.step,
        "status": measured.status,
        "reason": measured.reason,
        "verdict": run.judgement.verdict,
        "errors_at_end": {name: error.end for name, error in measured.errors.items()},
        "predicted_at_end": {
            name: error.predicted.end
            for name, error in measured.errors.items()
            if error.predicted
        },
        "allowed": {name: error.left_open for name, error in measured.errors.items()},
        "off_after": [None if np.isnan(off).any() else error_by_name(off) for off in run.after],
        "arising": {
            kind: error_by_name(off) for kind, off in errors_by_kind(plan, run.after).items()
        },
    }
