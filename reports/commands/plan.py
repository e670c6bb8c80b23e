"""plumbob plan: the capsule brought to a pose: its manoeuvres, their time, where they lead."""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from types import MappingProxyType
from typing import Any

from plumbob.analytic.parameters import ParameterError, known
from plumbob.analytic.systems.planner.result import Plan
from plumbob.analytic.systems.three_points.drive import plane_demand
from plumbob.engines.method import Method
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import Measurement, measure
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Scene
from plumbob.models.tripod_capsule.parameters import BODY, CHECK
from plumbob.models.tripod_capsule.plan import LIMITS, planned
from plumbob.reports.analyses.capsule_plan.pose_errors import (
    PoseError,
    PoseErrors,
    by_kind,
    pose_errors,
    run_duration,
)
from plumbob.reports.commands.arguments import values

PLACES = ("start", "slider", "slider_at_end", "legs", "arc")
ABOUT = """\
--set takes, beside the body's ({body}) and the limits ({limits}):
  start=[X, Y, PSI]       the pose at the start (default: 0, 0, 0)
  slider=[X, Y]           the slider's place from C at the start (default: at C)
  slider_at_end=[X, Y]    and at the end (default: as at the start)
  legs=[I, J]             on the curve: the supports whose lines C-Ai and C-Aj it follows
                          (default: 1, 2; --arc is its arc, shorter by default)"""
SYSTEM = "capsule-plan"
KINDS: Mapping[str, str] = MappingProxyType(
    {"slow": "slow motions", "turn": "turns", "line": "lines", "wait": "waits"}
)
MISSING = 3


def arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = ABOUT.format(body=", ".join(BODY), limits=", ".join(LIMITS))
    # Without this argparse takes -1e-3 for an option.
    parser._negative_number_matcher = re.compile(r"^-(\d|\.\d)")
    parser.add_argument(
        "--to", nargs=3, required=True, metavar=("X", "Y", "PSI"),
        help="where to: place of the body's centre of mass [m], heading [rad]",
    )  # fmt: skip
    parser.add_argument("--track", default="free", metavar="free|curve", help="where the slider is")
    parser.add_argument(
        "--arc", metavar="shorter|longer", help="on the curve: the way round between its two lines"
    )
    values.add_changes(parser)
    parser.add_argument("--method", metavar="METHOD", help="also run the plan open-loop")
    parser.add_argument("--step", metavar="DT", help="with --method: step [s]")
    parser.add_argument("--json", action="store_true", help="print JSON, with every digit")


def command(chosen: argparse.Namespace) -> int:
    """Print the manoeuvres, the total time and where the reference ends, and an engine's errors."""
    changes = values.changes(chosen.changes) | ({"arc": chosen.arc} if chosen.arc else {})
    known(changes, (*BODY, *LIMITS, *PLACES))
    parameters = asked(chosen.to, chosen.track, changes)
    if (chosen.method is None) != (chosen.step is None):
        raise ParameterError("step", chosen.step, "given with --method, and only with it")
    with values.representable(changes or {"to": chosen.to}):
        found = planned({**CHECK, **parameters})
        answer = described(found)
        measured = _measured(chosen, found, parameters) if chosen.method else None
    if measured is not None:
        answer["method"] = measured_data(found, measured)
    if chosen.json:
        json.dump(values.plain(answer), sys.stdout, indent=1)
        print()
    else:
        _print(answer)
    return MISSING if measured is not None and measured.found.status == "missing" else 0


def asked(to: list[str], track: Any, changes: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments as parameters of SYSTEM; raises ParameterError."""
    goal = [values.number(*pair) for pair in zip(("x", "y", "psi"), to, strict=True)]
    return {**changes, "to": goal, "track": track}


def described(found: Plan) -> dict[str, Any]:
    """What there is to say of a plan, as plain data."""
    distance, angle = found.error
    return {
        "start": asdict(found.start),
        "goal": asdict(found.goal),
        "track": found.track,
        "legs": found.legs if found.track == "curve" else None,
        "arc": found.arc if found.track == "curve" else None,
        "limits": asdict(found.limits),
        "parameters": asdict(found.capsule),
        "total_time": found.duration,
        "turns": found.turns,
        "lines": found.lines,
        "manoeuvres": [
            {
                "kind": one.kind,
                "start": one.start,
                "duration": one.duration,
                "parameters": dict(one.parameters),
            }
            for one in found.manoeuvres
        ],
        "reached": asdict(found.reached),
        "position_error": distance,
        "heading_error": angle,
        "drive": plane_demand(found.motion).facts(),
    }


def _measured(chosen: argparse.Namespace, found: Plan, parameters: Mapping[str, Any]) -> PlanRun:
    method, step = find_method(chosen.method), values.positive_number("step", chosen.step)
    return run_plan(found, find_scene(SYSTEM, parameters), method, step)


@dataclass(frozen=True)
class PlanRun:
    """A plan run open-loop: its measurement, and the error of the pose after each manoeuvre."""

    found: Measurement
    after: PoseErrors


def run_plan(plan: Plan, scene: Scene, method: Method, step: float) -> PlanRun:
    """Run `plan`, which is that of `scene`, with `step` [s] to its end. Raises ParameterError."""
    case = case_of(replace(scene, duration=run_duration(plan, step)))
    found, run = measure(case, method, step)
    if run is None or found.status != "done":
        return PlanRun(found, ())
    return PlanRun(found, pose_errors(plan, case.reference, run))


def measured_data(plan: Plan, run: PlanRun) -> dict[str, Any]:
    """What an engine makes of a plan, as plain data."""
    measured = run.found
    return {
        "name": measured.method,
        "step": measured.step,
        "status": measured.status,
        "reason": measured.reason,
        "errors_at_end": {name: error.end for name, error in measured.errors.items()},
        "off_after": [None if off is None else _off(off) for off in run.after],
        "arising": {kind: _off(off) for kind, off in by_kind(plan, run.after).items()},
    }


def _off(off: PoseError) -> dict[str, float]:
    return {"distance": off.distance, **asdict(off)}


def _print(answer: Mapping[str, Any]) -> None:
    goal, track = answer["goal"], answer["track"]
    print(
        f"to ({goal['x']:g}, {goal['y']:g}) m and {goal['heading']:g} rad, slider on the "
        f"{'free plane' if track == 'free' else _curve(answer)}: {answer['turns']} turns and "
        f"{answer['lines']} lines in {answer['total_time']:.6g} s"
    )
    after = answer.get("method", {}).get("off_after") or [None] * len(answer["manoeuvres"])
    heads = f"{'start [s]':>12} {'lasts [s]':>12}"
    if "method" in answer:
        heads += f" {'then off [m]':>13} {'[rad]':>10}"
    print(f"{heads}  manoeuvre")
    for one, off in zip(answer["manoeuvres"], after, strict=True):
        given = ", ".join(f"{name} {value:.6g}" for name, value in one["parameters"].items())
        row = f"{one['start']:>12.6f} {one['duration']:>12.6f}"
        if "method" in answer:
            row += " ".join(("", *_columns(off)))
        print(f"{row}  {one['kind']:<5} {given}".rstrip())
    print(
        f"the reference ends {answer['position_error']:.2g} m and "
        f"{answer['heading_error']:.2g} rad from the goal"
    )
    drive = answer["drive"]
    print(
        f"the actuator gives up to {drive['driving_force_peak']:.4g} N "
        f"({drive['driving_force_rms']:.4g} N r.m.s.) and {drive['driving_power_peak']:.4g} W"
    )
    if "method" in answer:
        run = answer["method"]
        print(f"{run['name']} at {run['step']:g} s: {run['status']} {run['reason']}".rstrip())
        for name, error in run["errors_at_end"].items():
            print(f"  {name}: ends {error:.4g} off")
        for kind, off in run["arising"].items():
            print(f"  of it from {KINDS[kind]}: {off['distance']:.3g} m, {off['heading']:.3g} rad")


def _curve(answer: Mapping[str, Any]) -> str:
    (i, j), arc = answer["legs"], answer["arc"]
    return f"curve C-A{i}, {arc} arc, C-A{j}"


def _columns(off: Mapping[str, float] | None) -> tuple[str, str]:
    if off is None:
        return f"{'moving':>13}", f"{'':>10}"
    return f"{off['distance']:>13.3e}", f"{off['heading']:>10.2e}"
